"""Partition curves that cost nothing, as points of the accuracy benchmark."""

from __future__ import annotations

import time
from dataclasses import dataclass
from math import sqrt

import numpy as np

from elutria.case.case import Case
from elutria.estimates.theory import drift_dispersion_fines_share
from elutria.physics.drag import plug_flow_cut_size, terminal_velocity
from elutria_validation.benchmarks.accuracy_error import Cut, cut_of_curve
from elutria_validation.benchmarks.accuracy_runs import Scene
from elutria_validation.harness.programs import project_root

HEIGHT, LENGTH = 0.25, 0.5
"""m: of the feed above the bottom, and of the shaft."""
INTENSITY, MIXING_LENGTH = 0.05, 0.0035
"""Of the turbulence at the inlet, over the gas velocity; m."""
C_MU, C_0 = 0.09, 2.1


@dataclass(frozen=True)
class Form:
    """A closed form's curve and the seconds it took."""

    name: str
    cut: Cut
    seconds: float


def closed_forms(scene: Scene) -> list[Form]:
    """The plug-flow cut, and drift with the dispersion of the turbulence at the inlet."""
    case = Case(project_root() / "cases/column")
    gas, law, material = case.gas(), case.theory_law(), case.feed().materials[0]
    start = time.perf_counter()
    cut = plug_flow_cut_size(scene.velocity, material.grain.density, gas, law)
    step = cut_of_curve(cut * np.array([0.1, 1 - 1e-9, 1 + 1e-9, 10]), [0, 0, 1, 1])
    middle = time.perf_counter()
    sizes = np.geomspace(material.sizes.smallest, material.sizes.largest, 101)
    grain = material.grain
    slip = np.array([terminal_velocity(d, grain.density, gas, law) for d in sizes.tolist()])
    spread = dispersion(scene.velocity)
    fines = drift_dispersion_fines_share(slip, scene.velocity, HEIGHT, LENGTH, spread)
    return [
        Form("plug-flow cut", step, middle - start),
        Form("drift with dispersion", cut_of_curve(sizes, 1 - fines), time.perf_counter() - middle),
    ]


def dispersion(velocity: float) -> float:
    """Axial dispersion (m2/s) of a grain near the cut: sigma^2 T by the inlet's k and epsilon.

    T as `continuousDispersionRAS` has it: Pope's Lagrangian time, shortened by the slip, which at
    the cut is the gas velocity (Csanady 1963).
    """
    k: float = 1.5 * (INTENSITY * velocity) ** 2
    epsilon: float = C_MU**0.75 * k**1.5 / MIXING_LENGTH
    variance = 2 / 3 * k
    lagrangian = k / epsilon / (0.5 + 0.75 * C_0)
    return variance * lagrangian / sqrt(1 + velocity**2 / variance)
