"""The inverse question: a setting for a cut size, in few runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from elutria.case.case import VELOCITY, Case
from elutria.errors import ElutriaError, InputError
from elutria.running.find import Asked, Cut, parse_range, search
from elutria.running.inverse import answer
from tests.support.sweeps import SMALL, Silent

LOADING = "system/simulationParameters:loading"


def power_law(power: float, made: list[float]):  # type: ignore[no-untyped-def]
    def run(value: float) -> Cut:
        made.append(value)
        d50 = 1e-4 * value**power
        return Cut(value, d50, d50 * 0.999, d50 * 1.001)

    return run


@pytest.mark.parametrize("power", [0.3, 1.0, 1.6, -0.5])
@pytest.mark.parametrize("name", [VELOCITY, LOADING])
def test_a_power_law_is_found_in_four_runs(column: Path, name: str, power: float) -> None:
    made: list[float] = []
    asked = Asked(1e-4 * 4.0**power, name, 1, 20)
    best, cuts = search(asked, [], power_law(power, made), Case(column))
    assert best.value == pytest.approx(4, rel=0.01)
    assert len(made) == len(cuts) <= 4


def test_a_curve_that_is_no_power_law_is_bracketed(column: Path) -> None:
    def run(value: float) -> Cut:
        d50 = 1e-4 * (1 + value**4) ** 0.5  # flat, then steep
        return Cut(value, d50, d50 * 0.999, d50 * 1.001)

    asked = Asked(1.02e-4, LOADING, 0.05, 5)
    best, cuts = search(asked, [], run, Case(column))
    assert run(best.value).d50 == pytest.approx(1.02e-4, rel=0.002)
    assert len(cuts) <= 12


def test_what_cannot_be_reached_is_said(column: Path) -> None:
    asked = Asked(1e-3, LOADING, 1, 2)
    with pytest.raises(ElutriaError, match=r"no value of .* from 1 to 2 .*1000 um \(.*: "):
        search(asked, [], power_law(0.5, []), Case(column))


def test_no_more_runs_are_made_than_allowed(column: Path) -> None:
    made: list[float] = []
    asked = Asked(1e-3, LOADING, 1, 2, most_runs=2)
    with pytest.raises(ElutriaError, match="no value of"):
        search(asked, [], power_law(0.5, made), Case(column))
    assert len(made) == 2


@pytest.mark.parametrize("text", ["x=1:2", f"{LOADING}=2:1", f"{LOADING}=1", f"{LOADING}=a:b"])
def test_bad_ranges_are_one_line(column: Path, text: str) -> None:
    with pytest.raises(InputError):
        parse_range(Case(column), text)


def test_runs_that_are_there_are_used(column: Path, fake_solver: Path, tmp_path: Path) -> None:
    to = tmp_path / "results"
    lines, tables = answer(Case(column), to, (500e-6, "all", None, 12), SMALL, 1, Silent())
    (value,) = re.findall(r"at (\S+) m/s", lines[0])
    assert float(value) == pytest.approx(5, rel=0.06)
    low, high = (float(x) for x in re.findall(r"95 %: (\S+) to (\S+)\)", lines[0])[0])
    assert low < 5 < high
    assert high / low < 1.2
    first = len(fake_solver.read_text().splitlines())
    assert first <= 4
    assert {row["material"] for row in tables.summary} == {"quartz", "all"}
    answer(Case(column), to, (500e-6, "quartz", None, 12), SMALL, 1, Silent())
    assert len(fake_solver.read_text().splitlines()) == first


def test_limits_of_more_digits_than_a_table_has(
    column: Path, fake_solver: Path, tmp_path: Path
) -> None:
    """Finest and coarsest that the search tries are a fifth of a guess and five times it."""
    wanted = (100e-6, "all", f"{VELOCITY}=2.123456789012:3", 12)
    with pytest.raises(ElutriaError, match=r"no value of .* 100 um \(2\.12346: "):
        answer(Case(column), tmp_path / "results", wanted, SMALL, 1, Silent())
    assert 2 <= len(fake_solver.read_text().splitlines()) <= 4
