"""Malformed cases given to elutriaFoam itself: one line, code 2, soon; no core is left behind."""

from __future__ import annotations

import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest

from elutria.classification.events import read_run
from elutria_validation.harness.box import TEMPLATE, BoxCase, Contacts
from elutria_validation.harness.cases import (
    CLOUD,
    CONTACTS,
    CONTROL,
    MODELS,
    add_feed,
    change,
    material,
    set_turbulence,
    solve,
    times,
)
from elutria_validation.harness.programs import run_program
from tests.support import malformed

SECONDS = 5
"""Of processor time, until a malformed input is refused."""
PATIENCE = 60
"""Seconds on the wall, on a machine that others use too."""
# what stock OpenFOAM takes although the tools refuse it, and what a scene does not have
NOT_HERE = {"wrong unit", "executed"}
FILES = [malformed.FEED, malformed.GAS, malformed.GRAVITY, malformed.CLOUD, malformed.CONTROL,
         "0/U.air", "0/p", "system/fvSchemes", "system/fvSolution"]  # fmt: skip
# a pipe or a device is read for ever by OpenFOAM; the tools refuse both
NO_END = {"pipe", "link to a device"}


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A box of few cells with a feed that collides, meshed in ASCII, that runs for one step."""
    box = BoxCase(gas_velocity=2, cells=(2, 2, 3), contacts=Contacts(), end=1e-3)
    case = box.make(tmp_path_factory.mktemp("bad") / "scene")
    law = {"type": "RosinRammler", "d63": 9e-4, "n": 3, "min": 3e-4, "max": 2e-3}
    quartz = {"quartz": material(2650, **law)["solid"]}
    add_feed(case, {"loading": 0.1, "particles": 50, "drainTime": 1, "materials": quartz})
    (case / "system/blockMeshDict").unlink()
    run_program(["elutriaFoam"], case)
    shutil.rmtree(case / "postProcessing")
    shutil.rmtree(case / "0.001")  # the fields of the start are read again
    return case


def inputs(seed: int) -> list[malformed.Input]:
    draw = random.Random(seed)
    made = [i for i in malformed.entry_inputs(draw)
            if i.file != malformed.PARAMETERS and i.kind not in NOT_HERE]  # fmt: skip
    for file in FILES:
        made += [i for i in malformed.file_inputs(draw, file, "dictionary") if i.kind not in NO_END]
    made += [i for i in malformed.mesh_inputs(draw) if i.kind not in NO_END]
    return made


def processor_s() -> float:
    """Processor time (s) of the programs that this process has started and that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def start(case: Path) -> tuple[int, str]:
    """Exit code (-1: took too long) and the line that says why. The time allowed is the program's
    processor time, so that others on the machine do not count; a program that waits for ever ends
    by the wall's clock."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CORE, (resource.getrlimit(resource.RLIMIT_CORE)[1],) * 2)
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS + 1, SECONDS + 1))

    before = processor_s()
    try:
        done = subprocess.run(
            ["elutriaFoam"], cwd=case, capture_output=True, text=True, errors="replace",
            check=False, timeout=PATIENCE, preexec_fn=limit,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return -1, f"waited for {PATIENCE} s"
    if processor_s() - before > SECONDS:
        return -1, f"took {processor_s() - before:.1f} s of processor, allowed: {SECONDS}"
    said = [line for line in done.stdout.splitlines() if line.startswith("elutria: failed:")]
    return done.returncode, said[-1] if said else (done.stdout + done.stderr)[-200:]


def check(scene: Path, place: Path, chosen: list[malformed.Input]) -> None:
    wrong = []
    for given in chosen:
        case = place / "case"
        shutil.copytree(scene, case)
        given.spoil(case)
        code, said = start(case)
        named = Path(given.file).name in said or (given.entry and given.entry in said)
        good = code == 2 and said.startswith("elutria: failed:") and not list(case.glob("core*"))
        outcome = ("named" if named else "refused") if good else "WRONG"
        malformed.outcomes[given.kind, "elutriaFoam", outcome] += 1
        if not good:
            wrong.append(f"{given}: code {code}: {said[:250]}")
        shutil.rmtree(case)
    assert not wrong, f"{len(wrong)} of {len(chosen)}:\n" + "\n".join(wrong)


def test_some_malformed_cases(scene: Path, tmp_path: Path) -> None:
    check(scene, tmp_path, random.Random(5).sample(inputs(5), 12))


@pytest.mark.parametrize(
    ("entry", "value"),
    [("constant/transportProperties:rho.air", -1.2), ("constant/transportProperties:nu", 0),
     (f"{CONTROL}:deltaT", -1)],
)  # fmt: skip
def test_what_must_be_positive(scene: Path, tmp_path: Path, entry: str, value: float) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    change(case, {entry: value})
    code, said = start(case)
    assert code == 2
    assert entry.split(":")[1] in said
    assert "allowed: above 0" in said


CONSTANTS = f"{malformed.CLOUD}:constantProperties"


@pytest.mark.parametrize(
    ("entry", "value", "said"),
    [
        (f"{CONTROL}:maxCo", -4, "maxCo is -4, allowed: > 0"),
        (f"{CONTROL}:maxDeltaT", 0, "maxDeltaT is 0, allowed: > 0"),
        (f"{CONTROL}:writePrecision", 0, "writePrecision is 0, allowed: 1 or more"),
        (f"{CONTROL}:writeFormat", "bynary", "writeFormat is bynary, allowed: ascii, binary"),
        (f"{CONTROL}:endTime", -1, "endTime is -1, allowed: >= 0"),
        (f"{CONSTANTS}/alphaMax", 2, "alphaMax is 2, allowed: above 0, up to 1"),
        (f"{CONTACTS}/particle/youngsModulus", 1e300, "allowed: above 0, up to 1e24 Pa"),
        (f"{malformed.FEED}:duration", 1e300, "allowed: above 0, up to 1000000000"),
    ],
    ids=lambda given: str(given).rpartition(":")[2],
)
def test_what_no_run_can_follow(
    scene: Path, tmp_path: Path, entry: str, value: Any, said: str
) -> None:
    """OpenFOAM takes these without a word, or the solver ended with another."""
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    change(case, {entry: value})
    code, found = start(case)
    assert code == 2, found
    assert said in found


def test_gas_that_starts_too_fast(scene: Path, tmp_path: Path) -> None:
    case = from_the_start(scene, tmp_path / "case")
    change(case, {"0/U.air:internalField": [0, 0, 1e300]})
    code, said = start(case)
    assert code == 2, said
    assert "0/U.air: internalField has " in said


@pytest.fixture(scope="module")
def turbulent(scene: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scene before its step, with k-epsilon turbulence."""
    case = from_the_start(scene, tmp_path_factory.mktemp("turbulent") / "scene")
    set_turbulence(case, 0.1, 1.0, wall_functions=True)
    return case


