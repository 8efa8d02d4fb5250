"""Single particles in uniform gas: settling and relaxation."""

from __future__ import annotations

from math import log2
from pathlib import Path

import numpy as np

from elutria_validation.book.figures import BLUE, COLOURS, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import solve
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.references.drag import AIR, fall, terminal_velocity

NAME = "settling"
TITLE = "Single particles in uniform gas"
HELP = "Single particles in uniform gas: settling and relaxation."

UPFLOW = 0.4  # m/s
# MFiX DEM06: velocity (m/s) at times (s)
DEM06 = {
    0.01: -0.01255261,
    0.05: -0.04078891,
    0.1: -0.05263133,
    0.2: -0.05701037,
    0.35: -0.05739251,
}


def settle(
    folder: Path, particles: Particles, step: float, moments: list[float]
) -> dict[float, Particles]:
    """The particles at `moments` (s), in gas that rises with UPFLOW through a periodic box."""
    interval = float(np.gcd.reduce([round(1e6 * t) for t in moments])) * 1e-6
    case = BoxCase(
        gas_velocity=UPFLOW, sides="cyclic", ends="cyclic", step=step, end=max(moments),
        interval=interval,
    ).make(folder, particles)  # fmt: skip
    solve(case)
    return {t: read_particles(case, f"{t:.10g}") for t in moments}


def dem06(folder: Path, quick: bool) -> Section:
    section = Section(
        "Settling in an upflow (MFiX DEM06)",
        "A grain of 100 um falls from rest through gas that rises with 0.4 m/s: drag by "
        "Schiller and Naumann, weight, buoyancy. Reference: the ODE's tabulated solution; "
        "order of convergence in the gas step.",
    )
    particle = Particles.of((0.05, 0.05, 0.05), diameter=1e-4, density=2000)
    found = settle(folder / "dem06", particle, 1e-3, list(DEM06))
    section.rows += [
        Row.relative("DEM06, step 1 ms", f"velocity at {time:g} s, m/s", reference,
                     found[time].velocity[0, 2], 1e-4, "0.005 %")
        for time, reference in DEM06.items()
    ]  # fmt: skip
    steps = [5e-3, 2.5e-3] if quick else [1e-2, 5e-3, 2.5e-3, 1.25e-3]
    reference = fall(1e-4, 2000, UPFLOW, [0.05])[0]
    errors = [
        abs(settle(folder / f"{h}", particle, h, [0.05])[0.05].velocity[0, 2] / reference - 1)
        for h in steps
    ]
    first = steps.index(5e-3)
    order = log2(errors[first] / errors[first + 1])
    section.rows.append(
        Row("DEM06", "order in the step (error: shortfall from 2)", 2, order, 2 - order, 0.1, "1")
    )
    figure, (axes,) = new_figure(60)
    axes.loglog(steps, errors, "o-", color=BLUE, label="elutriaFoam")
    axes.loglog(steps, [errors[0] * (h / steps[0]) ** 2 for h in steps], "k:", label="order 2")
    label(axes, "gas step, s", "relative error of velocity at 0.05 s")
    section.figures["order"] = (figure, "DEM06: error against the gas step.")
    return section


def sweep(folder: Path, _quick: bool) -> Section:
    section = Section(
        "Settling of 20 to 2000 um at 1000 to 8000 kg/m3",
        "From rest in the same upflow, against an ODE solution (scipy, DOP853, 1e-12), the "
        "worst of four times. The error is over the velocity or a tenth of the upflow, "
        "whichever is larger, since a velocity passes through 0 where the upflow carries.",
    )
    moments = [0.01, 0.05, 0.2, 1.0]
    sizes, densities = np.meshgrid(np.geomspace(20e-6, 2e-3, 7), [1000.0, 2650.0, 8000.0])
    particles = Particles.of(
        np.full((sizes.size, 3), 0.05), diameter=sizes.ravel(), density=densities.ravel()
    )
    found = settle(folder / "sweep", particles, 1e-3, moments)
    figure, (axes,) = new_figure(60)
    for density, colour in zip(densities[:, 0], COLOURS, strict=False):
        worst = []
        for i in np.flatnonzero(particles.density == density):
            reference = fall(particles.diameter[i], density, UPFLOW, moments)
            ours = np.array([found[t].velocity[i, 2] for t in moments])
            errors = np.abs(ours - reference) / np.maximum(np.abs(reference), 0.1 * UPFLOW)
            worst.append(errors.max())
            k = int(errors.argmax())
            section.rows.append(
                Row(
                    f"{particles.diameter[i] * 1e6:.0f} um, {density:g} kg/m3, step 1 ms",
                    f"velocity, worst of 4 times ({moments[k]:g} s), m/s",
                    reference[k], ours[k], errors[k], 1e-4, "0.005 % (DEM06)",
                )
            )  # fmt: skip
        axes.loglog(sizes[0] * 1e6, worst, "o-", color=colour, label=f"{density:g} kg/m³")
    axes.axhline(1e-4, color="k", linestyle=":", linewidth=0.8)
    label(axes, "diameter, µm", "largest relative error of velocity")
    section.figures["sweep"] = (figure, "Settling from rest in an upflow of 0.4 m/s, step 1 ms.")
    return section


def stiff(folder: Path, _quick: bool) -> Section:
    section = Section(
        "Relaxation far below the step",
        "Grains thrown sideways whose relaxation time is 1e-4 to 0.03 of the gas step must end "
        "at their terminal velocity.",
    )
    sizes = np.array([1e-6, 5e-6, 20e-6])
    particles = Particles.of(np.full((3, 3), 0.05), (5.0, 0, 0), diameter=sizes)
    found = settle(folder / "stiff", particles, 0.1, [1.0])[1.0]
    for i, size in enumerate(sizes):
        relaxation = 2650 * size**2 / (18 * AIR.viscosity)
        section.rows.append(
            Row.relative(
                f"{size * 1e6:.0f} um thrown at 5 m/s, relaxation time {relaxation:.2g} s, "
                "step 0.1 s",
                "velocity after 10 steps, m/s",
                UPFLOW - terminal_velocity(size, 2650), found.velocity[i, 2], 1e-4,
            )
        )  # fmt: skip
    return section


SECTIONS = (dem06, sweep, stiff)
