"""What a fitted formula leaves of the events' partition curve.

No formula of two parameters describes a column to the last tenth of a percent: with ten thousand
events the likeliest one may put d50 several of its own deviations aside, and two that are as likely
may lie 0.4 % apart. So the logit of T is the formula's, its parameters free to move, plus a broken
line over ln d with a normal prior about nothing: few events leave the formula as it is, many show
what it cannot say, and the intervals widen by what is not known of that.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import exp, log, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize
from scipy.special import expit, logit

from elutria.classification.curves import Model
from elutria.classification.likelihood import Likelihood, sensitivity

Array = NDArray[np.float64]

KNOTS = (0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98)
"""Shares at which the formula has the line's knots; beyond the outer ones it is constant."""
LIMIT = 1.96
"""Standard deviations of a 95 % interval's end."""
PRIOR = 0.25
"""Standard deviation of the line at its knots: columns' curves are off a formula by so much."""


@dataclass(frozen=True)
class Misfit:
    """The line beside a formula of `model` with the parameters `p` (ln d, ln s, bypass).

    `moved` are the changes of the `free` parameters and the line's values at its `knots` (ln d/m).
    """

    model: Model = field(compare=False)
    p: Array = field(compare=False)
    free: list[int] = field(compare=False)
    knots: Array = field(compare=False)
    moved: Array = field(compare=False)
    information: Array = field(compare=False)

    def share(self, diameter: Array) -> Array:
        """T at `diameter` (m)."""
        return np.asarray(expit(self._logit(np.log(diameter))))

    def band(self, diameter: Array, low: Array, high: Array) -> tuple[Array, Array]:
        """The formula's 95 % limits of T, moved with the curve and widened, in the tails by as much
        as at the outer knots."""
        at = np.log(diameter)
        formula, basis = self._formula(at)
        change = basis @ self.moved
        inside = np.clip(at, self.knots[0], self.knots[-1])
        own, every = self._deviations(self._formula(inside)[1])
        more = LIMIT * np.maximum(every - own, 0)
        with np.errstate(divide="ignore"):
            lower, upper = (logit(end) + change for end in (low, high))
        share = expit(formula + change)
        return np.minimum(expit(lower - more), share), np.maximum(expit(upper + more), share)

    def size(self, formula: float, low: float, high: float) -> tuple[float, float, float]:
        """The formula's size (m) at a level and its interval, moved and widened."""
        level = float(expit(self._formula(np.array([log(formula)]))[0][0]))
        log_d = self._log_diameter(level, log(formula))
        if not low > 0:
            return exp(log_d), low, high
        wider = self._wider(log_d)
        return (
            exp(log_d),
            exp(log_d + wider * (log(low) - log(formula))),
            exp(log_d + wider * (log(high) - log(formula))) if high < np.inf else high,
        )

    def sharpness_deviation(self, d25: float, d75: float) -> float:
        """Standard deviation of d25/d75 (sizes in m)."""
        at = np.log([d25, d75])
        basis, step = self._formula(at)[1], 1e-6
        slope = (self._logit(at + step) - self._logit(at - step)) / (2 * step)
        gradient = -basis[0] / slope[0] + basis[1] / slope[1]
        return d25 / d75 * sqrt(gradient @ np.linalg.solve(self.information, gradient))

    def _formula(self, log_diameter: Array) -> tuple[Array, Array]:
        """The formula's logit, and what `moved` adds to it (n, all)."""
        inner, share, columns = sensitivity(self.model, self.p, log_diameter)
        # beside a bypass of 0 the inner logit keeps its precision in the tails
        whole = inner if self.p[2] == 0 else logit(share)
        return whole, np.column_stack([columns[self.free].T, _hats(self.knots, log_diameter)])

    def _logit(self, log_diameter: Array) -> Array:
        formula, basis = self._formula(log_diameter)
        return np.asarray(formula + basis @ self.moved)

    def _deviations(self, basis: Array) -> tuple[Array, Array]:
        """Standard deviations of logits (n): as the formula alone has them, and with the line."""
        own = len(self.free)
        alone, whole = self.information[:own, :own], self.information

        def deviation(rows: Array, matrix: Array) -> Array:
            return np.asarray(np.sqrt(np.einsum("ij,ji->i", rows, np.linalg.solve(matrix, rows.T))))

        return deviation(basis[:, :own], alone), deviation(basis, whole)

    def _wider(self, log_diameter: float) -> float:
        """The deviation of a size over that which the formula alone would have."""
        own, every = self._deviations(self._formula(np.array([log_diameter]))[1])
        return max(float(every[0] / own[0]), 1.0)

    def _log_diameter(self, share: float, start: float) -> float:
        """ln d where T is `share`, near that of the formula."""

        def off(log_diameter: float) -> float:
            return float(self._logit(np.array([log_diameter]))[0] - logit(share))

        reach = 1e-3
        while off(start - reach) * off(start + reach) > 0:
            reach *= 2
            if reach > 1:
                return start
        return float(brentq(off, start - reach, start + reach, xtol=1e-9))


def find_misfit(
    likelihood: Likelihood,
    model: Model,
    p: Array,
    free: list[int],
    diameter_at: Callable[[float], float],
) -> Misfit | None:
    """The likeliest line beside a fitted formula, whose inverse is `diameter_at`(share), m; None
    where the events do not tell the formula's parameters apart."""
    knots = np.log([diameter_at(share) for share in KNOTS if share > p[2] + 0.01])
    if knots.size < 2 or not np.diff(knots).min() > 1e-9:
        return None
    own = len(free)
    nothing = Misfit(model, p, free, knots, np.zeros(own + knots.size), np.eye(own + knots.size))
    formula, basis = nothing._formula(likelihood.log_diameter)
    weight, coarse = likelihood.weight, likelihood.coarse
    prior = np.concatenate([np.zeros(own), np.full(knots.size, PRIOR**-2)])

    def lack(moved: Array) -> tuple[float, Array]:
        line = formula + basis @ moved
        chance = np.logaddexp(0, np.where(coarse, -line, line))
        slope = basis.T @ (weight * (expit(line) - coarse)) + prior * moved
        return float(weight @ chance + 0.5 * prior @ moved**2), slope

    def information(moved: Array) -> Array:
        share = expit(formula + basis @ moved)
        return np.asarray((basis.T * (weight * share * (1 - share))) @ basis + np.diag(prior))

    if np.linalg.cond(information(nothing.moved)[:own, :own]) > 1e12:
        return None
    found = minimize(lack, nothing.moved, jac=True, hess=information, method="trust-exact")
    return Misfit(model, p, free, knots, np.asarray(found.x), information(found.x))


def _hats(knots: Array, at: Array) -> Array:
    """Shares (n, knots) of the knots' values in a broken line's, constant beyond the outer ones."""
    return np.column_stack([np.interp(at, knots, row) for row in np.eye(knots.size)])
