"""What threads are worth to contact steps: spheres settled in a box, and falling through it.

1e5 and 1e6 spheres of 2.5 mm, Hertz's law, step 1e-5 s, on 1, 2, 4, 8 and 16 threads as far as the
cores go: wall time per particle and step, its ratio to one thread, and a checksum of positions,
velocities and spins, which must be the same for all. The engine's own program writes the table;
docs/developers/parallel.md says how it is built to run alone on another machine.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from statistics import median
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from elutria.errors import ElutriaError
from elutria.output.style import COLUMN_WIDTH, STYLE
from elutria_validation.book.figures import label
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.programs import built, run_program
from elutria_validation.harness.provenance import write_result

NAME = "threads"
HELP = "what threads are worth to contact steps, settled and falling spheres"

COLUMNS = (
    "scene", "particles", "threads", "steps", "wall_us_per_particle_step", "speed_up",
    "processor_us_per_particle_step", "processor_ratio", "coordination", "list_builds",
    "engine_bytes_per_particle", "state",
)  # fmt: skip
TIMES = ("wall_us_per_particle_step", "processor_us_per_particle_step")
Row = dict[str, Any]


@dataclass(frozen=True)
class Options:
    """Its own."""

    work: float = option(6e7, quick=2e6, least=1e5, unit="particle-steps of settled spheres")


def run(job: Job, options: Options) -> None:
    """Repeats the program's table; writes threads.csv, .png and .json."""
    sizes = "particles=25000" if job.quick else "particles=100000,1000000"
    words = ["threads", sizes, f"work={options.work:g}"]
    tables = []
    for repeat in range(job.repeats):
        job.say(f"run {repeat + 1} of {job.repeats}")
        tables.append(
            list(csv.DictReader(io.StringIO(run_program([built("elutriaDemBench"), *words]))))
        )
    rows = medians(tables)
    for row in rows:
        job.say(
            f"{row['scene']}, {row['particles']} particles, {row['threads']} threads: "
            f"{row['wall_us_per_particle_step']:.4f} us per particle and step, "
            f"{row['speed_up']:.2f} times one thread, same bits"
        )
    with mpl.rc_context(STYLE):
        write_result(job, NAME, COLUMNS, rows, figure(rows), {"repeats": job.repeats})


def medians(tables: list[list[dict[str, str]]]) -> list[Row]:
    """A row per scene, size and number of threads: medians of times, and ratios to one thread.

    Raises ElutriaError where a state differs: the program compares within a run, this between runs.
    """
    rows: list[Row] = []
    for same in zip(*tables, strict=True):
        row: Row = dict(same[0])
        if len({other["state"] for other in same}) > 1:
            raise ElutriaError(f"{row['scene']}, {row['particles']} particles: states differ")
        for name in ("particles", "threads", "steps", "list_builds"):
            row[name] = int(row[name])
        for name in ("coordination", "engine_bytes_per_particle"):
            row[name] = float(row[name])
        for name in TIMES:
            row[name] = median(float(other[name]) for other in same)
        one = next((r for r in rows if _series(r) == _series(row)), row)
        row["speed_up"] = one[TIMES[0]] / row[TIMES[0]]
        row["processor_ratio"] = row[TIMES[1]] / one[TIMES[1]]
        rows.append(row)
    return rows


def _series(row: Row) -> tuple[str, int]:
    """What a row is compared within."""
    return row["scene"], row["particles"]


def figure(rows: list[Row]) -> Figure:
    """Speed-up against threads."""
    drawing = Figure(figsize=(COLUMN_WIDTH, COLUMN_WIDTH))
    axes = drawing.subplots()
    for series in dict.fromkeys(_series(row) for row in rows):
        mine = [row for row in rows if _series(row) == series]
        axes.plot(
            [row["threads"] for row in mine],
            [row["speed_up"] for row in mine],
            marker="o",
            markersize=3,
            label=f"{series[0]}, {series[1]:,}",
        )
    most = max(row["threads"] for row in rows)
    axes.plot([1, most], [1, most], color="0.7", linewidth=0.6)
    label(axes, "threads", "times one thread")
    return drawing
