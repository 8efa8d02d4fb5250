"""What the plan skips changes nothing it promised to keep, also where it misjudged the scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elutria.bench.common import project_root
from elutria.bench.stability_scenes import column
from elutria.case import PARAMETERS, Case
from elutria.run import run_case
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


def default_column(
    folder: Path, velocity: float, *settings: str, neighbour: Path | None = None
) -> Case:
    """The default column, run with settings."""
    case = Case(project_root() / "cases/column")
    return run_case(case, folder, case.settings_for(velocity, settings), neighbour=neighbour)


def test_gas_that_starts_from_its_neighbours_settles_sooner_to_the_same(tmp_path: Path) -> None:
    """As a sweep starts them; a few grains for a moment, the gas is what counts."""
    brief = [f"{PARAMETERS}:{text}" for text in ("particles=5", "feedTime=0.01", "drainTime=0.01")]
    neighbour = default_column(tmp_path / "neighbour", 5, *brief).path
    alone = default_column(tmp_path / "alone", 6, *brief).path
    helped = default_column(tmp_path / "helped", 6, *brief, neighbour=neighbour).path
    gas = [read_gas(case, times(case)[-1]) for case in (alone, helped)]
    assert np.sqrt(((gas[1] - gas[0]) ** 2).sum(axis=1).mean()) < 0.01 * 6
    steps = [settling_steps(case) for case in (alone, helped)]
    assert steps[1] < 0.6 * steps[0]


def settling_steps(case: Path) -> int:
    """Steps in which the empty column's gas settled."""
    lines = (case / "log.elutriaFoam").read_text().splitlines()
    return int(next(line for line in lines if "gas settled in" in line).split()[4])
