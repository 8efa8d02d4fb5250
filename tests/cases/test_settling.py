"""Single particles in gas: settling in an upflow, and every drag law's terminal velocity."""

from __future__ import annotations

from math import log2, log10
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from elutria.physics.drag import LAWS, Gas, terminal_velocity
from elutria_validation.harness.scene import (
    BOX,
    CONTROL,
    MODELS,
    Particles,
    make_scene,
    read_particles,
    run_scene,
)

GRAVITY = 9.80665
GAS = Gas()

# MFiX DEM06: velocity (m/s) at times (s)
UPFLOW = {
    "0.01": -0.01255261,
    "0.05": -0.04078891,
    "0.1": -0.05263133,
    "0.2": -0.05701037,
    "0.35": -0.05739251,
}


def settle(folder: Path, step: float) -> dict[str, float]:
    case = make_scene(
        folder,
        Particles.of((0.05, 0.05, 0.05), diameter=1e-4, density=2000),
        {
            f"{BOX}:gasVelocity": 0.4,
            "system/scenePlan:gas": True,
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:endTime": 0.35,
            f"{CONTROL}:writeInterval": 0.01,
        },
    )
    run_scene(case)
    return {time: float(read_particles(case, time).velocity[0, 2]) for time in UPFLOW}


def test_settling_in_an_upflow(tmp_path: Path, measured) -> None:
    found = settle(tmp_path / "case", 1e-3)
    error = max(abs(found[time] / UPFLOW[time] - 1) for time in UPFLOW)
    measured("largest relative error at the listed times, step 1 ms", error, 1e-4)


def test_settling_is_second_order_in_the_step(tmp_path: Path, measured) -> None:
    reference = settle(tmp_path / "fine", 1e-4)["0.05"]
    errors = [settle(tmp_path / f"{h}", h)["0.05"] - reference for h in (5e-3, 2.5e-3)]
    order = log2(abs(errors[0] / errors[1]))
    measured("2 less the order of convergence", 2 - order, 0.1)


def falling(folder: Path, law: str, particles: Particles, duration: float, **more) -> Particles:
    """Fall through a box that repeats upward, in gas at rest, until the speed is steady."""
    case = make_scene(
        folder,
        particles,
        {
            f"{BOX}:sides": "cyclic",
            f"{BOX}:ends": "cyclic",
            f"{BOX}:bottomGroup": "closed",
            f"{BOX}:topGroup": "closed",
            f"{MODELS}/particleForces": {law: {"alphac": "alpha.air", **more}, "gravity": {}},
            f"{CONTROL}:deltaT": duration / 200,
            f"{CONTROL}:endTime": duration,
            f"{CONTROL}:writeInterval": duration,
        },
    )
    run_scene(case)
    return read_particles(case, f"{duration:g}")


@pytest.mark.parametrize(
    ("force", "law", "sphericity"),
    [
        ("SchillerNaumannDrag", "Schiller-Naumann", 1),
        ("CliftDrag", "Clift", 1),
        ("HaiderLevenspielDrag", "Haider-Levenspiel", 1),
        ("HaiderLevenspielDrag", "Haider-Levenspiel", 0.7),
        ("GanserDrag", "Ganser", 0.8),
        ("DiFeliceDrag", "Di Felice", 1),
        ("sphereDrag", "Putnam", 1),
    ],
)
def test_terminal_velocity_of_each_drag_law(
    tmp_path: Path, measured, force: str, law: str, sphericity: float
) -> None:
    sizes, densities = np.meshgrid(np.geomspace(20e-6, 2e-3, 9), [1000, 2650, 8000])
    start = Particles.of(
        np.full((sizes.size, 3), 0.05), diameter=sizes.ravel(), density=densities.ravel()
    )
    more = {} if force == "sphereDrag" else {"sphericity": sphericity}
    end = falling(tmp_path / "case", force, start, 40, **more)
    expected = [
        terminal_velocity(d, rho, GAS, law, sphericity, GRAVITY)
        for d, rho in zip(end.diameter, end.density, strict=True)
    ]
    # alpha is 1 less the volume share of these few particles: 1e-5
    error = np.abs(-end.velocity[:, 2] / expected - 1).max()
    measured(f"{force}, sphericity {sphericity:g}: largest relative error", error, 1e-4)


