"""Single particles in uniform gas: settling and relaxation."""

from __future__ import annotations

from math import log2
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from elutria.output.plots import STYLE, new_figure
from elutria.physics.drag import LAWS, Gas, terminal_velocity
from elutria_validation.book.book import Chapter, Row, Section, write_chapter
from elutria_validation.harness.common import Options
from elutria_validation.harness.scene import (
    BOX,
    CONTROL,
    Particles,
    make_scene,
    read_particles,
    run_scene,
)

NAME = "settling"
HELP = "Single particles in uniform gas: settling and relaxation."

Array = NDArray[np.float64]

GRAVITY = 9.80665
GAS = Gas()
UPFLOW = 0.4  # m/s
# MFiX DEM06: velocity (m/s) at times (s)
DEM06 = {
    0.01: -0.01255261,
    0.05: -0.04078891,
    0.1: -0.05263133,
    0.2: -0.05701037,
    0.35: -0.05739251,
}


@rc_context(STYLE)
def run(options: Options) -> Chapter:
    """Settling in an upflow, a sweep of sizes and densities, stiff relaxation."""
    chapter = Chapter(NAME, "Single particles in uniform gas")
    with TemporaryDirectory() as work:
        folder = Path(work)
        dem06 = chapter.section(
            "Settling in an upflow (MFiX DEM06)",
            "A grain of 100 um falls from rest through gas that rises with 0.4 m/s: drag by "
            "Schiller and Naumann, weight, buoyancy. Reference: the ODE's tabulated solution; "
            "order of convergence in the gas step.",
        )
        _dem06(dem06, folder)
        sweep = chapter.section(
            "Settling of 20 to 2000 um at 1000 to 8000 kg/m3",
            "From rest in the same upflow, against an ODE solution (scipy, DOP853, 1e-12), the "
            "worst of four times. The error is over the velocity or a tenth of the upflow, "
            "whichever is larger, since a velocity passes through 0 where the upflow carries.",
        )
        _sweep(sweep, folder)
        stiff = chapter.section(
            "Relaxation far below the step",
            "Grains thrown sideways whose relaxation time is 1e-4 to 0.03 of the gas step must end "
            "at their terminal velocity.",
        )
        _stiff(stiff, folder)
    return write_chapter(options, chapter)


def settle(
    folder: Path, particles: Particles, step: float, moments: list[float], **more: Any
) -> dict[float, Particles]:
    """The particles at `moments` (s), in gas that rises with UPFLOW through a periodic box."""
    interval = float(np.gcd.reduce([round(1e6 * t) for t in moments])) * 1e-6
    case = make_scene(
        folder,
        particles,
        {
            f"{BOX}:gasVelocity": UPFLOW,
            f"{BOX}:sides": "cyclic",
            f"{BOX}:ends": "cyclic",
            f"{BOX}:bottomGroup": "closed",
            f"{BOX}:topGroup": "closed",
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:endTime": max(moments),
            f"{CONTROL}:writeInterval": interval,
            **more,
        },
    )
    run_scene(case)
    return {t: read_particles(case, f"{t:.10g}") for t in moments}


def exact(diameter: float, density: float, moments: list[float]) -> Array:
    """Velocities (m/s) of a particle from rest, by an ODE solver; Schiller-Naumann."""

    def slope(_time: float, velocity: Array) -> Array:
        slip = UPFLOW - velocity[0]
        reynolds = max(abs(slip) * diameter * GAS.density / GAS.viscosity, 1e-12)
        drag = 0.75 * LAWS["Schiller-Naumann"](reynolds, 1) * GAS.density / (density * diameter)
        return np.array([drag * slip * abs(slip) - GRAVITY * (1 - GAS.density / density)])

    # starts of steps at the kink of the law need no care: Re stays below 1000 here
    solution = solve_ivp(slope, (0, max(moments)), [0.0], "DOP853", moments, rtol=1e-12, atol=1e-14)
    return np.asarray(solution.y[0])


