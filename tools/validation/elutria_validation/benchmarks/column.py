"""The default column with some 5 000 particles of 100 to 1500 um in flight: stock DPMFoam with
pairCollision, and elutriaFoam, both from the same state, in turns. Stock takes one step to start
with and one that is timed; ours a hundred, start-up left out of both."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from elutria.errors import ElutriaError
from elutria_validation.harness.cases import CONTROL, MODELS, PARAMETERS, change
from elutria_validation.harness.job import Job, NoOptions
from elutria_validation.harness.programs import project_root, run_program
from elutria_validation.harness.provenance import write_result
from elutria_validation.harness.timing import against_stock

NAME = "column"
HELP = "5 000 particles in the column: seconds per second of process time, stock and ours"

COLUMNS = (
    "variant", "time_step_s", "particles", "seconds_per_step", "low", "high",
    "seconds_per_simulated_second", "speed_over_stock",
)  # fmt: skip
START, STOCK_STEP, OUR_STEP, OUR_STEPS = 0.16, 2e-4, 1e-3, 50
LAW = {"useEquivalentSize": False, "collisionResolutionSteps": 12}
SLIDER = {
    "alpha": 0.12, "b": 1.5, "mu": 0.4, "cohesionEnergyDensity": 0,
}  # fmt: skip
WALL = {"youngsModulus": 1e7, "poissonsRatio": 0.25, **SLIDER}
STOCK_CONTACTS = {
    "maxInteractionDistance": 0.0015,
    "writeReferredParticleCloud": False,
    "U": "U.air",
    "pairModel": "pairSpringSliderDashpot",
    "pairSpringSliderDashpotCoeffs": {**LAW, **SLIDER},
    "wallModel": "wallLocalSpringSliderDashpot",
    "wallLocalSpringSliderDashpotCoeffs": {**LAW, "walls": WALL, "feedSlot": WALL},
}


def run(job: Job, _options: NoOptions) -> None:
    """Bring the column to its state, time both from there; writes column.csv, .png and .json."""
    ours, stock = job.folder / "runs/ours", job.folder / "runs/stock"
    particles = _prepare(ours, stock)
    seconds: dict[str, list[float]] = {"stock DPMFoam": [], "elutriaFoam": []}
    for repeat in range(1 if job.quick else job.repeats):
        seconds["stock DPMFoam"].append(stock_step(stock))
        seconds["elutriaFoam"].append(_our_step(ours))
        for name, values in seconds.items():
            job.say(f"{repeat + 1}: {name}: {values[-1]:.4g} s a step")
    steps = {"stock DPMFoam": STOCK_STEP, "elutriaFoam": OUR_STEP}
    rows = [
        {**against_stock(name, steps, seconds, "stock DPMFoam"), "particles": particles}
        for name in steps
    ]
    write_result(job, NAME, COLUMNS, rows, _figure(rows))
    shutil.rmtree(job.folder / "runs")


def _prepare(ours: Path, stock: Path) -> int:
    """Both cases at START, written by our run from the empty column; gives the particles inside."""
    shutil.rmtree(ours.parent, ignore_errors=True)
    shutil.copytree(
        project_root() / "cases/column", ours, ignore=shutil.ignore_patterns("polyMesh", "[1-9]*")
    )
    shutil.copytree(ours / "0.orig", ours / "0", dirs_exist_ok=True)
    change(
        ours,
        {
            f"{PARAMETERS}:gasVelocity": 5,
            f"{PARAMETERS}:loading": 0.4,
            f"{PARAMETERS}:parcels": "particles",
            f"{PARAMETERS}:particles": 10**6,
            "constant/feed:materials/quartz/sizeDistribution/min": 100e-6,
            "constant/feed:materials/quartz/sizeDistribution/max": 1500e-6,
            f"{CONTROL}:endTime": START,
            f"{CONTROL}:writeInterval": START,
        },
    )
    run_program(["blockMesh"], ours)
    output = run_program(["elutriaFoam"], ours)
    hand_to_stock(ours, stock, START, STOCK_STEP)
    change(
        stock,
        {
            f"{MODELS}/collisionModel": "pairCollision",
            f"{MODELS}/pairCollisionCoeffs": STOCK_CONTACTS,
        },
    )
    change(
        ours,
        {
            f"{CONTROL}:adjustTimeStep": False,
            f"{CONTROL}:deltaT": OUR_STEP,
            f"{CONTROL}:endTime": START + OUR_STEPS * OUR_STEP,
            f"{CONTROL}:writeInterval": 1000,
        },
    )
    return int(re.findall(r"inside (\d+)", output)[-1])


def hand_to_stock(ours: Path, stock: Path, start: float, step: float, steps: int = 2) -> None:
    """A copy of our run that DPMFoam goes on with: `steps` of `step` (s) from `start` (s)."""
    shutil.copytree(ours, stock)
    change(
        stock,
        {
            f"{CONTROL}:libs": ['"libelutriaCollision.so"'],
            f"{CONTROL}:startFrom": "startTime",
            f"{CONTROL}:startTime": start,
            f"{CONTROL}:adjustTimeStep": False,
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:endTime": start + steps * step,
            f"{CONTROL}:writeInterval": 1000,
        },
    )


def stock_step(case: Path) -> float:
    """Processor seconds of a step of DPMFoam, all but the first."""
    shutil.rmtree(case / "postProcessing", ignore_errors=True)
    output = run_program(["DPMFoam"], case)
    times = [float(text) for text in re.findall(r"ExecutionTime = (\S+) s", output)]
    if len(times) < 2:
        raise ElutriaError(f"{case}: DPMFoam took {len(times)} steps; 2 were asked")
    return (times[-1] - times[0]) / (len(times) - 1)


def _our_step(case: Path) -> float:
    """Seconds of a step, all parts of it."""
    shutil.rmtree(case / "postProcessing", ignore_errors=True)
    output = run_program(["elutriaFoam"], case)
    report = output[output.rindex("Scene plan: what was needed in") :]
    steps = int(report.split("needed in ")[1].split()[0])
    if steps != OUR_STEPS:
        raise ElutriaError(f"{case}: elutriaFoam took {steps} steps; {OUR_STEPS} were asked")
    parts = re.findall(r"^ +(?:particles|exchange|gas|output) +\S+ % +(\S+) s$", report, re.M)
    return sum(map(float, parts)) / steps


def _figure(rows: list[dict[str, Any]]) -> Figure:
    figure, axes = plt.subplots(figsize=(85 / 25.4, 35 / 25.4), layout="constrained")
    names = [row["variant"] for row in rows]
    values = [row["seconds_per_simulated_second"] for row in rows]
    axes.barh(names, values, color=["#999999", "#0072B2"])
    for place, value in enumerate(values):
        axes.annotate(f" {value:.3g} s", (value, place), va="center", fontsize=7)
    axes.set_xscale("log")
    axes.set_xlim(1, 20 * max(values))
    axes.invert_yaxis()
    axes.set_xlabel("seconds per second of process time", fontsize=8)
    axes.tick_params(labelsize=7)
    return figure