def test_what_openfoam_takes_without_a_word(turbulent: Path, tmp_path: Path) -> None:
    sound = tmp_path / "sound"
    shutil.copytree(turbulent, sound)
    assert start(sound)[0] == 0
    check(turbulent, tmp_path, list(malformed.silent_inputs("0")))


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [("k.air", "inflow { type fixedValue; value uniform 0.1; }", "0.1", "-0.1"),
     ("epsilon.air", "inflow { type fixedValue; value uniform 1; }", "uniform 1", "uniform 0")],
)  # fmt: skip
def test_turbulence_that_is_given_at_an_inlet(
    turbulent: Path, tmp_path: Path, file: str, old: str, new: str, said: str
) -> None:
    case = tmp_path / "case"
    shutil.copytree(turbulent, case)
    text = (case / "0" / file).read_text()
    sound = re.sub(r"inflow\s*\{[^}]*\}", old, text)
    assert sound != text
    (case / "0" / file).write_text(sound)
    code, found = start(case)
    assert code == 0, found
    shutil.rmtree(case / "0.001")
    (case / "0" / file).write_text(sound.replace(old, old.replace(new, said)))
    code, found = start(case)
    assert code == 2, found
    assert f"0/{file}: bottom has " in found


def test_turbulence_that_no_model_reads_may_be_anything(turbulent: Path, tmp_path: Path) -> None:
    case = tmp_path / "case"
    shutil.copytree(turbulent, case)
    text = (case / "0/epsilon.air").read_text().replace("epsilon.air", "omega.air")
    text = re.sub(r"dimensions\s[^;]*;", "dimensions [0 0 -1 0 0 0 0];", text)
    text = re.sub(r"internalField\s[^;]*;", "internalField uniform 0;", text)
    text = re.sub("epsilonWallFunction", "omegaWallFunction", text)
    (case / "0/omega.air").write_text(text)
    code, said = start(case)
    assert code == 0, said
    change(case, {"constant/turbulenceProperties.air:RAS/RASModel": "kOmegaSST",
                  "system/fvSchemes:wallDist": {"method": "meshWave"}})  # fmt: skip
    shutil.rmtree(case / "0.001")
    code, said = start(case)
    assert code == 2, said
    assert "0/omega.air: internalField has 0, allowed: above 0" in said


