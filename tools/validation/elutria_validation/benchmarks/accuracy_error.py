"""How far one partition curve is from another, and which settings are worth their seconds.

Sizes in m. Every quantity has a standard deviation (`_sd`) from the limits that the fit gives: a
difference below that of both curves together tells nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import hypot, isfinite, nan, sqrt
from statistics import fmean
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elutria.classification.classify import fit_events
from elutria.classification.events import Events

Array = NDArray[np.float64]

LIMITS = 2 * 1.96
"""Width of a 95 % interval in standard deviations."""
AROUND = np.exp(np.linspace(np.log(0.7), np.log(1.4), 71))
"""Where curves are compared, over the reference's d50."""

ERRORS = (
    "d50_error", "d50_noise", "d50_run", "sharpness_error", "sharpness_noise",
    "curve_error", "curve_noise", "curve_run",
)  # fmt: skip


@dataclass(frozen=True)
class Cut:
    """A partition curve: share to coarse at rising diameters, d50 and sharpness d25/d75."""

    d50: float
    d50_sd: float
    sharpness: float
    sharpness_sd: float
    diameter: Array
    share: Array

    def columns(self) -> dict[str, float]:
        """d50 with its 95 % interval (m), sharpness with its deviation, as tables have them."""
        return {
            "d50_m": self.d50,
            "d50_low_m": self.d50 - LIMITS / 2 * self.d50_sd,
            "d50_high_m": self.d50 + LIMITS / 2 * self.d50_sd,
            "sharpness": self.sharpness,
            "sharpness_sd": self.sharpness_sd,
        }

    def at(self, diameter: Array) -> Array:
        """Share, linear in ln d between the diameters that are known, constant beyond."""
        return np.interp(np.log(diameter), np.log(self.diameter), self.share)


def cut_of_events(events: Events) -> Cut:
    """The fitted curve of what has left."""
    left = events.diameter[events.has_left]
    fit = fit_events(events)
    if fit.curve is None:
        edge = np.array([left.min(), left.max()]) if left.size else np.array([1e-6, 1.0])
        return Cut(nan, nan, nan, nan, edge, np.full(2, nan))
    diameter = np.geomspace(left.min(), left.max(), 481)
    _, low, high = fit.sizes[0.50]
    blunt, sharp = fit.sharpness_interval[1:]
    return Cut(
        fit.d50,
        (high - low) / LIMITS,
        fit.sharpness,
        (sharp - blunt) / LIMITS,
        diameter,
        fit.share(diameter),
    )


def cut_of_curve(diameter: ArrayLike, share: ArrayLike) -> Cut:
    """A closed form's curve, share to coarse rising with the diameter; it has no noise."""
    sizes, shares = np.asarray(diameter, dtype=float), np.asarray(share, dtype=float)
    d25, d50, d75 = np.exp(np.interp((0.25, 0.5, 0.75), shares, np.log(sizes)))
    return Cut(float(d50), 0.0, float(d25 / d75), 0.0, sizes, shares)


def errors(cuts: Sequence[Cut], reference: Cut) -> dict[str, float]:
    """Of runs that differ by their seed alone, against the reference: d50 relative, sharpness, and
    the curve's root-mean-square difference around the cut.

    `_error` is the mean over the runs (the curve's: of their mean curve), `_noise` one standard
    deviation of what the runs together and the reference do not know; the curve's is what the
    noise of d50 does to it. `_run` is what a single run is off by, chance included:
    root-mean-square over the runs, never below the noise of one.
    """
    grid = AROUND * reference.d50
    d50 = [cut.d50 / reference.d50 - 1 for cut in cuts]
    sharpness = [cut.sharpness - reference.sharpness for cut in cuts]
    shares = np.array([cut.at(grid) - reference.at(grid) for cut in cuts])
    one = hypot(fmean(cut.d50_sd for cut in cuts), reference.d50_sd) / reference.d50
    d50_noise = mean_noise(d50, [cut.d50_sd / reference.d50 for cut in cuts],
                           reference.d50_sd / reference.d50)  # fmt: skip
    return {
        "d50_error": fmean(d50),
        "d50_noise": d50_noise,
        "d50_run": max(_root_mean_square(d50), one),
        "sharpness_error": fmean(sharpness),
        "sharpness_noise": mean_noise(
            sharpness, [cut.sharpness_sd for cut in cuts], reference.sharpness_sd
        ),
        "curve_error": _root_mean_square(shares.mean(axis=0)),
        "curve_noise": moved_by(reference, d50_noise),
        "curve_run": max(_root_mean_square(shares), moved_by(reference, one)),
    }


def _root_mean_square(values: ArrayLike) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def mean_noise(values: Sequence[float], fitted: Sequence[float], reference: float) -> float:
    """Standard deviation of the values' mean less a reference that has its own: from the values'
    scatter, or from the fit where there is one alone."""
    of_one = float(np.std(values, ddof=1)) if len(values) > 1 else fitted[0]
    return hypot(of_one / sqrt(len(values)), reference)


def moved_by(cut: Cut, shift: float) -> float:
    """Root-mean-square change around the cut of a curve that is moved by a share of d50."""
    grid = AROUND * cut.d50
    return float(np.sqrt(np.mean((cut.at(grid / (1 + shift)) - cut.at(grid)) ** 2)))


def known_error(row: Mapping[str, Any], quantity: str) -> float:
    """What a single run is off by, chance included."""
    return float(row[f"{quantity}_run"])


def front(costs: Sequence[float], faults: Sequence[float]) -> list[bool]:
    """Which points no other beats in both cost and fault (Pareto's front). NaN is never on it."""
    pairs = list(zip(costs, faults, strict=True))

    def beaten(cost: float, fault: float) -> bool:
        return any(
            c <= cost and f <= fault and (c < cost or f < fault)
            for c, f in pairs
        )  # fmt: skip

    return [isfinite(c) and isfinite(f) and not beaten(c, f) for c, f in pairs]


@dataclass(frozen=True)
class Verdict:
    """One of stock's points beside ours: how much faster at its error or better, and how much
    more accurate at its cost or less; nan where none of ours is as accurate, or as cheap."""

    faster: float
    by: str
    more_accurate: float

    def met(self, asked: float) -> bool:
        """As many times faster as asked, or 10 times more accurate."""
        return self.faster >= asked or self.more_accurate >= 10


def beside_stock(
    stock: Mapping[str, Any], ours: Iterable[Mapping[str, Any]], quantity: str
) -> Verdict:
    """The best of `ours` beside a row of stock's, by what a single run is off by."""
    error, seconds = known_error(stock, quantity), float(stock["seconds"])
    rows = [row for row in ours if isfinite(known_error(row, quantity))]
    as_good = [row for row in rows if known_error(row, quantity) <= error]
    as_cheap = [row for row in rows if row["seconds"] <= seconds]
    best = min(as_good, key=lambda row: float(row["seconds"]), default=None)
    least = min((known_error(row, quantity) for row in as_cheap), default=nan)
    return Verdict(
        faster=seconds / best["seconds"] if best else nan,
        by=str(best["point"]) if best else "none",
        more_accurate=error / least if least > 0 else nan,
    )
