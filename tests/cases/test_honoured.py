"""What a case asks for is done, or refused by name, or said to be unused."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

from elutria_validation.harness.box import BoxCase, Contacts, cube
from elutria_validation.harness.cases import (
    CLOUD,
    CONTROL,
    MODELS,
    add_feed,
    add_zone,
    change,
    read_gas,
    solve,
    times,
    uniform,
)

ROOT = Path(__file__).resolve().parents[2]
HEAD = "FoamFile {{ version 2.0; format ascii; class dictionary; object {}; }}\n"
SPEED, RESISTANCE = 2.0, 500.0  # m/s, and 1/m: Forchheimer's coefficient


def put(case: Path, file: str, text: str) -> None:
    (case / file).write_text(HEAD.format(Path(file).name) + text)


def refused(case: Path) -> str:
    """The line with which elutriaFoam refuses the case, at its start."""
    done = subprocess.run(
        ["elutriaFoam"], cwd=case, capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 2, done.stdout[-500:] + done.stderr[-500:]
    assert "Starting time loop" not in done.stdout
    (said,) = [line for line in done.stdout.splitlines() if line.startswith("elutria: failed:")]
    return said


def duct(folder: Path, sources: str | None) -> float:
    """Pressure over density (m2/s2) that a duct of 0.1 m takes from bottom to top, friction-free,
    with a layer of 20 mm in its middle that `sources` may name."""
    case = BoxCase(
        height=0.1, cells=(1, 1, 20), gas_velocity=SPEED, gravity=0, solve_gas=True, step=1e-3,
        end=0.02,
    ).make(folder)  # fmt: skip
    add_zone(case, "screen", (0, 0, 0.04), (0.1, 0.1, 0.06))
    if sources is not None:
        put(case, "constant/fvOptions", sources)
    solve(case)
    p = read_gas(case, times(case)[-1], "p")[:, 0]
    return float(p[0] - p[-1])


def porosity(field: str) -> str:
    return (
        "screen { type explicitPorositySource; explicitPorositySourceCoeffs { selectionMode"
        f" cellZone; cellZone screen; {field} type DarcyForchheimer; DarcyForchheimerCoeffs"
        f" {{ d (0 0 0); f ({RESISTANCE:g} {RESISTANCE:g} {RESISTANCE:g}); coordinateSystem"
        " { origin (0 0 0); e1 (1 0 0); e2 (0 1 0); } } } }"
    )


def test_porosity_takes_forchheimers_pressure(tmp_path: Path, measured) -> None:
    free = duct(tmp_path / "free", None)
    screened = duct(tmp_path / "screened", porosity("U U.air;"))
    expected = 0.5 * RESISTANCE * SPEED**2 * 0.02  # m2/s2
    measured("pressure over the screen", abs(screened - free - expected) / expected, 1e-3)


def test_a_source_of_no_field_is_refused(tmp_path: Path) -> None:
    """OpenFOAM's porosity acts on `U` unless it is told otherwise, and the gas' is U.air."""
    case = BoxCase(gas_velocity=1).make(tmp_path / "case")
    add_zone(case, "screen", (0, 0, 0), (1, 1, 1))
    put(case, "constant/fvOptions", porosity(""))
    said = refused(case)
    assert "fvOptions" in said
    assert "screen" in said
    assert "U.air" in said


@pytest.mark.parametrize(
    ("file", "text", "named"),
    [("constant/MRFProperties",
      "wheel { cellZone screen; origin (0 0 0); axis (0 0 1); omega 100; }", "wheel"),
     ("constant/dynamicMeshDict", "dynamicFvMesh dynamicMotionSolverFvMesh;",
      "dynamicMotionSolverFvMesh")],
)  # fmt: skip
def test_what_turns_or_moves_the_mesh_is_refused(
    tmp_path: Path, file: str, text: str, named: str
) -> None:
    case = BoxCase().make(tmp_path / "case")
    put(case, file, text)
    said = refused(case)
    assert Path(file).name in said
    assert named in said


def test_files_that_nothing_reads_are_named(tmp_path: Path) -> None:
    """An included file is read; so is what only the mesher reads, but not by the run."""
    case = BoxCase(end=1e-3).make(tmp_path / "case")
    put(case, "constant/radiationProperties", "radiation off;")
    put(case, "system/scenePlann", "gas never;")
    put(case, "system/frames", "record no;")
    put(case, "system/topoSetDict", "actions ();")
    put(case, "system/shared", "roomy 1;")
    (case / "system/controlDict").open("a").write('\n#include "shared"\n')
    (case / "0/T").write_text((case / "0/p").read_text().replace("object      p", "object T"))
    output = solve(case)
    decisions = json.loads((case / "postProcessing/plan.json").read_text())["decisions"]
    unused = {row[1] for row in decisions if row[0] == "not used"}
    assert unused == {"constant/radiationProperties", "system/scenePlann", "0/T"}
    assert "system/scenePlann" in output


@pytest.mark.parametrize("kind", ["stick", "escape"])
def test_planes_of_symmetry_that_do_not_turn_particles_back(tmp_path: Path, kind: str) -> None:
    """Stock's do so without contacts; with them it is refused, not ignored."""
    case = BoxCase(contacts=Contacts(), sides="symmetry", end=1e-3, **cube(0.1)).make(
        tmp_path / "case"
    )
    change(case, {f"{MODELS}/patchInteractionModel": "localInteraction",
                  f"{MODELS}/localInteractionCoeffs": {
                      "patches": [('".*"', {"type": kind})]}})  # fmt: skip
    said = refused(case)
    assert kind in said
    assert "west" in said
    assert "cellList" in said
    change(case, {f"{MODELS}/collisionModel": "none"})
    solve(case)


