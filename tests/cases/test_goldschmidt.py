"""OpenFOAM's own fluidised bed runs with nothing but its collision model changed."""

from __future__ import annotations

from pathlib import Path

import pytest

from elutria_validation.harness.cases import CONTROL, MODELS, change, solve
from elutria_validation.harness.goldschmidt import TUTORIAL, copy_tutorial, tutorials
from elutria_validation.harness.programs import run_program


@pytest.mark.skipif(not TUTORIAL.is_dir(), reason="OpenFOAM's tutorials are not installed")
@pytest.mark.parametrize("solver", ["elutriaFoam", "DPMFoam"])
def test_three_steps_of_the_tutorial(tmp_path: Path, solver: str) -> None:
    case = copy_tutorial(tmp_path / "case")
    change(
        case,
        {f"{MODELS}/collisionModel": "cellList", f"{CONTROL}:endTime": 6e-5},
    )
    if solver == "DPMFoam":
        change(case, {f"{CONTROL}:libs": ['"libelutriaCollision.so"']})
    run_program(["blockMesh"], case)
    log = solve(case, solver=solver)
    assert log.count("\nTime = ") == 3
    assert ("inside 24750" in log) or ("Current number of parcels       = 24750" in log)


def test_the_tutorials_are_those_of_the_sourced_openfoam(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("FOAM_TUTORIALS", str(tmp_path))
    assert tutorials() == tmp_path
    monkeypatch.delenv("FOAM_TUTORIALS")
    assert "openfoam-examples" in tutorials().parts
