"""Run time against error: closed forms, elutriaFoam at a ladder of settings, and stock OpenFOAM.

Two gas velocities of the default column and a dense one, each point from several seeds. Errors are
from converged curves that are kept in a table (accuracy_reference.csv; accuracy_refined.csv says
what refining them further changes). Seconds are of processor time, from a case's files to its
events, the seeds' median. In the same folder, uncertainty.csv and .png say how far what nobody
knows exactly moves the cut.

Each point is run from as many seeds as `--repeats`; reference=make makes the tables again (some
minutes more). Runs that are finished are not run again: after a break the command goes on.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import nan
from pathlib import Path
from statistics import fmean, median
from typing import Any, Literal

import matplotlib as mpl

from elutria.errors import ElutriaError
from elutria.files import write_text
from elutria.output.style import STYLE
from elutria_validation.benchmarks import accuracy_reference as references
from elutria_validation.benchmarks import accuracy_report as report
from elutria_validation.benchmarks import uncertainty
from elutria_validation.benchmarks.accuracy_error import (
    Cut,
    cut_of_events,
    errors,
    front,
    known_error,
)
from elutria_validation.benchmarks.accuracy_figure import figure
from elutria_validation.benchmarks.accuracy_forms import closed_forms
from elutria_validation.benchmarks.accuracy_reference import Reference
from elutria_validation.benchmarks.accuracy_runs import (
    DENSE,
    FAST,
    POINTS,
    SLOW,
    STOCK_LIKE,
    Done,
    Point,
    Scene,
    replicates,
)
from elutria_validation.benchmarks.accuracy_stock import run_mppic, stock_like, stretches
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.programs import slug
from elutria_validation.harness.provenance import write_result

NAME = "accuracy"
HELP = "run time against error: closed forms, the plan and what it skips, stock; and what moves d50"
COLUMNS = report.COLUMNS
SCENES = (SLOW, FAST, DENSE)
MPPIC_RUNS = 4
"""At most: a run takes minutes."""
QUICK = ("the plan", "mesh x 0.6", "step x 2, mesh x 0.6", "gas by points, mesh x 0.6")

Row = dict[str, Any]


@dataclass(frozen=True)
class Options:
    """Its own."""

    parcels: int = option(1200, quick=200, least=10, unit="of the usual run")
    scenes: int = option(3, quick=1, least=1, unit="the first so many")
    reference: Literal["kept", "make"] = option("kept")


def run(job: Job, options: Options) -> None:
    """All scenes and points; writes accuracy.csv, .png, .json, .md and uncertainty.csv, .png."""
    parcels, seeds = options.parcels, _seeds(job)
    runs = job.folder / "accuracy-runs"  # other benchmarks have a "runs" there
    scenes = SCENES[: options.scenes]
    table, refined = _references(job, options.reference == "make", runs, scenes)
    rows: list[Row] = []
    moved = uncertainty.measure(runs, parcels, seeds, job.quick, job.say)
    for scene in scenes:
        rows += _scene(job, runs, scene, parcels, table[scene.name])
    for quantity in ("d50", "curve"):
        mark_front(rows, quantity)
    with mpl.rc_context(STYLE):
        write_result(job, NAME, COLUMNS, rows, figure(rows), {
            "parcels": parcels,
            "seeds": len(seeds),
            "target": report.target(rows),
            "reference": {name: one.how for name, one in table.items()},
        })  # fmt: skip
        write_result(job, "uncertainty", uncertainty.COLUMNS, moved, uncertainty.figure(moved))
    page = report.text(rows, table, refined, moved, parcels, len(seeds))
    write_text(job.folder / f"{NAME}.md", page)
    shutil.rmtree(runs)


def _seeds(job: Job) -> Sequence[int]:
    return range(1, 1 + (1 if job.quick else job.repeats))


def _references(
    job: Job, anew: bool, runs: Path, scenes: Sequence[Scene]
) -> tuple[dict[str, Reference], list[Row]]:
    """The kept tables, or those made anew and put beside the results."""
    folder = references.kept()
    if anew:
        folder = job.folder
        references.write(folder, *references.make(runs, scenes, job.say))
    return references.read(folder)


def _scene(job: Job, runs: Path, scene: Scene, parcels: int, reference: Reference) -> list[Row]:
    """Rows of a scene."""
    rows = [
        row(scene, form.name, "closed form", [form.seconds], [form.cut], reference.cut)
        for form in closed_forms(scene)
    ]
    for point in POINTS:
        if not point.belongs_to(scene) or (job.quick and point.name not in QUICK):
            continue
        folder = runs / slug(scene.name, point.name)
        rows.append(
            _tried(scene, point.name, "elutriaFoam", reference.cut,
                   partial(_runs, job, folder, scene, point, parcels))
        )  # fmt: skip
        job.say(report.line(rows[-1]))
    return rows + _stock(job, runs, scene, reference.cut)


def _runs(job: Job, folder: Path, scene: Scene, point: Point, parcels: int) -> list[Done]:
    seeds = _seeds(job)[:1] if point.once else _seeds(job)
    return replicates(folder, scene, point, parcels, seeds)


def _stock(job: Job, runs: Path, scene: Scene, reference: Cut) -> list[Row]:
    """Stock's rows: MPPICFoam to the end, DPMFoam by a stretch."""
    rows = []
    if job.quick:
        rows.append(failed(scene, "stock MPPICFoam", "stock", "left out of --quick"))
    else:
        folder = runs / slug(scene.name, "mppic")
        rows.append(
            _tried(scene, "stock MPPICFoam", "stock", reference,
                   lambda: run_mppic(folder, scene, min(len(_seeds(job)), MPPIC_RUNS)))
        )  # fmt: skip
    folder = runs / slug(scene.name, "stock")
    try:
        like, filled = stock_like(folder, scene)
        others = [] if job.quick or scene == DENSE else _seeds(job)[1:]
        done = [like, *replicates(folder, scene, STOCK_LIKE, 0, others)]
    except ElutriaError as error:
        return [*rows, failed(scene, "stock DPMFoam", "stock", str(error))]
    cuts = [cut_of_events(one.run.events) for one in done]
    number = len(like.run.events)
    rows.append(row(scene, STOCK_LIKE.name, "elutriaFoam", [one.seconds for one in done], cuts,
                    reference, parcels=number))  # fmt: skip
    for stretch in stretches(folder, scene, filled, job.quick, job.say):
        kind = "ours in DPMFoam" if "our contacts" in stretch.name else "stock"
        note = f"{stretch.note}; error: elutriaFoam with stock's models"
        rows.append(row(scene, stretch.name, kind, [stretch.seconds], cuts, reference, True, note,
                        number))  # fmt: skip
    for one in rows:
        job.say(report.line(one))
    return rows