def test_a_function_that_is_asked_for_is_made_once(turbulent: Path, tmp_path: Path) -> None:
    """The plan leaves nothing of it; a run has its file."""
    case = tmp_path / "case"
    shutil.copytree(turbulent, case)
    change(
        case,
        {
            f"{CONTROL}:functions": {
                "most": {
                    "type": "fieldMinMax",
                    "libs": ['"libfieldFunctionObjects.so"'],
                    "fields": ["U.air"],
                }
            }
        },
    )
    before = {path.name for path in case.iterdir()}
    solve(case, options=["-plan"])
    assert {path.name for path in case.iterdir()} - before <= {"postProcessing", "log.elutriaFoam"}
    assert not (case / "postProcessing/most").exists()
    assert start(case)[0] == 0
    (file,) = (case / "postProcessing/most").rglob("*.dat")
    assert file.name == "fieldMinMax.dat"
    assert len(file.read_text().splitlines()) > 2


def test_a_mesh_that_is_inside_out(scene: Path, tmp_path: Path) -> None:
    case = from_the_start(scene, tmp_path / "case")
    points = case / "constant/polyMesh/points"
    head, brace, body = points.read_text().partition("}")
    mirrored = re.sub(r"\((\S+) (\S+) (\S+)\)", r"(-\1 \2 \3)", body)
    assert mirrored != body
    points.write_text(head + brace + mirrored)
    code, said = start(case)
    assert code == 2, said
    assert "constant/polyMesh: a cell has -" in said


def test_an_entry_that_stands_twice(scene: Path, tmp_path: Path) -> None:
    """OpenFOAM takes the last one, and all of two dictionaries. In a file of ours it is an error;
    alternatives are none."""
    case = from_the_start(scene, tmp_path / "case")
    with (case / malformed.CLOUD).open("a") as file:
        file.write("\nsubModels { dispersionModel none; particleForces { gravity {} } mine 1; }\n")
    solve(case, options=["-plan"])
    plan = json.loads((case / "postProcessing/plan.json").read_text())
    said = {row[1]: row[2] for row in plan["decisions"] if row[0] == "not used"}
    assert set(said) == {f"{malformed.CLOUD}: subModels/dispersionModel"}
    assert "the last rules" in said[f"{malformed.CLOUD}: subModels/dispersionModel"]
    text = (case / malformed.FEED).read_text()
    (case / malformed.FEED).write_text(text + "\n#ifeq 1 1\nvelocity (0 0 0);\n#else\n"
                                       "velocity (1 0 0);\n#endif\n")  # fmt: skip
    assert start(case)[0] == 0
    shutil.rmtree(case / "0.001")
    (case / malformed.FEED).write_text(text + "\nmaterials { quartz { density 2000; } }\n")
    code, found = start(case)
    assert code == 2
    assert "materials stands there twice" in found


def test_a_file_of_ours_that_need_not_be_there(scene: Path, tmp_path: Path) -> None:
    case = from_the_start(scene, tmp_path / "case")
    (case / "system/scenePlan").unlink()
    code, said = start(case)
    assert code == 0, said


@pytest.mark.parametrize("form", ["ascii", "binary"])
def test_an_entry_of_a_field_that_stands_twice(scene: Path, tmp_path: Path, form: str) -> None:
    """Of a value the last one rules, of a patch all of both, the last one first."""
    case = from_the_start(scene, tmp_path / "case")
    change(case, {f"{CONTROL}:writeFormat": form})
    run_program(["setFields"], with_values(case, "U.air"))
    field = case / "0/U.air"
    before, patches, after = field.read_bytes().partition(b"boundaryField\n{")
    again = b"west { type noSlip; }\n"
    field.write_bytes(before + b"dimensions [0 1 -1 0 0 0 0];\n" + patches + again + after)
    solve(case, options=["-plan"])
    plan = json.loads((case / "postProcessing/plan.json").read_text())
    said = [row[1] for row in plan["decisions"] if row[0] == "not used"]
    assert sorted(said) == ["0/U.air: boundaryField/west/type", "0/U.air: dimensions"]


