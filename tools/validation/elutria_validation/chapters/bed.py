"""Packed beds: pressure gradient by Ergun."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from elutria_validation.book.figures import COLOURS, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import CLOUD, read_gas, solve, times
from elutria_validation.harness.particles import Particles
from elutria_validation.references.drag import AIR
from elutria_validation.references.flows import ergun, minimum_fluidisation

NAME = "bed"
TITLE = "Beds"
HELP = "Packed bed against Ergun."

Array = NDArray[np.float64]

GIDASPOW: dict[str, Any] = {"GidaspowDrag": {"alphac": "alpha.air"}}
STOCK: dict[str, Any] = {"ErgunWenYuDrag": {"alphac": "alpha.air"}}


@dataclass(frozen=True)
class HeldBed:
    """Pressure gradient in the middle (Pa/m), and of the whole over the bed's height."""

    middle: float
    whole: float
    speeds: Array  # upward mean of each layer of cells, interstitial, m/s


def held_bed(
    folder: Path, diameter: float, void: float, velocity: float, forces: Mapping[str, Any],
    kernel: float | Literal["auto"] = "auto", free: int = 8,
) -> HeldBed:  # fmt: skip
    """Gas through a lattice of spheres too heavy to move, 4 x 4 x 48, two to a cell's side.

    `free`: layers without spheres below and above the bed.
    """
    across, along = 4, 48
    layers = (along + 2 * free) // 2
    pitch = diameter * (pi / 6 / (1 - void)) ** (1 / 3)
    grid = np.stack(
        np.meshgrid(np.arange(across), np.arange(across), np.arange(along), indexing="ij"), -1
    ).reshape(-1, 3)
    step = pitch / velocity
    case = BoxCase(
        width=across * pitch, depth=across * pitch, height=(along + 2 * free) * pitch,
        cells=(across // 2, across // 2, layers), gas_velocity=velocity, gravity=0,
        solve_gas=True, coupled=True, most_solids=0.9, kernel=kernel, forces=dict(forces),
        tolerance=(1e-10, 1e-5), step=step, end=200 * step,
        more={f"{CLOUD}:solution/interpolationSchemes/DUcDt": "cell"},
    ).make(folder, Particles.of((grid + 0.5 + [0, 0, free]) * pitch, diameter=diameter,
                                density=1e12))  # fmt: skip
    solve(case)
    end = times(case)[-1]
    pressure = read_gas(case, end, "p")[:, 0].reshape(layers, -1).mean(1) * AIR.density
    low, high = layers // 2 - 4, layers // 2 + 4
    return HeldBed(
        float(pressure[low] - pressure[high]) / (8 * 2 * pitch),
        float(pressure[0] - pressure[-1]) / (along * pitch),
        read_gas(case, end)[:, 2].reshape(layers, -1).mean(1),
    )


def packed(folder: Path, quick: bool) -> Section:
    section = Section(
        "Packed bed (Ergun 1952)",
        "Gas through a bed of held spheres, 48 layers on a lattice, slip walls, coupled both ways: "
        "the pressure gradient in the middle against Ergun, with our Gidaspow drag and OpenFOAM's "
        "ErgunWenYu. Rows marked info: the whole bed with its edges, which the kernel (1.5 "
        "diameters) blurs; and OpenFOAM's pressureGradient force added to ErgunWenYu.",
    )
    figure, (axes,) = new_figure(65)
    choices = ((0.4, 1e-3), (0.5, 1e-3), (0.4, 3e-3))
    for (void, diameter), colour in zip(choices[: 1 if quick else None], COLOURS, strict=False):
        lift = minimum_fluidisation(diameter, 2650, void)
        speeds = np.array([0.2, 1.0, 4.0]) * lift
        ours = []
        for velocity in speeds:
            case = f"void {void:g}, {diameter * 1e3:g} mm, {velocity:.3g} m/s"
            reference = ergun(velocity, diameter, void)
            for name, forces in (("Gidaspow", GIDASPOW), ("ErgunWenYu", STOCK)):
                place = folder / f"{name}{void}{diameter}{velocity}"
                bed = held_bed(place, diameter, void, velocity, forces)
                section.rows.append(
                    Row.relative(case, f"{name}: pressure gradient, Pa/m", reference, bed.middle,
                                 0.01)
                )  # fmt: skip
            ours.append(bed.middle)
            section.rows.append(
                Row.relative(case, "whole bed over its height, Pa/m", reference, bed.whole, None)
            )
        fine = np.geomspace(0.15, 5, 40) * lift
        name = f"void {void:g}, {diameter * 1e3:g} mm"
        axes.loglog(fine, [ergun(u, diameter, void) for u in fine], "-", color=colour, label=name)
        axes.loglog(speeds, ours, "o", color=colour, markersize=4)
    both = held_bed(folder / "both", 1e-3, 0.4, 1.0, {**STOCK, "pressureGradient": {"U": "U.air"}})
    section.rows.append(
        Row.relative("void 0.4, 1 mm, 1 m/s", "ErgunWenYu and pressureGradient, Pa/m",
                     ergun(1.0, 1e-3, 0.4), both.middle, None)
    )  # fmt: skip
    label(axes, "superficial velocity, m/s", "pressure gradient, Pa/m", "Ergun")
    section.figures["packed"] = (figure, "Packed beds: pressure gradient.")
    return section


SECTIONS = (packed,)