def test_hits_that_nobody_would_record(tmp_path: Path) -> None:
    case = BoxCase(contacts=Contacts(), sides="symmetry", end=1e-3).make(tmp_path / "case")
    erosion = {"type": "particleErosion", "p": 1, "psi": 2, "patches": ["west"]}
    change(case, {f"{CLOUD}:cloudFunctions/wear": erosion})
    assert "particleErosion" in refused(case)


def test_walls_that_let_particles_out_belong_to_a_product(tmp_path: Path) -> None:
    case = BoxCase(end=1e-3).make(tmp_path / "case")
    add_feed(case, {"loading": 0.1, "materials": uniform(2650, 1e-3, 1.1e-3)})
    change(case, {f"{MODELS}/standardWallInteractionCoeffs/type": "escape"})
    said = refused(case)
    assert "outlets" in said
    assert "belongs to no product" in said


def test_what_has_no_effect_is_named(tmp_path: Path) -> None:
    """With our motion; a stock collision model's motion is stock's, and uses them."""
    case = BoxCase(end=1e-3).make(tmp_path / "case")
    change(case, {f"{CLOUD}:solution/cellValueSourceCorrection": True})
    solve(case, options=["-plan"])
    decisions = json.loads((case / "postProcessing/plan.json").read_text())["decisions"]
    (row,) = [row for row in decisions if row[0] == "without effect"]
    for name in ("integrationSchemes", "sourceTerms", "cellValueSourceCorrection"):
        assert name in row[2]


def test_models_of_mppicfoam_are_refused_with_what_to_set(tmp_path: Path) -> None:
    case = BoxCase().make(tmp_path / "case")
    change(case, {f"{MODELS}/packingModel": "explicit"})
    said = refused(case)
    assert "kinematicCloudProperties" in said
    assert "packingModel" in said
    assert "gravity among the particleForces" in said
    change(case, {f"{MODELS}/packingModel": "none", f"{CONTROL}:endTime": 1e-3})
    solve(case)  # as MPPICFoam's own injectionChannel has it


def listed() -> list[tuple[str, str, str]]:
    """Kind, name and use of each row of the solver's list."""
    code = (ROOT / "solver/coupling/foam/honoured.C").read_text()
    rows = re.findall(r'\{\s*kind::(\w+),\s*"(.*?)",\s*use::(\w+),', code)
    assert len(rows) == len(re.findall(r"\buse::\w+,", code))
    return [(kind, name.replace("\\\\", "\\"), use) for kind, name, use in rows]


def test_the_manual_lists_what_numbers_and_words_may_be() -> None:
    code = (ROOT / "solver/app/elutriaFoam/run/controls.C").read_text()
    page = (ROOT / "docs/user/honoured.md").read_text().partition("## Numbers and words")[2]
    lines = [line.replace("\\|", "|") for line in page.splitlines() if line.startswith("| ")]
    told = [line.removesuffix(" |").split(" | ") for line in lines]
    ends = {"above": ("above {}", ", up to {}"), "atLeast": ("{} or more", ", up to {}"),
            "below": ("0 or more, below {}",)}  # fmt: skip
    rule = r'\{\s*"\w+", "([^"]+)",\s*(?:(\w+)\(([^)]*)\)|\{([^}]*)\})\s*\}'
    rules = re.findall(rule, code)
    assert len(rules) > 15
    for entry, kind, numbers, words in rules:
        (allowed,) = [row[2] for row in told if row[1] == f"`{entry}`"]
        if words:
            assert re.findall(r"`(\w+)`", allowed) == re.findall(r'"(\w+)"', words)
        else:
            parts = zip(ends[kind], numbers.split(","), strict=False)
            assert allowed == "".join(text.format(number.strip()) for text, number in parts)


def test_the_manual_lists_what_the_solver_lists() -> None:
    page = (ROOT / "docs/user/honoured.md").read_text()
    known = {name for kind, name, use in listed() if kind == "file"}
    named = set(re.findall(r"`((?:constant|system)/[^`]+)`", page.partition("## Sources")[0]))
    assert known == named
    for kind, name, use in listed():
        (row, *_) = [line for line in page.splitlines() if f"`{name}`" in line and "|" in line]
        words = {"refused": "refused|none|not ", "noEffect": "without effect", "works": "read"}
        if kind == "file" or use != "works":
            assert re.search(words.get(use, ""), row), (name, row)
