"""Goldschmidt's bed while it moves: stock DPMFoam with our contacts, which follow stock's own to
all digits while a run is short, beside elutriaFoam at a larger step, which goes on for longer.

The tutorial's front and back are planes of symmetry, where stock lets spheres reach through by a
radius and elutriaFoam does not. They are walls here, with slip for the gas, so that all compute the
same bed. All start from one state, made by elutriaFoam from the tutorial's lattice."""

from __future__ import annotations

import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import nan
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from numpy.typing import NDArray

from elutria.files import write_csv
from elutria.output.style import COLUMN_WIDTH, MATERIAL_COLOURS, STYLE
from elutria_validation.harness.cases import CONTROL, MODELS, change, solve, times
from elutria_validation.harness.goldschmidt import STEP, make_bed, read_history
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.particles import read_particles, write_particles
from elutria_validation.harness.programs import run_program, slug
from elutria_validation.harness.provenance import write_result

NAME = "bed"
HELP = "the moving Goldschmidt bed's pressure drop and height, ours beside stock's"

COLUMNS = (
    "variant", "time_step_s", "simulated_s", "windows",
    "pressure_drop_pa", "pressure_drop_scatter_pa", "mean_height_m", "mean_height_scatter_m",
)  # fmt: skip
SERIES_COLUMNS = ("variant", "time_s", "pressure_drop_pa", "mean_height_m")
SAMPLING = 0.005  # s between states
LEFT_OUT = 0.02  # s after the common start

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Variant:
    """Solver, step over the tutorial's, length over the reference's."""

    name: str
    solver: str
    factor: float
    length: float


START = Variant("start", "elutriaFoam", 10, 1)
VARIANTS = (
    Variant("our contacts in DPMFoam", "DPMFoam", 1, 1),
    Variant("elutriaFoam, step 10 times", "elutriaFoam", 10, 8),
)


@rc_context(STYLE)
@dataclass(frozen=True)
class Options:
    """Its own. elutriaFoam takes 8 times as much as the reference: its windows of the reference's
    length show how far such a mean moves by itself."""

    seconds: float = option(0.1, quick=0.01, least=1e-3, unit="s, simulated by the reference")
    start: float = option(0.5, quick=0.02, least=1e-3, unit="s, the bed's age at the start")


def run(job: Job, options: Options) -> None:
    """Run every variant and write bed.csv, bed_series.csv, .png and .json."""
    seconds, start = options.seconds, options.start
    runs = job.folder / "runs"

    first = _make(runs, START)
    _advance(first, START, start)
    job.say(f"the bed is {start} s old")

    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        results = pool.map(lambda variant: _measure(runs, first, variant, seconds), VARIANTS)
        rows, series = [], []
        for row, lines in results:
            rows.append(row)
            series.append(lines)
            job.say(
                f"{row['variant']}: {row['pressure_drop_pa']:.0f} Pa, scatter "
                f"{row['pressure_drop_scatter_pa']:.0f}; {1e3 * row['mean_height_m']:.2f} mm, "
                f"scatter {1e3 * row['mean_height_scatter_m']:.2f}"
            )
    write_csv(
        job.folder / "bed_series.csv",
        SERIES_COLUMNS,
        (
            dict(zip(SERIES_COLUMNS, (variant.name, *line), strict=True))
            for variant, lines in zip(VARIANTS, series, strict=True)
            for line in lines.tolist()
        ),
    )
    notes = {"seconds": seconds, "apart_from_the_same_start": _apart(series)}
    write_result(job, NAME, COLUMNS, rows, _figure(series), notes)
    shutil.rmtree(runs)


def _make(runs: Path, variant: Variant) -> Path:
    """The tutorial for a variant, with walls in front and behind, meshed."""
    case = make_bed(runs / slug(variant.name), variant.solver, variant.factor * STEP)
    for file, kind in {
        "system/blockMeshDict": "wall",
        "0/U.air": "slip",
        "0/p": "fixedFluxPressure; phi phi.air; value $internalField",
    }.items():
        text = (case / file).read_text()
        (case / file).write_text(text.replace("symmetry;", f"{kind};"))
    run_program(["blockMesh"], case)
    return case


def _advance(case: Path, variant: Variant, end: float) -> None:
    interval = min(SAMPLING, end)
    change(case, {f"{CONTROL}:endTime": end, f"{CONTROL}:writeInterval": interval})
    solve(case, solver=variant.solver)


def _measure(
    runs: Path, first: Path, variant: Variant, seconds: float
) -> tuple[dict[str, Any], Array]:
    """The row of a variant, and time (s), pressure drop (Pa) and height (m) of its states."""
    case = _make(runs, variant)
    last = times(first)[-1]
    for field in ("U.air", "p"):
        shutil.copy(first / last / field, case / "0" / field)
    write_particles(case, read_particles(first, last))
    change(case, {f"{MODELS}/injectionModels": {}})
    _advance(case, variant, variant.length * seconds)

    bed = read_history(case)
    at, (steps, drop) = bed.time, bed.pressure_drop.T
    before = np.concatenate(([0.0], at[:-1]))
    drops = [
        drop[(steps > low) & (steps <= high + 1e-9)].mean()
        for low, high in zip(before, at, strict=True)
    ]
    lines = np.column_stack([at, drops, bed.height])
    left_out = min(LEFT_OUT, seconds / 2)
    settled = lines[at > left_out]
    windows = max(1, round((at[-1] - left_out) / (seconds - left_out)))
    row = {
        "variant": variant.name,
        "time_step_s": variant.factor * STEP,
        "simulated_s": variant.length * seconds,
        "windows": windows,
        **_statistics("pressure_drop", "pa", settled[:, 1], windows),
        **_statistics("mean_height", "m", settled[:, 2], windows),
    }
    return row, lines


def _apart(series: list[Array]) -> dict[str, float]:
    """Root mean square of the variants' difference while both run, over their mean."""
    one, other = (lines[: min(map(len, series)), 1:] for lines in series)
    pressure, height = np.sqrt(((one - other) ** 2).mean(axis=0)) / one.mean(axis=0)
    return {"pressure_drop": float(pressure), "mean_height": float(height)}


def _statistics(name: str, unit: str, values: Array, windows: int) -> dict[str, float]:
    """Mean, and standard deviation of the windows' means."""
    means = [window.mean() for window in np.array_split(values, windows)]
    scatter = float(np.std(means, ddof=1)) if windows > 1 else nan
    return {f"{name}_{unit}": float(values.mean()), f"{name}_scatter_{unit}": scatter}


def _figure(series: list[Array]) -> Figure:
    figure, (above, below) = plt.subplots(
        2, figsize=(COLUMN_WIDTH, 1.1 * COLUMN_WIDTH), sharex=True
    )
    for variant, lines, colour in zip(VARIANTS, series, MATERIAL_COLOURS, strict=False):
        above.plot(lines[:, 0], lines[:, 1], color=colour, label=variant.name)
        below.plot(lines[:, 0], 1e3 * lines[:, 2], color=colour)
    above.set_ylabel("pressure drop (Pa)")
    below.set_ylabel("mean height (mm)")
    below.set_xlabel("time after the common start (s)")
    figure.legend(loc="outside upper center", ncols=1)
    return figure
