"""Cut size in air: drops that hover in an upflow, beside the velocity at which they were measured
to fall."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from foamlib import FoamFile
from numpy.typing import NDArray

from elutria.classification.classify import fit_events
from elutria.classification.events import read_run
from elutria.output.style import legend_above
from elutria_validation.book.figures import BLUE, COLOURS, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.chapters.drag import force
from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import add_feed, solve, uniform
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.references.drag import Gas, read_table

Array = NDArray[np.float64]

WATER, AIR = 998.0, Gas(1.204, 1.818e-5)
DEFAULT = "SchillerNaumannDrag"
LAWS = (DEFAULT, "CliftDrag", "HaiderLevenspielDrag", "GanserDrag", "HoelzerSommerfeldDrag",
        "sphereDrag", "DiFeliceDrag", "WenYuVoidDrag", "GidaspowDrag", "BeetstraDrag")  # fmt: skip
SPREAD, NEAR = 0.5, 0.15
"""Sizes about the measured one, relative, of drops that hover and of those that are fed."""
EVERYWHERE, IN_THE_MEAN = 0.05, 0.025
"""What the default law is to reach."""
MEASURED = 0.01
"""Relative error of the measured velocities."""
PEERS = "the measurement: about 1 %"


def hovering(folder: Path, law: str, velocities: Array, sizes: Array) -> Array:
    """The size (m) that hovers at each of `velocities` (m/s): drops about each of `sizes` in a row
    of cells, each with its own upflow."""
    number, each = velocities.size, 81
    width = 0.1 * number
    case = BoxCase(
        width=width, cells=(number, 1, 1), sides="cyclic", ends="cyclic",
        gas_density=AIR.density, gas_viscosity=AIR.viscosity / AIR.density,
        forces={**force(law), "gravity": {}}, step=0.02, end=5,
    )  # fmt: skip
    about = np.linspace(1 - SPREAD, 1 + SPREAD, each)
    diameter = np.outer(sizes, about).ravel()
    places = np.full((diameter.size, 3), 0.05)
    places[:, 0] = np.repeat((np.arange(number) + 0.5) * width / number, each)
    path = case.make(folder, Particles.of(places, diameter=diameter, density=WATER))
    upward: Any = np.zeros((number, 3))
    upward[:, 2] = velocities
    with FoamFile(path / "0/U.air") as field:
        field["internalField"] = upward
    solve(path)
    rising = read_particles(path, "5").velocity[:, 2].reshape(number, each)
    # coarser drops rise more slowly: the size at which they stand still
    return np.array([size * np.interp(0, -row, about)
                     for size, row in zip(sizes, rising, strict=True)])  # fmt: skip


def classified(folder: Path, velocity: float, size: float, number: int) -> tuple[float, ...]:
    """Cut size (m) and its interval: drops about `size` (m), from feed to curve."""
    case = BoxCase(
        width=0.2, depth=0.2, height=0.04, gas_velocity=velocity, gas_density=AIR.density,
        gas_viscosity=AIR.viscosity / AIR.density, step=0.01 * velocity, end=1000,
    ).make(folder)  # fmt: skip
    grains = uniform(WATER, (1 - NEAR) * size, (1 + NEAR) * size)
    add_feed(case, {"materials": grains, "massFlowRate": 1e-4, "particles": number,
                    "drainTime": 15 / velocity})  # fmt: skip
    solve(case)
    return fit_events(read_run(case).events).sizes[0.50]


def cut_in_air(folder: Path, quick: bool) -> Section:
    section = Section(
        "Cut size in air, measured (Gunn and Kinzer 1949)",
        "Drops of 0.2 to 1 mm that fall through still air at a measured velocity hover where air "
        "rises at that velocity: nine measured pairs of gas velocity and cut size. With the "
        "default drag law they are fed, leave at the top or the bottom, and the curve is fitted, "
        "as a user does; with every other law drops about each size are let go in the upflow, and "
        "the one that stands still is found. Allowed for the default law: 5 % everywhere, 2.5 % "
        "in the mean. The measurement is good to about 1 %; drops of 1 mm begin to flatten.",
    )
    table = read_table("drops")[:: 4 if quick else 1]
    sizes = np.array([1e-3 * float(row["diameter_mm"]) for row in table])
    velocities = np.array([float(row["velocity_m_s"]) for row in table])
    found = {
        law: hovering(folder / law, law, velocities, sizes) for law in (LAWS[:2] if quick else LAWS)
    }
    cuts = np.array([
        classified(folder / f"{d}", u, d, 100 if quick else 300)
        for u, d in zip(velocities, sizes, strict=True)
    ])  # fmt: skip
    at = [f"{u:g} m/s" for u in velocities]
    errors = np.abs(cuts[:, 0] / sizes - 1)
    half = float(np.max(cuts[:, 2] / cuts[:, 1] - 1)) / 2
    section.rows += [
        Row.worst(f"{DEFAULT}, from feed to curve", "d50, m", at, sizes, cuts[:, 0], EVERYWHERE,
                  PEERS),
        Row.size(f"{DEFAULT}, from feed to curve", "mean relative error of d50; error: itself",
                 float(errors.mean()), IN_THE_MEAN, PEERS),
        Row.size(f"{DEFAULT}, from feed to curve", "chance: widest half interval of d50, relative",
                 half, None),
        Row.worst(DEFAULT, "d50 from feed to curve beside the drop that hovers, m", at,
                  found[DEFAULT], cuts[:, 0], 0.005),
    ]  # fmt: skip
    means = {law: float(np.mean(np.abs(ours / sizes - 1))) for law, ours in found.items()}
    for law, ours in found.items():
        section.rows += [
            Row.worst(law, "d50, m", at, sizes, ours, None),
            Row.size(law, "mean relative error of d50", means[law], None),
        ]
    section.found = _found(found, sizes, means)
    figure, (axes,) = new_figure(110)
    axes.axhspan(-100 * MEASURED, 100 * MEASURED, color="0.9", label="measured, 1 %", zorder=0)
    marks = "osv^D<>PX*"
    for (law, ours), mark, k in zip(found.items(), marks, range(99), strict=False):
        axes.plot(1e3 * sizes, 100 * (ours / sizes - 1), f"{mark}-", ms=3, lw=0.7,
                  color=COLOURS[k % len(COLOURS)], label=law.removesuffix("Drag"))  # fmt: skip
    bars = 100 * np.abs(cuts[:, 1:].T / sizes - cuts[:, 0] / sizes)
    axes.errorbar(1e3 * sizes, 100 * (cuts[:, 0] / sizes - 1), bars, fmt="o", ms=5, mfc="none",
                  color=BLUE, lw=0.8, label="from feed to curve, 95 %")  # fmt: skip
    axes.set_xlabel("measured size, mm")
    axes.set_ylabel("computed cut size less measured, %")
    legend_above(figure, *axes.get_legend_handles_labels())
    section.figures["cut"] = (
        figure, "Cut size at nine measured velocities: every drag law beside measured drops."
    )  # fmt: skip
    return section


def _found(found: dict[str, Array], sizes: Array, means: dict[str, float]) -> str:
    """Which law is best at which size, and in the mean."""
    laws = list(found)
    best = [laws[int(k)] for k in np.argmin([np.abs(found[law] / sizes - 1) for law in laws], 0)]
    where = ", ".join(f"{1e3 * d:g} mm {law}" for d, law in zip(sizes, best, strict=True))
    ranked = ", ".join(
        f"{law} {100 * means[law]:.1f} %" for law in sorted(means, key=lambda one: means[one])
    )
    return f"Nearest to the measurement: {where}. Mean error: {ranked}."
