"""A partition curve without a formula, by penalised likelihood, and limits that cover the truth.

The logit of T is a spline over ln d (spline.py) with normal priors: bending of standard deviation
`roughness`, and hinges. Each pair of a roughness and a hinges' prior gives a curve and its
evidence, by Laplace's approximation; T and its limits are averages over the pairs. The limits of
one pair are those of the profile: the highest and the lowest T of all splines whose penalised ln L
is within 1.92 of the best. Unlike standard deviations they stay sound where T is near 0 or 1. The
interval of the sharpness, which no direction of the coefficients follows, is that of likely curves.

What no prior knows is whether a small share of the finest goes to coarse whatever its size
(bypass), or of the coarsest to fines: limits reach as far as the events allow.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import exp, inf, log, nan

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq
from scipy.special import expit, log_expit, logit, logsumexp, ndtr

from elutria.classification.spline import HINGE_PRIORS, Space

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Interval = tuple[float, float, float]

ROUGHNESS = (0.3, 1.0, 3.0, 10.0)
"""Standard deviations of the logit's bending per unit of u, from a formula's to a staircase's."""
LIMIT = 1.959964
"""Standard deviations of a 95 % interval's end."""
MISPLACED = 3.0
"""Loss of ln L that a share of misplaced particles may cost: 0 seen of n gives 3/n."""
SATURATED = 12.0
"""Logit of T, 6e-6 from 0 or 1, beyond which a limit is not followed further."""
ENDLESS = 40.0
"""Logit from which on T is 0 or 1."""
PIECES = (13, 2.0)
"""Pieces of the spline: a number, and a number per cube root of the effective number of events."""
BINS = 8
"""Bins per piece."""
TRUST = 0.75
"""Power of the evidence in a prior's weight: Laplace's approximation knows it roughly."""
NEGLIGIBLE = 0.02
"""Weight of a prior below which it is left out."""
DRAWS = 1000
"""Likely curves from which the interval of the sharpness is read."""
CONVERGED = 1e-8
"""Change of ln L, twice that which is left, at which a mode is found."""
NEWTON = 100, 30
"""Most rounds of the search for a mode, and halvings of a step."""
ROUNDS = 15
"""Most rounds of the search for a limit."""
GRID = 41
"""Points, even in u, at which limits are found; between them they are interpolated."""


@dataclass(frozen=True)
class Trials:
    """Events as binomial trials in narrow bins: effective number and those that went to coarse,
    at ln d `place`, with the basis' rows (bins, size) and the products of its columns not 0."""

    place: Array
    number: Array
    coarse: Array
    rows: Array
    pairs: tuple[NDArray[np.int_], NDArray[np.int_]]
    products: Array

    def lack(self, coefficients: Array, penalty: Array) -> tuple[Array, Array]:
        """-ln L with the penalty, and the logits (.., bins), of coefficients (.., size)."""
        line = coefficients @ self.rows.T
        chance = np.logaddexp(0, line) @ self.number - line @ self.coarse
        rough = np.einsum("...i,ij,...j->...", coefficients, penalty, coefficients)
        return np.asarray(chance + 0.5 * rough), np.asarray(line)

    def gradient(self, coefficients: Array, penalty: Array, line: Array) -> Array:
        """Of the lack, (.., size)."""
        misses = self.number * expit(line) - self.coarse
        return np.asarray(misses @ self.rows + coefficients @ penalty)

    def hessian(self, penalty: Array, line: Array) -> Array:
        """Of the lack, (.., size, size)."""
        share = expit(line)
        entries = (self.number * share * (1 - share)) @ self.products
        whole = np.zeros((*entries.shape[:-1], *penalty.shape))
        whole[..., self.pairs[0], self.pairs[1]] = entries
        whole[..., self.pairs[1], self.pairs[0]] = entries
        return whole + penalty


@dataclass(frozen=True)
class Mode:
    """The likeliest spline of one prior, and the prior's weight among all."""

    penalty: Array
    coefficients: Array
    lack: float
    weight: float


