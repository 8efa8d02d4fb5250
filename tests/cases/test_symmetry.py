"""At a plane of symmetry a sphere meets its own mirror image: one radius away, without friction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elutria_validation.harness.scene import (
    BOX,
    CONTACTS,
    CONTROL,
    MODELS,
    Particles,
    make_scene,
    read_particles,
    run_scene,
    times,
)

RADIUS, SPEED = 1e-3, 0.1


@pytest.mark.parametrize("treatment", ["soft", "auto"])
def test_a_sphere_turns_one_radius_before_the_plane(tmp_path: Path, treatment: str) -> None:
    start = Particles.of([3e-3, 5e-3, 5e-3], [-SPEED, 0, 0.02], [0, 5, 0], 2 * RADIUS)
    case = make_scene(
        tmp_path / "case",
        start,
        {
            **{f"{BOX}:{name}": 0.01 for name in ("width", "depth", "height")},
            f"{BOX}:sides": "symmetry",
            f"{BOX}:gravity": 0,
            f"{MODELS}/particleForces": {},
            f"{MODELS}/collisionModel": "cellList",
            f"{CONTACTS}/treatment": treatment,
            f"{CONTROL}:deltaT": 2e-3,
            f"{CONTROL}:endTime": 0.04,
            f"{CONTROL}:writeInterval": 2e-3,
        },
    )
    run_scene(case)
    found = [read_particles(case, t) for t in times(case)[1:]]
    nearest = min(float(p.position[0, 0]) for p in found)
    assert 0.9 * RADIUS < nearest < 1.2 * RADIUS
    end = found[-1]
    assert end.velocity[0] == pytest.approx([0.8 * SPEED, 0, 0.02], rel=0.02)
    assert np.allclose(end.spin[0], [0, 5, 0])
