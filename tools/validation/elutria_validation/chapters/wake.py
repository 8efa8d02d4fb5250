"""A grain's own wake: two-way coupling feels the gas that the grain has slowed itself."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray

from elutria.output.plots import MATERIAL_COLOURS, STYLE, new_figure
from elutria.physics.drag import Gas, terminal_velocity
from elutria_validation.book.book import Chapter, Row, Section, write_chapter
from elutria_validation.harness.common import Options
from elutria_validation.harness.scene import (
    BOX,
    CLOUD,
    CONTROL,
    Particles,
    make_scene,
    read_particles,
    run_scene,
    times,
)

NAME = "wake"
HELP = "A grain's own wake: settling in a ladder of cell sizes with two-way coupling."

Array = NDArray[np.float64]

GAS, GRAVITY, DENSITY, NU = Gas(), 9.80665, 24.0, 1.5e-5


@rc_context(STYLE)
def run(options: Options) -> Chapter:
    """Settling of single grains at three Reynolds numbers and four cell sizes, before and after."""
    chapter = Chapter(NAME, "A particle's own wake")
    section = chapter.section(
        "A particle's own wake",
        "A single grain settles through gas that rises nearly as fast, coupled both ways, the gas "
        "solved on every step; walls slip. Drag laws are made for undisturbed gas, so the error is "
        "the settling slip over the terminal velocity, less 1. Cells of 1 to 8 diameters, kernel "
        "1.5 diameters (auto). Without correction the rows are for information; with it (ownWake, "
        "the default; regularised Stokeslet with Oseen's factor) the allowed error is 3 %. The "
        "grain is light (24 kg/m3), so that it follows its drag within the box.",
        "Without correction a grain settles up to a quarter too fast at Re 0.05, a tenth at Re 4, "
        "2 % at Re 87; coarse cells help only beyond 8 diameters, and least where the flow is "
        "viscous. The correction takes that to a few per cent and below. Walls hold a viscous "
        "disturbance back, which the correction for unbounded gas must not see: at Re 0.05 they "
        "are 32 diameters away (at 6, in cells of one diameter, the error was 10 %). There "
        "the step must not exceed h^2/nu either, the time in which viscosity crosses a cell: at "
        "five times that the gas itself began to swing.",
    )
    ratios = (2, 8) if options.quick else (1, 2, 4, 8)
    with TemporaryDirectory() as work:
        _ladder(section, Path(work), ratios)
        _hovering(chapter, Path(work), options.quick)
    return write_chapter(options, chapter)


def _hovering(chapter: Chapter, folder: Path, quick: bool) -> None:
    """Rows of grains that the gas nearly holds: solved on every step, and left at rest."""
    section = chapter.section(
        "The wake of a grain near the cut",
        "A grain of quartz in gas that rises as fast as it falls, or 10 % slower or faster: the "
        "part by which its slip is too small, from its acceleration. Inertia rules in these cells "
        "(s h/nu 1000 to 3300), and a grain that hovers stays in the cell that it slows. In gas at "
        "rest the gas is solved once, with the grain's force, and then left (scene plan auto). "
        "Allowed with the correction: 0.1 %.",
        "Hovering grains feel gas slowed by their own force through their cell, F/(rho s^2 h^2), "
        "half as much again as ones that fall through cells: this decides at a cut.",
    )
    scenes = [(8e-4, 5e-3, 0.0, True), (8e-4, 5e-3, 0.0, "auto")]
    if not quick:
        scenes += [(8e-4, 5e-3, -0.1, True), (8e-4, 5e-3, 0.1, True), (1.5e-3, 5e-3, 0.0, True)]
    for number, (diameter, cell, rising, gas) in enumerate(scenes):
        for corrected in (False, True):
            found = own_share(
                folder / f"hover{number}{corrected}", diameter, cell, rising, gas, corrected
            )
            section.rows.append(
                Row(
                    f"{1e3 * diameter:g} mm, cells of {1e3 * cell:g} mm, velocity {rising:+g} slips"
                    + (", gas at rest" if gas == "auto" else ""),
                    f"lost slip, {'corrected' if corrected else 'as the gas is'}",
                    0, found, abs(found),
                    0.001 if corrected else None,
                )
            )  # fmt: skip


def own_share(
    folder: Path, diameter: float, cell: float, rising: float, gas: object, corrected: bool
) -> float:
    """Part of its terminal slip that a grain of quartz misses, which moves at `rising` slips.

    From its acceleration, after the gas has crossed some cells; `gas` is the plan's entry.
    """
    density, cells = 2650.0, 40
    terminal = terminal_velocity(diameter, density, GAS, gravity=GRAVITY)
    heavier = terminal_velocity(diameter, 1.01 * density, GAS, gravity=GRAVITY)
    exponent = np.log(1.01) / np.log(heavier / terminal)  # of drag over slip
    velocity = rising * terminal
    duration, steps = (30 * cell / terminal, 120) if gas is True else (100 * cell / terminal, 20)
    place = (5.1 * cell, 5.06 * cell, (cells / 2 + 0.14) * cell - velocity * duration / 2)
    case = make_scene(
        folder,
        Particles.of(place, (0, 0, velocity), diameter=diameter, density=density),
        {
            f"{BOX}:width": 10 * cell,
            f"{BOX}:depth": 10 * cell,
            f"{BOX}:height": cells * cell,
            f"{BOX}:cellsAcross": 10,
            f"{BOX}:cellsAlong": cells,
            f"{BOX}:gasVelocity": terminal + velocity,
            f"{CLOUD}:solution/coupled": True,
            f"{CLOUD}:ownWake": {"undisturbed": corrected},
            "system/scenePlan:gas": gas,
            "system/scenePlan:gasTolerance": 3e-5,  # of one grain
            **loose_solvers(1e-7, 1e-3),
            f"{CONTROL}:deltaT": duration / steps,
            f"{CONTROL}:endTime": duration,
            f"{CONTROL}:writeInterval": duration / 2,
        },
    )
    run_scene(case)
    middle, end = (read_particles(case, t).velocity[0, 2] for t in times(case)[-2:])
    acceleration = (end - middle) / (duration / 2)
    felt = (1 + acceleration / GRAVITY) ** (1 / exponent)
    return float(1 + (velocity - (middle + end) / 2) / terminal - felt)


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


def settling_error(folder: Path, diameter: float, ratio: float, corrected: bool) -> float:
    """Mean relative error of the slip, in cells of `ratio` diameters, once it is steady."""
    terminal = terminal_velocity(diameter, DENSITY, GAS, gravity=GRAVITY)
    cell, cells = ratio * diameter, 12
    width = max(1.5 * diameter, 0.34 * cell)
    duration = max(
        3 * terminal / GRAVITY, 6 * min(width**2 / NU, 4 * width / terminal), 20 * cell / terminal
    )
    upflow = terminal - 6 * cell / duration  # it falls past six cells
    step = min(0.25 * cell / terminal, cell**2 / NU)
    steps = int(np.ceil(duration / step))
    # Viscosity carries the disturbance over nu/u: walls are beyond, or 32 diameters away
    reach = max(0.0, min(32 * diameter, 2 * NU / terminal) - cells * cell / 2)
    across, side, grading = stretched(cells, cell, reach)
    along, height, grading_along = stretched(2 * cells, cell, reach)
    case = make_scene(
        folder,
        Particles.of(
            (side / 2 + 0.11 * cell, side / 2 + 0.07 * cell, height / 2 + 0.5 * cells * cell),
            (0, 0, upflow - terminal), diameter=diameter, density=DENSITY,
        ),
        {
            f"{BOX}:width": side,
            f"{BOX}:depth": side,
            f"{BOX}:height": height,
            f"{BOX}:cellsAcross": across,
            f"{BOX}:cellsAlong": along,
            f"{BOX}:grading": [grading, grading, grading_along],
            f"{BOX}:gasVelocity": upflow,
            f"{CLOUD}:solution/coupled": True,
            f"{CLOUD}:ownWake": {"undisturbed": corrected},
            "system/scenePlan:gas": True,
            **loose_solvers(1e-9, 1e-3),
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:endTime": steps * step,
            f"{CONTROL}:writeInterval": step * max(1, steps // 40),
        },
    )  # fmt: skip
    run_scene(case)
    slips = [upflow - read_particles(case, t).velocity[0, 2] for t in times(case)[1:-1]]
    return float(np.mean(slips[len(slips) // 2 :]) / terminal - 1)


def loose_solvers(tolerance: float, relative: float) -> dict[str, float]:
    """Settings of the box' linear solvers for flows that need no round-off balance."""
    pressure, velocity = (f'system/fvSolution:solvers/"{f}(Final)?"' for f in ("p", "U.air"))
    return {
        f"{pressure}/tolerance": tolerance,
        f"{pressure}/relTol": relative,
        f"{velocity}/tolerance": tolerance,
    }


