"""OpenFOAM's own fluidised bed runs with nothing but its collision model changed."""

from __future__ import annotations

from pathlib import Path

import pytest

from elutria_validation.harness.cases import CONTROL, MODELS, change, read_patch_mean, solve
from elutria_validation.harness.goldschmidt import (
    GAS_DENSITY,
    STEP,
    TUTORIAL,
    copy_tutorial,
    make_bed,
    tutorials,
)
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


@pytest.mark.slow
@pytest.mark.skipif(not TUTORIAL.is_dir(), reason="OpenFOAM's tutorials are not installed")
def test_stocks_collision_model_gives_the_gas_all_it_gathered(tmp_path: Path) -> None:
    """The pressure drop of the bed with the tutorial's pairCollision is that with our contacts."""
    drops = {}
    for ours in (False, True):
        case = make_bed(tmp_path / f"{ours}", "elutriaFoam", STEP, ours)
        change(case, {f"{CONTROL}:endTime": 30 * STEP, f"{CONTROL}:writeInterval": 30 * STEP})
        run_program(["blockMesh"], case)
        solve(case)
        drops[ours] = read_patch_mean(case, "bottom")[-1, 1] * GAS_DENSITY  # Pa
    assert drops[False] == pytest.approx(drops[True], rel=0.02)
    assert drops[True] > 300


def test_the_tutorials_are_those_of_the_sourced_openfoam(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("FOAM_TUTORIALS", str(tmp_path))
    assert tutorials() == tmp_path
    monkeypatch.delenv("FOAM_TUTORIALS")
    assert "openfoam-examples" in tutorials().parts
