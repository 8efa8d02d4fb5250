"""A grain's own wake: two-way coupling feels the gas that the grain has slowed itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elutria_validation.book.figures import COLOURS, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase, GasPlan
from elutria_validation.harness.cases import solve, times
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.references.drag import AIR, STANDARD_GRAVITY, terminal_velocity

NAME = "wake"
TITLE = "A particle's own wake"
HELP = "A grain's own wake: settling in a ladder of cell sizes with two-way coupling."

LIGHT = 24.0  # kg/m3, so that a grain follows its drag within the box
QUARTZ = 2650.0  # kg/m3
NU = AIR.viscosity / AIR.density
FAR = 32  # diameters: walls are not nearer where viscosity carries the disturbance to them


@dataclass(frozen=True)
class Settling:
    """A light grain of `diameter` (m) that falls past cells of `ratio` diameters."""

    diameter: float
    ratio: float

    @property
    def terminal(self) -> float:
        """Terminal velocity, m/s."""
        return terminal_velocity(self.diameter, LIGHT)

    @property
    def reynolds(self) -> float:
        return self.terminal * self.diameter / NU

    @property
    def cell(self) -> float:
        """Size of a cell, m."""
        return self.ratio * self.diameter

    @property
    def duration(self) -> float:
        """In which its motion and the gas become steady, s."""
        width = max(1.5 * self.diameter, 0.34 * self.cell)
        gas = 6 * min(width**2 / NU, 4 * width / self.terminal)
        return max(3 * self.terminal / STANDARD_GRAVITY, gas, 20 * self.cell / self.terminal)

    @property
    def falling(self) -> float:
        """Velocity past the cells, six of them in its duration, over the terminal one."""
        return 6 * self.cell / self.duration / self.terminal

    def error(self, folder: Path, corrected: bool | None) -> float:
        """Mean relative error of the slip once steady, coupled both ways; None: the default."""
        diameter, terminal, cell, cells = self.diameter, self.terminal, self.cell, 12
        upflow = terminal - self.falling * terminal
        step = min(0.25 * cell / terminal, cell**2 / NU)
        steps = int(np.ceil(self.duration / step))
        # viscosity carries the disturbance over nu/u: walls are beyond, or far enough
        reach = max(0.0, min(FAR * diameter, 2 * NU / terminal) - cells * cell / 2)
        across, side, grading = stretched(cells, cell, reach)
        along, height, grading_along = stretched(2 * cells, cell, reach)
        place = (side / 2 + 0.11 * cell, side / 2 + 0.07 * cell, height / 2 + 0.5 * cells * cell)
        case = BoxCase(
            width=side, depth=side, height=height, cells=(across, across, along),
            grading=[grading, grading, grading_along], gas_velocity=upflow, coupled=True,
            undisturbed=corrected, solve_gas=True, tolerance=(1e-9, 1e-3), step=step,
            end=steps * step, interval=step * max(1, steps // 40),
        ).make(folder, Particles.of(place, (0, 0, upflow - terminal), diameter=diameter,
                                    density=LIGHT))  # fmt: skip
        solve(case)
        slips = [upflow - read_particles(case, t).velocity[0, 2] for t in times(case)[1:-1]]
        return float(np.mean(slips[len(slips) // 2 :]) / terminal - 1)


def stretched(core: int, cell: float, reach: float) -> tuple[int, float, list[list[float]]]:
    """Cells, length (m) and blockMesh grading of `core` equal cells between two growing shells.

    Each shell is `reach` (m) thick and grows by 1.4 from cell to cell.
    """
    if reach <= 0:
        return core, core * cell, [[1, 1, 1]]
    growth = 1.4
    outer = int(np.ceil(np.log(1 + reach / cell * (growth - 1)) / np.log(growth)))
    ratio = growth ** (outer - 1)
    grading = [[reach, outer, 1 / ratio], [core * cell, core, 1], [reach, outer, ratio]]
    return core + 2 * outer, core * cell + 2 * reach, grading


@dataclass(frozen=True)
class Hovering:
    """A grain of quartz of `diameter` (m) in cells of `cell` (m), which moves at `rising` of its
    terminal velocities; `gas` is the plan's entry."""

    diameter: float
    cell: float
    rising: float
    gas: GasPlan = True

    @property
    def terminal(self) -> float:
        """Terminal velocity, m/s."""
        return terminal_velocity(self.diameter, QUARTZ)

    @property
    def name(self) -> str:
        at_rest = ", gas at rest" if self.gas == "auto" else ""
        return (
            f"{1e3 * self.diameter:g} mm, cells of {1e3 * self.cell:g} mm, velocity "
            f"{self.rising:+g} slips{at_rest}"
        )

    def lost(self, folder: Path, corrected: bool) -> float:
        """Part of its terminal slip that it misses, from its acceleration, after the gas has
        crossed some cells."""
        cell, cells, terminal = self.cell, 40, self.terminal
        heavier = terminal_velocity(self.diameter, 1.01 * QUARTZ)
        exponent = np.log(1.01) / np.log(heavier / terminal)  # of drag over slip
        velocity = self.rising * terminal
        solved = self.gas is True
        duration, steps = (30 * cell / terminal, 120) if solved else (100 * cell / terminal, 20)
        place = (5.1 * cell, 5.06 * cell, (cells / 2 + 0.14) * cell - velocity * duration / 2)
        case = BoxCase(
            width=10 * cell, depth=10 * cell, height=cells * cell, cells=(10, 10, cells),
            gas_velocity=terminal + velocity, coupled=True, undisturbed=corrected,
            solve_gas=self.gas, gas_tolerance=3e-5,  # of one grain
            tolerance=(1e-7, 1e-3), step=duration / steps, end=duration, interval=duration / 2,
        ).make(folder, Particles.of(place, (0, 0, velocity), diameter=self.diameter,
                                    density=QUARTZ))  # fmt: skip
        solve(case)
        middle, end = (read_particles(case, t).velocity[0, 2] for t in times(case)[-2:])
        acceleration = (end - middle) / (duration / 2)
        felt = (1 + acceleration / STANDARD_GRAVITY) ** (1 / exponent)
        return float(1 + (velocity - (middle + end) / 2) / terminal - felt)


