"""The gas makes room for a particle as fast as the particle comes, not within a time step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elutria_validation.harness.box import BoxCase, cube
from elutria_validation.harness.cases import (
    add_feed,
    add_zone,
    material,
    read_gas,
    solve,
    times,
)
from elutria_validation.harness.particles import Particles

CELL, DIAMETER, SPEED = 5e-3, 2e-3, 0.1


def gas_at_rest(step: float, steps: int) -> BoxCase:
    """8 x 8 x 8 cells of gas at rest that feels the particles' volume and not their drag."""
    return BoxCase(**cube(8 * CELL, 8), gravity=0, coupled=True, kernel=0, forces={},
                   solve_gas=True, step=step, end=steps * step, interval=step)  # fmt: skip


def fastest_gas(case: Path) -> float:
    return max(float(np.linalg.norm(read_gas(case, t), axis=1).max()) for t in times(case)[1:])


@pytest.mark.parametrize("step", [1e-4, 1e-5])
def test_a_particle_that_changes_cells(tmp_path: Path, step: float) -> None:
    start = Particles.of(
        [4 * CELL - 5.5 * step * SPEED, 3.4 * CELL, 3.3 * CELL], [SPEED, 0, 0], diameter=DIAMETER
    )
    case = gas_at_rest(step, 10).make(tmp_path / "case", start)
    solve(case)
    assert fastest_gas(case) < SPEED
    void = read_gas(case, times(case)[-1], "alpha.air")
    solid = (1 - void).sum() * CELL**3
    assert solid == pytest.approx(np.pi / 6 * DIAMETER**3, rel=1e-5)
    assert np.count_nonzero(void < 1) == 2


def test_particles_that_appear_and_leave(tmp_path: Path) -> None:
    """Fed into the gas, and out through the top: no gas makes room for either."""
    step = 1e-5
    case = gas_at_rest(step, 150).make(tmp_path / "case")
    add_zone(case, "near", [0, 0, 7 * CELL], [8 * CELL, 8 * CELL, 8 * CELL])
    add_feed(case, {"zone": "near", "velocity": [0, 0, 5], "particles": 20,
                    "massFlowRate": 20 * 2650 * np.pi / 6 * DIAMETER**3 / 0.0003,
                    "materials": material(2650, type="fixedValue", value=DIAMETER)})  # fmt: skip
    log = solve(case)
    assert "fines 20" in log
    assert fastest_gas(case) < 0.5
