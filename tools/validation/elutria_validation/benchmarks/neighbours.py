"""Neighbour search: time per step against the number of particles, for every method.

Two scenes: a two-dimensional random walk, and a three-dimensional column ten times as high as wide;
the latter also with a size ratio of 20 at equal mass per size decade. Times are of the processor.
bruteForce stops at 10 000 particles.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from elutria.output.style import COLUMN_WIDTH, STYLE
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.programs import built, run_program
from elutria_validation.harness.provenance import write_result

NAME = "neighbours"
HELP = "neighbour search: time per step against the number of particles"

COLUMNS = (
    "scene", "method", "layers", "size_ratio", "particles", "s_per_step", "wall_s_per_step",
    "pairs_per_particle", "memory_bytes_per_particle",
)  # fmt: skip
METHODS = (
    ("bruteForce", 1), ("cells", 1), ("cells", 2), ("cells", 3), ("verlet", 1), ("hierarchical", 1)
)  # fmt: skip
FRAME = 1 / 30
"""s: a step of process time that must take no longer than itself."""
PAPER = {"full search": 150, "cells": 600}
"""Particles in real time in the paper that this project started from."""
BRUTE_FORCE_MOST = 10_000
WIDE = 20
"""Largest over smallest diameter of the polydisperse column."""


@dataclass(frozen=True)
class Options:
    """Its own. With largest=10000000 it goes one decade further."""

    largest: int = option(1_000_000, quick=10_000, least=1000, unit="particles")
    seconds: float = option(0.5, quick=0.1, least=1e-3, unit="s per point")


def run(job: Job, options: Options) -> None:
    """Measures every method; writes neighbours.csv, .png and .json."""
    largest, seconds = options.largest, options.seconds
    rows: list[dict[str, Any]] = []
    for scene in ("walk", "column"):
        for method, layers in METHODS:
            most = min(largest, BRUTE_FORCE_MOST) if method == "bruteForce" else largest
            for particles in numbers(most):
                rows.append(measure(scene, method, layers, particles, seconds, job.repeats))
            job.say(f"{scene} {label(method, layers)}: {summary(rows, scene, method, layers)}")
    wide = [
        measure("column", "hierarchical", 1, min(largest, 100_000), seconds, job.repeats, ratio)
        for ratio in (1, WIDE)
    ]
    rows.append(wide[1])
    polydispersity = wide[1]["s_per_step"] / wide[0]["s_per_step"]
    job.say(f"column, size ratio {WIDE}: {polydispersity:.2f} of the time of equal spheres")
    curves = {
        f"{scene} {label(method, layers)}": of(rows, scene, method, layers)
        for scene in ("walk", "column")
        for method, layers in METHODS
    }
    notes = {
        "exponents_above_1000_particles": {name: exponent(one) for name, one in curves.items()},
        "real_time_particles": {name: real_time(one) for name, one in curves.items()},
        "paper_real_time_particles": PAPER,
        "size_ratio_20_over_equal_spheres": polydispersity,
    }
    with mpl.rc_context(STYLE):
        write_result(job, NAME, COLUMNS, rows, figure(rows), notes)


def numbers(most: int) -> list[int]:
    """Particle numbers from 100 on, two per decade."""
    steps = round(2 * math.log10(most / 100))
    return [round(100 * 10 ** (k / 2)) for k in range(steps + 1)]


def measure(
    scene: str, method: str, layers: int, particles: int, seconds: float, repeats: int,
    ratio: int = 1,
) -> dict[str, Any]:  # fmt: skip
    """One point: the median of several runs."""
    settings = {"scene": scene, "method": method, "layers": layers, "particles": particles,
                "seconds": seconds, "ratio": ratio}  # fmt: skip
    words = [f"{name}={value}" for name, value in settings.items()]
    runs = [
        json.loads(run_program([built("elutriaDemBench"), "neighbours", *words]))
        for _ in range(repeats)
    ]
    return {
        "scene": scene,
        "method": method,
        "layers": layers,
        "size_ratio": ratio,
        "particles": particles,
        "s_per_step": median(r["cpu_s_per_step"] for r in runs),
        "wall_s_per_step": median(r["wall_s_per_step"] for r in runs),
        "pairs_per_particle": runs[-1]["pairs_per_particle"],
        "memory_bytes_per_particle": runs[-1]["process_bytes_per_particle"],
    }


def of(
    rows: Sequence[dict[str, Any]], scene: str, method: str, layers: int
) -> list[dict[str, Any]]:
    """The rows of one curve."""
    wanted = (scene, method, layers, 1)
    names = ("scene", "method", "layers", "size_ratio")
    return [r for r in rows if tuple(r[name] for name in names) == wanted]


def exponent(rows: Sequence[dict[str, Any]]) -> float:
    """Slope of log time against log number, from 1000 particles on."""
    large = [r for r in rows if r["particles"] >= 1000]
    if len(large) < 2:
        return math.nan
    x = np.log([r["particles"] for r in large])
    return float(np.polyfit(x, np.log([r["s_per_step"] for r in large]), 1)[0])


def real_time(rows: Sequence[dict[str, Any]]) -> int:
    """Particles for which a step takes FRAME, between the points or beyond the last (log-log)."""
    times = np.log([r["s_per_step"] for r in rows])
    counts = np.log([r["particles"] for r in rows])
    slope, start = np.polyfit(counts[-3:], times[-3:], 1)
    target = math.log(FRAME)
    inside = times[0] < target < times[-1]
    found = np.interp(target, times, counts) if inside else (target - start) / slope
    return round(math.exp(float(found)))


def label(method: str, layers: int) -> str:
    """Name of a curve."""
    names = {"bruteForce": "brute force", "verlet": "Verlet list"}
    if method == "cells":
        return f"cells, {layers} layer" + ("s" if layers > 1 else "")
    return names.get(method, method)


def summary(rows: Sequence[dict[str, Any]], scene: str, method: str, layers: int) -> str:
    """One curve in a line."""
    mine = of(rows, scene, method, layers)
    return f"exponent {exponent(mine):.3f}, {real_time(mine)} particles in real time"


def figure(rows: Sequence[dict[str, Any]]) -> Figure:
    """Time per step against number, one panel per scene, with the paper's two points."""
    drawing = Figure(figsize=(2 * COLUMN_WIDTH, COLUMN_WIDTH))
    panels = drawing.subplots(1, 2, sharey=True)
    for axes, scene in zip(panels, ("walk", "column"), strict=True):
        for method, layers in METHODS:
            mine = of(rows, scene, method, layers)
            axes.loglog(
                [r["particles"] for r in mine],
                [r["s_per_step"] for r in mine],
                marker="o",
                markersize=2,
                label=label(method, layers),
            )
        axes.axhline(FRAME, color="0.5", linewidth=0.6)
        for (name, count), marker in zip(PAPER.items(), ("x", "+"), strict=True):
            axes.plot(count, FRAME, marker, color="k", label=f"paper, {name}: {count}")
        axes.set_xlabel("number of particles")
        axes.set_title("2D random walk" if scene == "walk" else "3D column", fontsize=8)
    panels[0].set_ylabel("processor time per step (s)")
    panels[0].legend()
    return drawing
