"""Models of a partition curve T(d): the share of size d that goes to coarse.

Each is a scale family T(x; s) of x = d/d50 with T(1) = 1/2 and one shape parameter s; a bypass b,
the share of the finest particles that still goes to coarse, lifts it to b + (1 - b) T.

- log-logistic            1/(1 + x^-s)
- Rosin-Rammler (Plitt)   1 - exp(-ln2 x^s)
- Whiten                  (e^(s x) - 1)/(e^(s x) + e^s - 2)
- Molerus-Hoffmann        1/(1 + x^-2 exp(s (1 - x^2))), made for air classifiers
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Model:
    """A curve's logit as function of ln x and ln s, its inverse, and a start and bounds for ln s.

    The logit ln(T/(1 - T)) keeps its precision where T is near 0 or 1. `spread` is the shape ln s
    whose d75/d25 is about e^w for a given w: where a fit starts.
    """

    name: str
    logit: Callable[[Array, float], Array]
    start: Callable[[float], float]
    bounds: tuple[float, float]

    def share(self, x: Array, log_shape: float) -> Array:
        """T at x = d/d50."""
        with np.errstate(divide="ignore"):
            return np.asarray(expit(self.logit(np.log(x), log_shape)))

    def log_x_at(self, share: float, log_shape: float) -> float:
        """ln x where T is `share`; the logit rises with x, so it is found by bisection."""
        target = np.log(share / (1 - share))
        low, high = -1.0, 1.0
        while self._at(low, log_shape) > target and low > -60:
            low *= 2
        while self._at(high, log_shape) < target and high < 60:
            high *= 2
        for _ in range(60):
            middle = 0.5 * (low + high)
            if self._at(middle, log_shape) < target:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    def _at(self, log_x: float, log_shape: float) -> float:
        return float(self.logit(np.array([log_x]), log_shape)[0])


def _log_logistic(log_x: Array, log_shape: float) -> Array:
    return np.exp(log_shape) * log_x


def _rosin_rammler(log_x: Array, log_shape: float) -> Array:
    # T/(1-T) = exp(h) - 1 with h = ln2 x^s
    h = np.log(2) * np.exp(np.clip(np.exp(log_shape) * log_x, -700, 700))
    return _log_of_exp_minus_one(h)


def _whiten(log_x: Array, log_shape: float) -> Array:
    # T/(1-T) = (e^(sx) - 1)/(e^s - 1)
    s = np.exp(log_shape)
    x = np.exp(np.clip(log_x, -700, 50))
    return _log_of_exp_minus_one(s * x) - _log_of_exp_minus_one(np.asarray(s))


def _molerus_hoffmann(log_x: Array, log_shape: float) -> Array:
    # T/(1-T) = x^2 exp(s (x^2 - 1))
    x_squared = np.exp(np.clip(2 * log_x, -700, 100))
    return 2 * log_x + np.exp(log_shape) * (x_squared - 1)


def _log_of_exp_minus_one(h: Array) -> Array:
    small = np.minimum(h, 30.0)
    return np.where(h > 30.0, h, np.log(np.expm1(np.maximum(small, 1e-300))))


MODELS = (
    # 2 ln3/w, and so on: from each curve's slope d(logit)/d(ln x) at the cut
    Model("log-logistic", _log_logistic, lambda w: np.log(2.2 / w), (-3.0, 9.0)),
    Model("Rosin-Rammler", _rosin_rammler, lambda w: np.log(1.57 / w), (-3.0, 9.0)),
    Model("Whiten", _whiten, lambda w: np.log(2.2 / w), (-3.0, 9.0)),
    Model("Molerus-Hoffmann", _molerus_hoffmann, lambda w: np.log(1.1 / w), (-9.0, 9.0)),
)
