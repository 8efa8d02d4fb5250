"""The accuracy benchmark's page: advice, the target beside stock, and all points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot, isfinite, sqrt
from typing import Any

from elutria_validation.benchmarks import uncertainty
from elutria_validation.benchmarks.accuracy_error import ERRORS, beside_stock, known_error
from elutria_validation.benchmarks.accuracy_figure import QUANTITIES
from elutria_validation.benchmarks.accuracy_reference import Reference
from elutria_validation.benchmarks.accuracy_runs import (
    COURANT,
    DENSE,
    DRAIN_TIME,
    FEED_TIME,
    FINE,
    PLAN,
    SLOW,
    STEP,
    STOCK_LIKE,
)
from elutria_validation.benchmarks.accuracy_stock import LATER
from elutria_validation.harness.provenance import machine

TEXTS = ("scene", "point", "kind", "extrapolated", "note")
COLUMNS = (
    "scene", "point", "kind", "parcels", "runs", "seconds", "seconds_low", "seconds_high",
    "extrapolated", "d50_m", "sharpness",
    *ERRORS, "front_d50", "front_curve", "note",
)  # fmt: skip
LADDERS = (
    ("gas by points, mesh x 0.6", "gas by points", f"gas by points, {FINE}"),
    ("mesh x 0.6", "parcels x 3", FINE),
)

HOW = (
    "Seconds are of the processor, from a case's files to its events (`elutria bench accuracy`):",
    "the median of the runs, and their range. Errors are the runs' mean, with one standard",
    "deviation of what they together and the reference do not know; `one run` is what a single",
    "run is off by, chance included (root-mean-square over the runs): the figure, the front and",
    "the comparisons go by it. Sharpness is d25/d75; the curve's error is its root-mean-square",
    "difference from 0.7 to 1.4 d50. Stock DPMFoam is extrapolated from a stretch; its error is",
    "that of elutriaFoam with stock's models on the same particles. MPPICFoam is run to its end;",
    "its random numbers have no seed, so each of its runs is fed",
    f"{1e3 * LATER:g} ms later than the last.",
)

Row = dict[str, Any]


def line(row: Row) -> str:
    """One line for the terminal."""
    said = f"{row['scene']}, {row['point']}: "
    if not isfinite(row["seconds"]):
        return f"{said}{row['note']}"
    mark = " (extrapolated)" if row["extrapolated"] else ""
    return (
        f"{said}{row['seconds']:.3g} s{mark}, d50 {100 * row['d50_error']:+.1f} "
        f"+- {100 * row['d50_noise']:.1f} %, one run {100 * row['d50_run']:.2g} %"
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
    """A line for the column and one for the dense scene: the cheapest settings of which one run's
    d50 is `within` the converged one in all such scenes; else those that come closest.
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
    refined: Sequence[Row],
    moved: Sequence[uncertainty.Row],
    parcels: int,
    seeds: int,
) -> str:
    """The page: advice, the target, all points, and what moves the cut."""
    made = machine()
    lines = [
        "# Run time against error",
        "",
        f"The default column with its own settings where nothing else is said (steps of up to "
        f"{1e3 * STEP:g} ms",
        f"and {COURANT:g} cells), fed with {parcels} parcels in {FEED_TIME:g} s and emptied for "
        f"{DRAIN_TIME:g} s, from {seeds} seeds.",
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
        *_refined_lines(refined),
        *_meshes(rows, table),
        *_target_lines(target(rows)),
        *default_lines(rows),
        *_tables(rows),
        *uncertainty.page(moved),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _refined_lines(refined: Sequence[Row]) -> list[str]:
    """Whether the references are converged."""
    return [
        "What refining a reference further changes, one run each; the noise is the parcels', two",
        "runs differ by what the gas does by chance too:",
        "",
        "| scene | refined | d50 | s |",
        "| --- | --- | --- | --- |",
        *(
            f"| {row['scene']} | {row['refined']} | {100 * row['d50_change']:+.2f} +- "
            f"{100 * row['d50_noise']:.2f} % | {row['seconds']:.0f} |"
            for row in refined
        ),
        "",
        "Finer meshes have their first cell below the logarithmic layer that the wall functions",
        "stand for: what they change is the model's as much as the mesh's.",
        "",
    ]


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
        "in the dense column) or 10 times more accurate at its cost:",
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


def default_lines(rows: Sequence[Row]) -> list[str]:
    """Whether the default settings are on the front of the runs, and what is before them."""
    lines, better = [], []
    for default in rows:
        if default["point"] != PLAN or not isfinite(default["seconds"]):
            continue
        before = {
            quantity: _cheaper_and_as_good(rows, default, quantity) for quantity in QUANTITIES
        }
        for quantity, found in before.items():
            said = ", ".join(_before(row, default, quantity) for row in found)
            lines.append(
                f"- {default['scene']}, {quantity} "
                f"({100 * known_error(default, quantity):.2g} %): "
                f"{f'behind {said}' if found else 'on the front'}."
            )
            better += [row["point"] for row in found if _is_better(row, default, quantity)]
        names = [{row["point"] for row in found} for found in before.values()]
        both = ", ".join(sorted(set.intersection(*names)))
        lines.append(
            f"- {default['scene']}, front of seconds and both errors together: "
            f"{f'behind {both}' if both else 'on it'}."
        )
    if not lines:
        return []
    known = ", ".join(dict.fromkeys(better)) or "nothing"
    return [
        "The default settings, by what a single run is off by:",
        "",
        *lines,
        "",
        f"Cheaper than the default and more accurate by more than chance: {known}.",
        "",
    ]


def _cheaper_and_as_good(rows: Sequence[Row], default: Row, quantity: str) -> list[Row]:
    """Our runs of the same scene that beat the default in seconds and an error."""
    return [
        row
        for row in rows
        if row["scene"] == default["scene"]
        and row["kind"] not in ("closed form", "stock")
        and row["seconds"] < default["seconds"]
        and known_error(row, quantity) <= known_error(default, quantity)
    ]


def _before(row: Row, default: Row, quantity: str) -> str:
    """What is cheaper than the default, by how much, and whether more than chance says so."""
    saved = 1 - row["seconds"] / default["seconds"]
    always = row["seconds_high"] < default["seconds_low"]
    better = _is_better(row, default, quantity)
    return (
        f"{row['point']} ({100 * saved:.0f} % cheaper{', in every run' * always}, "
        f"{100 * known_error(row, quantity):.2g} %, "
        f"{'better' if better else 'as good within chance'})"
    )


def _is_better(row: Row, default: Row, quantity: str) -> bool:
    """Whether more than chance says that a point is the more accurate one."""
    # a root-mean-square of n runs is known to 1/sqrt(2 n) of itself
    chance = hypot(*(known_error(one, quantity) / sqrt(2 * one["runs"]) for one in (row, default)))
    return known_error(default, quantity) - known_error(row, quantity) > 2 * chance


def _yes(flag: bool) -> str:
    return "yes" if flag else "no"


def _tables(rows: Sequence[Row]) -> list[str]:
    """A table for each scene; (front): on the runs' Pareto front of d50's error and seconds."""
    lines = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        lines += [
            f"## {scene}",
            "",
            "| point | s | d50 | one run | sharpness | curve | one run | |",
            "| --- | --- | --- | --- | --- | --- | --- | --- |",
        ]
        lines += [_table_line(row) for row in rows if row["scene"] == scene]
        lines.append("")
    return lines


def _table_line(row: Row) -> str:
    mark = " (front)" if row["front_d50"] is True else ""
    if not isfinite(row["seconds"]):
        return f"| {row['point']} | | | | | | | {row['note']} |"
    seconds = f"{row['seconds']:.3g}"
    if row["extrapolated"]:
        seconds += " (extrapolated)"
    elif row["runs"] > 1:
        seconds += f" ({row['seconds_low']:.3g} to {row['seconds_high']:.3g})"
    return (
        f"| {row['point']}{mark} | {seconds} | "
        f"{100 * row['d50_error']:+.1f} +- {100 * row['d50_noise']:.1f} % | "
        f"{100 * row['d50_run']:.2g} % | "
        f"{row['sharpness_error']:+.3f} +- {row['sharpness_noise']:.3f} | "
        f"{row['curve_error']:.3f} +- {row['curve_noise']:.3f} | {row['curve_run']:.3f} | "
        f"{row['note']} |"
    )
