"""What processors are worth to whole runs, from a dilute column to a bed that lies on one of them.

Each scene is run on 1, 2, 4, 8 and 16 processors, as far as the cores go, with its mesh cut along
gravity and across it: wall time, its ratio to one processor, how evenly the work lay, what was told
to others, and whether the rows of the particles that left are the same bytes. From all of them come
the constants that say how many processors pay (`elutria.estimates.ranks.Shared`), and what more
processors than were at hand would do.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass
from math import ceil, log2, nan
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.figure import Figure

from elutria.case.case import Case
from elutria.errors import ElutriaError, InputError, one_line, suggestion
from elutria.estimates import ranks as model
from elutria.files import read_json
from elutria.output.style import COLUMN_WIDTH, STYLE
from elutria_validation.book.figures import label
from elutria_validation.harness.cases import (
    CONTACTS,
    CONTROL,
    MODELS,
    PARAMETERS,
    PLAN,
    change,
    decompose,
    solve_decomposed,
)
from elutria_validation.harness.goldschmidt import make_bed
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.particles import HEADER
from elutria_validation.harness.programs import processor_time, project_root, run_program, slug
from elutria_validation.harness.provenance import write_result

NAME = "ranks"
HELP = "what processors are worth to whole runs; what more of them would do"

COLUMNS = (
    "scene", "cut", "ranks", "cells", "particle_steps", "steps", "gas_solves", "start_s", "wall_s",
    "speed_up", "processor_s", "processor_ratio", "busiest", "ghost_steps", "shared_islands",
    "exchanges", "exchange_s", "sent_bytes", "same_rows", "model_s",
)  # fmt: skip
DECOMPOSITION = "system/decomposeParDict"
CUTS = ("along", "across")
"""Slices along gravity, or columns side by side."""
FORESEEN = (16, 128, 1024)
"""Numbers of processors for which the model is asked."""
BED_STEP, BED_STEPS = 2e-4, 100
Row = dict[str, Any]


@dataclass(frozen=True)
class Options:
    """Its own."""

    parcels: int = option(50_000, quick=1000, least=100, unit="fed in the dilute scenes")
    ranks: str = option("1,2,4,8,16", quick="1,2", unit="processors, as many as there are cores")
    scene: str | None = option(None, unit="one alone")


def run(job: Job, options: Options) -> None:
    """Run every scene on each number of processors; writes ranks.csv, .png and .json."""
    scenes, numbers = _chosen(options), _numbers(options.ranks)
    os.environ[model.INSIST] = model.EXACT
    rows: list[Row] = []
    for scene, prepare in scenes.items():
        case = prepare(job.folder / "runs" / slug(scene), options)
        rows += _ladder(job, scene, case, numbers)
    constants = measured(rows)
    foreseen = _model(rows, constants)
    for row in rows:
        job.say(
            f"{row['scene']}, {row['ranks']} ranks {row['cut']}: {row['wall_s']:.2f} s, "
            f"{row['speed_up']:.2f} times one, busiest {row['busiest']:.2f} of the mean; "
            f"by the model {row['model_s']:.2f} s"
        )
    with mpl.rc_context(STYLE):
        notes = {"constants": constants and asdict(constants), "foreseen_speed_up": foreseen}
        write_result(job, NAME, COLUMNS, rows, figure(rows), {"repeats": job.repeats, **notes})
    shutil.rmtree(job.folder / "runs")


def _chosen(options: Options) -> dict[str, Prepare]:
    """All scenes, or the one that is asked for."""
    if options.scene is None:
        return SCENES
    if options.scene not in SCENES:
        raise InputError(
            f"--option scene={one_line(options.scene, 40)}{suggestion(options.scene, SCENES)}; "
            f"allowed: {'; '.join(SCENES)}"
        )
    return {options.scene: SCENES[options.scene]}


def _numbers(text: str) -> list[int]:
    """Numbers of processors, 1 first: all are compared with it; as many as there are cores."""
    words = text.split(",")
    if words[0] != "1" or not all(word.isdecimal() and int(word) > 0 for word in words):
        raise InputError(f"--option ranks={one_line(text, 40)}; allowed: 1 and more, as 1,2,4")
    return [n for n in map(int, words) if n <= model.cores()]


def _column(folder: Path, options: Options, settings: dict[str, Any]) -> Path:
    """The delivered column at its default gas velocity, meshed."""
    shutil.rmtree(folder, ignore_errors=True)
    Case(project_root() / "cases/column").copy_to(folder, [])
    shutil.copytree(folder / "0.orig", folder / "0", dirs_exist_ok=True)
    change(folder, {f"{PARAMETERS}:particles": options.parcels, **settings})
    run_program(["blockMesh"], folder)
    return folder


def _frozen(folder: Path, options: Options) -> Path:
    # gas that is never solved, impacts alone, and nothing that is known to rounding: the rows do
    # not depend on the number of processors
    settings = {
        f"{CONTACTS}/treatment": "impact", f"{MODELS}/dispersionModel": "none",
        f"{PLAN}:gas": False, f"{PLAN}:convergeGas": False,
    }  # fmt: skip
    return _column(folder, options, settings)


def _coupled(folder: Path, options: Options) -> Path:
    return _column(folder, options, {})


def _gas(folder: Path, options: Options) -> Path:
    # eight times the cells, and gas on every step
    settings = {
        f"{PARAMETERS}:particles": max(100, options.parcels // 100),
        f"{PLAN}:gas": True, f"{PLAN}:convergeGas": False,
        f"{CONTROL}:endTime": 0.01, f"{CONTROL}:writeInterval": 0.01,
    }  # fmt: skip
    case = _column(folder, options, settings)
    run_program(["refineMesh", "-overwrite"], case)
    return case


def _bed(folder: Path, _: Options) -> Path:
    case = make_bed(folder, "elutriaFoam", BED_STEP)
    (case / PARAMETERS).write_text(HEADER.format("dictionary", "system", "simulationParameters"))
    end = BED_STEP * BED_STEPS
    change(case, {f"{CONTROL}:endTime": end, f"{CONTROL}:writeInterval": end})
    run_program(["blockMesh"], case)
    return case


EXACT = "column, frozen gas"
"""The scene whose rows must be the same bytes for any number of processors."""
Prepare = Callable[[Path, Options], Path]
SCENES: dict[str, Prepare] = {
    EXACT: _frozen,
    "column, two-way": _coupled,
    "column, fine gas": _gas,
    "bed": _bed,
}


def _ladder(job: Job, scene: str, case: Path, numbers: list[int]) -> list[Row]:
    """Rows of a scene, for each number of processors one per cut: medians over the repeats."""
    rows: list[Row] = []
    serial = b""
    for n, cut in [(one, cut) for one in numbers for cut in (CUTS if one > 1 else CUTS[:1])]:
        runs = []
        for _ in range(job.repeats):
            row, events = _once(case, n, cut)
            runs.append(row)
            serial = serial or events
            row["same_rows"] = "yes" if events == serial else "no"
            if scene == EXACT and events != serial:
                raise ElutriaError(f"{scene}: {n} ranks record other rows than one")
            job.say(f"{scene}, {n} ranks {cut}: {row['wall_s']:.2f} s")
        row = {"scene": scene, "cut": cut if n > 1 else "", **runs[-1]}
        for name in ("start_s", "wall_s", "processor_s", "exchange_s"):
            row[name] = median(run[name] for run in runs)
        one = rows[0] if rows else row
        row["speed_up"] = one["wall_s"] / row["wall_s"]
        row["processor_ratio"] = row["processor_s"] / one["processor_s"]
        rows.append(row)
    return rows


def _once(prepared: Path, ranks: int, cut: str) -> tuple[Row, bytes]:
    """A run of a copy on so many processors, decomposed beforehand: its row, and the rows of
    parcels that left."""
    case = prepared.with_name("run")
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(prepared, case)
    if ranks > 1:
        pieces = _pieces(ranks, cut)
        change(
            case,
            {
                f"{DECOMPOSITION}:numberOfSubdomains": ranks,
                f"{DECOMPOSITION}:method": "simple",
                f"{DECOMPOSITION}:simpleCoeffs": {"n": pieces, "delta": 1e-3},
                f"{DECOMPOSITION}:coeffs": {"n": pieces},
            },
        )
        decompose(case)
    start = perf_counter()
    solve_decomposed(case, ranks, options=["-plan"])
    planned = perf_counter() - start
    plan = read_json(case / "postProcessing/plan.json")
    before, start = processor_time(), perf_counter()
    log = solve_decomposed(case, ranks)
    wall, processor = perf_counter() - start, processor_time() - before
    report = log[log.rindex("Scene plan: what was needed in") :]
    steps = int(report.split("needed in ")[1].split()[0])
    row: Row = {
        "ranks": ranks, "cells": plan["mesh"]["cells"], "steps": steps, "start_s": planned,
        "gas_solves": _number(r"gas solved +(\d+) times", report), "wall_s": wall,
        "processor_s": processor, "plan": plan,
    }  # fmt: skip
    events = b"".join(f.read_bytes() for f in case.glob("postProcessing/outlets/*/particles.csv"))
    return {**row, **_work(case, report)}, events


def _pieces(ranks: int, cut: str) -> list[int]:
    """Pieces in x, y and z, which is up in every scene: slices along gravity, or about as many in x
    as in y."""
    if cut == "along":
        return [1, 1, ranks]
    across = max(n for n in range(1, int(ranks**0.5) + 1) if ranks % n == 0)
    return [across, ranks // across, 1]


def _work(case: Path, report: str) -> Row:
    """What each processor had to do; of one processor the log's number of steps alone."""
    file = case / "postProcessing/ranks.csv"
    if not file.is_file():
        return {
            "particle_steps": _number(r"of (\S+) particle steps", report), "busiest": 1.0,
            "ghost_steps": 0, "shared_islands": 0, "exchanges": 0, "exchange_s": 0.0,
            "sent_bytes": 0,
        }  # fmt: skip
    work = pd.read_csv(file)
    moved = work["particle_steps"] + work["ghost_steps"]
    return {
        "particle_steps": work["particle_steps"].sum(),
        "busiest": moved.max() / moved.mean(),
        "ghost_steps": work["ghost_steps"].sum(),
        "shared_islands": work["shared_islands"].sum(),
        "exchanges": work["exchanges"].max(),
        # of the one that waits least: the others' is waiting for it
        "exchange_s": work["exchange_s"].min(),
        "sent_bytes": work["sent_bytes"].sum(),
    }


