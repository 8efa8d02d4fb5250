"""A user's function objects, which Debian 13's OpenFOAM cannot start by itself, run."""

from __future__ import annotations

from pathlib import Path

from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import cell_centres, change, patch_mean, read_patch_mean
from elutria_validation.harness.programs import run_program

CELLS = (2, 2, 3)


def test_function_objects_run_in_a_case_and_by_postprocess(tmp_path: Path) -> None:
    box = BoxCase(gas_velocity=2, cells=CELLS, contacts=Contacts(), end=1e-3)
    case = box.make(tmp_path / "case")
    change(case, patch_mean("west", "p"))
    run_program(["elutriaFoam"], case)
    assert len(read_patch_mean(case, "west")) > 0

    centres, _ = cell_centres(case)
    assert len(centres) == CELLS[0] * CELLS[1] * CELLS[2]