def settling(folder: Path, quick: bool) -> Section:
    ratios = (2, 8) if quick else (1, 2, 4, 8)
    section = Section(
        "A particle's own wake",
        "A single grain settles through gas that rises nearly as fast, coupled both ways, the gas "
        "solved on every step; walls slip. Drag laws are made for undisturbed gas, so the error is "
        "the settling slip over the terminal velocity, less 1. Cells of 1 to 8 diameters, kernel "
        "1.5 diameters (auto). Without correction the rows are for information; with it (ownWake, "
        "the default; regularised Stokeslet with Oseen's factor) the allowed error is 3 %. The "
        f"grain is light ({LIGHT:g} kg/m3), so that it follows its drag within the box. Where "
        f"viscosity carries the disturbance to the walls, they are {FAR} diameters away. None of "
        "these grains is among those that the correction's constants are fitted to (fits, "
        "own_wake).",
    )
    figure, (axes,) = new_figure(65)
    learnt = []
    for diameter, colour in zip((1e-4, 5e-4, 2e-3)[: 2 if quick else 3], COLOURS, strict=False):
        worst = {}
        for corrected in (False, True):
            kind = "corrected" if corrected else "as the gas is"
            errors = []
            for ratio in ratios:
                grain = Settling(diameter, ratio)
                errors.append(grain.error(folder / f"{diameter}{ratio}{corrected}", corrected))
                section.rows.append(
                    Row(
                        f"Re {grain.reynolds:.2g}, cell {ratio} diameters",
                        f"settling slip, m/s, {kind}", grain.terminal,
                        grain.terminal * (1 + errors[-1]), abs(errors[-1]),
                        0.03 if corrected else None,
                    )
                )  # fmt: skip
            worst[corrected] = max(map(abs, errors))
            axes.plot(ratios, 100 * np.array(errors), "o-" if corrected else "s:", color=colour,
                      ms=3, label=f"Re {grain.reynolds:.2g}, {kind}")  # fmt: skip
        learnt.append(
            f"at Re {grain.reynolds:.2g} {100 * worst[False]:.2g} % as the gas is, "
            f"{100 * worst[True]:.2g} % corrected"
        )
    section.found = f"Largest error of the slip: {'; '.join(learnt)}."
    axes.axhline(0, color="k", linewidth=0.5)
    axes.set_xscale("log", base=2)
    axes.set_xticks(ratios, [str(r) for r in ratios])
    axes.set_ylim(-12, 46)
    label(axes, "cell size, diameters", "error of the settling slip, %", ncols=2, fontsize=6)
    section.figures["wake"] = (figure, "Settling of single grains with two-way coupling.")
    return section


def hovering(folder: Path, quick: bool) -> Section:
    scenes = [Hovering(8e-4, 5e-3, 0.0), Hovering(8e-4, 5e-3, 0.0, "auto")]
    if not quick:
        scenes += [Hovering(8e-4, 5e-3, -0.1), Hovering(8e-4, 5e-3, 0.1),
                   Hovering(1.5e-3, 5e-3, 0.0)]  # fmt: skip
    inertia = [one.terminal * one.cell / NU for one in scenes]
    section = Section(
        "The wake of a grain near the cut",
        "A grain of quartz in gas that rises as fast as it falls, or 10 % slower or faster: the "
        "part by which its slip is too small, from its acceleration. Inertia rules in these cells "
        f"(s h/nu {min(inertia):.0f} to {max(inertia):.0f}), and a grain that hovers stays in the "
        "cell that it slows. In gas at rest the gas is solved once, with the grain's force, and "
        "then left (scene plan auto). Allowed with the correction: 0.1 %.",
    )
    for number, scene in enumerate(scenes):
        for corrected in (False, True):
            kind = "corrected" if corrected else "as the gas is"
            section.rows.append(
                Row.size(scene.name, f"lost slip, {kind}",
                         scene.lost(folder / f"hover{number}{corrected}", corrected),
                         0.001 if corrected else None)
            )  # fmt: skip
    return section


SECTIONS = (settling, hovering)