def test_clift_gives_the_published_standard_curve() -> None:
    published = {0.5: 51.54, 50: 1.574, 500: 0.5549, 2500: 0.4082}
    for reynolds, value in published.items():
        assert LAWS["Clift"](reynolds, 1) == pytest.approx(value, rel=5e-4)


def schiller_naumann(reynolds: float) -> float:
    return 24 / reynolds * (1 + 0.15 * reynolds**0.687) if reynolds < 1000 else 0.44


def wen_yu(void: float, reynolds: float) -> float:
    """beta d^2/(mu (1 - void)) of Wen and Yu, model A; Re superficial."""
    return 0.75 * schiller_naumann(reynolds) * reynolds * void**-2.65


def gidaspow(void: float, reynolds: float) -> float:
    """Ergun's below void 0.8, Wen and Yu's above."""
    if void >= 0.8:
        return wen_yu(void, reynolds)
    return 150 * (1 - void) / void + 1.75 * reynolds / void


def di_felice(void: float, reynolds: float) -> float:
    """1/8 Cd pi d^2 rho U^2 void^-chi on a particle, U superficial, as model A's beta."""
    chi = 3.7 - 0.65 * np.exp(-0.5 * (1.5 - log10(reynolds)) ** 2)
    coefficient = (0.63 + 4.8 / reynolds**0.5) ** 2
    return 0.75 * coefficient * reynolds * void ** (1 - chi)


def beetstra(void: float, reynolds: float) -> float:
    """18 void^2 (1 - void) F in their eq. for beta d^2/mu, over (1 - void)."""
    phi = 1 - void
    friction = 10 * phi / void**2 + void**2 * (1 + 1.5 * phi**0.5)
    inertia = (1 / void + 3 * void * phi + 8.4 * reynolds**-0.343) / (
        1 + 10 ** (3 * phi) * reynolds ** -(0.5 + 2 * phi)
    )
    return 18 * void**2 * (friction + 0.413 * reynolds / (24 * void**2) * inertia) / void


@pytest.mark.parametrize("solids", [0.1, 0.4])
@pytest.mark.parametrize(
    ("force", "beta"),
    [
        ("WenYuVoidDrag", wen_yu),
        ("GidaspowDrag", gidaspow),
        ("DiFeliceDrag", di_felice),
        ("BeetstraDrag", beetstra),
    ],
)
def test_hindered_settling_by_each_law_for_suspensions(
    tmp_path: Path, measured, force: str, beta, solids: float
) -> None:
    # equal particles that share a box of gas at rest: drag beta/void (model B) equals the weight
    diameter, density, number = 1e-3, 1500.0, 600
    side = (number * np.pi / 6 * diameter**3 / solids) ** (1 / 3)
    places = np.random.default_rng(1).uniform(0.01, 0.99, (number, 3)) * side
    case = make_scene(
        tmp_path / "case",
        Particles.of(places, diameter=diameter, density=density),
        {
            **{f"{BOX}:{name}": side for name in ("width", "depth", "height")},
            f"{BOX}:sides": "cyclic",
            f"{BOX}:ends": "cyclic",
            f"{BOX}:bottomGroup": "closed",
            f"{BOX}:topGroup": "closed",
            f"{MODELS}/particleForces": {force: {"alphac": "alpha.air"}, "gravity": {}},
            f"{CONTROL}:deltaT": 0.02,
            f"{CONTROL}:endTime": 4,
            f"{CONTROL}:writeInterval": 4,
        },
    )
    run_scene(case)
    speed = -read_particles(case, "4").velocity[:, 2]

    weight = (density - GAS.density) * GRAVITY

    def surplus(slip: float) -> float:
        reynolds = (1 - solids) * slip * diameter * GAS.density / GAS.viscosity
        drag = beta(1 - solids, reynolds) / (1 - solids) * GAS.viscosity / diameter**2
        return drag * slip - weight

    expected = brentq(surplus, 1e-6, 100)
    error = np.abs(speed / expected - 1).max()
    measured(f"{force}, solids {solids:g}: largest relative error", error, 1e-4)
