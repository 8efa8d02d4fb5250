"""OpenFOAM's own fluidised bed (Goldschmidt's, 24 750 spheres) through stock DPMFoam with
pairCollision, stock DPMFoam with our collision model, and elutriaFoam: seconds per time step from
runs of two lengths in turns (start-up drops out), and the bed's state at the end of the longer."""

from __future__ import annotations

import shutil
import time
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from elutria_validation.harness.cases import CONTROL, change, read_patch_mean, times
from elutria_validation.harness.goldschmidt import GAS_DENSITY, STEP, make_bed
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.particles import read_particles
from elutria_validation.harness.programs import run_program, slug
from elutria_validation.harness.provenance import write_result
from elutria_validation.harness.timing import against_stock

NAME = "stock"
HELP = "the Goldschmidt bed: stock DPMFoam, our contacts in it, and elutriaFoam"

COLUMNS = (
    "variant", "time_step_s", "seconds_per_step", "low", "high", "seconds_per_simulated_second",
    "speed_over_stock", "bed_pressure_drop_pa", "bed_height_m",
)  # fmt: skip

# what is run: solver, time step over the tutorial's, gas on every step or as the plan decides
VARIANTS: dict[str, tuple[str, float, str]] = {
    "stock DPMFoam": ("DPMFoam", 1, ""),
    "our contacts in DPMFoam": ("DPMFoam", 1, ""),
    "elutriaFoam, same gas step": ("elutriaFoam", 1, "on"),
    "elutriaFoam, step 10 times": ("elutriaFoam", 10, "auto"),
}
STOCK = "stock DPMFoam"


@dataclass(frozen=True)
class Options:
    """Its own."""

    steps: int = option(60, quick=30, least=20, unit="of the tutorial, of the longer run")


def run(job: Job, options: Options) -> None:
    """Time every variant and write stock.csv, .png and .json."""
    steps = options.steps
    lengths = (max(steps // 3 // 10 * 10, 10), steps)
    cases = {name: _make(job.folder / "runs", name) for name in VARIANTS}

    seconds: dict[str, list[float]] = {name: [] for name in VARIANTS}
    for repeat in range(job.repeats):
        for name, case in cases.items():
            solver, factor, _ = VARIANTS[name]
            short, long = (_time(case, solver, n * STEP) for n in lengths)
            seconds[name].append((long - short) / ((lengths[1] - lengths[0]) / factor))
            job.say(f"{repeat + 1}/{job.repeats} {name}: {seconds[name][-1]:.4f} s a step")

    steps_taken = {name: factor * STEP for name, (_, factor, _) in VARIANTS.items()}
    rows = [
        {**against_stock(name, steps_taken, seconds, STOCK), **_bed(cases[name])}
        for name in VARIANTS
    ]
    write_result(job, NAME, COLUMNS, rows, _figure(rows), {"steps": steps})
    shutil.rmtree(job.folder / "runs")


def _make(folder: Path, name: str) -> Path:
    """A copy of the tutorial set up for a variant."""
    solver, factor, gas = VARIANTS[name]
    case = make_bed(folder / slug(name), solver, factor * STEP, ours=name != STOCK)
    if gas:
        header = "FoamFile { version 2.0; format ascii; class dictionary; object scenePlan; }\n"
        (case / "system/scenePlan").write_text(f"{header}gas {gas};\n")
    run_program(["blockMesh"], case)
    return case


def _time(case: Path, solver: str, end: float) -> float:
    """Wall seconds of a run from the start to `end` seconds."""
    shutil.rmtree(case / "postProcessing", ignore_errors=True)
    for written in case.glob("[0-9]*[.e]*"):
        shutil.rmtree(written)
    change(case, {f"{CONTROL}:endTime": end, f"{CONTROL}:writeInterval": end})
    start = time.perf_counter()
    run_program([solver], case)
    return time.perf_counter() - start


def _bed(case: Path) -> dict[str, float]:
    """Pressure drop (Pa, mean of the longer run's second half) and mean height (m) at its end."""
    pressure = read_patch_mean(case, "bottom")
    height = read_particles(case, times(case)[-1]).position[:, 2].mean()
    return {
        "bed_pressure_drop_pa": GAS_DENSITY * float(np.mean(pressure[len(pressure) // 2 :, 1])),
        "bed_height_m": float(height),
    }


def _figure(rows: list[dict[str, object]]) -> Figure:
    figure, axes = plt.subplots(figsize=(85 / 25.4, 60 / 25.4), layout="constrained")
    names = [str(row["variant"]) for row in rows]
    speed = [float(str(row["speed_over_stock"])) for row in rows]
    axes.barh(names, speed, color="#0072B2")
    for place, value in enumerate(speed):
        axes.annotate(f" {value:.1f}", (value, place), va="center", fontsize=7)
    axes.invert_yaxis()
    axes.set_xlabel("speed over stock", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.set_xlim(0, max(speed) * 1.15)
    return figure
