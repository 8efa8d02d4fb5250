"""Drag coefficients of single particles, and what follows: terminal velocity and its inverse.

SI units throughout; Re = |slip| d rho / mu. Laws are functions of Re (and sphericity) and say
where they come from.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, log10, pi

from fluids.drag import Clift
from fluids.numerics import brenth

GRAVITY = 9.81
"""m/s2, where a case does not say otherwise."""


@dataclass(frozen=True)
class Gas:
    """Density (kg/m3) and dynamic viscosity (Pa s). The default is air at 20 C, 1013 hPa."""

    density: float = 1.2
    viscosity: float = 1.8e-5


def schiller_naumann(reynolds: float, _sphericity: float = 1.0) -> float:
    """24/Re (1 + 0.15 Re^0.687) up to Re 1000, 0.44 above. Schiller and Naumann 1935."""
    if reynolds > 1000:
        return 0.44
    return float(24 / reynolds * (1 + 0.15 * reynolds**0.687))


def putnam(reynolds: float, _sphericity: float = 1.0) -> float:
    """24/Re (1 + Re^(2/3)/6) up to Re 1000, 0.424 above. Putnam 1961; OpenFOAM's sphereDrag."""
    if reynolds > 1000:
        return 0.424
    return float(24 / reynolds * (1 + reynolds ** (2 / 3) / 6))


def clift(reynolds: float, _sphericity: float = 1.0) -> float:
    """The piecewise standard curve of Clift, Grace and Weber 1978, up to Re 1e6."""
    return float(Clift(reynolds))


def haider_levenspiel(reynolds: float, sphericity: float = 1.0) -> float:
    """24/Re (1 + a Re^b) + c Re/(d + Re), Haider and Levenspiel 1989; OpenFOAM's nonSphereDrag."""
    a = exp(2.3288 - 6.4581 * sphericity + 2.4486 * sphericity**2)
    b = 0.0964 + 0.5565 * sphericity
    c = exp(4.905 - 13.8944 * sphericity + 18.4222 * sphericity**2 - 10.2599 * sphericity**3)
    d = exp(1.4681 + 12.2584 * sphericity - 20.7322 * sphericity**2 + 15.8855 * sphericity**3)
    return float(24 / reynolds * (1 + a * reynolds**b) + c * reynolds / (d + reynolds))


def ganser(reynolds: float, sphericity: float = 1.0) -> float:
    """Stokes' and Newton's shape factors from the sphericity, isometric particles. Ganser 1993.

    With the published coefficients a sphere has up to 27 % less drag than Clift's curve (Re 100).
    """
    stokes = 3 / (1 + 2 / sphericity**0.5)
    newton = 10 ** (1.8148 * (-log10(sphericity)) ** 0.5743)
    shaped = reynolds * stokes * newton
    laminar = 24 / (reynolds * stokes) * (1 + 0.1118 * shaped**0.6567)
    return float(laminar + newton * 0.4305 * shaped / (shaped + 3305))


def di_felice(reynolds: float, _sphericity: float = 1.0) -> float:
    """(0.63 + 4.8/Re^0.5)^2, the single-particle limit of Di Felice 1994."""
    return float((0.63 + 4.8 / reynolds**0.5) ** 2)


DragLaw = Callable[[float, float], float]

LAWS: dict[str, DragLaw] = {
    "Schiller-Naumann": schiller_naumann,
    "Putnam": putnam,
    "Clift": clift,
    "Haider-Levenspiel": haider_levenspiel,
    "Ganser": ganser,
    "Di Felice": di_felice,
}


def wen_yu(reynolds: float, void: float) -> float:
    """Schiller-Naumann at the superficial Re, times void^-2.65 (1/void in our gas equation).

    The laws for suspensions are functions of the interstitial Re and the void fraction; Cd is of
    the interstitial slip in a gas that keeps the whole pressure gradient. Wen and Yu 1966.
    """
    return schiller_naumann(void * reynolds) * void**-2.65


def gidaspow(reynolds: float, void: float) -> float:
    """Ergun's packed bed below void 0.8, Wen and Yu above; Gidaspow 1994, OpenFOAM's ErgunWenYu."""
    if void >= 0.8:
        return wen_yu(reynolds, void)
    return 4 / 3 * (150 * (1 - void) / (void * reynolds) + 1.75) / void


