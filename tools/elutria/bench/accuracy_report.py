"""The accuracy benchmark's page: advice, the target beside stock, and all points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

from elutria.bench import uncertainty
from elutria.bench.accuracy_error import ERRORS, beside_stock, known_error
from elutria.bench.accuracy_figure import QUANTITIES
from elutria.bench.accuracy_reference import Reference
from elutria.bench.accuracy_runs import (
    DENSE,
    DRAIN_TIME,
    FEED_TIME,
    PLAN,
    SLOW,
    STEP,
    STOCK_LIKE,
)
from elutria.bench.common import machine

TEXTS = ("scene", "point", "kind", "extrapolated", "note")
COLUMNS = (
    "scene", "point", "kind", "parcels", "seconds", "extrapolated", "d50_m", "sharpness",
    *ERRORS, "front_d50", "front_curve", "note",
)  # fmt: skip
CHEAP_FINE = "one-way, step x 2, mesh x 1.5, parcels x 3"
LADDERS = (
    ("gas by points, mesh x 0.6", "gas by points", f"gas by points, {CHEAP_FINE}"),
    ("mesh x 0.6", "parcels x 3", CHEAP_FINE),
)

HOW = (
    "Seconds are of the processor, from a case's files to its events (`elutria bench accuracy`);",
    "errors with one standard deviation of what both curves do not know. Sharpness is d25/d75; the",
    "curve's error is its root-mean-square difference from 0.7 to 1.4 d50. Stock DPMFoam is",
    "extrapolated from a stretch; its error is that of elutriaFoam with stock's models on the same",
    "particles.",
)

Row = dict[str, Any]


def line(row: Row) -> str:
    """One line for the terminal."""
    said = f"{row['scene']}, {row['point']}: "
    if not isfinite(row["seconds"]):
        return said + row["note"]
    mark = " (extrapolated)" if row["extrapolated"] else ""
    return (
        f"{said}{row['seconds']:.3g} s{mark}, d50 {100 * row['d50_error']:+.1f} "
        f"+- {100 * row['d50_noise']:.1f} %"
    )


def target(rows: Sequence[Row]) -> list[Row]:
    """For every point of stock: the best run of elutriaFoam beside it, whether it is as many times
    faster at stock's error as asked or 10 times more accurate at its cost, and whether a closed
    form would have done."""
    found = []
    for stock in rows:
        if stock["kind"] != "stock" or not isfinite(stock["seconds"]):
            continue
        here = [row for row in rows if row["scene"] == stock["scene"]]
        runs = [row for row in here if row["kind"] == "elutriaFoam"]
        forms = [row for row in here if row["kind"] == "closed form"]
        for quantity in QUANTITIES:
            verdict = beside_stock(stock, runs, quantity)
            found.append({
                "scene": stock["scene"],
                "stock": stock["point"],
                "quantity": quantity,
                "faster": verdict.faster,
                "by": verdict.by,
                "more_accurate": verdict.more_accurate,
                "met": verdict.met(10 if stock["scene"] == DENSE.name else 100),
                "closed_form_as_good": beside_stock(stock, forms, quantity).by != "none",
            })  # fmt: skip
    return found


def advice(rows: Sequence[Row], within: float = 0.01) -> list[str]:
    """A line for the column and one for the dense scene: the cheapest settings whose d50, its
    noise included, is `within` the converged one in all such scenes; else those that come closest.
    """
    ours = [row for row in rows if row["kind"] == "elutriaFoam" and isfinite(row["seconds"])]
    ours = [row for row in ours if row["point"] != STOCK_LIKE.name]
    dense = [row for row in ours if row["scene"] == DENSE.name]
    column = [row for row in ours if row["scene"] != DENSE.name]
    found = [("in the default column", column), ("in the dense column", dense)]
    return [_advice(where, here, within) for where, here in found if here]


def _advice(where: str, rows: Sequence[Row], within: float) -> str:
    scenes = {row["scene"] for row in rows}
    points: dict[str, tuple[float, float]] = {}  # seconds a run, error
    for name in {row["point"] for row in rows}:
        here = [row for row in rows if row["point"] == name]
        if {row["scene"] for row in here} == scenes:
            seconds = sum(row["seconds"] for row in here) / len(here)
            points[name] = (seconds, max(known_error(row, "d50") for row in here))
    good = {name: cost for name, (cost, error) in points.items() if error <= within}
    if good:
        best = min(good, key=lambda name: good[name])
        return f"For d50 to {100 * within:g} % {where} use **{best}** ({good[best]:.0f} s a run)."
    best = min(points, key=lambda name: points[name][1])
    seconds, error = points[best]
    return (
        f"For d50 to {100 * within:g} % {where} none is known to be enough; **{best}** "
        f"({seconds:.0f} s a run) comes closest, {100 * error:.2f} %, chance included."
    )


def text(
    rows: Sequence[Row],
    table: Mapping[str, Reference],
    moved: Sequence[uncertainty.Row],
    parcels: int,
) -> str:
    """The page: advice, the target, all points, and what moves the cut."""
    made = machine()
    lines = [
        "# Run time against error",
        "",
        f"The default column, {parcels} parcels and steps of {1e3 * STEP:g} ms where nothing else",
        f"is said, fed for {FEED_TIME:g} s and emptied for {DRAIN_TIME:g} s.",
        *HOW,
        "",
        f"OpenFOAM {made['openfoam']}, {made['processor']}, commit {made['commit'][:10]}.",
        "",
        *advice(rows),
        "",
        *_closed_forms(rows),
        "",
        "Errors are counted from:",
        "",
        *(f"- {name}: {one.how}, {one.parcels} parcels, {one.seconds:.0f} s; d50 "
          f"{1e6 * one.cut.d50:.1f} +- {1e6 * one.cut.d50_sd:.1f} um, sharpness "
          f"{one.cut.sharpness:.3f} +- {one.cut.sharpness_sd:.3f}"
          for name, one in table.items()),
        "",
        *_meshes(rows, table),
        *_target_lines(target(rows)),
        *_default_lines(rows),
        *_tables(rows),
        *uncertainty.page(moved),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _meshes(rows: Sequence[Row], table: Mapping[str, Reference]) -> list[str]:
    """d50 against the mesh, with the gas at a particle by OpenFOAM's cellPoint and by cells."""
    known = {
        row["point"]: f"{1e6 * row['d50_m']:.0f} um"
        for row in rows
        if row["scene"] == SLOW.name and isfinite(row["seconds"])
    }
    by_points, by_cells = (
        ", ".join(f"{name} {known[name]}" for name in names if name in known) for names in LADDERS
    )
    return [
        f"How the gas is taken to a particle decides what the mesh does ({SLOW.name}). OpenFOAM's",
        "`cellPoint` is linear from the wall's zero to the first cell's centre, where the true",
        f"profile is flat down to a thin layer: {by_points}. By cells, as the case has it:",
        f"{by_cells}, the reference {1e6 * table[SLOW.name].cut.d50:.0f} um.",
        "",
    ]


