"""The time left of a run, beside runs whose end is known."""

from __future__ import annotations

import json
from math import exp, isnan
from pathlib import Path

import pytest

from elutria.running.ahead import Ahead
from elutria.running.solver import Step


def plan(tmp_path: Path, feed_end: float | None, run_end: float | None) -> Path:
    file = tmp_path / "plan.json"
    file.write_text(json.dumps({"feed": {"end_s": feed_end, "run_ends_s": run_end}}))
    return file


def test_a_column_that_empties_tells_its_end(tmp_path: Path) -> None:
    """1000 parcels a second for 1 s, each of which stays 0.5 s on average, at random; the last of
    500 leaves near 1 + 0.5 ln 500 = 4.1 s. A simulated second takes 10 s."""
    clock = [0.0]
    ahead = Ahead(plan(tmp_path, 1.0, 30.0), lambda: clock[0])
    for number in range(1, 400):
        time = 0.01 * number
        clock[0] = 10 * time
        inside = 500 * (1 - exp(-min(time, 1) / 0.5)) * exp(-max(time - 1, 0) / 0.5)
        fed = round(1000 * min(time, 1))
        left = ahead.left_s(Step(time, fed, {}, round(inside), 0))
        if 0.3 < time < 3:
            assert 0.5 < left / (10 * (4.1 - time)) < 2, time
    assert ahead.share(left) > 0.9


def test_one_that_hovers_is_waited_for_until_the_run_ends(tmp_path: Path) -> None:
    clock = [0.0]
    ahead = Ahead(plan(tmp_path, 1.0, 7.0), lambda: clock[0])
    assert isnan(ahead.left_s(Step(0.0, 0, {}, 0, 0)))
    for number in range(1, 60):
        clock[0] = 0.2 * number
        left = ahead.left_s(Step(0.1 * number, 100, {"fines": 97}, 3, 0))
    assert left == pytest.approx(2 * (7 - 5.9), rel=0.05)


@pytest.mark.parametrize("feed_end", [1.0, None])
def test_a_feed_that_does_not_say_when_the_run_ends(tmp_path: Path, feed_end: float | None) -> None:
    """Such as one without drainTime: the run goes on, and what is left is a number or not known."""
    clock = [0.0]
    ahead = Ahead(plan(tmp_path, feed_end, None), lambda: clock[0])
    for number in range(1, 30):
        clock[0] = 0.2 * number
        left = ahead.left_s(Step(0.1 * number, 100, {"fines": 97}, 3, 0))
        assert isnan(left) or left > 0
    assert 0 <= ahead.share(left) <= 1


def test_without_a_plan_nothing_is_known(tmp_path: Path) -> None:
    ahead = Ahead(tmp_path / "none.json")
    assert isnan(ahead.left_s(Step(0.1, 10, {}, 5, 0)))