def with_values(case: Path, field: str) -> Path:
    """Let setFields write a value for each cell of the field, which is not what it begins with."""
    (case / "system/setFieldsDict").write_text(
        "FoamFile { version 2.0; format ascii; class dictionary; object setFieldsDict; }\n"
        f"defaultFieldValues ( volVectorFieldValue {field} (0 0 2) );\n"
        "regions ( boxToCell { box (0 0 0) (1 1 0.05);"
        f" fieldValues ( volVectorFieldValue {field} (0 0 2.5) ); }} );\n"
    )
    return case


def test_an_entry_of_the_meshers_that_stands_twice(scene: Path, tmp_path: Path) -> None:
    case = from_the_start(scene, tmp_path / "case")
    (case / "system/blockMeshDict").write_text(
        (TEMPLATE / "system/blockMeshDict").read_text() + "\nscale 1;\nscale 2;\n"
    )
    solve(case, options=["-plan"])
    plan = json.loads((case / "postProcessing/plan.json").read_text())
    said = [row[1] for row in plan["decisions"] if row[0] == "not used"]
    assert said == ["system/blockMeshDict: scale"]


@pytest.mark.parametrize(
    "beside",
    ["// the column #c of the drawing", 'deep #calc "system(\\"touch made\\"), 0.1";',
     "deep #codeStream { code #{ system(\"touch made\"); os << 0.1; #}; };"],
)  # fmt: skip
def test_code_of_a_mesh_hides_no_other_entry(scene: Path, tmp_path: Path, beside: str) -> None:
    """It is not executed, and the rest is looked at."""
    case = from_the_start(scene, tmp_path / "case")
    text = (TEMPLATE / "system/blockMeshDict").read_text()
    (case / "system/blockMeshDict").write_text(f"{text}\n{beside}\n")
    assert start(case)[0] == 0
    shutil.rmtree(case / "0.001")
    (case / "system/blockMeshDict").write_text(f"{text}\n{beside}\nscale -1;\n")
    code, said = start(case)
    assert code == 2, said
    assert "scale is -1, allowed: > 0" in said
    assert not (case / "made").exists()


def test_code_of_the_runs_own_files_is_still_executed(scene: Path, tmp_path: Path) -> None:
    """What is left alone is the mesh's code; OpenFOAM refuses to execute any as root."""
    case = from_the_start(scene, tmp_path / "case")
    (case / "system/blockMeshDict").write_text(
        (TEMPLATE / "system/blockMeshDict").read_text() + '\nn #calc "1 + 1";\n'
    )
    solution = case / "system/fvSolution"
    text, places = re.subn(r"(nCorrectors +)\d", r'\1#calc "1 + 1"', solution.read_text())
    assert places == 1
    solution.write_text(text)
    code, said = start(case)
    if os.geteuid() == 0:
        assert code == 2
        assert "should not be executed" in said
    else:
        assert code == 0, said


def test_a_misspelt_entry_behind_an_expression(scene: Path, tmp_path: Path) -> None:
    case = from_the_start(scene, tmp_path / "case")
    text = (case / malformed.FEED).read_text()
    spoiled = re.sub(r"velocity\s+[^;]*;", "velocity (#eval{ 0.25 * 2 } 0 0);\ndrainTme 3;", text)
    assert spoiled != text
    (case / malformed.FEED).write_text(spoiled)
    code, said = start(case)
    assert code == 2, said
    assert "drainTme is not an entry of" in said


@pytest.mark.parametrize("file", ["system/scenePlan", "constant/fvOptions"])
def test_a_folder_in_the_place_of_a_file(scene: Path, tmp_path: Path, file: str) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    (case / file).unlink(missing_ok=True)
    (case / file).mkdir()
    code, said = start(case)
    assert code == 2, said
    assert f"{file}: is a folder; allowed: a file" in said


