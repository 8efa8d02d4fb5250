"""Likelihood of partition events under a curve, and the parameters that make it largest."""

from __future__ import annotations

from math import log1p

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, log_expit

from elutria.classification.curves import Model

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MAX_BYPASS = 0.6
"""Beyond it more than half of the finest go to coarse, and there is no cut."""


class Likelihood:
    """ln L of events, its gradient and Fisher information, against p = (ln d, ln s, bypass).

    ln d is that of the cut without bypass, or of a `level` of the whole curve.
    """

    def __init__(self, log_diameter: Array, coarse: Flags, weight: Array):
        self.log_diameter = log_diameter
        self.coarse = coarse
        self.weight = weight

    def value(self, model: Model, p: Array, level: float | None = None) -> float:
        """ln L."""
        logit = model.logit(self.log_diameter - _center(model, p, level)[0], p[1])[0]
        return float(self.weight @ self._log_chance(logit, p[2]))

    def _log_chance(self, logit: Array, bypass: float) -> Array:
        if bypass == 0:
            return np.asarray(log_expit(np.where(self.coarse, logit, -logit)))
        log_coarse = np.log(bypass + (1 - bypass) * expit(logit))
        return np.asarray(np.where(self.coarse, log_coarse, log_expit(-logit) + log1p(-bypass)))

    def derivatives(
        self, model: Model, p: Array, level: float | None = None
    ) -> tuple[float, Array, Array]:
        """ln L, its gradient (3) and the expected information (3 x 3)."""
        logit, share, columns = sensitivity(model, p, self.log_diameter, level)
        gradient = columns @ (self.weight * (self.coarse - share))
        information = (columns * (self.weight * share * (1 - share))) @ columns.T
        return float(self.weight @ self._log_chance(logit, p[2])), gradient, information


def sensitivity(
    model: Model, p: Array, log_diameter: Array, level: float | None = None
) -> tuple[Array, Array, Array]:
    """The logit without bypass and T at each ln d, and the derivatives (3, n) of T's logit by p."""
    center, by_shape, by_bypass = _center(model, p, level)
    logit, along, shape = model.logit(log_diameter - center, p[1])
    bypass = p[2]
    inner = expit(logit)
    share = bypass + (1 - bypass) * inner
    # dT/dp over T (1 - T); 1 - T = (1 - bypass)(1 - inner)
    steep = inner / np.maximum(share, 1e-300)
    columns = np.stack(
        [
            -steep * along,
            steep * (shape - along * by_shape),
            1 / (np.maximum(share, 1e-12) * (1 - bypass)) - steep * along * by_bypass,
        ]
    )
    return logit, share, columns


def _center(model: Model, p: Array, level: float | None) -> tuple[float, float, float]:
    """ln d of the cut without bypass, and its derivatives by ln s and by the bypass."""
    if level is None:
        return float(p[0]), 0.0, 0.0
    bypass = float(p[2])
    inner = (level - bypass) / (1 - bypass)
    y = model.log_x_at(inner, float(p[1]))
    _, along, shape = (float(v[0]) for v in model.logit(np.array([y]), float(p[1])))
    by_bypass = (1 - level) / (1 - bypass) ** 2 / (inner * (1 - inner)) / along
    return float(p[0]) - y, shape / along, by_bypass


def maximize(
    likelihood: Likelihood,
    model: Model,
    start: Array,
    free: list[int],
    upper_bypass: float,
    level: float | None = None,
    tolerance: float = 1e-7,
) -> tuple[Array, float]:
    """Fisher scoring with Levenberg's damping over the `free` parameters, within their bounds.

    Ends when a step can gain less than `tolerance` in ln L.
    """
    low = np.array([likelihood.log_diameter.min() - 3, model.bounds[0], 0.0])
    high = np.array([likelihood.log_diameter.max() + 3, model.bounds[1], upper_bypass])
    p, damping = np.clip(start, low, high), 1e-6
    value, gradient, information = likelihood.derivatives(model, p, level)
    for _ in range(100):
        stuck = ((p <= low) & (gradient < 0)) | ((p >= high) & (gradient > 0))
        moving = [k for k in free if not stuck[k]]
        if not moving:
            break
        matrix = information[np.ix_(moving, moving)]
        scale = np.diag(matrix) + 1e-12
        step = np.zeros(3)
        step[moving] = np.linalg.solve(matrix + np.diag(damping * scale), gradient[moving])
        if gradient @ step < 2 * tolerance:
            break
        step[1] = np.clip(step[1], -1.0, 1.0)
        trial = np.clip(p + step, low, high)
        better = likelihood.derivatives(model, trial, level)
        if better[0] >= value:
            p, (value, gradient, information) = trial, better
            damping = max(damping / 10, 1e-9)
        elif damping > 1e6:
            break
        else:
            damping = max(damping * 10, 1e-3)
    return p, value
