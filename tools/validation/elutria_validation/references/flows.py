"""Closed forms of beds and of classification in a vertical gas stream. SI units."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from elutria_validation.references.drag import AIR, STANDARD_GRAVITY, Gas

Array = NDArray[np.float64]


def ergun(velocity: float, diameter: float, void: float, gas: Gas = AIR) -> float:
    """Pressure gradient (Pa/m) of a bed at a superficial velocity; Ergun 1952."""
    solids = 1 - void
    viscous = 150 * solids**2 / void**3 * gas.viscosity * velocity / diameter**2
    return viscous + 1.75 * solids / void**3 * gas.density * velocity**2 / diameter


def minimum_fluidisation(diameter: float, density: float, void: float, gas: Gas = AIR) -> float:
    """Superficial velocity (m/s) at which Ergun's gradient carries the bed's weight."""
    weight = (1 - void) * (density - gas.density) * STANDARD_GRAVITY
    return float(brentq(lambda u: ergun(u, diameter, void, gas) - weight, 1e-6, 100))


def pipe_fines_share(terminal: ArrayLike, velocity: float) -> Array:
    """Laminar round pipe, feed uniform over the section, no lateral motion: 1 - v_t/(2U)."""
    return np.clip(1 - np.asarray(terminal) / (2 * velocity), 0, 1)


def channel_fines_share(terminal: ArrayLike, velocity: float) -> Array:
    """Laminar plane channel, fed and moving likewise: sqrt(1 - v_t/(1.5 U))."""
    return np.sqrt(np.clip(1 - np.asarray(terminal) / (1.5 * velocity), 0, 1))


def drift_fines_share(drift: Array, dispersion: Array, length: Array) -> Array:
    """Drift w (m/s) with axial dispersion D (m2/s) from the middle of `length` (m) to absorbing
    ends: (1 - exp(-w L/2D))/(1 - exp(-w L/D)), which is 1/(1 + exp(-w L/2D))."""
    return np.asarray(1 / (1 + np.exp(-drift * length / (2 * dispersion))))


def contact_value(solids: float) -> float:
    """Radial distribution function at contact; Carnahan and Starling 1969."""
    return (1 - solids / 2) / (1 - solids) ** 3


def kurtosis_factor(restitution: float) -> float:
    """1 + 3/16 a2: cooling of the velocities' true distribution over the Gaussian's.

    van Noije and Ernst 1998, doi 10.1007/s100350050009.
    """
    e = restitution
    a2 = 16 * (1 - e) * (1 - 2 * e**2) / (81 - 17 * e + 30 * e**2 * (1 - e))
    return 1 + 3 / 16 * a2
