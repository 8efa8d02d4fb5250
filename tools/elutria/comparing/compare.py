"""Whether a computed partition curve and a measured one are the same, and by how much they differ.

Chi-square asks whether they are. Ours at a size is the curve there plus the mean of what parcels of
about that size depart from it: the smoothed curve's own errors drop out, those of neighbouring
sizes are independent, and their variance is that of so many trials. Rows of the measurement err
independently too, so that chi-square, the sum of squared differences over both variances, has as
many degrees of freedom as rows. The posterior of the smooth curve would not do: its curves bend as
much as the prior lets them, and chi-squares of it come out too small where the truth is smooth.

Differences in d50, sharpness and yield are taken of both in one way, from the shares at the same
sizes: what interpolation between few sizes does to one it does to the other. Their intervals come
from likely curves, drawn from that posterior, which carry that neighbouring sizes err together.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nan

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from elutria.classification.fit import LEVELS
from elutria.classification.smooth import SmoothCurve
from elutria.comparing.measured import NORMAL, Measured

Array = NDArray[np.float64]

DRAWS = 4000
SEED = 1
WITHIN = 9
"""Sizes in a class over which the curve is averaged, even in ln d."""
ENDS = (2.5, 97.5)
"""Percentiles that limit an interval."""
NONE_SEEN = 0.25
"""Added to the trials' summed variance: parcels that all went one way leave a share unsure."""
OFTEN = 0.95
"""A quantity has an interval where so many of the draws have it."""


@dataclass(frozen=True)
class Difference:
    """A quantity of both sides, and ours less the measured one with its 95 % interval; nan where
    it is not known."""

    name: str
    measured: float
    ours: float
    low: float
    high: float

    @property
    def value(self) -> float:
        """Ours less the measured one."""
        return self.ours - self.measured


@dataclass(frozen=True)
class Comparison:
    """At the measurement's sizes (n,): our shares, limits of the band there, and each term of
    chi-square's root (nan where a side's variance is not known); then the whole."""

    measured: Measured
    ours: Array
    low: Array
    high: Array
    standardised: Array
    differences: tuple[Difference, ...]

    @property
    def sizes(self) -> int:
        """Rows that are compared."""
        return int(self.ours.size)

    @property
    def degrees(self) -> int:
        """Degrees of freedom: rows of which both sides know how well."""
        return int(np.sum(np.isfinite(self.standardised)))

    @property
    def chi_square(self) -> float:
        """Sum of the squared terms; nan without any."""
        return float(np.nansum(self.standardised**2)) if self.degrees else nan

    @property
    def p_value(self) -> float:
        """Chance of as large a chi-square between curves that are the same; nan without any."""
        return float(chdtrc(self.degrees, self.chi_square)) if self.degrees else nan


def within(curve: SmoothCurve, measured: Measured) -> Measured:
    """The rows whose size lies within those that left: beyond them nothing is known of ours."""
    smallest, largest = (float(np.exp(end)) for end in (curve.space.low, curve.space.high))
    here = (measured.diameter >= smallest) & (measured.diameter <= largest)
    return Measured(
        np.clip(measured.low[here], smallest, largest),
        np.clip(measured.high[here], smallest, largest),
        measured.share[here],
        None if measured.deviation is None else measured.deviation[here],
        None if measured.mass is None else measured.mass[here],
        measured.chosen,
    )


def compare(curve: SmoothCurve, measured: Measured, seed: int = SEED) -> Comparison:
    """Ours beside the measurement, whose sizes lie within those that left."""
    random = np.random.default_rng(seed)
    places = _places(measured)
    drawn = _means(curve.draws(places, DRAWS, random), measured)
    ours = _means(curve.share(places)[None], measured)[0]
    _, low, high = (_means(one[None], measured)[0] for one in curve.band(places))
    theirs, standardised = np.broadcast_to(measured.share, drawn.shape), np.full(ours.size, nan)
    if measured.deviation is not None:
        theirs = measured.share + measured.deviation * random.standard_normal(drawn.shape)
        local, variance = _independent(curve, measured, ours)
        both = np.sqrt(variance + measured.deviation**2)
        standardised = np.where(np.isfinite(both), (local - measured.share) / both, nan)
    differences = _differences(measured, ours, drawn, theirs)
    return Comparison(measured, ours, low, high, standardised, differences)


