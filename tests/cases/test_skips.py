"""What the plan skips changes nothing it promised to keep, also where it misjudged the scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elutria.bench.stability_scenes import column
from elutria.verification.classification import loaded
from elutria.verification.scene import read_gas, times


@pytest.mark.parametrize(("start", "end"), [(3, 6), (6, 3), (0.1, 5)])
def test_gas_at_rest_wakes_when_its_inlet_changes(tmp_path: Path, start: float, end: float) -> None:
    """A ramp within 0.1 s, and particles too few to be felt."""
    ramp = f"(0 (0 0 {start})) (0.1 (0 0 {start})) (0.2 (0 0 {end})) (9 (0 0 {end}))"
    case, output = column(tmp_path / "case", start, 1e-5, inlet=ramp, end=0.3, particles=20)
    through = read_gas(case, times(case)[-1])[:, 2].mean()
    assert through == pytest.approx(end, rel=0.02)
    assert "left at rest" in output


def test_gas_at_rest_leaves_the_products_as_they_are(tmp_path: Path) -> None:
    """600 grains within 20 % of the cut, solved on every step and as the plan decides."""
    every = loaded(tmp_path / "every", 0.2, "four-way")
    plan = loaded(tmp_path / "plan", 0.2, "four-way", gas="auto")
    assert len(plan) == len(every) == 600
    shares = [float(np.mean(e.select(e.has_left).is_coarse)) for e in (every, plan)]
    chance = 1.96 * (0.5 / 600) ** 0.5  # both products are about equal
    assert shares[0] == pytest.approx(shares[1], abs=chance)
