"""At a plane of symmetry a sphere meets its own mirror image: one radius away, without friction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elutria_validation.harness.box import BoxCase, Contacts, cube
from elutria_validation.harness.cases import solve, times
from elutria_validation.harness.particles import Particles, read_particles

RADIUS, SPEED = 1e-3, 0.1


@pytest.mark.parametrize("treatment", ["soft", "auto"])
def test_a_sphere_turns_one_radius_before_the_plane(tmp_path: Path, treatment: str) -> None:
    start = Particles.of([3e-3, 5e-3, 5e-3], [-SPEED, 0, 0.02], [0, 5, 0], 2 * RADIUS)
    case = BoxCase(
        **cube(0.01), sides="symmetry", gravity=0, forces={}, step=2e-3, end=0.04, interval=2e-3,
        contacts=Contacts(treatment=treatment),
    ).make(tmp_path / "case", start)  # fmt: skip
    solve(case)
    found = [read_particles(case, t) for t in times(case)[1:]]
    nearest = min(float(p.position[0, 0]) for p in found)
    assert 0.9 * RADIUS < nearest < 1.2 * RADIUS
    end = found[-1]
    assert end.velocity[0] == pytest.approx([0.8 * SPEED, 0, 0.02], rel=0.02)
    assert np.allclose(end.spin[0], [0, 5, 0])
