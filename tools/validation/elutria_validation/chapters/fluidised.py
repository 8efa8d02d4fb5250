"""Fluidised beds: pressure drop from Ergun's packed bed to the plateau of the bed's weight."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from elutria_validation.book.figures import COLOURS, GREEN, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.chapters.bed import GIDASPOW
from elutria_validation.harness.box import BoxCase, Contacts, Pair
from elutria_validation.harness.cases import (
    PARAMETERS,
    patch_mean,
    read_patch_mean,
    solve,
    times,
)
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.references.drag import AIR, STANDARD_GRAVITY
from elutria_validation.references.flows import ergun, minimum_fluidisation

NAME = "fluidised"
TITLE = "Fluidised beds"
HELP = "Fluidised beds: pressure drop against the bed's weight."

Array = NDArray[np.float64]

FREE = 24  # height over the bed, in spheres
SPACING = 1.04  # of the spheres at the start, diameters
SETTLED = 0.1  # s


@dataclass(frozen=True)
class Bed:
    """A bed of equal spheres without friction; gas velocities in minimum velocities at 0.4."""

    diameter: float  # m
    density: float  # kg/m3
    stiffness: float  # N/m
    step: float  # s
    duration: float  # s
    across: int = 8  # spheres along a side
    along: int = 16  # and up

    @property
    def name(self) -> str:
        return f"{self.diameter * 1e6:g} um, {self.density:g} kg/m3"

    @property
    def minimum(self) -> float:
        """Minimum velocity (m/s) at a void fraction of 0.4."""
        return minimum_fluidisation(self.diameter, self.density, 0.4)

    @property
    def pitch(self) -> float:
        """Between spheres at the start, m."""
        return SPACING * self.diameter

    @property
    def section(self) -> float:
        """Area of the column, m2."""
        return (self.across * self.pitch) ** 2

    @property
    def height(self) -> float:
        """Of the column, m."""
        return (self.along + FREE) * self.pitch

    @property
    def solids(self) -> float:
        """Volume of the spheres over the section, m."""
        return self.across**2 * self.along * pi / 6 * self.diameter**3 / self.section

    @property
    def weight(self) -> float:
        """Of the spheres less buoyancy, over the section, Pa."""
        return self.solids * (self.density - AIR.density) * STANDARD_GRAVITY


@dataclass(frozen=True)
class Means:
    """Time means of a bed (Pa): pressure drop, force on the bottom, momentum gained per time."""

    drop: float
    bottom: float
    gained: float
    void: float  # of the bed, from its spheres' mean height

    @property
    def carried(self) -> float:
        """What gas and bottom carry."""
        return self.drop + self.bottom - self.gained


def fluidise(folder: Path, bed: Bed, velocity: float, writes: int = 30) -> Means:
    """Gas through the bottom of a bed that stands on it; sides periodic."""
    numbers = np.indices((bed.across, bed.across, bed.along))
    grid = np.moveaxis(numbers, 0, -1).reshape(-1, 3)
    shaken = np.random.default_rng(1).uniform(-0.018, 0.018, grid.shape)
    side = bed.across * bed.pitch
    case = BoxCase(
        width=side, depth=side, height=bed.height, gas_velocity=velocity, sides="cyclic",
        # cells of two spheres' size
        cells=(bed.across // 2, bed.across // 2, (bed.along + FREE) // 2),
        solve_gas=True, coupled=True, most_solids=0.9, forces={**GIDASPOW, "gravity": {}},
        contacts=Contacts(Pair(0.8, 0, bed.stiffness), law="linearSpringDashpot",
                          treatment="soft"),
        tolerance=(1e-9, 1e-4), step=bed.step, end=bed.duration, interval=bed.duration / writes,
        # the spheres stand on a bottom that lets gas in
        more={f"{PARAMETERS}:ends": "wall", **patch_mean("bottom", "p")},
    ).make(folder, Particles.of((grid + 0.5 + shaken) * bed.pitch, diameter=bed.diameter,
                                density=bed.density))  # fmt: skip
    solve(case)
    return _means(case, bed)


def _means(case: Path, bed: Bed) -> Means:
    head = AIR.density * STANDARD_GRAVITY
    series = read_patch_mean(case, "bottom")
    settled = series[series[:, 0] > SETTLED, 1]

    written = [t for t in times(case) if float(t) > SETTLED]
    beds = [read_particles(case, t) for t in written]
    heights = [b.position[:, 2] for b in beds]
    pressed = [bed.stiffness * np.maximum(bed.diameter / 2 - z, 0).sum() for z in heights]
    gained = (beds[-1].momentum - beds[0].momentum)[2] / (float(written[-1]) - float(written[0]))

    return Means(
        AIR.density * float(settled.mean()) - head * bed.height,
        float(np.mean(pressed)) / bed.section,
        gained / bed.section,
        1 - bed.solids / (2 * float(np.mean(heights))),
    )


def equilibrium_void(bed: Bed, velocity: float) -> float:
    """Void fraction at which Ergun's gradient carries the spheres."""
    return float(
        brentq(lambda v: minimum_fluidisation(bed.diameter, bed.density, v) - velocity, 0.3, 0.8)
    )


