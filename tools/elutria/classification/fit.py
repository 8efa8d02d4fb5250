"""Maximum-likelihood fit of partition curves to single events, with honest intervals.

Each parcel that left is one Bernoulli trial: coarse with probability T(d). Nothing is binned. Every
model is fitted with and without bypass, ranked by Akaike's criterion; d25, d50, d75 of the best one
get 95 % intervals from the profile likelihood: all values that a likelihood-ratio test would not
reject at 5 %. What the best model leaves of the events moves the sizes and widens their intervals
(misfit.py). Statistical weights enter relative to parcels of like size, since a choice by size
alone tells nothing about T(d), and their spread lowers the effective number of events (Kish).

When every coarse parcel is larger than every fine one, the likeliest curve is a step in the gap,
but no certain one: the intervals hold what the models' likelihood does not reject beside it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import exp, inf, isfinite, log, nan, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from elutria.classification.curves import MODELS, Model
from elutria.classification.likelihood import MAX_BYPASS, Likelihood, maximize
from elutria.classification.misfit import Misfit, find_misfit

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

LEVELS = (0.25, 0.50, 0.75)
_BELT = (0.01, 0.05, 0.1, 0.25, 0.50, 0.75, 0.9, 0.95, 0.99)
_THRESHOLD = float(chdtri(1, 0.05))


@dataclass(frozen=True)
class CurveFit:
    """One fitted model. Diameters in m; `log_shape` is ln s of the model, `bypass` 0..1."""

    model: Model | None  # None: a step
    log_diameter: float  # ln(d50/m) of the curve without its bypass
    log_shape: float
    bypass: float
    log_likelihood: float
    parameters: int
    # of (ln d, ln s, bypass); None where it cannot be told
    covariance: Array | None = field(default=None, compare=False)

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

    def diameter_at(self, share: float) -> float:
        """Diameter (m) where T is `share`; nan where the bypass lies above it."""
        if self.model is None:
            return exp(self.log_diameter)
        if self.bypass >= share:
            return nan
        inner = (share - self.bypass) / (1 - self.bypass)
        return exp(self.log_diameter + self.model.log_x_at(inner, self.log_shape))

    def limits(self, diameter: Array, deviations: float) -> tuple[Array, Array]:
        """Lowest and highest T over the parameters within so many standard deviations of the best.

        To first order these are T's own normal limits; but each curve tried is a partition curve.
        """
        low, high = np.zeros_like(diameter), np.ones_like(diameter)
        if self.covariance is None:
            return low, high
        root = np.linalg.cholesky(self.covariance)
        tried = []
        for direction in _directions(self.parameters):
            step = np.zeros(3)
            step[: self.parameters] = deviations * root @ direction
            moved = replace(
                self,
                log_diameter=self.log_diameter + step[0],
                log_shape=self.log_shape + step[1],
                bypass=float(np.clip(self.bypass + step[2], 0, MAX_BYPASS)),
            )
            tried.append(moved.share(diameter))
        return np.min(tried, axis=0), np.max(tried, axis=0)

    def finest_is_seen(self, smallest: float) -> bool:
        """Whether the curve without its bypass is below 5 % at the smallest size (m)."""
        if self.model is None:
            return True
        return self.log_diameter + self.model.log_x_at(0.05, self.log_shape) > log(smallest)


@dataclass(frozen=True)
class PartitionFit:
    """Fits ranked best first, and `sizes[level] = (d, low, high)` in m from the best one with its
    `misfit`, what it leaves of the events.

    A size is nan where the curve does not reach its level within the sizes that left; an interval
    that the events do not close ends at 0 or inf. `parted` holds the events of a step.
    """

    ranked: list[CurveFit]
    sizes: dict[float, tuple[float, float, float]]
    parted: Likelihood | None = None
    misfit: Misfit | None = None

    @property
    def best(self) -> CurveFit | None:
        """The fit with the smallest AIC, None when there is nothing to fit."""
        return self.ranked[0] if self.ranked else None

    def share(self, diameter: Array) -> Array:
        """T at `diameter` (m). There must be a fit."""
        return self.misfit.share(diameter) if self.misfit else self.ranked[0].share(diameter)

    def band(self, diameter: Array) -> tuple[Array, Array, Array]:
        """T at `diameter` (m) with its pointwise 95 % limits.

        A share is within them when some parameters of some model that give it are not rejected by
        their likelihood ratio to the likeliest (AIC's price left out: far from the cut the models
        differ more among each other than any of them knows).
        """
        best = self.ranked[0]
        share = best.share(diameter)
        if self.parted is not None:
            ends = [_step_interval(self.parted, MODELS, level) for level in _BELT]
            lowest, highest = np.maximum.accumulate(np.log(np.clip(ends, 1e-12, 1e12)), axis=0).T
            at = np.log(diameter)
            low = np.interp(at, highest, _BELT, left=0, right=1)
            high = np.interp(at, lowest, _BELT, left=0, right=1)
            return share, np.minimum(low, share), np.maximum(high, share)
        low, high = share.copy(), share.copy()
        likeliest = max(fit.log_likelihood for fit in self.ranked)
        # a bypass that ended at 0 may have no covariance: the curve without it says the same
        known = [fit for fit in self.ranked if fit.covariance is not None]
        for fit in known or self.ranked:
            slack = _THRESHOLD - 2 * (likeliest - fit.log_likelihood)
            if slack > 0:
                lower, upper = fit.limits(diameter, sqrt(slack))
                low, high = np.minimum(low, lower), np.maximum(high, upper)
        if self.misfit:
            low, high = self.misfit.band(diameter, low, high)
        return self.share(diameter), low, high

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
    models: tuple[Model, ...] = MODELS,
    intervals: bool = True,
) -> PartitionFit:
    """Fit the events of one material: diameters (m) and whether each went to coarse.

    `weight` (mass per parcel at equal size, any unit) defaults to 1 for all.
    """
    nothing = dict.fromkeys(LEVELS, (nan, nan, nan))
    if coarse.all() or not coarse.any():
        return PartitionFit([], nothing)
    likelihood = Likelihood(np.log(diameter), coarse, relative_weights(diameter, weight))
    low, high = _gap(likelihood)
    if low < high:
        return _step(likelihood, models, intervals)
    start = _start(likelihood)
    fits = [_fit(likelihood, model, bypass, start) for model in models for bypass in (False, True)]
    # a bypass is known only where sizes that the cut itself sends to fines were seen
    known = [fit for fit in fits if fit.bypass == 0 or fit.finest_is_seen(diameter.min())]
    ranked = sorted(known, key=lambda fit: fit.aic)
    best = ranked[0]
    misfit = _misfit(likelihood, best)
    sizes = {}
    for level in LEVELS:
        value = best.diameter_at(level)
        if not diameter.min() <= value <= diameter.max():
            sizes[level] = (nan, nan, nan)
            continue
        ends = _interval(likelihood, ranked, level) if intervals else (nan, nan)
        sizes[level] = misfit.size(value, *ends) if misfit else (value, *ends)
    return PartitionFit(ranked, sizes, misfit=misfit)


def _misfit(likelihood: Likelihood, best: CurveFit) -> Misfit | None:
    assert best.model is not None
    p = np.array([best.log_diameter, best.log_shape, best.bypass])
    return find_misfit(likelihood, best.model, p, [0, 1, 2][: best.parameters], best.diameter_at)


def _directions(dimensions: int) -> Array:
    """Unit vectors spread evenly over the circle or the sphere."""
    number = 64 if dimensions == 2 else 256
    k = np.arange(number) + 0.5
    if dimensions == 2:
        return np.column_stack([np.cos(2 * np.pi * k / number), np.sin(2 * np.pi * k / number)])
    height, turn = 1 - 2 * k / number, np.pi * (1 + sqrt(5)) * k
    radius = np.sqrt(1 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def relative_weights(diameter: Array, weight: Array | None) -> Array:
    """Weights over the mean of parcels of like size, scaled to add up to the effective number."""
    if weight is None or np.ptp(weight) == 0:
        return np.ones_like(diameter)
    classes = np.floor(np.log(diameter) / log(10) * 40).astype(int)
    _, index = np.unique(classes, return_inverse=True)
    mean = np.bincount(index, weight) / np.bincount(index)
    relative = weight / mean[index]
    return np.asarray(relative * relative.sum() / np.sum(relative**2))


def _start(likelihood: Likelihood) -> tuple[float, float]:
    """ln d that parts coarse from fines with the least misplaced weight, and their spread."""
    order = np.argsort(likelihood.log_diameter)
    log_d = likelihood.log_diameter[order]
    coarse = np.where(likelihood.coarse, likelihood.weight, 0.0)[order]
    fines = likelihood.weight[order] - coarse
    misplaced = np.cumsum(coarse) + fines.sum() - np.cumsum(fines)
    center = float(log_d[np.argmin(misplaced)])
    wrong = likelihood.coarse != (likelihood.log_diameter > center)
    distance = np.abs(likelihood.log_diameter[wrong] - center)
    spread = 2 * float(np.median(distance)) if distance.size else 0.01
    return center, max(spread, 1e-4)


def _fit(
    likelihood: Likelihood, model: Model, with_bypass: bool, start: tuple[float, float]
) -> CurveFit:
    center, spread = start
    begin = np.array([center, model.start(spread), 0.02 if with_bypass else 0.0])
    free = [0, 1, 2] if with_bypass else [0, 1]
    p, value = maximize(likelihood, model, begin, free, MAX_BYPASS)
    information = likelihood.derivatives(model, p)[2][np.ix_(free, free)]
    known = np.linalg.cond(information) < 1e12
    covariance = np.asarray(np.linalg.inv(information), dtype=float) if known else None
    return CurveFit(model, float(p[0]), float(p[1]), float(p[2]), value, len(free), covariance)


def _interval(likelihood: Likelihood, ranked: list[CurveFit], level: float) -> tuple[float, float]:
    """The 95 % interval of the diameter at `level`, the model being one more nuisance parameter.

    A diameter is in it when some model, its other parameters at their best, comes within the
    likelihood-ratio threshold of the best fit, AIC's price of its parameters included.
    """
    ends: list[float] = []
    for fit in ranked:
        slack = _THRESHOLD - (fit.aic - ranked[0].aic)
        at = fit.diameter_at(level)
        if slack > 0 and isfinite(at):
            assert fit.model is not None
            best = np.array([log(at), fit.log_shape, fit.bypass])
            free = [1, 2][: fit.parameters - 1]
            ends += _profile_interval(
                likelihood, fit.model, fit.log_likelihood, best, free, level, slack
            )
    return float(np.min(ends)), float(np.max(ends))


def _profile_interval(
    likelihood: Likelihood,
    model: Model,
    highest: float,
    best: Array,
    free: list[int],
    level: float,
    slack: float,
) -> tuple[float, float]:
    """Diameters at `level` costing less than `slack` in 2 ln L from the `highest`, which is that of
    `best` (ln d at the level, ln s, bypass), the `free` others at their best; open ends are 0 and
    inf."""

    def lack(log_d: float, start: Array) -> tuple[float, Array]:
        begin = np.array([log_d, start[1], start[2]])
        most = min(MAX_BYPASS, level - 1e-3)
        p, value = maximize(likelihood, model, begin, free, most, level, tolerance=1e-3)
        return 2 * (highest - value), p

    low = _crossing(lambda t, p: lack(best[0] - t, p), best, slack)
    guess = low if isfinite(low) else 0.01
    high = _crossing(lambda t, p: lack(best[0] + t, p), best, slack, guess)
    return exp(best[0] - low), exp(best[0] + high)


def _crossing(
    lack: Callable[[float, Array], tuple[float, Array]],
    start: Array,
    slack: float,
    guess: float = 0.01,
) -> float:
    """Distance at which `lack` reaches `slack`; its square root is nearly linear."""
    near, near_root, nuisance = 0.0, 0.0, start
    target = sqrt(slack)
    far = guess
    for _ in range(40):
        value, found = lack(far, nuisance)
        root = sqrt(max(value, 0.0))
        if abs(root - target) < 0.01:
            return far
        if root > target:
            break
        near, near_root, nuisance = far, root, found
        far *= min(max(1.1 * target / max(root, 1e-9), 1.1), 4.0)
        if far > 7:
            return inf
    else:
        return inf
    far_root = root
    for _ in range(40):  # regula falsi between near (inside) and far (outside)
        middle = near + (far - near) * (target - near_root) / (far_root - near_root)
        value, found = lack(middle, nuisance)
        root = sqrt(max(value, 0.0))
        if abs(root - target) < 0.01:
            return middle
        if root > target:
            far, far_root = middle, root
        else:
            near, near_root, nuisance = middle, root, found
    return 0.5 * (near + far)


def _gap(likelihood: Likelihood) -> tuple[float, float]:
    """ln d of the largest that went to fines and of the smallest that went to coarse."""
    coarse, log_diameter = likelihood.coarse, likelihood.log_diameter
    return float(log_diameter[~coarse].max()), float(log_diameter[coarse].min())


def _step(likelihood: Likelihood, models: tuple[Model, ...], intervals: bool) -> PartitionFit:
    """The fit when sizes part the products completely."""
    middle = 0.5 * sum(_gap(likelihood))
    sizes = {}
    for level in LEVELS:
        ends = _step_interval(likelihood, models, level) if intervals else (nan, nan)
        sizes[level] = (exp(middle), *ends)
    return PartitionFit([CurveFit(None, middle, inf, 0.0, 0.0, 1)], sizes, likelihood)


def _step_interval(
    likelihood: Likelihood, models: tuple[Model, ...], level: float
) -> tuple[float, float]:
    """The 95 % interval of the diameter at `level` beside a step, whose ln L is 0."""
    low, high = _gap(likelihood)
    ends = [exp(low), exp(high)]
    for model in models:
        steep = np.array([0.5 * (low + high), model.start(high - low), 0.0])
        ends += _profile_interval(likelihood, model, 0.0, steep, [1], level, _THRESHOLD)
    return min(ends), max(ends)
