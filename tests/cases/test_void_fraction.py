"""The gas makes room for a particle as fast as the particle comes, not within a time step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elutria_validation.harness.scene import (
    BOX,
    CLOUD,
    CONTROL,
    MODELS,
    Particles,
    add_feed,
    add_zone,
    make_scene,
    read_gas,
    run_scene,
    times,
)

CELL, DIAMETER, SPEED = 5e-3, 2e-3, 0.1


def gas_at_rest(step: float, steps: int) -> dict[str, Any]:
    """8 x 8 x 8 cells of gas at rest that feels the particles' volume and not their drag."""
    return {
        **{f"{BOX}:{name}": 8 * CELL for name in ("width", "depth", "height")},
        f"{BOX}:cellsAcross": 8,
        f"{BOX}:cellsAlong": 8,
        f"{BOX}:gasVelocity": 0,
        f"{BOX}:gravity": 0,
        f"{CLOUD}:solution/coupled": True,
        f"{CLOUD}:spreading": {"width": 0},
        f"{MODELS}/particleForces": {},
        "system/scenePlan:gas": True,
        "system/scenePlan:convergeGas": False,
        f"{CONTROL}:deltaT": step,
        f"{CONTROL}:endTime": steps * step,
        f"{CONTROL}:writeInterval": step,
    }


def fastest_gas(case: Path) -> float:
    return max(float(np.linalg.norm(read_gas(case, t), axis=1).max()) for t in times(case)[1:])


@pytest.mark.parametrize("step", [1e-4, 1e-5])
def test_a_particle_that_changes_cells(tmp_path: Path, step: float) -> None:
    start = Particles.of(
        [4 * CELL - 5.5 * step * SPEED, 3.4 * CELL, 3.3 * CELL], [SPEED, 0, 0], diameter=DIAMETER
    )
    case = make_scene(tmp_path / "case", start, gas_at_rest(step, 10))
    run_scene(case)
    assert fastest_gas(case) < SPEED
    void = read_gas(case, times(case)[-1], "alpha.air")
    solid = (1 - void).sum() * CELL**3
    assert solid == pytest.approx(np.pi / 6 * DIAMETER**3, rel=1e-5)
    assert np.count_nonzero(void < 1) == 2


def test_particles_that_appear_and_leave(tmp_path: Path) -> None:
    """Fed into the gas, and out through the top: no gas makes room for either."""
    step = 1e-5
    case = make_scene(tmp_path / "case", settings=gas_at_rest(step, 150))
    add_zone(case, "near", [0, 0, 7 * CELL], [8 * CELL, 8 * CELL, 8 * CELL])
    sizes = {"type": "fixedValue", "value": DIAMETER}
    solid = {"density": 2650, "massFraction": 1, "sizeDistribution": sizes}
    add_feed(case, {"zone": "near", "velocity": [0, 0, 5], "particles": 20,
                    "massFlowRate": 20 * 2650 * np.pi / 6 * DIAMETER**3 / 0.0003,
                    "materials": {"solid": solid}})  # fmt: skip
    log = run_scene(case)
    assert "fines 20" in log
    assert fastest_gas(case) < 0.5
