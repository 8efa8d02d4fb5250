"""OpenFOAM's own fluidised bed, Goldschmidt's: its files for any solver, and what it weighs."""

from __future__ import annotations

import gzip
import os
import shutil
from dataclasses import dataclass
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray

from elutria.errors import InputError
from elutria.output.plots import STYLE, new_figure
from elutria_validation.book.book import Chapter, Row, write_chapter
from elutria_validation.harness.common import Options, run_program
from elutria_validation.harness.scene import (
    CONTROL,
    MODELS,
    change,
    patch_mean,
    read_particles,
    read_patch_mean,
    run_scene,
    times,
)

NAME = "goldschmidt"
HELP = "Goldschmidt's bed, OpenFOAM's tutorial: the pressure drop carries the bed."

Array = NDArray[np.float64]


def tutorials() -> Path:
    """OpenFOAM's tutorials: those of the sourced environment, else Debian's examples."""
    return Path(os.environ.get("FOAM_TUTORIALS") or "/usr/share/doc/openfoam-examples/examples")


TUTORIAL = tutorials() / "lagrangian/DPMFoam/Goldschmidt"
STEP = 2e-5  # s, the tutorial's
GAS_DENSITY = 1.2  # kg/m3
SECTION = 0.015 * 0.150  # m2
SPHERES, DIAMETER, DENSITY, GRAVITY = 24750, 2.5e-3, 2526.0, 9.81
WEIGHT = SPHERES * pi / 6 * DIAMETER**3 * (DENSITY - GAS_DENSITY) * GRAVITY / SECTION  # Pa


def copy_tutorial(case: Path) -> Path:
    """The tutorial's files, unpacked, in a folder that is made anew."""
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(TUTORIAL, case)
    for packed in case.rglob("*.gz"):
        packed.with_suffix("").write_bytes(gzip.decompress(packed.read_bytes()))
        packed.unlink()
    return case


def make_bed(case: Path, solver: str, step: float, ours: bool = True) -> Path:
    """A copy of the tutorial for a solver and a time step (s), with our contacts or stock's."""
    case = copy_tutorial(case)
    change(
        case,
        {
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:writeControl": "runTime",
            f"{CONTROL}:writeFormat": "ascii",
            f"{CONTROL}:writeCompression": False,
            **patch_mean("bottom", "p"),
        },
    )
    if ours:
        change(case, {f"{MODELS}/collisionModel": "cellList"})
        if solver == "DPMFoam":
            change(case, {f"{CONTROL}:libs": ['"libelutriaCollision.so"']})
    return case


@dataclass(frozen=True)
class History:
    """A bed's states at the written times (s): momentum upwards (kg m/s), mean height (m); and
    rows of time (s) and pressure drop (Pa) at every step."""

    time: Array
    momentum: Array
    height: Array
    pressure_drop: Array


def read_history(case: Path) -> History:
    """What a run of make_bed()'s case has written."""
    written = [name for name in times(case) if float(name) > 0]
    states = [read_particles(case, name) for name in written]
    return History(
        np.array([float(name) for name in written]),
        np.array([state.momentum[2] for state in states]),
        np.array([state.position[:, 2].mean() for state in states]),
        read_patch_mean(case, "bottom") * (1, GAS_DENSITY),
    )


@rc_context(STYLE)
def run(options: Options) -> Chapter:
    """The bed from its lattice at ten times the tutorial's step, its start-up left out."""
    if not TUTORIAL.is_dir():
        raise InputError(f"{TUTORIAL}: not found; apt-get install openfoam-examples")
    chapter = Chapter(NAME, "Goldschmidt's bed")
    section = chapter.section(
        "Goldschmidt's bed",
        "OpenFOAM's tutorial: 24 750 spheres of 2.5 mm between walls 15 mm apart, gas at 1.875 "
        "m/s, contacts by the tutorial's own numbers, steps of 0.2 ms instead of 0.02. The mean "
        "pressure drop over the bed, less what the spheres gain in momentum, must carry their "
        "weight less buoyancy. Allowed: 5 %, which the side walls' friction may hold.",
        "A bed that lies on a lattice first falls and throws a slug: the first 0.3 s are left out. "
        "`elutria bench bed` runs the same bed beside stock DPMFoam with our contacts.",
    )
    left_out, end = (0.01, 0.03) if options.quick else (0.3, 0.8)
    with TemporaryDirectory() as work:
        case = make_bed(Path(work) / "bed", "elutriaFoam", 10 * STEP)
        change(case, {f"{CONTROL}:endTime": end, f"{CONTROL}:writeInterval": 0.01})
        run_program(["blockMesh"], case)
        run_scene(case)
        bed = read_history(case)

    kept = bed.time >= left_out - 1e-9
    drop = bed.pressure_drop[bed.pressure_drop[:, 0] >= left_out, 1].mean()
    (first, last), (start, stop) = bed.momentum[kept][[0, -1]], bed.time[kept][[0, -1]]
    gain = (last - first) / (stop - start) / SECTION
    case_name = f"mean from {left_out:g} to {end:g} s"
    section.rows += [
        Row.relative(case_name, "pressure drop less gain in momentum, Pa", WEIGHT, drop - gain,
                     None if options.quick else 0.05),
        Row.relative(case_name, "pressure drop alone, Pa", WEIGHT, drop, None),
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
    return write_chapter(options, chapter)
