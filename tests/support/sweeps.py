"""Sweeps of a few parcels, for tests that look at their tables."""

from __future__ import annotations

from pathlib import Path

from elutria.case.case import Case
from elutria.classification.precision import Precision
from elutria.estimates.price import Price
from elutria.running.axes import grid
from elutria.running.budget import Budget
from elutria.running.engine import local_executor
from elutria.running.results import Results
from elutria.running.sweep import SweepResult, plan, run_sweep

SMALL = ["system/simulationParameters:particles=400"]


class Silent:
    """A sweep's watcher that tells nothing."""

    def progress(self, name: str, share: float, note: str) -> None:
        pass

    def finished(self, name: str, line: str) -> None:
        pass

    def planned(self, runs: int) -> None:
        pass

    def expected(self, cost: Price) -> None:
        pass


def sweep(
    case: Path,
    to: Path,
    velocities: str,
    replicates: int = 1,
    extra: list[str] = SMALL,
    precision: Precision | Budget | None = None,
    vary: list[str] | None = None,
) -> SweepResult:
    source = Case(case)
    members = plan(source, to, grid(source, velocities, vary or []), replicates, extra)
    with local_executor(2) as executor:
        return run_sweep(Results(source, to, extra), members, executor, 1, Silent(), precision)