@dataclass(frozen=True)
class SmoothCurve:
    """The curve: share(d) with band(d), and size(level) and sharpness with intervals."""

    space: Space
    trials: Trials
    modes: tuple[Mode, ...]

    def share(self, diameter: Array) -> Array:
        """T at `diameter` (m)."""
        return np.asarray(expit(self._line(self.space.rows(np.log(diameter)))))

    def band(self, diameter: Array) -> tuple[Array, Array, Array]:
        """T at `diameter` (m) with its pointwise 95 % limits."""
        y = np.log(diameter)
        line = self._line(self.space.rows(y))
        below, above = (gap(self.space.stretched(np.clip(y, self.space.low, self.space.high)))
                        for gap in self._gaps)  # fmt: skip
        low, high = line - below, line + above
        return (
            expit(line),
            np.where(low < 0.01 - ENDLESS, 0.0, expit(low)),
            np.where(high > ENDLESS - 0.01, 1.0, expit(high)),
        )

    def draws(self, diameter: Array, number: int, random: np.random.Generator) -> Array:
        """T at `diameter` (n, m) of so many likely curves, (number, n): Laplace's approximation of
        each prior's posterior, as often as the prior weighs."""
        rows = self.space.rows(np.log(diameter))
        return np.asarray(expit(self._drawn(number, random) @ rows.T))

    def size(self, level: float, interval: bool = True) -> Interval:
        """The largest size (m) of which less than `level` goes to coarse, and its interval.

        nan where the curve does not cross the level within the sizes that left; an end that the
        events do not close is 0 or inf.
        """
        y, line = self._grid[0], self._line(self._grid[1])
        at = _last_crossing(y, line - logit(level))
        if at is None:
            return nan, nan, nan
        if not interval:
            return exp(at), nan, nan
        below, above = (gap(self.space.stretched(y)) for gap in self._gaps)
        # sizes at which the band holds the level, next to the estimate
        here = int(np.searchsorted(y, at))
        low = _last_crossing(y[: here + 1], (line + above - logit(level))[: here + 1])
        high = _first_crossing(y[here - 1 :], (line - below - logit(level))[here - 1 :])
        return exp(at), 0.0 if low is None else exp(low), inf if high is None else exp(high)

    def sharpness(self) -> Interval:
        """d25/d75 and its interval; nan where the curve does not cross both levels."""
        d25, d75 = (self.size(level, interval=False)[0] for level in (0.25, 0.75))
        y, rows = self._grid
        lines = self._drawn(DRAWS, np.random.default_rng(0)) @ rows.T
        low, high = (_last_crossings(y, lines - logit(level)) for level in (0.25, 0.75))
        known = np.isfinite(low) & np.isfinite(high)
        if not d25 < d75 or not known.any():
            return nan, nan, nan
        value = d25 / d75
        ends = np.exp(np.quantile((low - high)[known], [1 - ndtr(LIMIT), ndtr(LIMIT)]))
        return value, min(float(ends[0]), value), max(float(ends[1]), value)

    def _drawn(self, number: int, random: np.random.Generator) -> Array:
        """Coefficients (number, size) of likely curves, as `draws` has them."""
        weight = np.array([mode.weight for mode in self.modes])
        found = []
        for mode, often in zip(self.modes, random.multinomial(number, weight), strict=True):
            hessian = self.trials.hessian(mode.penalty, mode.coefficients @ self.trials.rows.T)
            scatter = random.standard_normal((int(often), self.space.size))
            step = np.linalg.solve(np.linalg.cholesky(hessian).T, scatter.T).T
            found.append(mode.coefficients + step)
        return np.concatenate(found)

    @cached_property
    def _grid(self) -> tuple[Array, Array]:
        """ln d even in u, and the basis' rows there."""
        y = self.space.grid(401)
        return y, self.space.rows(y)

    def _line(self, rows: Array) -> Array:
        """Logit of the modes' mean T at rows of the basis, precise where T is near 0 or 1."""
        lines = np.array([rows @ mode.coefficients for mode in self.modes])
        weight = np.array([mode.weight for mode in self.modes])[:, None]
        coarse, fines = (logsumexp(log_expit(v), axis=0, b=weight) for v in (lines, -lines))
        return np.asarray(np.clip(coarse - fines, -ENDLESS, ENDLESS))

    @cached_property
    def _gaps(self) -> tuple[PchipInterpolator, PchipInterpolator]:
        """Distances of the limits' logits below and above the curve's, over u."""
        y = self.space.grid(GRID)
        rows = self.space.rows(y)
        weight = np.array([mode.weight for mode in self.modes])
        own = np.array([rows @ mode.coefficients for mode in self.modes])
        high, low = np.empty_like(own), np.empty_like(own)
        for k, mode in enumerate(self.modes):
            ends = farthest(self.trials, mode, np.concatenate([rows, -rows]))
            reached = np.sum(ends * np.concatenate([rows, rows]), axis=1)
            high[k], low[k] = reached[: y.size], reached[y.size :]
        above, below = _mixture(weight, own, high), -_mixture(weight, -own, -low)
        u, line = self.space.stretched(y), self._line(rows)
        above, below = self._reach(y, line, np.maximum(above, line), np.minimum(below, line))
        return PchipInterpolator(u, line - below), PchipInterpolator(u, above - line)

    def _reach(self, y: Array, line: Array, above: Array, below: Array) -> tuple[Array, Array]:
        """Limits moved to what the events allow: misplaced shares, and none where none was seen."""
        to_coarse, to_fines = self._misplaced
        share = expit(line)
        above = np.maximum(above, logit(share + (1 - share) * to_coarse))
        below = np.minimum(below, logit(share * (1 - to_fines)))
        trials = self.trials
        above[y > trials.place[trials.coarse < trials.number].max()] = ENDLESS
        below[y < trials.place[trials.coarse > 0].min()] = -ENDLESS
        return np.minimum(above, ENDLESS), np.maximum(below, -ENDLESS)

    @cached_property
    def _misplaced(self) -> tuple[float, float]:
        """Largest shares of all sizes that may go to coarse, and to fines, beside the curve."""
        line = self._line(self.trials.rows)
        fines = self.trials.number - self.trials.coarse
        coarse = self.trials.coarse
        return _misplaced(line, coarse, fines), _misplaced(-line, fines, coarse)