def _number(pattern: str, text: str) -> float:
    found = re.search(pattern, text)
    return float(found[1]) if found else nan


def measured(rows: list[Row]) -> model.Shared | None:
    """The constants of `estimates.ranks`, from the rows of several processors; None where there
    are none. Times are of this machine.

    A message is the time of a call in which the rank that waits least is, for each other rank; what
    a solve of the gas on n ranks takes longer than the n-th part of that on one is its reductions.
    """
    several = [row for row in rows if row["ranks"] > 1]
    if not several:
        return None
    usual = model.SHARED
    ones = {row["scene"]: row for row in rows if row["ranks"] == 1}
    message = median(
        row["exchange_s"] / row["exchanges"] / (row["ranks"] - 1)
        for row in several
        if row["exchanges"]
    )
    dilute = [row for row in several if row["scene"].startswith("column")]
    solved = [row for row in dilute if row["scene"] == "column, fine gas" and row["gas_solves"]]
    reductions = [
        (row["wall_s"] - row["start_s"] - (one["wall_s"] - one["start_s"]) / row["ranks"])
        / (message * ceil(log2(row["ranks"])) * row["gas_solves"])
        for row in solved
        for one in [ones[row["scene"]]]
    ]
    return model.Shared(
        message=message,
        reductions=max(0.0, median(reductions)) if reductions else usual.reductions,
        uneven=median(row["busiest"] for row in dilute) if dilute else usual.uneven,
        start=median(
            max(0.0, row["start_s"] - ones[row["scene"]]["start_s"]) / row["ranks"]
            for row in several
        ),
    )