@pytest.mark.parametrize("form", ["ascii", "binary"])
def test_a_mesh_names_only_what_is_there(tmp_path: Path, form: str) -> None:
    """Of the lists of cells, and of the points of faces, in both forms of the files."""
    case = BoxCase(gas_velocity=1, cells=(2, 2, 3), end=1e-3).make(tmp_path / "case")
    change(case, {f"{CONTROL}:writeFormat": form})
    run_program(["blockMesh"], case)
    assert start(case)[0] == 0
    for name in ("owner", "neighbour", "faces"):
        file = case / "constant/polyMesh" / name
        sound = file.read_bytes()
        head, body = sound.split(b"}", 1)
        if form == "ascii":
            spoiled = re.sub(rb"(\(\s*(?:\d+\()?)\d+", rb"\g<1>77", body, count=1)
        else:  # the last label of the last list
            end = body.rindex(b")")
            spoiled = body[: end - 4] + (77).to_bytes(4, "little") + body[end:]
        file.write_bytes(head + b"}" + spoiled)
        code, said = start(case)
        assert code == 2
        assert f"constant/polyMesh/{name}: 77; allowed: 0 to" in said
        file.write_bytes(sound)


@pytest.mark.parametrize("file", [CONTROL, "constant/transportProperties", "0/U.air"])
def test_a_file_that_is_longer_than_its_kind_is_refused(
    scene: Path, tmp_path: Path, file: str
) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    with (case / file).open("a") as stream:
        stream.write("a 1;\n" * 1_200_000)
    code, said = start(case)
    assert code == 2
    assert file in said
    assert "has 6 MB; allowed: 5" in said


def test_a_material_named_as_all_together(scene: Path, tmp_path: Path) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    text = (case / malformed.FEED).read_text()
    (case / malformed.FEED).write_text(text.replace("quartz", "all"))
    code, said = start(case)
    assert code == 2
    assert "a material is named all" in said


def test_a_cloud_that_is_switched_off(scene: Path, tmp_path: Path) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    change(case, {f"{CLOUD}:solution/active": False})
    code, said = start(case)
    assert code == 2
    assert "constant/kinematicCloudProperties.solution" in said
    assert "active is no: no particle would move, allowed: yes" in said


def test_a_feed_that_is_not_there_is_named(scene: Path, tmp_path: Path) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    (case / "constant/feed").unlink()
    code, said = start(case)
    assert code == 2
    assert "constant/feed: file not found; injection model feed" in said


