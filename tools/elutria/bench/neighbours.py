"""Neighbour search: time per step against the number of particles, for every method.

Two scenes: a two-dimensional random walk, and a three-dimensional column ten times as high as wide.
Options: largest=1000000 (particles; bruteForce stops at 10 000), seconds=0.5 per point.
With largest=10000000 it goes one decade further.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from statistics import median
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from elutria.bench.common import Options, built, run_program, write_result
from elutria.plots import COLUMN_WIDTH, STYLE

NAME = "neighbours"
HELP = "neighbour search: time per step against the number of particles"

COLUMNS = (
    "scene",
    "method",
    "layers",
    "particles",
    "s_per_step",
    "cpu_s_per_step",
    "pairs_per_particle",
    "memory_bytes_per_particle",
)
METHODS = (
    ("bruteForce", 1),
    ("cells", 1),
    ("cells", 2),
    ("cells", 3),
    ("verlet", 1),
    ("hierarchical", 1),
)
FRAME = 1 / 30
"""s: a step of process time that must take no longer than itself."""
PAPER = {"full search": 150, "cells": 600}
"""Particles in real time in the paper that this project started from."""
BRUTE_FORCE_MOST = 10_000


def run(options: Options) -> None:
    """Measures every method; writes neighbours.csv, .png and .json."""
    largest = int(options.extra.get("largest", 10_000 if options.quick else 1_000_000))
    seconds = float(options.extra.get("seconds", 0.1 if options.quick else 0.5))
    rows: list[dict[str, Any]] = []
    for scene in ("walk", "column"):
        for method, layers in METHODS:
            most = min(largest, BRUTE_FORCE_MOST) if method == "bruteForce" else largest
            for particles in numbers(most):
                rows.append(measure(scene, method, layers, particles, seconds, options.repeats))
            options.say(f"{scene} {label(method, layers)}: {summary(rows, scene, method, layers)}")
    exponents = {
        f"{scene} {label(method, layers)}": exponent(of(rows, scene, method, layers))
        for scene in ("walk", "column")
        for method, layers in METHODS
    }
    notes = {
        "exponents_above_1000_particles": exponents,
        "real_time_particles": {
            f"{scene} {label(method, layers)}": real_time(of(rows, scene, method, layers))
            for scene in ("walk", "column")
            for method, layers in METHODS
        },
        "paper_real_time_particles": PAPER,
    }
    with mpl.rc_context(STYLE):
        write_result(options, NAME, COLUMNS, rows, figure(rows), notes)


def numbers(most: int) -> list[int]:
    """Particle numbers from 100 on, two per decade."""
    steps = round(2 * math.log10(most / 100))
    return [round(100 * 10 ** (k / 2)) for k in range(steps + 1)]


def measure(
    scene: str, method: str, layers: int, particles: int, seconds: float, repeats: int
) -> dict[str, Any]:
    """One point: the median of several runs."""
    runs = [
        json.loads(
            run_program(
                [
                    built("elutriaDemBench"),
                    "neighbours",
                    f"scene={scene}",
                    f"method={method}",
                    f"layers={layers}",
                    f"particles={particles}",
                    f"seconds={seconds}",
                ]
            )
        )
        for _ in range(repeats)
    ]
    return {
        "scene": scene,
        "method": method,
        "layers": layers,
        "particles": particles,
        "s_per_step": median(r["wall_s_per_step"] for r in runs),
        "cpu_s_per_step": median(r["cpu_s_per_step"] for r in runs),
        "pairs_per_particle": runs[-1]["pairs_per_particle"],
        "memory_bytes_per_particle": runs[-1]["process_bytes_per_particle"],
    }


def of(
    rows: Sequence[dict[str, Any]], scene: str, method: str, layers: int
) -> list[dict[str, Any]]:
    """The rows of one curve."""
    wanted = (scene, method, layers)
    return [r for r in rows if (r["scene"], r["method"], r["layers"]) == wanted]


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
    panels[0].set_ylabel("wall time per step (s)")
    panels[0].legend()
    return drawing
