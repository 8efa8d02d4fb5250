"""The weight of a Hertzian dashpot's first step: a cubic for -zeta(-1/4, 1 + theta).

The cubic goes through Chebyshev's four points of 0 <= theta <= 1. It is judged by what it is for:
with it, the sum of a force ~ t^(1/4) over steps from a contact's beginning on is the integral but
for what the trapezoidal rule leaves at the other end.
"""

from __future__ import annotations

from math import factorial

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from numpy.typing import NDArray
from scipy.special import bernoulli

from elutria_validation.fits.constants import Constant, Fit

Array = NDArray[np.float64]

POWER = 0.25
USED = ("0.3203419", "0.8638905", "0.1641759", "-0.0280252")


def hurwitz(s: float, q: Array, terms: int = 30, orders: int = 8) -> Array:
    """zeta(s, q) by Euler and Maclaurin, also for s < 0, where scipy has none."""
    far = q + terms
    value = np.sum([(q + k) ** -s for k in range(terms)], axis=0)
    value += far ** (1 - s) / (s - 1) + 0.5 * far**-s
    rising = s
    for j in range(1, orders + 1):
        value += bernoulli(2 * j)[-1] / factorial(2 * j) * rising * far ** (-s - 2 * j + 1)
        rising *= (s + 2 * j - 1) * (s + 2 * j)
    return np.asarray(value)


def exact(theta: Array) -> Array:
    """The weight that keeps second order."""
    return -hurwitz(-POWER, 1 + np.asarray(theta, dtype=float))


def summed(weight: Polynomial, theta: Array, steps: int = 400) -> Array:
    """Error of the sum over steps of t^(1/4), which begins theta before the first step, over the
    force of a whole step."""
    whole = np.arange(1, steps)[:, None] + theta
    end = steps + theta
    total = weight(theta) + (whole**POWER).sum(axis=0) + 0.5 * end**POWER
    # the trapezoidal rule's own error at the end, which is not the beginning's
    end_error = POWER * end ** (POWER - 1) / 12
    return np.asarray(total - end ** (1 + POWER) / (1 + POWER) - end_error)


def fit() -> Fit:
    """The cubic's coefficients."""
    today = Chebyshev.interpolate(exact, 3, domain=[0, 1]).convert(kind=Polynomial)
    used = Polynomial([float(text) for text in USED])
    between = np.linspace(0, 1, 1001)
    others = np.random.default_rng(1).uniform(0, 1, 500)
    return Fit(
        "Onset weight of Hertz' dashpot",
        "ContactForce.hpp",
        tuple(
            Constant(f"theta^{n}, size", text.lstrip("-"), float(abs(value)))
            for n, (text, value) in enumerate(zip(USED, today.coef, strict=True))
        ),
        "largest error of the weight; of a contact's sum over its steps, in whole steps' forces",
        float(np.abs(used(between) - exact(between)).max()),
        float(np.abs(summed(used, others)).max()),
        2e-4,
    )  # fmt: skip