def _dem06(section: Section, folder: Path) -> None:
    particle = Particles.of((0.05, 0.05, 0.05), diameter=1e-4, density=2000)
    times = list(DEM06)
    found = settle(folder / "dem06", particle, 1e-3, times)
    for time, reference in DEM06.items():
        ours = found[time].velocity[0, 2]
        section.rows.append(
            Row.relative(
                "DEM06, step 1 ms", f"velocity at {time:g} s, m/s", reference, ours, 1e-4, "0.005 %"
            )
        )
    steps = [1e-2, 5e-3, 2.5e-3, 1.25e-3]
    reference = exact(1e-4, 2000, [0.05])[0]
    errors = [
        abs(settle(folder / f"{h}", particle, h, [0.05])[0.05].velocity[0, 2] / reference - 1)
        for h in steps
    ]
    order = log2(errors[1] / errors[2])
    section.rows.append(
        Row("DEM06", "order in the step (error: shortfall from 2)", 2, order, 2 - order, 0.1, "1")
    )
    figure, (axes,) = new_figure(60)
    axes.loglog(steps, errors, "o-", color="#0072B2", label="elutriaFoam")
    axes.loglog(steps, [errors[0] * (h / steps[0]) ** 2 for h in steps], "k:", label="order 2")
    axes.set_xlabel("gas step, s")
    axes.set_ylabel("relative error of velocity at 0.05 s")
    axes.legend()
    section.figures["order"] = (figure, "DEM06: error against the gas step.")


def _sweep(section: Section, folder: Path) -> None:
    moments = [0.01, 0.05, 0.2, 1.0]
    sizes, densities = np.meshgrid(np.geomspace(20e-6, 2e-3, 7), [1000.0, 2650.0, 8000.0])
    particles = Particles.of(
        np.full((sizes.size, 3), 0.05), diameter=sizes.ravel(), density=densities.ravel()
    )
    found = settle(folder / "sweep", particles, 1e-3, moments)
    figure, (axes,) = new_figure(60)
    for density, colour in zip((1000.0, 2650.0, 8000.0), ("#0072B2", "#D55E00", "#009E73"),
                               strict=True):  # fmt: skip
        worst = []
        for i in np.flatnonzero(particles.density == density):
            reference = exact(particles.diameter[i], density, moments)
            ours = np.array([found[t].velocity[i, 2] for t in moments])
            # a velocity passes through 0 where the upflow carries: over the slip's scale
            scale = np.maximum(np.abs(reference), 0.1 * UPFLOW)
            errors = np.abs(ours - reference) / scale
            worst.append(errors.max())
            k = int(errors.argmax())
            section.rows.append(
                Row(
                    f"{particles.diameter[i] * 1e6:.0f} um, {density:g} kg/m3, step 1 ms",
                    f"velocity, worst of 4 times ({moments[k]:g} s), m/s",
                    reference[k],
                    ours[k],
                    errors[k],
                    1e-4,
                    "0.005 % (DEM06)",
                )
            )
        axes.loglog(sizes[0] * 1e6, worst, "o-", color=colour, label=f"{density:g} kg/m³")
    axes.axhline(1e-4, color="k", linestyle=":", linewidth=0.8)
    axes.set_xlabel("diameter, µm")
    axes.set_ylabel("largest relative error of velocity")
    axes.legend()
    section.figures["sweep"] = (figure, "Settling from rest in an upflow of 0.4 m/s, step 1 ms.")


def _stiff(section: Section, folder: Path) -> None:
    sizes = np.array([1e-6, 5e-6, 20e-6])
    particles = Particles.of(np.full((3, 3), 0.05), (5.0, 0, 0), diameter=sizes)
    found = settle(folder / "stiff", particles, 0.1, [1.0])[1.0]
    for i, size in enumerate(sizes):
        relaxation = 2650 * size**2 / (18 * GAS.viscosity)
        reference = UPFLOW - terminal_velocity(size, 2650, GAS, gravity=GRAVITY)
        section.rows.append(
            Row.relative(
                f"{size * 1e6:.0f} um thrown at 5 m/s, relaxation time {relaxation:.2g} s, "
                "step 0.1 s",
                "velocity after 10 steps, m/s",
                reference,
                found.velocity[i, 2],
                1e-4,
            )
        )
