"""A user's function objects, which Debian 13's OpenFOAM cannot start by itself, run."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

from elutria.case.case import Case
from elutria.openfoam.dictionary import set_entry
from elutria.running.run import make_mesh
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


def test_a_run_that_a_function_stops_is_not_finished_and_goes_on(
    column: Path, tmp_path: Path
) -> None:
    """OpenFOAM's `abort`: the user touches its file while the feed comes in."""
    set_entry(column / "system/simulationParameters", "particles", "100")
    set_entry(column / "system/simulationParameters", "drainTime", "0.5")
    set_entry(column / "system/controlDict", "writeInterval", "0.1")
    with (column / "system/controlDict").open("a") as control:
        control.write('functions { stop { type abort; libs ("libutilityFunctionObjects.so");'
                      ' file "<case>/STOP"; action nextWrite; } }\n')  # fmt: skip
    case = make_mesh_of(column, tmp_path / "case")
    with subprocess.Popen(
        ["elutriaFoam"], cwd=case, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        lines = []
        for line in process.stdout or ():
            lines.append(line)
            if line.startswith("elutria: time"):
                (case / "STOP").touch()
    assert process.returncode == 1
    assert "elutria: finished\n" not in lines
    (failed,) = [line for line in lines if line.startswith("elutria: failed: ")]
    found = re.search(r"stopped at time (\S+) by a function of system/controlDict", failed)
    assert found
    assert float(found[1]) < 1
    assert run_program(["elutriaFoam"], case).endswith("elutria: finished\n")
    ledger = json.loads((case / "postProcessing/ledger.json").read_text())
    assert ledger["total"]["injected"]["parcels"] == 100


def make_mesh_of(source: Path, folder: Path) -> Path:
    case = Case(source).copy_to(folder, [])
    make_mesh(case)
    return case.path