def _closed_forms(rows: Sequence[Row], within: float = 0.02) -> list[str]:
    lines = []
    for row in rows:
        if row["kind"] == "closed form":
            good = abs(row["d50_error"]) <= within
            lines.append(
                f"- {row['point']} ({row['scene']}): d50 {100 * row['d50_error']:+.1f} %, "
                f"sharpness {row['sharpness_error']:+.3f}: "
                f"{'good' if good else 'not good'} enough for d50 to {100 * within:g} %."
            )
    return lines


def _target_lines(verdicts: Sequence[Row]) -> list[str]:
    lines = [
        "For every point of stock, one of ours should be 100 times faster at its error (10 times",
        "in the dense column) or 10 times more accurate at its cost (an error below its noise",
        "counts as the noise, so that accuracy shows only as far as chance lets it):",
        "",
        "| scene | stock | error of | ours is faster by | with | more accurate by | met |"
        " a closed form is as good |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for one in verdicts:
        lines.append(
            f"| {one['scene']} | {one['stock']} | {one['quantity']} | {one['faster']:.3g} | "
            f"{one['by']} | {one['more_accurate']:.2g} | {_yes(one['met'])} | "
            f"{_yes(one['closed_form_as_good'])} |"
        )
    met = sum(one["met"] for one in verdicts)
    with_forms = sum(one["met"] or one["closed_form_as_good"] for one in verdicts)
    return [
        *lines,
        "",
        f"elutriaFoam meets it for {met} of {len(verdicts)}; with the closed forms, {with_forms}.",
        "",
    ]


def _default_lines(rows: Sequence[Row]) -> list[str]:
    """Whether the default settings are on the front of the runs, and what is before them."""
    lines = []
    for default in rows:
        if default["point"] != PLAN or not isfinite(default["seconds"]):
            continue
        runs = [row for row in rows if row["scene"] == default["scene"]]
        runs = [row for row in runs if row["kind"] not in ("closed form", "stock")]
        for quantity in QUANTITIES:
            error = known_error(default, quantity)
            before = [
                f"{row['point']} ({100 * (1 - row['seconds'] / default['seconds']):.0f} % cheaper, "
                f"{100 * known_error(row, quantity):.2g} %)"
                for row in runs
                if row["seconds"] < default["seconds"] and known_error(row, quantity) <= error
            ]
            where = f"behind {', '.join(before)}" if before else "on the front"
            lines.append(
                f"- {default['scene']}, {quantity} ({100 * error:.2g} %, chance included): {where}."
            )
    return ["The default settings:", "", *lines, ""] if lines else []


def _yes(flag: bool) -> str:
    return "yes" if flag else "no"


def _tables(rows: Sequence[Row]) -> list[str]:
    """A table for each scene; (front): on the runs' Pareto front of d50's error and seconds."""
    lines = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        lines += [
            f"## {scene}",
            "",
            "| point | s | d50 | sharpness | curve | |",
            "| --- | --- | --- | --- | --- | --- |",
        ]
        lines += [_table_line(row) for row in rows if row["scene"] == scene]
        lines.append("")
    return lines


def _table_line(row: Row) -> str:
    mark = " (front)" if row["front_d50"] is True else ""
    if not isfinite(row["seconds"]):
        return f"| {row['point']} | | | | | {row['note']} |"
    return (
        f"| {row['point']}{mark} | {row['seconds']:.3g}{' (extrapolated)' * row['extrapolated']} | "
        f"{100 * row['d50_error']:+.1f} +- {100 * row['d50_noise']:.1f} % | "
        f"{row['sharpness_error']:+.3f} +- {row['sharpness_noise']:.3f} | "
        f"{row['curve_error']:.3f} +- {row['curve_noise']:.3f} | {row['note']} |"
    )