def _tried(
    scene: Scene, name: str, kind: str, reference: Cut, work: Callable[[], list[Done]]
) -> Row:
    """The row of a point's runs, or of the reason why there is none."""
    try:
        done = work()
    except ElutriaError as error:
        return failed(scene, name, kind, str(error))
    cuts = [cut_of_events(one.run.events) for one in done]
    return row(scene, name, kind, [one.seconds for one in done], cuts, reference,
               parcels=len(done[0].run.events))  # fmt: skip


def row(
    scene: Scene,
    name: str,
    kind: str,
    seconds: Sequence[float],
    cuts: Sequence[Cut],
    reference: Cut,
    extrapolated: bool = False,
    note: str = "",
    parcels: int = 0,
) -> Row:
    """A row of accuracy.csv from a point's runs: seconds of processor, sizes in m, errors with
    their noise."""
    return {
        "scene": scene.name,
        "point": name,
        "kind": kind,
        "parcels": parcels,
        "runs": len(cuts),
        "seconds": median(seconds),
        "seconds_low": min(seconds),
        "seconds_high": max(seconds),
        "extrapolated": extrapolated,
        "d50_m": fmean(cut.d50 for cut in cuts),
        "sharpness": fmean(cut.sharpness for cut in cuts),
        **errors(cuts, reference),
        "front_d50": False,
        "front_curve": False,
        "note": note,
    }


def failed(scene: Scene, name: str, kind: str, reason: str) -> Row:
    """The row of a point that has no numbers, with the reason."""
    numbers = {name: nan for name in COLUMNS if name not in report.TEXTS}
    return {**numbers, "scene": scene.name, "point": name, "kind": kind, "parcels": 0,
            "runs": 0, "extrapolated": False, "note": reason}  # fmt: skip


def mark_front(rows: Sequence[Row], quantity: str) -> None:
    """Say of each row whether it is on its scene's Pareto front of seconds and known error.

    The front is that of the runs: a closed form costs nothing, and knows nothing but the cut.
    """
    for scene in {row["scene"] for row in rows}:
        here = [row for row in rows if row["scene"] == scene and row["kind"] != "closed form"]
        marks = front([row["seconds"] for row in here], [known_error(r, quantity) for r in here])
        for one, mark in zip(here, marks, strict=True):
            one[f"front_{quantity}"] = mark