def beetstra(reynolds: float, void: float) -> float:
    """24 F/Re by Beetstra, van der Hoef and Kuipers 2007, monodisperse."""
    solids, superficial = 1 - void, void * reynolds
    stokes = 10 * solids / void**2 + void**2 * (1 + 1.5 * solids**0.5)
    inertia = (1 / void + 3 * void * solids + 8.4 * superficial**-0.343) / (
        1 + 10 ** (3 * solids) * superficial ** -(0.5 + 2 * solids)
    )
    return 24 / reynolds * (stokes + 0.413 * superficial / (24 * void**2) * inertia)


def di_felice_void(reynolds: float, void: float) -> float:
    """Di Felice 1994: single-particle law at the superficial Re, times void^(1 - chi)."""
    superficial = void * reynolds
    chi = 3.7 - 0.65 * exp(-0.5 * (1.5 - log10(superficial)) ** 2)
    return di_felice(superficial) * void ** (1 - chi)


# by the particle force of a case
SUSPENSION_LAWS: dict[str, DragLaw] = {
    "WenYuVoidDrag": wen_yu,
    "GidaspowDrag": gidaspow,
    "ErgunWenYuDrag": gidaspow,
    "BeetstraDrag": beetstra,
    "DiFeliceDrag": di_felice_void,
}

# a particle force of a case -> the law that it becomes for a single particle
SINGLE_PARTICLE_LIMIT = {
    "SchillerNaumannDrag": "Schiller-Naumann",
    "CliftDrag": "Clift",
    "HaiderLevenspielDrag": "Haider-Levenspiel",
    "GanserDrag": "Ganser",
    "DiFeliceDrag": "Di Felice",
    "WenYuVoidDrag": "Schiller-Naumann",
    "GidaspowDrag": "Schiller-Naumann",
    "BeetstraDrag": "Schiller-Naumann",
    "WenYuDrag": "Schiller-Naumann",
    "ErgunWenYuDrag": "Schiller-Naumann",
    "PlessisMasliyahDrag": "Schiller-Naumann",
    "sphereDrag": "Putnam",
    "nonSphereDrag": "Haider-Levenspiel",
}


def terminal_velocity(
    diameter: float,
    density: float,
    gas: Gas,
    law: str = "Schiller-Naumann",
    sphericity: float = 1.0,
    gravity: float = GRAVITY,
) -> float:
    """Settling velocity (m/s) of one particle in gas at rest: drag equals weight less buoyancy.

    Raises ValueError for a particle that is not denser than the gas.
    """
    if density <= gas.density:
        raise ValueError(f"particle density {density:g} kg/m3 must exceed the gas's")
    weight = (density - gas.density) * gravity * pi / 6 * diameter**3
    area = pi / 4 * diameter**2

    def surplus(velocity: float) -> float:
        reynolds = velocity * diameter * gas.density / gas.viscosity
        drag = LAWS[law](reynolds, sphericity)
        return drag * 0.5 * gas.density * velocity**2 * area - weight

    stokes = (density - gas.density) * gravity * diameter**2 / (18 * gas.viscosity)
    low = 1e-6 * min(stokes, 1.0)
    return float(brenth(surplus, low, 2 * stokes, xtol=1e-13, rtol=1e-12))


def plug_flow_cut_size(
    velocity: float,
    density: float,
    gas: Gas,
    law: str = "Schiller-Naumann",
    sphericity: float = 1.0,
    gravity: float = GRAVITY,
) -> float:
    """Diameter (m) whose terminal velocity is `velocity` (m/s): the cut in uniform gas.

    NaN when it lies outside 0.1 um to 0.1 m.
    """

    def surplus(diameter: float) -> float:
        return terminal_velocity(diameter, density, gas, law, sphericity, gravity) - velocity

    low, high = 1e-7, 0.1
    if surplus(low) > 0 or surplus(high) < 0:
        return float("nan")
    return float(brenth(surplus, low, high, xtol=1e-13, rtol=1e-12))
