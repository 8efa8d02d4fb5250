"""Single particles in uniform gas: settling, relaxation, terminal velocities."""

from __future__ import annotations

from math import log2
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from elutria.bench.common import Options
from elutria.drag import LAWS, Gas, terminal_velocity
from elutria.plots import STYLE, new_figure
from elutria.verification.book import Chapter, Row, write_chapter
from elutria.verification.scene import (
    BOX,
    CONTROL,
    MODELS,
    Particles,
    make_scene,
    read_particles,
    run_scene,
)

NAME = "settling"
HELP = "Single particles in uniform gas: settling, relaxation, terminal velocities."

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
FORCES = {
    "SchillerNaumannDrag": "Schiller-Naumann",
    "CliftDrag": "Clift",
    "HaiderLevenspielDrag": "Haider-Levenspiel",
    "GanserDrag": "Ganser",
    "DiFeliceDrag": "Di Felice",
    "sphereDrag": "Putnam",
}


@rc_context(STYLE)
def run(options: Options) -> None:
    """Settling in an upflow, a sweep of sizes and densities, stiff relaxation, each drag law."""
    chapter = Chapter(
        NAME,
        "Single particles in uniform gas",
        "A particle moves by drag, gravity and buoyancy in gas that it does not change. "
        "References: MFiX DEM06; an ODE solution (scipy solve_ivp, DOP853, 1e-12) for sizes from "
        "20 to 2000 um and densities from 1000 to 8000 kg/m3; each drag law's terminal velocity "
        "from its formula.",
    )
    with TemporaryDirectory() as work:
        folder = Path(work)
        _dem06(chapter, folder)
        _sweep(chapter, folder)
        _stiff(chapter, folder)
        _laws(chapter, folder)
    write_chapter(options, chapter)


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


def _dem06(chapter: Chapter, folder: Path) -> None:
    particle = Particles.of((0.05, 0.05, 0.05), diameter=1e-4, density=2000)
    times = list(DEM06)
    found = settle(folder / "dem06", particle, 1e-3, times)
    for time, reference in DEM06.items():
        ours = found[time].velocity[0, 2]
        chapter.rows.append(
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
    chapter.rows.append(
        Row("DEM06", "order in the step (error: shortfall from 2)", 2, order, 2 - order, 0.1, "1")
    )
    figure, (axes,) = new_figure(60)
    axes.loglog(steps, errors, "o-", color="#0072B2", label="elutriaFoam")
    axes.loglog(steps, [errors[0] * (h / steps[0]) ** 2 for h in steps], "k:", label="order 2")
    axes.set_xlabel("gas step, s")
    axes.set_ylabel("relative error of velocity at 0.05 s")
    axes.legend()
    chapter.figures["order"] = (figure, "DEM06: error against the gas step.")


def _sweep(chapter: Chapter, folder: Path) -> None:
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
            chapter.rows.append(
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
    chapter.figures["sweep"] = (figure, "Settling from rest in an upflow of 0.4 m/s, step 1 ms.")


def _stiff(chapter: Chapter, folder: Path) -> None:
    sizes = np.array([1e-6, 5e-6, 20e-6])
    particles = Particles.of(np.full((3, 3), 0.05), (5.0, 0, 0), diameter=sizes)
    found = settle(folder / "stiff", particles, 0.1, [1.0])[1.0]
    for i, size in enumerate(sizes):
        relaxation = 2650 * size**2 / (18 * GAS.viscosity)
        reference = UPFLOW - terminal_velocity(size, 2650, GAS, gravity=GRAVITY)
        chapter.rows.append(
            Row.relative(
                f"{size * 1e6:.0f} um thrown at 5 m/s, relaxation time {relaxation:.2g} s, "
                "step 0.1 s",
                "velocity after 10 steps, m/s",
                reference,
                found.velocity[i, 2],
                1e-4,
            )
        )


def _laws(chapter: Chapter, folder: Path) -> None:
    sizes = np.geomspace(20e-6, 5e-3, 9)
    start = Particles.of(np.full((9, 3), 0.05), diameter=sizes)
    for force, law in FORCES.items():
        forces: dict[str, Any] = {force: {}, "gravity": {}}
        found = settle(folder / force, start, 0.1, [40.0], **{f"{MODELS}/particleForces": forces})[
            40.0
        ]
        speed = UPFLOW - found.velocity[:, 2]
        expected = np.array([terminal_velocity(d, 2650, GAS, law, 1, GRAVITY) for d in sizes])
        errors = np.abs(speed / expected - 1)
        k = int(errors.argmax())
        chapter.rows.append(
            Row(
                f"{force} ({law}), 20 to 5000 um",
                f"terminal velocity, worst of 9 sizes ({sizes[k] * 1e6:.0f} um), m/s",
                expected[k],
                speed[k],
                errors[k],
                1e-4,
            )
        )
    for reynolds, published in {0.5: 51.54, 50: 1.574, 500: 0.5549, 2500: 0.4082}.items():
        ours = LAWS["Clift"](reynolds, 1)
        chapter.rows.append(
            Row.relative("Clift's standard curve", f"Cd at Re {reynolds:g}", published, ours, 5e-4)
        )
