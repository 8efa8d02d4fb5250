"""Meshes of two dimensions: what cannot be right there is refused in one line."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from elutria.case.case import PARAMETERS, Case
from elutria.classification.classify import fit_events
from elutria.classification.events import read_run
from elutria.running.run import run_case
from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import MODELS, change
from elutria_validation.harness.programs import run_program

WEDGE = """FoamFile { version 2.0; format ascii; class dictionary; object blockMeshDict; }
vertices ((0 0 0) (X -Y 0) (X Y 0) (0 0 0.1) (X -Y 0.1) (X Y 0.1));
blocks (hex (0 1 2 0 3 4 5 3) (3 1 6) simpleGrading (1 1 1));
edges ();
boundary (
    south { type wedge; faces ((0 1 4 3)); } north { type wedge; faces ((0 3 5 2)); }
    bottom { type patch; faces ((0 2 1 0)); } top { type patch; faces ((3 4 5 3)); }
    west { type wall; faces ((1 2 5 4)); } axis { type empty; faces ((0 3 3 0)); }
);
"""


def box(folder: Path, kind: str) -> Path:
    """A box of gas with contacts, one cell deep, whose front and back are patches of a kind."""
    case = BoxCase(
        gas_velocity=1, cells=(3, 1, 3), contacts=Contacts(), step=1e-3, end=2e-3
    ).make(folder)  # fmt: skip
    mesh = case / "system/blockMeshDict"
    sides = re.sub(
        r"((south|north) +\{ type )\$(?:sides|northType)", rf"\1{kind}", mesh.read_text()
    )
    mesh.write_text(sides)
    for field in (case / "0").glob("[Up]*"):
        text = field.read_text().rstrip().removesuffix("}")
        field.write_text(f"{text}    empty {{ type empty; }}\n}}\n")
    run_program(["blockMesh"], case)
    return case


def ending(case: Path) -> tuple[int, list[str]]:
    """Exit code, and the lines that say why."""
    done = subprocess.run(["elutriaFoam"], cwd=case, capture_output=True, text=True, check=False)
    return done.returncode, re.findall(r"elutria: failed: .*", done.stdout)


def test_contacts_in_a_flat_mesh_are_refused(tmp_path: Path) -> None:
    case = box(tmp_path / "flat", "empty")
    code, (said,) = ending(case)
    assert code == 2
    for part in ("boundary", "patch south is empty", "allowed: cyclic or symmetryPlane"):
        assert part in said
    change(case, {f"{MODELS}/collisionModel": "none"})
    assert ending(case) == (0, [])


@pytest.mark.parametrize("kind", ["cyclic", "symmetry"])
def test_what_is_allowed_instead_runs(tmp_path: Path, kind: str) -> None:
    assert ending(box(tmp_path / kind, kind)) == (0, [])


def test_a_wedge_is_refused(tmp_path: Path) -> None:
    case = BoxCase(gas_velocity=1, contacts=None).make(tmp_path / "wedge")
    half = math.radians(2.5)
    corners = {"X": f"{0.05 * math.cos(half):.9f}", "Y": f"{0.05 * math.sin(half):.9f}"}
    text = re.sub(r"\b[XY]\b", lambda found: corners[found[0]], WEDGE)
    (case / "system/blockMeshDict").write_text(text)
    run_program(["blockMesh"], case)
    code, (said,) = ending(case)
    assert code == 2
    assert "patch south is wedge" in said
    assert "symmetryPlane" in said


def cyclic_column(column: Path, cells: int) -> Path:
    """The default column, front and back cyclic, so many cells deep."""
    plan = column / "system/blockMeshDict"
    text = re.sub(r"\(10 10 (\d+)\)", rf"(10 {cells} \1)", plan.read_text())
    front, back = "(0 1 5 4)  (4 5 9 8)   (8 9 13 12)", "(3 7 6 2)  (7 11 10 6) (11 15 14 10)"
    assert front in text and back in text
    text = text.replace(front, "").replace(back, "")
    pair = "".join(
        f"    {name} {{ type cyclic; neighbourPatch {other}; faces ({faces}); }}\n"
        for name, other, faces in (("front", "back", front), ("back", "front", back))
    )
    end = text.index(");\n\nmergePatchPairs")
    plan.write_text(text[:end] + pair + text[end:])
    for field in (column / "0.orig").iterdir():
        text = field.read_text().rstrip().removesuffix("}")
        field.write_text(f'{text}    "front|back" {{ type cyclic; }}\n}}\n')
    return column


@pytest.mark.slow
def test_a_flat_mesh_with_cyclic_sides_cuts_as_a_deep_one(column: Path, tmp_path: Path) -> None:
    """One cell deep as ten: within chance. As empty patches, where all centres lay in one plane, it
    cut at 1168 instead of 842 um."""
    found = {}
    for cells in (1, 10):
        shutil.copytree(column, tmp_path / f"{cells}")
        case = Case(cyclic_column(tmp_path / f"{cells}", cells))
        settings = case.settings_for(6, [f"{PARAMETERS}:particles=1500"])
        run = run_case(case, tmp_path / f"run{cells}", settings)
        found[cells] = fit_events(read_run(run.path).events).sizes[0.5]
    half = {cells: math.log(high / low) / 2 for cells, (_, low, high) in found.items()}
    assert max(half.values()) < 0.02
    apart = math.log(found[1][0] / found[10][0])
    assert abs(apart) < math.hypot(*half.values()), found
    assert found[1][0] == pytest.approx(842e-6, rel=0.02)  # walls all round: 0.7 % coarser