SMOOTH = {
    Bed(80e-6, 1000, 0.1, 2e-4, 0.25): (0.6, 1.5, 3.0),
    Bed(120e-6, 1500, 0.3, 2e-4, 0.25): (2.0,),
}
BUBBLING = (Bed(5e-4, 2650, 20, 4e-4, 1.0), 1.5)


def _rows(case: str, bed: Bed, velocity: float, means: Means, smooth: bool) -> list[Row]:
    if not smooth:
        return [
            Row.relative(case, "pressure drop and force on the bottom, Pa", bed.weight,
                         means.carried, 0.01),
            Row.relative(case, "pressure drop alone, Pa", bed.weight, means.drop, None),
        ]  # fmt: skip
    void = equilibrium_void(bed, velocity)
    return [
        Row.relative(case, "pressure drop, Pa", bed.weight, means.drop, 0.01),
        Row.relative(case, "void fraction of the expanded bed", void, means.void, None),
    ]


def plateau(folder: Path, quick: bool) -> Section:
    section = Section(
        "Fluidisation plateau",
        "A bed of 1024 equal spheres without friction stands on the inlet of a periodic column; "
        "Gidaspow's drag, coupled both ways. Above minimum fluidisation the time-mean pressure "
        "drop must be the bed's weight less buoyancy over the area; fine light grains expand "
        "smoothly. For information: their void fraction beside the one at which Ergun carries "
        "them. Below, and where coarse grains bubble and fall on the bottom, the bottom carries "
        "the rest: pressure drop and mean force on the bottom (of its springs, at up to 200 "
        "times), less what the bed gains in momentum, must be the weight. Ergun's law below "
        "minimum fluidisation is the packed bed's section.",
    )
    figure, (axes,) = new_figure(65)
    for (bed, ratios), colour in zip(SMOOTH.items(), COLOURS, strict=False):
        found = []
        for ratio in ratios[: 2 if quick else None]:
            velocity = ratio * bed.minimum
            case = f"{bed.name}, {velocity:.3g} m/s ({ratio:g} u_mf)"
            means = fluidise(folder / f"{bed.diameter}{ratio}", bed, velocity)
            found.append((ratio, means.drop / bed.weight))
            section.rows += _rows(case, bed, velocity, means, ratio > 1)
        axes.plot(*zip(*found, strict=True), "o", color=colour, ms=4, label=bed.name)
    if not quick:
        bed, ratio = BUBBLING
        velocity = ratio * bed.minimum
        means = fluidise(folder / "bubbling", bed, velocity, 200)
        case = f"{bed.name}, {velocity:.3g} m/s ({ratio:g} u_mf), bubbling"
        section.rows += _rows(case, bed, velocity, means, False)
        axes.plot(ratio, means.carried / bed.weight, "^", color=GREEN, ms=5,
                  label=f"{bed.name}, with the bottom's force")  # fmt: skip
        axes.plot(ratio, means.drop / bed.weight, "^", color=GREEN, ms=5, mfc="none",
                  label="the same, pressure drop alone")  # fmt: skip
    bed = next(iter(SMOOTH))
    below = np.linspace(0, 1, 30)
    drop = [ergun(max(r, 1e-9) * bed.minimum, bed.diameter, 0.4) for r in below]
    axes.plot([*below, 4], [*np.array(drop) / drop[-1], 1], "k-", lw=0.8)
    axes.set_xlabel("velocity over minimum fluidisation (void 0.4)")
    axes.set_ylabel("pressure drop over weight")
    axes.legend(title="line: Ergun at void 0.4, then the weight", title_fontsize=7)
    section.figures["plateau"] = (figure, "Pressure drop of beds on the inlet.")
    return section


SECTIONS = (plateau,)