def smooth_curve(
    log_diameter: Array, coarse: Flags, weight: Array, cut: float, width: float
) -> SmoothCurve:
    """The curve of events at ln d (d in m), each with its effective `weight`, whose rough `cut`
    (ln d50) and `width` (of T's logit, in ln d) are known."""
    pieces = int(PIECES[0] + PIECES[1] * weight.sum() ** (1 / 3))
    space = Space(cut, width, float(log_diameter.min()), float(log_diameter.max()), pieces)
    trials = _trials(space, log_diameter, coarse, weight)
    y = space.grid(200)
    straight = np.clip((y - cut) / width, -SATURATED, SATURATED)
    start = np.asarray(np.linalg.lstsq(space.rows(y), straight, rcond=None)[0], dtype=float)
    return SmoothCurve(space, trials, _modes(space, trials, start))


def _modes(space: Space, trials: Trials, start: Array) -> tuple[Mode, ...]:
    """Of each prior that is not negligible beside the others."""
    found, evidence = [], []
    bending = space.roughness()
    for hinge, sigma in product(HINGE_PRIORS, ROUGHNESS):
        penalty = bending / sigma**2 + space.proper(hinge)
        start, lack, curvature = _likeliest(trials, penalty, start)
        evidence.append(-lack + 0.5 * (np.linalg.slogdet(penalty)[1] - curvature))
        found.append((penalty, start, lack))
    chance = np.exp(TRUST * (np.array(evidence) - max(evidence)))
    chance[chance < NEGLIGIBLE * chance.sum()] = 0
    chance /= chance.sum()
    return tuple(Mode(*one, float(w)) for one, w in zip(found, chance, strict=True) if w > 0)


def _trials(space: Space, log_diameter: Array, coarse: Flags, weight: Array) -> Trials:
    number = BINS * space.pieces
    if log_diameter.size > number:
        edges = np.linspace(*space.ends, number + 1)
        index = np.searchsorted(edges, space.stretched(log_diameter)) - 1
        index = np.clip(index, 0, number - 1)
        used = np.bincount(index, minlength=number) > 0

        def held(values: Array) -> Array:
            return np.asarray(np.bincount(index, values, number)[used], dtype=float)

        total, heavy = held(weight), held(weight * coarse)
        place = held(weight * log_diameter) / total
    else:
        total, heavy, place = weight, weight * coarse, log_diameter
    rows = space.rows(place)
    first, second = np.array(
        [
            (i, j)
            for i in range(space.size)
            for j in range(i, space.size)
            if j < i + 4 or j >= space.splines  # splines meet three others, hinges all
        ]
    ).T
    return Trials(place, total, heavy, rows, (first, second), rows[:, first] * rows[:, second])


def _likeliest(trials: Trials, penalty: Array, start: Array) -> tuple[Array, float, float]:
    """The likeliest coefficients (size), by Newton's method; their lack, ln det of its hessian."""
    at = start
    lack, line = trials.lack(at, penalty)
    for _ in range(NEWTON[0]):
        gradient, hessian = trials.gradient(at, penalty, line), trials.hessian(penalty, line)
        step = np.linalg.solve(hessian, gradient)
        gain = float(gradient @ step)
        if gain < CONVERGED:
            break
        for halved in range(NEWTON[1]):
            tried = at - step / 2**halved
            value, there = trials.lack(tried, penalty)
            if value < lack - 0.1 * gain / 2**halved:
                break
        at, lack, line = tried, value, there
    return at, float(lack), float(np.linalg.slogdet(hessian)[1])