def _model(rows: list[Row], constants: model.Shared | None) -> dict[str, dict[int, float]]:
    """Put into each row what the model with these constants says (s, so that one processor takes
    what it took); gives by scene the speed-up on FORESEEN processors. Without a feed nothing."""
    foreseen = {}
    shared = constants or model.SHARED
    for row in rows:
        plan, one = row["plan"], next(r for r in rows if r["scene"] == row["scene"])
        row["model_s"] = nan
        if plan["feed"] is None:
            continue
        alone = model.run_s(plan, 1, shared)
        row["model_s"] = one["wall_s"] * model.run_s(plan, row["ranks"], shared) / alone
        foreseen[row["scene"]] = {n: alone / model.run_s(plan, n, shared) for n in FORESEEN}
    return foreseen


def figure(rows: list[Row]) -> Figure:
    """Speed-up against processors, by scene, beside what each would give alone."""
    drawing = Figure(figsize=(COLUMN_WIDTH, COLUMN_WIDTH))
    axes = drawing.subplots()
    for number, scene in enumerate(dict.fromkeys(row["scene"] for row in rows)):
        for cut, style in zip(CUTS, ("-", "--"), strict=True):
            mine = [row for row in rows if row["scene"] == scene and row["cut"] in ("", cut)]
            axes.plot(
                [row["ranks"] for row in mine],
                [row["speed_up"] for row in mine],
                linestyle=style,
                color=f"C{number}",
                marker="o",
                markersize=3,
                label=f"{scene}, cut {cut} gravity",
            )
    most = max(row["ranks"] for row in rows)
    axes.plot([1, most], [1, most], color="0.7", linewidth=0.6)
    label(axes, "processors", "times one processor")
    return drawing
