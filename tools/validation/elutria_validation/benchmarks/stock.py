"""OpenFOAM's own fluidised bed (Goldschmidt's, 24 750 spheres) through stock DPMFoam with
pairCollision, stock DPMFoam with our collision model, and elutriaFoam: seconds per time step from
runs of two lengths in turns (start-up drops out), and the bed's state at the end of the longer."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from elutria.errors import InputError
from elutria_validation.chapters.goldschmidt import GAS_DENSITY, STEP, TUTORIAL, make_bed
from elutria_validation.harness.common import (
    Options,
    against_stock,
    run_program,
    slug,
    write_result,
)
from elutria_validation.harness.scene import CONTROL, change, read_particles, read_patch_mean, times

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


def run(options: Options) -> None:
    """Time every variant and write stock.csv, .png and .json.

    `--option steps=N`: length of the longer run in the tutorial's time steps (default 60).
    Raises InputError without the tutorial (Debian's openfoam-examples).
    """
    if not TUTORIAL.is_dir():
        raise InputError(f"{TUTORIAL}: not found; apt-get install openfoam-examples")
    steps = int(options.extra.get("steps", "30" if options.quick else "60"))
    lengths = (max(steps // 3 // 10 * 10, 10), steps)
    cases = {name: _make(options.folder / "runs", name) for name in VARIANTS}

    seconds: dict[str, list[float]] = {name: [] for name in VARIANTS}
    for repeat in range(options.repeats):
        for name, case in cases.items():
            solver, factor, _ = VARIANTS[name]
            short, long = (_time(case, solver, n * STEP) for n in lengths)
            seconds[name].append((long - short) / ((lengths[1] - lengths[0]) / factor))
            options.say(f"{repeat + 1}/{options.repeats} {name}: {seconds[name][-1]:.4f} s a step")

    steps_taken = {name: factor * STEP for name, (_, factor, _) in VARIANTS.items()}
    rows = [
        {**against_stock(name, steps_taken, seconds, STOCK), **_bed(cases[name])}
        for name in VARIANTS
    ]
    write_result(options, NAME, COLUMNS, rows, _figure(rows), {"steps": steps})
    shutil.rmtree(options.folder / "runs")


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


def _figure(rows: list[dict[str, object]]) -> plt.Figure:
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
