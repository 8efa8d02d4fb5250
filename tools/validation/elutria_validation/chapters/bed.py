"""Packed beds: pressure gradient by Ergun."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray
from scipy.optimize import brentq

from elutria.output.plots import MATERIAL_COLOURS, STYLE, new_figure
from elutria.physics.drag import Gas
from elutria_validation.book.book import Chapter, Row, write_chapter
from elutria_validation.chapters.wake import loose_solvers
from elutria_validation.harness.common import Options
from elutria_validation.harness.scene import (
    BOX,
    CLOUD,
    CONTROL,
    MODELS,
    Particles,
    make_scene,
    read_gas,
    run_scene,
    times,
)

NAME = "bed"
HELP = "Packed bed against Ergun."

Array = NDArray[np.float64]

GAS, GRAVITY = Gas(), 9.80665
GIDASPOW: dict[str, Any] = {"GidaspowDrag": {"alphac": "alpha.air"}}
STOCK: dict[str, Any] = {"ErgunWenYuDrag": {"alphac": "alpha.air"}}


@rc_context(STYLE)
def run(options: Options) -> Chapter:
    """Held beds at two void fractions and two sizes."""
    chapter = Chapter(NAME, "Beds")
    with TemporaryDirectory() as work:
        _packed(chapter, Path(work), options.quick)
    return write_chapter(options, chapter)


def ergun(velocity: float, diameter: float, void: float) -> float:
    """Pressure gradient (Pa/m) of a bed at a superficial velocity; Ergun 1952."""
    solids = 1 - void
    viscous = 150 * solids**2 / void**3 * GAS.viscosity * velocity / diameter**2
    return viscous + 1.75 * solids / void**3 * GAS.density * velocity**2 / diameter


def minimum_velocity(diameter: float, density: float, void: float) -> float:
    """Superficial velocity (m/s) at which Ergun's gradient carries the bed's weight."""
    weight = (1 - void) * (density - GAS.density) * GRAVITY
    return float(brentq(lambda u: ergun(u, diameter, void) - weight, 1e-6, 100))


@dataclass(frozen=True)
class HeldBed:
    """Pressure gradient in the middle (Pa/m), and of the whole over the bed's height."""

    middle: float
    whole: float
    speeds: Array  # upward mean of each layer of cells, interstitial, m/s


def held_bed(
    folder: Path, diameter: float, void: float, velocity: float, forces: Mapping[str, Any],
    kernel: Any = "auto", free: int = 8,
) -> HeldBed:  # fmt: skip
    """Gas through a lattice of spheres too heavy to move, 4 x 4 x 48, two to a cell's side.

    `free`: layers without spheres below and above the bed.
    """
    across, along = 4, 48
    pitch = diameter * (pi / 6 / (1 - void)) ** (1 / 3)
    grid = np.stack(
        np.meshgrid(np.arange(across), np.arange(across), np.arange(along), indexing="ij"), -1
    ).reshape(-1, 3)
    step = pitch / velocity
    case = make_scene(
        folder,
        Particles.of((grid + 0.5 + [0, 0, free]) * pitch, diameter=diameter, density=1e12),
        {
            f"{BOX}:width": across * pitch,
            f"{BOX}:depth": across * pitch,
            f"{BOX}:height": (along + 2 * free) * pitch,
            f"{BOX}:cellsAcross": across // 2,
            f"{BOX}:cellsAlong": (along + 2 * free) // 2,
            f"{BOX}:gasVelocity": velocity,
            f"{BOX}:gravity": 0,
            "system/scenePlan:gas": True,
            f"{CLOUD}:solution/coupled": True,
            f"{CLOUD}:solution/interpolationSchemes/DUcDt": "cell",
            f"{CLOUD}:constantProperties/alphaMax": 0.9,
            f"{CLOUD}:spreading": {"width": kernel},
            f"{MODELS}/particleForces": dict(forces),
            **loose_solvers(1e-10, 1e-5),
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:endTime": 200 * step,
            f"{CONTROL}:writeInterval": 200 * step,
        },
    )
    run_scene(case)
    layers = (along + 2 * free) // 2
    end = times(case)[-1]
    pressure = read_gas(case, end, "p")[:, 0].reshape(layers, -1).mean(1) * GAS.density
    low, high = layers // 2 - 4, layers // 2 + 4
    return HeldBed(
        float(pressure[low] - pressure[high]) / (8 * 2 * pitch),
        float(pressure[0] - pressure[-1]) / (along * pitch),
        read_gas(case, end)[:, 2].reshape(layers, -1).mean(1),
    )