def farthest(trials: Trials, mode: Mode, directions: Array) -> Array:
    """Coefficients (n, size) farthest along each of `directions` (n, size) among those whose lack
    is within LIMIT^2/2 of the mode's.

    Each round takes the farthest point of the lack's quadratic model, in closed form. All
    directions are solved at once, which no optimiser of scipy does.
    """
    found = np.tile(mode.coefficients, (directions.shape[0], 1))
    todo = np.arange(directions.shape[0])
    for _ in range(ROUNDS):
        ahead, at = directions[todo], found[todo]
        lack, line = trials.lack(at, mode.penalty)
        gradient = trials.gradient(at, mode.penalty, line)
        solved = np.linalg.solve(
            trials.hessian(mode.penalty, line), np.stack([ahead, gradient], axis=-1)
        )
        along, back = solved[..., 0], solved[..., 1]
        reach = np.sum(ahead * along, axis=-1)
        left = LIMIT**2 - 2 * (lack - mode.lack)
        pull = np.sqrt(np.maximum(left + np.sum(gradient * back, axis=-1), 0) / reach)
        step = pull[:, None] * along - back
        moved = step @ trials.rows.T
        # the model holds over a few units of a logit, or as long as it stays saturated
        allowed = 2.5 + np.maximum(np.abs(line) - 4, 0)
        allowed[(np.abs(line) > 3) & (moved * line > 0)] = inf
        step *= np.minimum(1, np.min(allowed / np.maximum(np.abs(moved), 1e-12), axis=-1))[:, None]
        found[todo] = at + step
        gain = np.sum(ahead * step, axis=-1)
        settled = (np.abs(gain) < 0.05 * LIMIT * np.sqrt(reach)) & (np.abs(left) < 0.1)
        todo = todo[~(settled | (np.sum(ahead * found[todo], axis=-1) > SATURATED))]
        if not todo.size:
            break
    return found


def _misplaced(line: Array, coarse: Array, fines: Array) -> float:
    """The share b of all that may go to coarse beside T = expit(line): T + (1 - T) b costs
    MISPLACED in ln L. 1 where the few that went to fines do not speak against it."""

    def loss(log_share: float) -> float:
        more = coarse @ np.logaddexp(0, log_share - line)  # ln(1 + b (1 - T)/T)
        return float(-more - fines.sum() * np.log1p(-exp(log_share)) - MISPLACED)

    most = log(1 - 1e-9)
    return exp(brentq(loss, log(1e-9), most, xtol=1e-3)) if loss(most) > 0 else 1.0


def _mixture(weight: Array, center: Array, end: Array) -> Array:
    """Upper limits (n) of normal distributions' mixture (modes, n), each with its own limit."""
    deviation = np.maximum((end - center) / LIMIT, 1e-9)
    low, high = center.min(axis=0), end.max(axis=0)
    level = float(ndtr(LIMIT))
    for _ in range(40):
        middle = (low + high) / 2
        below = weight @ ndtr((middle - center) / deviation) < level
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray((low + high) / 2)


def _last_crossings(at: Array, values: Array) -> Array:
    """The last places (m) where `values` (m, n) rise through 0; nan without any."""
    rising = (values[:, :-1] < 0) & (values[:, 1:] >= 0)
    last = rising.shape[1] - 1 - np.argmax(rising[:, ::-1], axis=1)
    below, above = (np.take_along_axis(values, k[:, None], axis=1)[:, 0] for k in (last, last + 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        place = at[last] - below * (at[last + 1] - at[last]) / (above - below)
    return np.asarray(np.where(rising.any(axis=1), place, nan))


def _last_crossing(at: Array, value: Array) -> float | None:
    """The last place where `value` rises through 0, linear between points; None without any."""
    return _crossing(at, value, -1)


def _first_crossing(at: Array, value: Array) -> float | None:
    """The first place where `value` rises through 0."""
    return _crossing(at, value, 0)


def _crossing(at: Array, value: Array, which: int) -> float | None:
    rising = np.flatnonzero((value[:-1] < 0) & (value[1:] >= 0))
    if not rising.size:
        return None
    k = int(rising[which])
    return float(at[k] - value[k] * (at[k + 1] - at[k]) / (value[k + 1] - value[k]))
