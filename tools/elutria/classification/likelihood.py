"""Likelihood of partition events under a formula, and its maximum."""

from __future__ import annotations

from math import log1p

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit, log_expit

from elutria.classification.curves import Model

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MAX_BYPASS = 0.6
"""Beyond it more than half of the finest go to coarse, and there is no cut."""
GROUPS = 2_000


class Likelihood:
    """ln L of events and its gradient against p = (ln d, ln s, bypass), ln d that of the cut
    without bypass.

    `weight` adds up to the effective number of events. Beyond twice GROUPS, neighbours in size are
    taken together, at their mean ln d.
    """

    def __init__(self, log_diameter: Array, coarse: Flags, weight: Array):
        heavy = np.where(coarse, weight, 0.0)
        if log_diameter.size > 2 * GROUPS:
            order = np.argsort(log_diameter)
            first = np.linspace(0, order.size, GROUPS, endpoint=False).astype(int)
            place = np.add.reduceat((weight * log_diameter)[order], first)
            weight, heavy = (np.add.reduceat(v[order], first) for v in (weight, heavy))
            log_diameter = place / weight
        self.log_diameter = log_diameter
        self.coarse = heavy
        self.weight = weight

    def value(self, model: Model, p: Array) -> tuple[float, Array]:
        """ln L and its gradient (3)."""
        inner, along, shape = model.logit(self.log_diameter - p[0], p[1])
        bypass = p[2]
        rising = expit(inner)
        share = np.maximum(bypass + (1 - bypass) * rising, 1e-300)
        log_coarse = log_expit(inner) if bypass == 0 else np.log(share)
        log_fines = log_expit(-inner) + log1p(-bypass)
        value = self.coarse @ log_coarse + (self.weight - self.coarse) @ log_fines
        # d ln L by T over the slopes of T's logit: 1 - T = (1 - bypass)(1 - rising)
        pull = self.coarse - self.weight * share
        steep = pull * rising / share
        by_bypass = pull / (np.maximum(share, 1e-12) * (1 - bypass))
        return float(value), np.array([-steep @ along, steep @ shape, by_bypass.sum()])

    def maximize(self, model: Model, start: Array, with_bypass: bool) -> tuple[Array, float]:
        """The likeliest p and its ln L; without bypass p[2] stays 0."""
        free = 3 if with_bypass else 2
        ends = self.log_diameter.min(), self.log_diameter.max()
        bounds = [(ends[0] - 3, ends[1] + 3), model.bounds, (0.0, MAX_BYPASS)][:free]
        scale = np.array([np.exp(-start[1]), 1.0, 0.1])[:free]  # changes that matter alike

        def lack(moved: Array) -> tuple[float, Array]:
            p = np.zeros(3)
            p[:free] = moved * scale
            value, gradient = self.value(model, p)
            return -value, -gradient[:free] * scale

        found = minimize(
            lack, start[:free] / scale, jac=True, method="L-BFGS-B",
            bounds=[(low / s, high / s) for (low, high), s in zip(bounds, scale, strict=True)],
            options={"ftol": 1e-12, "gtol": 1e-4},
        )  # fmt: skip
        p = np.zeros(3)
        p[:free] = found.x * scale
        return p, -float(found.fun)
