"""When is a cut size known well enough, and how many more runs would it take?"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf, isfinite, nan

from elutria.classification.classify import fit_events
from elutria.classification.events import Run
from elutria.classification.fit import PartitionFit
from elutria.errors import InputError


@dataclass(frozen=True)
class Precision:
    """Asked half-width of the 95 % interval of d50 over d50, and the most runs spent on it."""

    half_width: float
    most_runs: int = 12

    def __post_init__(self) -> None:
        if not 1e-4 <= self.half_width < 1:
            raise InputError(f"--precision {self.half_width:g}; allowed: 0.0001 to below 1")
        if self.most_runs < 1:
            raise InputError(f"--most-runs {self.most_runs}; allowed: a whole number >= 1")

    def further_runs(self, run: Run, runs: int) -> int | None:
        """How many more runs like the `runs` joined in `run` should do, None if it is precise.

        Precise: every material's cut is known as asked; one without a cut has nothing to know. 0:
        it is not, but there are as many runs as there may be. The half-width falls with the square
        root of the number of parcels. A first guess may be poor, so there are never more further
        runs than there have been.
        """
        ratio = d50_half_width(run) / self.half_width
        if not ratio > 1:
            return None
        wanted = ceil(runs * ratio**2) - runs if isfinite(ratio) else runs
        return max(min(wanted, runs, self.most_runs - runs), 0)


def d50_half_width(run: Run) -> float:
    """The worst material's half-width of the interval of d50 over d50; nan when none has a cut."""
    names = [name for name in run.accounts if name != "all"]
    widths = [_half_width(fit_events(run.events.of_material(name))) for name in names]
    return max((width for width in widths if width == width), default=nan)


def _half_width(fit: PartitionFit) -> float:
    value, low, high = fit.sizes[0.50]
    if value != value:
        return nan
    return (high - low) / (2 * value) if isfinite(high) and low > 0 else inf
