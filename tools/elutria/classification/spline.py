"""The space of partition curves without a formula: what a logit may be, and how likely it is.

The logit of T over y = ln d is a cubic spline with hinges on both sides of the cut. Sizes are
measured from the cut in widths c of the cut: u = asinh((y - cut)/c), about y/c near the cut and
ln|y| far from it, so that a curve may bend over distances in proportion to that from the cut.
Bending is the departure from a straight line in y (a log-logistic curve), per unit of u; the hinges
let each tail be flatter (a bypass) or steeper (Rosin-Rammler's upper end, the steps on either side
of a shelf) than the cut's slope says.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

Array = NDArray[np.float64]

HINGES = (0.8, 1.6, 3.2)
"""Distances of the hinges from the cut, in c: where a log-logistic curve is 0.31, 0.17 and 0.04 on
one side. The knee of a bypass or of a hook may lie at any of them; a hinge at a single place made
d50 too coarse by a third of half its interval."""
HINGE_PRIORS = (1.0, 4.0)
"""Standard deviations of the change of slope at the first hinge, over the slope at the cut; those
of the others are smaller, as one over their distance. A bypass takes the whole slope away, 1; each
of two steps is several times as steep as the one cut that both together are taken for."""
SLOPE_PRIOR = 15.0
"""Standard deviation of the slope over 1/c: keeps a perfect cut's slope finite."""
LEVEL_PRIOR = 50.0
"""Standard deviation of the mean logit: keeps it finite."""


@dataclass(frozen=True)
class Space:
    """Splines over the sizes from `low` to `high` (ln d/m) with a cut of `width` c at `cut`."""

    cut: float
    width: float
    low: float
    high: float
    pieces: int

    @property
    def size(self) -> int:
        """Number of coefficients: splines, then the hinges."""
        return self.splines + 2 * len(HINGES)

    @property
    def splines(self) -> int:
        """Number of splines."""
        return self.pieces + 3

    def stretched(self, log_diameter: Array) -> Array:
        """u of ln d."""
        return np.asarray(np.arcsinh((log_diameter - self.cut) / self.width))

    @property
    def ends(self) -> tuple[float, float]:
        """u of `low` and `high`."""
        low, high = self.stretched(np.array([self.low, self.high]))
        return float(low), float(high)

    def grid(self, number: int) -> Array:
        """ln d of points even in u, from `low` to `high`."""
        inner = self.cut + self.width * np.sinh(np.linspace(*self.ends, number))
        return np.asarray(np.clip(inner, self.low, self.high))

    def rows(self, log_diameter: Array) -> Array:
        """Values (n, size) of the basis at ln d; beyond the ends those of the ends."""
        y = np.clip(log_diameter, self.low, self.high)
        x = (y - self.cut) / self.width
        hinges = [sign * _ramp(sign * x - at) for at in HINGES for sign in (-1, 1)]
        return np.column_stack([self._splines(self.stretched(y), 0), *hinges])

    def roughness(self) -> Array:
        """Matrix (size, size) of the integrated squared bending."""
        ends = np.linspace(*self.ends, self.pieces + 1)
        node, weight = np.polynomial.legendre.leggauss(4)
        half = np.diff(ends) / 2
        u = (ends[:-1, None] + half[:, None] * (1 + node)).ravel()
        # d2/dx2 at x = sinh u, times cosh^2 u
        bending = self._splines(u, 2) - np.tanh(u)[:, None] * self._splines(u, 1)
        matrix = np.zeros((self.size, self.size))
        n = self.splines
        matrix[:n, :n] = (bending.T * (half[:, None] * weight).ravel()) @ bending
        return matrix

    def proper(self, hinge: float) -> Array:
        """Precision (size, size) of what bending leaves free: mean logit, slope, and the hinges'
        changes of slope, of standard deviation `hinge` at the first."""
        u = np.linspace(*self.ends, 201)
        rows, near = self._splines(u, 0), np.cosh(u) ** -2
        near /= near.sum()
        distance = np.sinh(u) - near @ np.sinh(u)
        level = near @ rows
        slope = (near * distance / (near @ distance**2)) @ rows
        n = self.splines
        deviation = np.repeat(hinge * HINGES[0] / np.array(HINGES), 2)
        matrix = np.diag(np.append(np.full(n, 1e-9), deviation**-2))
        matrix[:n, :n] += np.outer(level, level) / LEVEL_PRIOR**2
        matrix[:n, :n] += np.outer(slope, slope) / SLOPE_PRIOR**2
        return matrix

    def _splines(self, u: Array, derivative: int) -> Array:
        low, high = self.ends
        step = (high - low) / self.pieces
        knots = low + step * np.arange(-3, self.pieces + 4)
        splines = BSpline(knots, np.eye(self.splines), 3)
        inside = np.clip(u, low, high)
        return np.asarray((splines.derivative(derivative) if derivative else splines)(inside))


def _ramp(x: Array) -> Array:
    """max(x, 0) with its corner rounded."""
    return np.asarray(np.logaddexp(0, 2 * x) / 2)
