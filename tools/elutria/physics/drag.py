"""Terminal velocity of a single particle and its inverse, by the solver's drag laws. SI units.

A law is named as a case's particleForces name it (``SchillerNaumannDrag``) or by its title
(``Schiller-Naumann``); its formula, range and source stand in solver/coupling/laws/drag.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elutria.physics import laws
from elutria.physics.laws import Grain, drag_coefficient

__all__ = ["GRAVITY", "Gas", "Grain", "drag_coefficient", "plug_flow_cut_size", "terminal_velocity"]

GRAVITY = 9.81
"""m/s2, where a case does not say otherwise."""

SMALLEST_CUT, LARGEST_CUT = 1e-7, 0.1
"""m: a cut beyond is not looked for."""


@dataclass(frozen=True)
class Gas:
    """Density (kg/m3) and dynamic viscosity (Pa s). The default is air at 20 C, 1013 hPa."""

    density: float = 1.2
    viscosity: float = 1.8e-5


def terminal_velocity(
    diameter: float,
    grain: Grain | float,
    gas: Gas,
    law: str = "Schiller-Naumann",
    gravity: float = GRAVITY,
) -> float:
    """Settling velocity (m/s) of one grain in gas at rest: drag equals weight less buoyancy. A
    number is the density of a sphere.

    Raises ValueError for a grain that is not denser than the gas.
    """
    grain = _grain(grain)
    if grain.density <= gas.density:
        raise ValueError(f"particle density {grain.density:g} kg/m3 must exceed the gas's")
    medium = (gas.density, gas.viscosity)
    return float(laws.terminal_velocities(law, np.array([diameter]), grain, medium, gravity)[0])


def plug_flow_cut_size(
    velocity: float,
    grain: Grain | float,
    gas: Gas,
    law: str = "Schiller-Naumann",
    gravity: float = GRAVITY,
) -> float:
    """Diameter (m) whose terminal velocity is `velocity` (m/s): the cut in uniform gas.

    NaN when it lies outside 0.1 um to 0.1 m.
    """
    size = laws.settling_sizes(
        law,
        np.array([velocity]),
        _grain(grain),
        (gas.density, gas.viscosity),
        gravity,
        (SMALLEST_CUT, LARGEST_CUT),
    )[0]
    return float(size) if size > 0 else float("nan")


def _grain(given: Grain | float) -> Grain:
    return given if isinstance(given, Grain) else Grain(given)
