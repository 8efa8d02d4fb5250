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
from scipy.special import expit, wrightomega

Array = NDArray[np.float64]
Logit = tuple[Array, Array, Array]


@dataclass(frozen=True)
class Model:
    """A curve by its logit l = ln(T/(1 - T)), which keeps its precision where T is near 0 or 1.

    `logit(y, a)` gives l and its derivatives by y = ln x and by a = ln s; `log_x(l, a)` inverts it;
    `slope` is about dl/dy at the cut over s, from which a fit starts.
    """

    name: str
    logit: Callable[[Array, float], Logit]
    log_x: Callable[[float, float], float]
    slope: float
    bounds: tuple[float, float] = (-6.0, 9.0)

    def share(self, x: Array, log_shape: float) -> Array:
        """T at x = d/d50."""
        return np.asarray(expit(self.logit(np.log(x), log_shape)[0]))

    def log_x_at(self, share: float, log_shape: float) -> float:
        """ln x where T is `share`."""
        return self.log_x(float(np.log(share / (1 - share))), log_shape)

    def start(self, spread: float) -> float:
        """ln s of a curve that rises over about `spread` in ln d."""
        return float(np.clip(np.log(2.2 / (self.slope * spread)), *self.bounds))


def _log_logistic(y: Array, a: float) -> Logit:
    s = np.exp(a)
    return s * y, np.full_like(y, s), s * y


def _rosin_rammler(y: Array, a: float) -> Logit:
    # T/(1 - T) = e^h - 1 with h = ln2 x^s
    s = np.exp(a)
    h = np.log(2) * _exp(s * y)
    rise = h / -np.expm1(-h)
    return _log_expm1(h), s * rise, s * y * rise


def _whiten(y: Array, a: float) -> Logit:
    # T/(1 - T) = (e^(s x) - 1)/(e^s - 1)
    s = np.exp(a)
    h = s * _exp(y)
    rise = h / -np.expm1(-h)
    return _log_expm1(h) - _log_expm1(s), rise, rise - s / -np.expm1(-s)


def _molerus_hoffmann(y: Array, a: float) -> Logit:
    # T/(1 - T) = x^2 e^(s (x^2 - 1))
    s, x2 = np.exp(a), _exp(2 * y)
    return 2 * y + s * (x2 - 1), 2 + 2 * s * x2, s * (x2 - 1)


def _exp(value: Array) -> Array:
    return np.asarray(np.exp(np.clip(value, -200, 100)))


def _log_expm1(h: Array) -> Array:
    """ln(e^h - 1) without overflow."""
    return np.asarray(h + np.log(-np.expm1(-h)))


def _log_logistic_inverse(t: float, a: float) -> float:
    return float(t / np.exp(a))


def _rosin_rammler_inverse(t: float, a: float) -> float:
    return float(np.log(np.logaddexp(0, t) / np.log(2)) / np.exp(a))


def _whiten_inverse(t: float, a: float) -> float:
    return float(np.log(np.logaddexp(0, t + _log_expm1(np.exp(a)))) - a)


def _molerus_hoffmann_inverse(t: float, a: float) -> float:
    # x^2 s + ln(x^2 s) = t + s + ln s
    return float((np.log(wrightomega(t + np.exp(a) + a)) - a) / 2)


MODELS = (
    Model("log-logistic", _log_logistic, _log_logistic_inverse, 1.0),
    Model("Rosin-Rammler", _rosin_rammler, _rosin_rammler_inverse, 1.4),
    Model("Whiten", _whiten, _whiten_inverse, 1.2),
    Model("Molerus-Hoffmann", _molerus_hoffmann, _molerus_hoffmann_inverse, 2.0),
)