@pytest.mark.parametrize("parcels", ["evenMass", "evenSizes"])
def test_stock_refuses_weighted_parcels_by_their_name(
    scene: Path, tmp_path: Path, parcels: str
) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    change(case, {f"{malformed.FEED}:parcels": parcels, f"{malformed.FEED}:duration": 0.1})
    change(case, {f"{CONTROL}:libs": ["libelutriaCollision.so"], f"{CONTROL}:endTime": 3e-3})
    done = subprocess.run(["DPMFoam"], cwd=case, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert f"parcels is {parcels}, allowed in this solver: particles" in done.stdout + done.stderr


def test_a_memory_fault_while_reading_does_not_blame_the_mesh(scene: Path, tmp_path: Path) -> None:
    """The run waits for an included file, a pipe that nobody writes to, when the fault comes."""
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    os.mkfifo(case / "constant/pipe")
    with (case / "constant/transportProperties").open("a") as file:
        file.write('\n#include "pipe"\n')
    with subprocess.Popen(["elutriaFoam"], cwd=case, stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None
        for line in run.stdout:
            if line.startswith("Create mesh"):
                break
        time.sleep(1)
        run.send_signal(signal.SIGSEGV)
        said = run.stdout.read()
    assert run.returncode == 2
    assert "memory fault while the case was read" in said
    assert "a defect of elutriaFoam" in said


PAIR = {"restitution": 0.8, "friction": 0.2}


@pytest.mark.parametrize(
    ("material", "pairs", "said"),
    [
        (
            "quartz",
            ("quartz-west", "west-quartz"),
            "quartz-west and west-quartz, allowed: one",
        ),
        ("west", ("west-west",), "west-west is the name of two pairs of materials and walls"),
    ],
)
def test_pairs_of_materials_are_told_apart(
    scene: Path, tmp_path: Path, material: str, pairs: tuple[str, ...], said: str
) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    feed = case / malformed.FEED
    feed.write_text(re.sub(r"\bquartz\b", material, feed.read_text()))
    change(case, {f"{CONTACTS}/pairs": dict.fromkeys(pairs, PAIR)})
    code, told = start(case)
    assert code == 2, told
    assert said in told
    assert "kinematicCloudProperties" in told


SIZES = f"{malformed.FEED}:materials/quartz/sizeDistribution"
FORCES = f"{MODELS}/particleForces"
MISSPELT = [
    (f"{malformed.FEED}:drainTme", 1, "drainTme"),
    (f"{malformed.FEED}:materials/quartz/sphericty", 0.9, "sphericty"),
    (f"{SIZES}/wieghting", "number", "wieghting"),
    (f"{SIZES}/d50", 1e-3, "d50"),  # not of RosinRammler
    ("system/scenePlan:gass", "on", "gass"),
    ("system/frames:perSecnd", 1, "perSecnd"),
    ("system/steering:chnges", 1, "chnges"),
    (f"{CLOUD}:ownWake", {"undisturbd": False}, "undisturbd"),
    (f"{CLOUD}:selfInducedVelocity", {"corect": False}, "corect"),
    (f"{CLOUD}:spreading", {"widht": 0}, "widht"),
    (f"{CLOUD}:spredding", {"width": 0}, "spredding"),
    (f"{CONTACTS}/treatmnt", "soft", "treatmnt"),
    (f"{CONTACTS}/particle/poisonsRatio", 0.3, "poisonsRatio"),
    (f"{CONTACTS}/particleWall/rollingfriction", 0.1, "rollingfriction"),
    (f"{CONTACTS}/pairs", {"solid-wst": {"restitution": 0.8, "friction": 0}}, "solid-wst"),
    (FORCES, {"GidaspowDrag": {"alphaC": "alpha.air"}}, "alphaC"),
    (FORCES, {"SchillerNaumannDrag": {"sphericty": 0.9}}, "sphericty"),
    (f"{MODELS}/continuousDispersionRASCoefs", {"beta": 0}, "continuousDispersionRASCoefs"),
]


@pytest.mark.parametrize(("entry", "value", "wrong"), MISSPELT, ids=[row[2] for row in MISSPELT])
def test_a_misspelt_entry_of_ours_is_named(
    scene: Path, tmp_path: Path, entry: str, value: Any, wrong: str
) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    change(case, {entry: value})
    code, said = start(case)
    assert code == 2, said
    assert f"{wrong} is not an entry of" in said
    assert ", allowed: " in said
    assert Path(entry.partition(":")[0]).name in said


@pytest.mark.parametrize("coefficients", [{}, {"alphac": "alpha.gas"}])
def test_a_law_of_suspensions_needs_the_void_fraction(
    scene: Path, tmp_path: Path, coefficients: dict[str, str]
) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    change(case, {f"{MODELS}/particleForces": {"GidaspowDrag": coefficients, "gravity": {}}})
    code, said = start(case)
    assert code == 2
    assert "alphac" in said
    assert "alpha.air" in said
    change(case, {f"{MODELS}/particleForces": {"GidaspowDrag": {"alphac": "alpha.air"}}})
    assert start(case)[0] == 0


def test_entries_of_others_are_left_alone(scene: Path, tmp_path: Path) -> None:
    """What OpenFOAM's models read, and variables in a file that is included."""
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    change(case, {f"{CLOUD}:constantProperties/parcelTypeId": 3, f"{CLOUD}:myOwn": 1})
    (case / "constant/mine").write_text("drainTme 3;\nrhoOfMine 2650;\n")
    for file in ("constant/feed", "system/scenePlan"):
        text = (case / file).read_text()
        (case / file).write_text(text + '\n#include "../constant/mine"\n')
    code, said = start(case)
    assert code == 0, said


def test_an_outlet_that_is_a_wall_and_an_open_patch_without_a_product(
    scene: Path, tmp_path: Path
) -> None:
    case = tmp_path / "case"
    shutil.copytree(scene, case)
    change(case, {f"{malformed.FEED}:outlets": {"fines": ["top"], "coarse": ["bottom", "west"]}})
    code, said = start(case)
    assert code == 2
    assert "coarse: the patch west has the type wall, through which nothing leaves" in said
    change(case, {f"{malformed.FEED}:outlets": {"fines": ["top"]}})
    code, said = start(case)
    assert code == 2
    assert "constant/feed" in said
    assert "the open patch bottom belongs to no product" in said
    assert "allowed: its name in fines, in a product other (bottom)" in said
    change(case, {f"{malformed.FEED}:outlets/other": ["bottom"]})
    assert start(case)[0] == 0


def from_the_start(scene: Path, case: Path) -> Path:
    """A copy of the scene before its step."""
    shutil.copytree(scene, case)
    for written in times(case):
        if float(written) > 0:
            shutil.rmtree(case / written)
    return case


def test_lost_parcels_are_an_error_that_names_the_patch(scene: Path, tmp_path: Path) -> None:
    """Walls that let particles out: nothing tells it before."""
    case = from_the_start(scene, tmp_path / "case")
    change(case, {f"{MODELS}/collisionModel": "none",
                  f"{MODELS}/multiInteractionCoeffs": {
                      "oneInteractionOnly": True,
                      "one": {"patchInteractionModel": "standardWallInteraction",
                              "standardWallInteractionCoeffs": {"type": "escape"}}},
                  f"{MODELS}/patchInteractionModel": "multiInteraction",
                  f"{malformed.FEED}:velocity": [30, 0, 0], f"{malformed.FEED}:particles": 20,
                  f"{malformed.FEED}:massFlowRate": 1, f"{CONTROL}:endTime": 0.02,
                  f"{CONTROL}:writeInterval": 0.02})  # fmt: skip
    text = (case / malformed.FEED).read_text()
    (case / malformed.FEED).write_text(re.sub(r"loading [^;]*;", "", text))
    code, said = start(case)
    ledger = json.loads((case / "postProcessing/ledger.json").read_text())["total"]
    lost = ledger["lost"]
    assert lost["parcels"] > 0
    assert code == 1, said
    told = re.search(r"failed: (\d+) parcels, (\S+) kg", said)
    assert told
    assert int(told[1]) == lost["parcels"]
    assert float(told[2]) == pytest.approx(lost["mass_kg"], rel=1e-6)
    assert f"{lost['parcels']} left through the patch " in said
    # the tables agree with the ledger, and are an error of the tool too
    assert read_run(case).accounts["all"].mass_closure_error == pytest.approx(
        ledger["mass_closure_error"], rel=1e-9
    )
    assert ledger["mass_closure_error"] == pytest.approx(
        lost["mass_kg"] / ledger["injected"]["mass_kg"], rel=1e-9
    )


def test_warnings_are_kept_over_a_restart(scene: Path, tmp_path: Path) -> None:
    """Contacts far too soft: said before the run and in its steps, in both starts."""
    case = from_the_start(scene, tmp_path / "case")
    change(case, {f"{CONTACTS}/treatment": "soft", f"{CONTACTS}/particle/youngsModulus": 1e4,
                  f"{CONTACTS}/wall/youngsModulus": 1e4, f"{CONTROL}:startFrom": "latestTime",
                  f"{CONTROL}:writeInterval": 1e-3})  # fmt: skip
    file = case / "warnings.json"
    assert start(case)[0] == 0
    (first,) = [w for w in json.loads(file.read_text()) if w["name"] == "stiffness"]
    assert first["times"] == 1
    assert first["first_time_s"] == 0
    file.unlink()
    change(case, {f"{CONTROL}:endTime": 2e-3})
    assert start(case)[0] == 0
    (again,) = [w for w in json.loads(file.read_text()) if w["name"] == "stiffness"]
    assert (again["first_time_s"], again["last_time_s"], again["times"]) == (0, 1e-3, 2)
    plan = json.loads((case / "postProcessing/plan.json").read_text())
    assert f"{again['what']}: {again['how_much']}; {again['what_to_set']}" in plan["warnings"]


def test_a_variable_loading_beside_a_mass_flow_rate(scene: Path, tmp_path: Path) -> None:
    """system/simulationParameters, which the feed includes, may name a variable so."""
    case = from_the_start(scene, tmp_path / "case")
    text = re.sub(r"loading [^;]*;", "massFlowRate 0.25;", (case / malformed.FEED).read_text())
    (case / malformed.FEED).write_text(text + '\n#include "variables"\n')
    (case / "constant/variables").write_text("loading 0.2;\n")
    code, said = start(case)
    assert code == 0, said
    plan = json.loads((case / "postProcessing/plan.json").read_text())
    assert plan["feed"]["rate_kg_s"] == 0.25
    shutil.rmtree(case / "0.001")
    (case / malformed.FEED).write_text(text + "\nloading 0.2;\n")
    code, said = start(case)
    assert code == 2
    assert "give either loading" in said


@pytest.mark.slow
def test_all_malformed_cases(scene: Path, tmp_path: Path) -> None:
    check(scene, tmp_path, inputs(1))
