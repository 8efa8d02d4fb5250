"""A budget goes where the answer is known least, and is not exceeded."""

from __future__ import annotations

from itertools import product
from math import inf, nan
from pathlib import Path

import pytest

from elutria.errors import InputError
from elutria.running.axes import Point
from elutria.running.budget import Budget, Known, parse_budget
from elutria.running.costs import came_to
from tests.support.sweeps import sweep

A, B = Point(4.0), Point(5.0)


@pytest.mark.parametrize(("text", "seconds"), [("90s", 90), ("10min", 600), ("1.5 h", 5400)])
def test_times_are_read(text: str, seconds: float) -> None:
    assert parse_budget(text).processor_s == seconds


@pytest.mark.parametrize("text", ["", "10", "-5s", "0s", "5 days", "1e999h", "1.2.3s"])
def test_other_words_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="allowed: such as 90s, 10min or 2h"):
        parse_budget(text)


def rounds(budget: Budget, known: dict[Point, Known]) -> dict[Point, int]:
    """All rounds, each run as narrow as expected; how many runs each point has at the end."""
    while further := budget.further_runs(known):
        for point, count in further.items():
            for _ in range(count):
                known[point] = known[point].with_one_more()
        assert sum(one.runs * one.run_s for one in known.values()) <= budget.processor_s
    return {point: one.runs for point, one in known.items()}


@pytest.mark.parametrize(
    ("first", "second"),
    [(Known(0.04, 1, 10), Known(0.01, 1, 10)), (Known(0.02, 1, 10), Known(0.02, 1, 30)),
     (Known(0.05, 2, 7), Known(0.02, 1, 20))],
)  # fmt: skip
def test_it_is_spent_as_the_best_of_all_ways(first: Known, second: Known) -> None:
    """Least sum of the squares of both half-widths, among all numbers of runs that fit."""
    budget = Budget(400)
    found = rounds(budget, {A: first, B: second})

    def squares(a: int, b: int) -> float:
        return sum(one.half_width**2 * one.runs / n for one, n in ((first, a), (second, b)))

    fit = [(a, b) for a, b in product(range(first.runs, 41), range(second.runs, 41))
           if a * first.run_s + b * second.run_s <= budget.processor_s]  # fmt: skip
    best = min(squares(*pair) for pair in fit)
    assert squares(found[A], found[B]) <= 1.05 * best


def test_a_point_without_a_cut_gets_nothing_one_without_an_end_more() -> None:
    found = rounds(Budget(200), {A: Known(nan, 1, 10), B: Known(inf, 1, 10)})
    assert found == {A: 1, B: 19}
    assert rounds(Budget(15), {A: Known(0.1, 1, 10)}) == {A: 1}


@pytest.mark.slow
@pytest.mark.usefixtures("fake_solver")
def test_a_sweep_keeps_to_its_budget_and_goes_on_with_a_larger_one(
    column: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ELUTRIA_CACHE", str(tmp_path / "cache"))
    to = tmp_path / "results"
    with pytest.raises(InputError, match=r"--budget: .* s, but the runs asked for take .* allowed"):
        sweep(column, to, "4,6", precision=Budget(0.1))  # on any machine too little
    first = sweep(column, to, "4,6", precision=Budget(6))
    spent = came_to(first.ran)
    assert 2 < spent.runs == len(list(to.glob("U*/finished.json")))
    assert spent.processor_s < 1.3 * 6  # the last run may take longer than those before it
    assert not sweep(column, to, "4,6", precision=Budget(6)).ran
    assert sweep(column, to, "4,6", precision=Budget(9)).ran
