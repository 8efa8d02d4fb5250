"""OpenFOAM's own fluidised bed, Goldschmidt's: the pressure drop carries the bed."""

from __future__ import annotations

from pathlib import Path

from elutria_validation.book.figures import new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.cases import CONTROL, change, solve, times
from elutria_validation.harness.goldschmidt import (
    SECTION,
    SPHERES,
    STEP,
    WEIGHT,
    make_bed,
    read_history,
)
from elutria_validation.harness.particles import read_particles
from elutria_validation.harness.programs import run_program

NAME = "goldschmidt"
TITLE = "Goldschmidt's bed"
HELP = "Goldschmidt's bed, OpenFOAM's tutorial: the pressure drop carries the bed."


def tutorial(folder: Path, quick: bool) -> Section:
    left_out, end = (0.01, 0.03) if quick else (0.3, 0.8)
    section = Section(
        "Goldschmidt's bed",
        "OpenFOAM's tutorial: 24 750 spheres of 2.5 mm between walls 15 mm apart, gas at 1.875 "
        "m/s, contacts by the tutorial's own numbers, steps of 0.2 ms instead of 0.02. The mean "
        "pressure drop over the bed, less what the spheres gain in momentum, must carry their "
        "weight less buoyancy. Allowed: 5 %, which the side walls' friction may hold. A bed that "
        f"lies on a lattice first falls and throws a slug: the first {left_out:g} s are left out. "
        "`elutria bench bed` runs the same bed beside stock DPMFoam with our contacts.",
    )
    case = make_bed(folder / "bed", "elutriaFoam", 10 * STEP)
    change(case, {f"{CONTROL}:endTime": end, f"{CONTROL}:writeInterval": 0.01})
    run_program(["blockMesh"], case)
    solve(case)
    bed = read_history(case)

    kept = bed.time >= left_out - 1e-9
    drop = bed.pressure_drop[bed.pressure_drop[:, 0] >= left_out, 1].mean()
    (first, last), (start, stop) = bed.momentum[kept][[0, -1]], bed.time[kept][[0, -1]]
    gain = (last - first) / (stop - start) / SECTION
    name = f"mean from {left_out:g} to {end:g} s"
    inside = len(read_particles(case, times(case)[-1]).diameter)
    section.rows += [
        Row.relative(name, "spheres inside at the end", SPHERES, inside, 0),
        Row.relative(name, "pressure drop less gain in momentum, Pa", WEIGHT, drop - gain,
                     None if quick else 0.05),
        Row.relative(name, "pressure drop alone, Pa", WEIGHT, drop, None),
    ]  # fmt: skip
    figure, (above, below) = new_figure(90, rows=2, sharex=True)
    above.plot(*bed.pressure_drop.T, linewidth=0.6)
    above.axhline(WEIGHT, color="k", linestyle=":", linewidth=0.8)
    above.set_ylabel("pressure drop (Pa)")
    above.set_ylim(0, 2 * WEIGHT)
    below.plot(bed.time, 1e3 * bed.height)
    below.set_ylabel("mean height (mm)")
    below.set_xlabel("time (s)")
    section.figures["bed"] = (figure, "Pressure drop (dotted: the bed's weight) and mean height.")
    return section


SECTIONS = (tutorial,)