def _packed(chapter: Chapter, folder: Path, quick: bool) -> None:
    section = chapter.section(
        "Packed bed (Ergun 1952)",
        "Gas through a bed of held spheres, 48 layers on a lattice, slip walls, coupled both ways: "
        "the pressure gradient in the middle against Ergun, with our Gidaspow drag and OpenFOAM's "
        "ErgunWenYu. Rows marked info: the whole bed with its edges, which the kernel (1.5 "
        "diameters) blurs; and OpenFOAM's pressureGradient force added to ErgunWenYu.",
        "ErgunWenYu scales as beta/(eps (1 - eps)): the drag of a gas equation that keeps the "
        "whole pressure gradient. It meets Ergun alone, so a force by the bed's pressure "
        "gradient on the particles would count it twice. OpenFOAM's pressureGradient does not: "
        "it is made of the gas' acceleration Du/Dt, which is nil in a steady bed, and changes "
        "nothing here. A bed of few layers loses the drag of about two layers at each blurred "
        "edge.",
    )
    figure, (axes,) = new_figure(65)
    choices = ((0.4, 1e-3), (0.5, 1e-3), (0.4, 3e-3))
    for (void, diameter), colour in zip(choices[:1] if quick else choices, MATERIAL_COLOURS,
                                        strict=False):  # fmt: skip
        lift = minimum_velocity(diameter, 2650, void)
        speeds = np.array([0.2, 1.0, 4.0]) * lift
        ours = []
        for velocity in speeds:
            case = f"void {void:g}, {diameter * 1e3:g} mm, {velocity:.3g} m/s"
            reference = ergun(velocity, diameter, void)
            for name, forces in (("Gidaspow", GIDASPOW), ("ErgunWenYu", STOCK)):
                bed = held_bed(folder / f"{name}{void}{diameter}{velocity}", diameter, void,
                               velocity, forces)  # fmt: skip
                section.rows.append(
                    Row.relative(case, f"{name}: pressure gradient, Pa/m", reference, bed.middle,
                                 0.01)
                )  # fmt: skip
            ours.append(bed.middle)
            section.rows.append(
                Row.relative(case, "whole bed over its height, Pa/m", reference, bed.whole, None)
            )
        fine = np.geomspace(0.15, 5, 40) * lift
        label = f"void {void:g}, {diameter * 1e3:g} mm"
        axes.loglog(fine, [ergun(u, diameter, void) for u in fine], "-", color=colour, label=label)
        axes.loglog(speeds, ours, "o", color=colour, markersize=4)
    both = held_bed(folder / "both", 1e-3, 0.4, 1.0, {**STOCK, "pressureGradient": {"U": "U.air"}})
    section.rows.append(
        Row.relative("void 0.4, 1 mm, 1 m/s", "ErgunWenYu and pressureGradient, Pa/m",
                     ergun(1.0, 1e-3, 0.4), both.middle, None)
    )  # fmt: skip
    axes.set_xlabel("superficial velocity, m/s")
    axes.set_ylabel("pressure gradient, Pa/m")
    axes.legend(title="lines: Ergun; dots: elutriaFoam", title_fontsize=7)
    section.figures["packed"] = (figure, "Packed beds: pressure gradient.")
