"""A velocity is done when its cut size is known as well as asked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elutria.classification import classify
from elutria.classification.events import Account, Events, Run
from elutria.classification.fit import PartitionFit, fit_partition
from elutria.classification.precision import Precision, d50_half_width
from elutria.errors import InputError
from tests.support.sweeps import sweep


def run_of(number: int, cut: float = 500e-6, largest: float = 2e-3) -> Run:
    """Parcels even on a log size axis, a log-logistic cut."""
    random = np.random.default_rng(1)
    diameter = np.geomspace(100e-6, largest, number)
    coarse = random.random(number) < 1 / (1 + (diameter / cut) ** -10)
    ones = np.ones(number)
    events = Events(
        np.full(number, "a"), np.where(coarse, "coarse", "fines"), diameter, ones, ones, ones
    )
    account = Account((number, 1.0), {}, (0, 0.0), (0, 0.0))
    return Run(events, {"a": account, "all": account})


def test_sixteen_times_the_parcels_narrow_the_interval_to_a_third_or_less() -> None:
    """A quarter where the curve is a formula's; what no formula says only parcels near the cut do,
    and of them one must learn first."""
    few, many = d50_half_width(run_of(1000)), d50_half_width(run_of(16000))
    assert 0.01 < few < 0.05
    assert 2.2 < few / many < 4.4


def test_as_many_further_runs_as_the_square_root_law_asks_for() -> None:
    run = run_of(2000)
    now = d50_half_width(run)
    assert Precision(1.01 * now).further_runs(run, 1) is None
    assert Precision(now / 1.2).further_runs(run, 4) == 2
    assert Precision(now / 10).further_runs(run, 4) == 4  # no more than there were
    assert Precision(now / 10, most_runs=5).further_runs(run, 4) == 1
    assert Precision(now / 10, most_runs=4).further_runs(run, 4) == 0


def test_without_a_cut_there_is_nothing_to_know() -> None:
    run = run_of(500, cut=5e-3, largest=1e-3)
    assert np.isnan(d50_half_width(run))
    assert Precision(0.01).further_runs(run, 1) is None


@pytest.mark.parametrize("value", [0.0, -0.1, 1.0, float("nan")])
def test_a_precision_is_a_share(value: float) -> None:
    with pytest.raises(InputError, match="--precision"):
        Precision(value)


def test_a_sweep_runs_replicates_until_it_is_precise_and_none_twice(
    column: Path, tmp_path: Path, fake_solver: Path
) -> None:
    to = tmp_path / "out"
    first = sweep(column, to, "4,6", precision=Precision(0.03))
    assert not first.failures and not first.imprecise
    runs = len(fake_solver.read_text().splitlines())
    assert runs > 2
    for row in first.tables.summary:
        assert (row["d50_high_m"] - row["d50_low_m"]) / 2 <= 0.03 * row["d50_m"]
    again = sweep(column, to, "4,6", precision=Precision(0.03))
    assert len(fake_solver.read_text().splitlines()) == runs == again.skipped
    assert again.tables.summary == first.tables.summary


@pytest.mark.usefixtures("fake_solver")
def test_what_stays_imprecise_is_said(column: Path, tmp_path: Path) -> None:
    result = sweep(column, tmp_path / "out", "5", precision=Precision(0.002, most_runs=2))
    assert result.imprecise == ["5 m/s"]


def test_the_same_events_are_fitted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sweep asks for a run's cut when it plans and when it writes; other events are fitted."""
    fitted: list[int] = []

    def counted(diameter: np.ndarray, *rest: np.ndarray) -> PartitionFit:
        fitted.append(len(diameter))
        return fit_partition(diameter, *rest)

    monkeypatch.setattr(classify, "fit_partition", counted)
    run = run_of(307)
    first = d50_half_width(run)
    assert d50_half_width(run_of(307)) == first
    assert fitted == [307]
    assert d50_half_width(run_of(307, cut=501e-6)) != first
    assert fitted == [307, 307]
