"""From single events to a partition curve with limits that cover the truth.

Each parcel that left is one Bernoulli trial: coarse with probability T(d). Nothing is classed. The
reported curve has no formula (smooth.py). Formulas of the literature are fitted beside it, with and
without bypass, ranked by Akaike's criterion, each with the chance that events of its own would lie
as far from it as these do.

Statistical weights enter relative to parcels of like size, since a choice by size alone tells
nothing about T(d), and their spread lowers the effective number of events (Kish 1965); so does
what parcels that entered one after the other have in common (blocks in time).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp, inf, log, nan

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from elutria.classification.curves import MODELS, Model
from elutria.classification.likelihood import Likelihood
from elutria.classification.smooth import Interval, SmoothCurve, smooth_curve

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

LEVELS = (0.25, 0.50, 0.75)
UNKNOWN: Interval = (nan, nan, nan)
LIKE_SIZES = (40, 25)
"""Classes of like size: so many a decade, joined until each holds so many parcels."""
NOTICEABLE = 1.02
"""Design effect below which events are taken to be independent."""
REJECTED, WIDTHS = 1e-3, 8
"""Chance below which the best formula tells nothing of the cut, and how many widths of a cut there
are at least from the smallest to the largest size then."""
NEIGHBOURS, GAPS = 10, 1.5
"""The cut is taken to be at least so many mean gaps wide, those between so many nearest sizes."""


@dataclass(frozen=True)
class CurveFit:
    """One fitted formula. Diameters in m; `log_shape` is ln s of the model, `bypass` 0..1."""

    model: Model | None  # None: a step
    log_diameter: float  # ln(d50/m) of the curve without its bypass
    log_shape: float
    bypass: float
    log_likelihood: float
    parameters: int
    p_value: float = nan
    """Chance that events of this curve lie as far from it (Pearson's chi-square in classes)."""

    @property
    def name(self) -> str:
        """Model and whether it has a bypass."""
        if self.model is None:
            return "step"
        return self.model.name + (" + bypass" if self.parameters == 3 else "")

    @property
    def aic(self) -> float:
        """Akaike's criterion: 2 parameters - 2 ln L. The smaller the better."""
        return 2 * self.parameters - 2 * self.log_likelihood

    def share(self, diameter: Array) -> Array:
        """T at `diameter` (m)."""
        if self.model is None:
            return (np.log(diameter) > self.log_diameter).astype(float)
        inner = self.model.share(diameter / exp(self.log_diameter), self.log_shape)
        return self.bypass + (1 - self.bypass) * inner

    def finest_is_seen(self, smallest: float) -> bool:
        """Whether the curve without its bypass is below 5 % at the smallest size (m)."""
        if self.model is None:
            return True
        return self.log_diameter + self.model.log_x_at(0.05, self.log_shape) > log(smallest)


@dataclass(frozen=True)
class PartitionFit:
    """The `curve` without a formula, with `sizes[level] = (d, low, high)` in m and sharpness from
    it, and the formulas `ranked` best first. Without both products there is no curve.

    A size is nan where the curve does not cross its level within the sizes that left; an interval
    that the events do not close ends at 0 or inf.
    """

    ranked: list[CurveFit]
    sizes: dict[float, Interval]
    sharpness_interval: Interval = UNKNOWN
    curve: SmoothCurve | None = None

    @property
    def best(self) -> CurveFit | None:
        """The formula with the smallest AIC, None when there is nothing to fit."""
        return self.ranked[0] if self.ranked else None

    def share(self, diameter: Array) -> Array:
        """T (n) at `diameter` (n, m). There must be a curve."""
        assert self.curve is not None
        return self.curve.share(diameter)

    def band(self, diameter: Array) -> tuple[Array, Array, Array]:
        """T (n) at `diameter` (n, m) with its pointwise 95 % limits. There must be a curve."""
        assert self.curve is not None
        return self.curve.band(diameter)

    @property
    def d25(self) -> float:
        return self.sizes[0.25][0]

    @property
    def d50(self) -> float:
        return self.sizes[0.50][0]

    @property
    def d75(self) -> float:
        return self.sizes[0.75][0]

    @property
    def sharpness(self) -> float:
        """d25/d75 (ISO 9276-4): 1 for a perfect cut."""
        return self.d25 / self.d75

    @property
    def ecart_probable(self) -> float:
        """(d75 - d25)/2, m."""
        return (self.d75 - self.d25) / 2


def fit_partition(
    diameter: Array,
    coarse: Flags,
    weight: Array | None = None,
    time: Array | None = None,
    models: tuple[Model, ...] = MODELS,
    intervals: bool = True,
) -> PartitionFit:
    """Fit the events of one material: diameters (n, m) and whether each went to coarse.

    `weight` (mass per parcel at equal size, any unit) defaults to 1 for all; with the `time` at
    which each entered, parcels that entered together need not be independent.
    """
    if coarse.all() or not coarse.any() or np.ptp(diameter) == 0:
        return PartitionFit([], dict.fromkeys(LEVELS, UNKNOWN))
    log_diameter = np.log(diameter)
    effective = relative_weights(diameter, weight)
    formulas = _formulas(log_diameter, coarse, effective, models)
    best = min(formulas, key=lambda fit: fit.aic)
    cut, width = _rough_cut(log_diameter, best)
    if _p_value(best, diameter, coarse, effective) < REJECTED:
        cut, width = _within(log_diameter, cut, width)
    curve = smooth_curve(log_diameter, coarse, effective, cut, width)
    effect = design_effect(effective * (coarse - curve.share(diameter)), time)
    if effect > NOTICEABLE:
        curve = smooth_curve(log_diameter, coarse, effective / effect, cut, width)
    ranked = sorted(
        (
            replace(fit, p_value=_p_value(fit, diameter, coarse, effective / effect))
            for fit in formulas
            # a bypass is known only where sizes that the cut itself sends to fines were seen
            if fit.bypass == 0 or fit.finest_is_seen(diameter.min())
        ),
        key=lambda fit: fit.aic,
    )
    sizes = {level: curve.size(level, intervals) for level in LEVELS}
    sharpness = curve.sharpness() if intervals else UNKNOWN
    return PartitionFit(ranked, sizes, sharpness, curve)


def relative_weights(diameter: Array, weight: Array | None) -> Array:
    """Weights over the mean of parcels of like size, scaled there to the effective number."""
    if weight is None or np.ptp(weight) == 0:
        return np.ones_like(diameter)
    per_decade, fewest = LIKE_SIZES
    classes = np.floor(np.log(diameter) / log(10) * per_decade).astype(int)
    numbers = np.bincount(classes - classes.min())
    joined, group, held = np.zeros(numbers.size, dtype=int), 0, 0
    for k, number in enumerate(numbers):
        joined[k] = group
        held += number
        if held >= fewest:
            group, held = group + 1, 0
    if held and group:  # what is left at the coarse end
        joined[joined == group] = group - 1
    index = joined[classes - classes.min()]
    relative = weight / (np.bincount(index, weight) / np.bincount(index))[index]
    scale = np.bincount(index, relative) / np.bincount(index, relative**2)
    return np.asarray(relative * scale[index])


def design_effect(residual: Array, time: Array | None) -> float:
    """Variance of the curve over that of independent events, from the weighted residuals.

    Their sums over blocks in time vary more than those of independent events where parcels that
    enter together fare alike. A ratio that chance explains counts little.
    """
    if time is None or residual.size < 40 or np.ptp(time) == 0:
        return 1.0
    blocks = int(min(max(residual.size**0.5, 10), 50))
    index = np.arange(residual.size) * blocks // residual.size
    sums = np.bincount(index, residual[np.argsort(time, kind="stable")])
    more = float(np.sum(sums**2) / np.sum(residual**2)) - 1
    if not more > 0:
        return 1.0
    return 1 + more**3 / (more**2 + 4 / blocks)


def _formulas(
    log_diameter: Array, coarse: Flags, weight: Array, models: tuple[Model, ...]
) -> list[CurveFit]:
    """Each model without and with bypass; where sizes part the products completely, a step."""
    largest_fines, smallest_coarse = log_diameter[~coarse].max(), log_diameter[coarse].min()
    if largest_fines < smallest_coarse:
        middle = float(largest_fines + smallest_coarse) / 2
        return [CurveFit(None, middle, inf, 0.0, 0.0, 1)]
    likelihood = Likelihood(log_diameter, coarse, weight)
    center, spread = _start(log_diameter, coarse, weight)
    fits = []
    for model in models:
        start = np.array([center, model.start(spread), 0.02])
        for with_bypass in (False, True):
            p, value = likelihood.maximize(model, start, with_bypass)
            number = 3 if with_bypass else 2
            fits.append(CurveFit(model, float(p[0]), float(p[1]), float(p[2]), value, number))
    return fits


def _rough_cut(log_diameter: Array, best: CurveFit) -> tuple[float, float]:
    """ln d50 of the best formula's cut and the width of its logit, at least that of the gaps
    between neighbouring sizes: what lies in between is not seen."""
    nearest = np.sort(np.abs(log_diameter - best.log_diameter))[:NEIGHBOURS]
    width = GAPS * 2 * float(nearest[-1]) / nearest.size
    if best.model is not None:
        inner = [best.model.log_x_at(level, best.log_shape) for level in (0.25, 0.75)]
        width = max(width, (inner[1] - inner[0]) / (2 * log(3)))
    return best.log_diameter, max(width, 1e-5)


def _within(log_diameter: Array, cut: float, width: float) -> tuple[float, float]:
    """A cut that no formula tells, as where the share falls or has a summit: among the sizes, and
    no wider than lets the curve bend between them."""
    low, high = float(log_diameter.min()), float(log_diameter.max())
    return min(max(cut, low), high), min(width, (high - low) / WIDTHS)


def _p_value(fit: CurveFit, diameter: Array, coarse: Flags, weight: Array) -> float:
    """Pearson's test of a formula, in classes of size that hold like variances."""
    if fit.model is None:
        return nan
    order = np.argsort(diameter)
    share = fit.share(diameter)[order]
    variance = weight[order] * share * (1 - share)
    whole = float(variance.sum())
    number = int(min(max(whole / 5, 4), 20))
    index = np.minimum((np.cumsum(variance) / whole * number).astype(int), number - 1)
    off = np.bincount(index, weight[order] * (coarse[order] - share), number)
    expected = np.bincount(index, variance, number)
    chi_square = float(np.sum(off**2 / np.maximum(expected, 1e-300)))
    return float(chdtrc(max(number - fit.parameters, 1), chi_square))


def _start(log_diameter: Array, coarse: Flags, weight: Array) -> tuple[float, float]:
    """ln d that parts coarse from fines with the least misplaced weight, and their spread."""
    order = np.argsort(log_diameter)
    heavy = np.where(coarse, weight, 0.0)[order]
    fines = weight[order] - heavy
    misplaced = np.cumsum(heavy) + fines.sum() - np.cumsum(fines)
    center = float(log_diameter[order][np.argmin(misplaced)])
    wrong = coarse != (log_diameter > center)
    distance = np.abs(log_diameter[wrong] - center)
    spread = 2 * float(np.median(distance)) if distance.size else 0.01
    return center, max(spread, 1e-4)
