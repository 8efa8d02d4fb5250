"""Drag of single particles as published: one law to make references with, and tables to judge by.

The law is written here apart from the solver's and the tools', which it helps to judge; the tables
are other people's numbers. SI units; Re = |slip| d rho / mu.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from math import log10, pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Array = NDArray[np.float64]

TABLES = Path(__file__).with_name("tables")
STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True)
class Gas:
    """Density (kg/m3) and dynamic viscosity (Pa s). The default is air at 20 C, 1013 hPa."""

    density: float = 1.2
    viscosity: float = 1.8e-5


AIR = Gas()


def schiller_naumann(reynolds: float) -> float:
    """Cd: 24/Re (1 + 0.15 Re^0.687) up to Re 1000, 0.44 above. Schiller and Naumann 1935."""
    return 0.44 if reynolds > 1000 else 24 / reynolds * (1 + 0.15 * reynolds**0.687)


def terminal_velocity(
    diameter: float, density: float, gas: Gas = AIR, gravity: float = STANDARD_GRAVITY,
    law: Callable[[float], float] = schiller_naumann,
) -> float:  # fmt: skip
    """Settling velocity (m/s) in gas at rest: drag equals weight less buoyancy."""
    weight = (density - gas.density) * gravity * pi / 6 * diameter**3
    half_area = 0.5 * gas.density * pi / 4 * diameter**2
    stokes = (density - gas.density) * gravity * diameter**2 / (18 * gas.viscosity)

    def surplus(velocity: float) -> float:
        drag = law(velocity * diameter * gas.density / gas.viscosity)
        return drag * half_area * velocity**2 - weight

    return float(brentq(surplus, 1e-6 * min(stokes, 1.0), 2 * stokes, xtol=1e-15, rtol=1e-13))


def cut_size(velocity: float, density: float, gravity: float, gas: Gas = AIR) -> float:
    """Diameter (m) whose terminal velocity is `velocity` (m/s): the cut of plug flow."""

    def surplus(diameter: float) -> float:
        return terminal_velocity(diameter, density, gas, gravity) - velocity

    return float(brentq(surplus, 1e-7, 0.1, xtol=1e-15, rtol=1e-13))


def fall(
    diameter: float, density: float, upflow: float, moments: list[float], method: str = "DOP853"
) -> Array:
    """Velocities (m/s, upward) at `moments` (s) of a particle from rest in rising air, by a method
    of scipy's ODE solvers (1e-12)."""

    def slope(_time: float, velocity: Array) -> Array:
        slip = upflow - velocity[0]
        reynolds = max(abs(slip) * diameter * AIR.density / AIR.viscosity, 1e-12)
        drag = 0.75 * schiller_naumann(reynolds) * AIR.density / (density * diameter)
        return np.array([drag * slip * abs(slip) - STANDARD_GRAVITY * (1 - AIR.density / density)])

    # the kink of the law at Re 1000 is not reached by what falls here
    solution = solve_ivp(slope, (0, max(moments)), [0.0], method, moments, rtol=1e-12, atol=1e-14)
    return np.asarray(solution.y[0])


def stokes_factor(sphericity: float) -> float:
    """24/(Cd Re) of isometric particles at Re below 0.05, measured: Pettyjohn and Christiansen
    1948, Chem. Eng. Prog. 44:157."""
    return 0.843 * log10(sphericity / 0.065)


def newton_drag(sphericity: float) -> float:
    """Cd of isometric particles at Re 2000 to 200 000, measured; the same source."""
    return 5.31 - 4.88 * sphericity


def settling_exponent(reynolds: float) -> float:
    """n of Richardson and Zaki 1954, superficial slip over v_t = void^n; Re at v_t."""
    for limit, factor, power in (
        (0.2, 4.65, 0.0), (1, 4.35, -0.03), (500, 4.45, -0.1), (np.inf, 2.39, 0.0)
    ):  # fmt: skip
        if reynolds < limit:
            return float(factor * reynolds**power)
    raise ValueError(f"Reynolds number {reynolds}")


def read_table(name: str) -> list[dict[str, str]]:
    """Rows of references/tables/NAME.csv, whose lines of source begin with #."""
    with (TABLES / f"{name}.csv").open() as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))
