"""Many particles: homogeneous cooling by Haff's law, and hindered settling."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elutria_validation.book.figures import BLUE, COLOURS, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import (
    NO_DRAG,
    PERIODIC,
    WEIGHTLESS,
    BoxCase,
    Contacts,
    Pair,
    cube,
)
from elutria_validation.harness.cases import solve, times
from elutria_validation.harness.particles import Particles, lattice, read_particles
from elutria_validation.references.drag import AIR, settling_exponent, terminal_velocity
from elutria_validation.references.flows import contact_value, kurtosis_factor

NAME = "clouds"
TITLE = "Many particles"
HELP = "Many particles: homogeneous cooling by Haff's law, and hindered settling."

Array = NDArray[np.float64]


def cooling(
    folder: Path, number: int, solids: float, restitution: float
) -> tuple[Array, Array, float]:
    """Times (s), sqrt(T0/T) and Haff's rate 1/t0 (1/s)."""
    diameter, speed, duration = 1e-3, 0.1, 0.6
    side = (number * np.pi / 6 * diameter**3 / solids) ** (1 / 3)
    velocity = np.random.default_rng(7).normal(0, speed, (number, 3))
    across = int(np.ceil(number ** (1 / 3)))
    places = np.random.default_rng(5).permutation(lattice(across**3, side))[:number]
    start = Particles.of(places, velocity - velocity.mean(0), diameter=diameter)
    case = BoxCase(
        **cube(side), **WEIGHTLESS, forces=NO_DRAG, contacts=Contacts(Pair(restitution)),
        step=2e-3, end=duration, interval=duration / 12,
    ).make(folder, start)  # fmt: skip
    solve(case)
    written = times(case)[1:]
    states = [start, *(read_particles(case, time) for time in written)]
    temperature = np.array([state.velocity.var(axis=0).mean() for state in states])
    rate = (
        (1 - restitution**2) / 3 * 2 * np.sqrt(np.pi) * number / side**3 * diameter**2
        * contact_value(solids) * np.sqrt(temperature[0])
    )  # fmt: skip
    moments = np.array([0.0, *map(float, written)])
    return moments, np.sqrt(temperature[0] / temperature), float(rate)


def haff(folder: Path, quick: bool) -> Section:
    number = 600 if quick else 3000
    section = Section(
        "Homogeneous cooling (Haff 1983)",
        f"{number} spheres without friction in a periodic box lose their random motion: "
        "sqrt(T0/T) = 1 + t/t0, with the contact value of Carnahan and Starling. Error of the "
        "slope; the slope of one run scatters by about 1/sqrt(number), "
        f"{100 / number**0.5:.0f} %.",
    )
    figure, (axes,) = new_figure(60)
    colours = iter(COLOURS)
    for solids in (0.05,) if quick else (0.05, 0.15):
        for restitution in (0.95, 0.9) if quick else (0.95, 0.9, 0.8):
            name = f"haff{solids}{restitution}"
            moments, cooled, rate = cooling(folder / name, number, solids, restitution)
            slope = float(np.polyfit(moments, cooled, 1)[0])
            case = f"solids {solids:g}, e {restitution:g}"
            checked = "slope of sqrt(T0/T), 1/s"
            allowed = 0.05 if restitution >= 0.9 else None
            section.rows += [
                Row.relative(case, checked, rate, slope, allowed, "8 % at e = 0.9"),
                Row.relative(case, f"{checked}, against theory with kurtosis",
                             rate * kurtosis_factor(restitution), slope, None),
            ]  # fmt: skip
            axes.plot(moments * rate, cooled, "o", color=next(colours), markersize=3, label=case)
    end = axes.get_xlim()[1]
    axes.plot([0, end], [1, 1 + end], "k:", label="Haff")
    label(axes, "time over t0", "sqrt(T0/T)")
    section.figures["haff"] = (figure, "Homogeneous cooling in a periodic box.")
    return section


def hindered(folder: Path, quick: bool) -> Section:
    diameter, density, number = 5e-4, 1500.0, 400
    alone = terminal_velocity(diameter, density)
    exponent = settling_exponent(alone * diameter * AIR.density / AIR.viscosity)
    section = Section(
        "Hindered settling",
        "Equal spheres of 0.5 mm share gas at rest with Wen and Yu's drag. All must settle alike: "
        "the spread of their slips is nil. Superficial slip over the terminal velocity beside "
        f"Richardson and Zaki (1954), void^{exponent:.2f}, measured: allowed 10 % up to solids of "
        "0.2; beyond, for information, the law itself goes another way.",
    )
    found = [(0.0, 1.0)]
    for solids in (0.1, 0.3) if quick else (0.05, 0.1, 0.2, 0.3, 0.4):
        side = (number * np.pi / 6 * diameter**3 / solids) ** (1 / 3)
        places = np.random.default_rng(1).uniform(0.01, 0.99, (number, 3)) * side
        start = Particles.of(places, diameter=diameter, density=density)
        box = BoxCase(
            **cube(side), **PERIODIC, step=0.02, end=4,
            forces={"WenYuVoidDrag": {"alphac": "alpha.air"}, "gravity": {}},
        )  # fmt: skip
        case = box.make(folder / f"{solids}", start)
        solve(case)
        speed = -read_particles(case, "4").velocity[:, 2]
        slip = float(speed.mean())
        share = (1 - solids) * slip / alone
        section.rows += [
            Row.size(f"solids {solids:g}", "spread of the slips over their mean",
                     float(np.ptp(speed)) / slip, 1e-6),
            Row.relative(f"solids {solids:g}", "superficial slip over the terminal velocity",
                         (1 - solids) ** exponent, share, 0.1 if solids <= 0.2 else None),
        ]  # fmt: skip
        found.append((solids, share))
    figure, (axes,) = new_figure(60)
    fractions = np.linspace(0, 0.45, 40)
    axes.plot(fractions, (1 - fractions) ** exponent, "-", color=BLUE,
              label=f"Richardson-Zaki, n {exponent:.2f}")  # fmt: skip
    axes.plot(*np.array(found).T, "o", color=RED, markersize=4, label="Wen and Yu, elutriaFoam")
    label(axes, "solid volume fraction", "superficial slip over v_t")
    section.figures["hindered"] = (figure, "Hindered settling of 0.5 mm spheres of 1500 kg/m³.")
    return section


SECTIONS = (haff, hindered)