def _ladder(section: Section, folder: Path, ratios: tuple[int, ...]) -> None:
    figure, (axes,) = new_figure(65)
    for diameter, colour in zip((1e-4, 5e-4, 2e-3), MATERIAL_COLOURS, strict=False):
        terminal = terminal_velocity(diameter, DENSITY, GAS, gravity=GRAVITY)
        reynolds = terminal * diameter * GAS.density / GAS.viscosity
        for corrected in (False, True):
            errors = []
            for ratio in ratios:
                name = f"{diameter}{ratio}{corrected}"
                errors.append(settling_error(folder / name, diameter, ratio, corrected))
                section.rows.append(
                    Row(
                        f"Re {reynolds:.2g}, cell {ratio} diameters",
                        f"settling slip, m/s, {'corrected' if corrected else 'as the gas is'}",
                        terminal, terminal * (1 + errors[-1]), abs(errors[-1]),
                        0.03 if corrected else None,
                    )
                )  # fmt: skip
            label = f"Re {reynolds:.2g}, {'corrected' if corrected else 'as the gas is'}"
            style = "o-" if corrected else "s:"
            axes.plot(ratios, 100 * np.array(errors), style, color=colour, ms=3, label=label)
    axes.axhline(0, color="k", linewidth=0.5)
    axes.set_xscale("log", base=2)
    axes.set_xticks(ratios, [str(r) for r in ratios])
    axes.set_xlabel("cell size, diameters")
    axes.set_ylabel("error of the settling slip, %")
    axes.set_ylim(-12, 46)
    axes.legend(ncols=2, fontsize=6)
    section.figures["wake"] = (figure, "Settling of single grains with two-way coupling.")