def _independent(curve: SmoothCurve, measured: Measured, ours: Array) -> tuple[Array, Array]:
    """Our shares (n,) whose errors are independent, and their variances (inf without parcels):
    `ours` plus the mean departure of the parcels in each class, or nearest each size."""
    trials = curve.trials
    number, limits = np.zeros(ours.size), _windows(measured)
    departure, variance = np.zeros_like(number), np.zeros_like(number)
    share = curve.share(np.exp(trials.place))
    for k, (low, high) in enumerate(zip(*limits, strict=True)):
        here = (trials.place >= low) & (trials.place < high)
        number[k] = trials.number[here].sum()
        departure[k] = np.sum(trials.coarse[here] - trials.number[here] * share[here])
        variance[k] = np.sum(trials.number[here] * share[here] * (1 - share[here]))
    sure = np.where(number > 0, number, nan)
    spread = (variance + NONE_SEEN) / sure**2
    return ours + departure / sure, np.where(number > 0, spread, inf)


def _windows(measured: Measured) -> tuple[Array, Array]:
    """Limits in ln d of the parcels that speak for each row: its class, or halfway to the next."""
    if measured.of_classes:
        return np.log(measured.low), np.log(measured.high)
    at = np.log(measured.diameter)
    middle = (at[1:] + at[:-1]) / 2
    first, last = 2 * at[0] - middle[0], 2 * at[-1] - middle[-1]
    return np.append(first, middle), np.append(middle, last)


def _places(measured: Measured) -> Array:
    """Sizes (m) at which the curve is asked for: WITHIN a class, or the size itself."""
    if not measured.of_classes:
        return measured.diameter
    share = (np.arange(WITHIN) + 0.5) / WITHIN
    low, high = np.log(measured.low)[:, None], np.log(measured.high)[:, None]
    return np.asarray(np.exp(low + share * (high - low)).ravel())


def _means(shares: Array, measured: Measured) -> Array:
    """Means (draws, rows) over the classes of shares (draws, places)."""
    if not measured.of_classes:
        return shares
    return np.asarray(shares.reshape(len(shares), -1, WITHIN).mean(axis=2))


def _differences(
    measured: Measured, ours: Array, drawn: Array, theirs: Array
) -> tuple[Difference, ...]:
    """d50, sharpness and yield of both, with the interval of the difference."""
    at = np.log(measured.diameter)
    pairs = [
        (_sizes(at, measured.share[None]), _sizes(at, ours[None])),
        (_sizes(at, theirs), _sizes(at, drawn)),
    ]
    found = []
    for name in ("d50_m", "sharpness"):
        (one, other), (some, others) = ((a[name], b[name]) for a, b in pairs)
        limits = _limits(others - some, measured.deviation is not None)
        found.append(Difference(name, float(one[0]), float(other[0]), *limits))
    if measured.mass is not None:
        weight = measured.mass / measured.mass.sum()
        limits = _limits((theirs - drawn) @ weight, measured.deviation is not None)
        is_theirs, is_ours = (float((1 - share) @ weight) for share in (measured.share, ours))
        found.append(Difference("fines_yield", is_theirs, is_ours, *limits))
    return tuple(found)


def _limits(values: Array, known: bool) -> tuple[float, float]:
    """The 95 % interval of what was drawn; nan where it is not known."""
    sound = values[np.isfinite(values)]
    if not known or sound.size < OFTEN * values.size:
        return nan, nan
    low, high = np.percentile(sound, ENDS)
    return float(low), float(high)


def _sizes(at: Array, shares: Array) -> dict[str, Array]:
    """d50 (m) and d25/d75 of curves (draws, n) at ln d `at` (n); nan without a crossing."""
    d25, d50, d75 = (np.exp(_crossings(at, shares - level)) for level in LEVELS)
    return {"d50_m": d50, "sharpness": d25 / d75}


def _crossings(at: Array, values: Array) -> Array:
    """The last place of each curve (draws, n) where it rises through 0, linear in between."""
    rising = (values[:, :-1] < 0) & (values[:, 1:] >= 0)
    last = rising.shape[1] - 1 - np.argmax(rising[:, ::-1], axis=1)
    rows = np.arange(len(values))
    below, above = values[rows, last], values[rows, last + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        place = at[last] - below * (at[last + 1] - at[last]) / (above - below)
    return np.where(rising.any(axis=1), place, nan)


def interval(measured: Measured) -> tuple[Array, Array]:
    """95 % limits of the measured shares; the shares where nothing is known of them."""
    if measured.deviation is None:
        return measured.share, measured.share
    half = NORMAL * measured.deviation
    return np.maximum(measured.share - half, 0), np.minimum(measured.share + half, 1)
