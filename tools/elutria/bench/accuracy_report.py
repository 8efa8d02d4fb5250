"""The accuracy benchmark's page and its figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from elutria.bench import uncertainty
from elutria.bench.accuracy_error import ERRORS, beside_stock, known_error
from elutria.bench.accuracy_reference import Reference
from elutria.bench.accuracy_runs import DENSE, SLOW, STOCK_LIKE
from elutria.bench.common import machine
from elutria.plots import COLUMN_WIDTH

TEXTS = ("scene", "point", "kind", "extrapolated", "note")
COLUMNS = (
    "scene", "point", "kind", "parcels", "seconds", "extrapolated", "d50_m", "sharpness",
    *ERRORS, "front_d50", "front_curve", "note",
)  # fmt: skip
KINDS = {
    "closed form": ("^", "#009E73"),
    "elutriaFoam": ("o", "#0072B2"),
    "ours in DPMFoam": ("s", "#CC79A7"),
    "stock": ("D", "#D55E00"),
}
CHEAP_FINE = "one-way, step x 4, mesh x 1.5, parcels x 3"
LADDERS = (
    ("mesh x 0.6", "parcels x 3", CHEAP_FINE),
    ("gas by cells, mesh x 0.6", "gas by cells", f"gas by cells, {CHEAP_FINE}"),
)
QUANTITIES = {"d50": "error of d50, %", "curve": "error of the curve (rms), %"}

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
    """For every point of stock on the column: the best of ours beside it, and whether it is 100
    times faster at its error or 10 times more accurate at its cost."""
    found = []
    for stock in rows:
        if stock["kind"] != "stock" or not isfinite(stock["seconds"]):
            continue
        here = [row for row in rows if row["scene"] == stock["scene"]]
        ours = [row for row in here if row["kind"] in ("elutriaFoam", "closed form")]
        for quantity in QUANTITIES:
            verdict = beside_stock(stock, ours, quantity)
            found.append({
                "scene": stock["scene"],
                "stock": stock["point"],
                "quantity": quantity,
                "faster": verdict.faster,
                "by": verdict.by,
                "more_accurate": verdict.more_accurate,
                "met": verdict.met,
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
        f"({seconds:.0f} s a run) comes closest, {100 * error:.1f} %, chance included."
    )


def figure(rows: Sequence[Row]) -> Figure:
    """Known error against seconds: a row of panels for each scene, d50 left, the curve right."""
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    size = (2 * COLUMN_WIDTH, 0.62 * COLUMN_WIDTH * len(scenes) + 0.35)
    result, panels = plt.subplots(len(scenes), 2, figsize=size, squeeze=False, sharex="row")
    for pair, scene in zip(panels, scenes, strict=True):
        here = [row for row in rows if row["scene"] == scene and isfinite(row["seconds"])]
        for axes, quantity in zip(pair, QUANTITIES, strict=True):
            _panel(axes, [row for row in here if isfinite(known_error(row, quantity))], quantity)
        pair[0].set_title(scene, fontsize=8, loc="left")
    for axes in panels[-1]:
        axes.set_xlabel("processor time, s (hollow: extrapolated)")
    handles = [
        plt.Line2D([], [], marker=mark, color=colour, linestyle="", markersize=4, label=kind)
        for kind, (mark, colour) in KINDS.items()
    ]
    handles.append(plt.Line2D([], [], color="0.5", linewidth=0.8, label="Pareto front"))
    result.legend(handles=handles, loc="outside upper center", ncols=len(handles))
    return result


def _panel(axes: Axes, rows: Sequence[Row], quantity: str) -> None:
    for row in rows:
        mark, colour = KINDS[row["kind"]]
        axes.errorbar(
            row["seconds"],
            known_error(row, quantity),
            yerr=[[0], [row[f"{quantity}_noise"]]],
            marker=mark, color=colour, markersize=4, linewidth=0.5, capsize=0,
            markerfacecolor="white" if row["extrapolated"] else colour,
        )  # fmt: skip
    best = sorted((row for row in rows if row[f"front_{quantity}"]), key=lambda r: r["seconds"])
    axes.step([row["seconds"] for row in best], [known_error(row, quantity) for row in best],
              where="post", color="0.5", linewidth=0.8, zorder=0)  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(3e-4, 3e4)
    low, high = axes.get_ylim()
    axes.set_ylim(low / 1.3, high)
    _label(axes, best, quantity)
    percent = FuncFormatter(lambda value, _: f"{100 * value:g}")
    axes.yaxis.set_major_formatter(percent)
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_ylabel(QUANTITIES[quantity])


def _label(axes: Axes, best: Sequence[Row], quantity: str) -> None:
    """Names of the front's runs in a column of their own, in their order from the top; a closed
    form's name stands beside its mark."""
    low, high = np.log(axes.get_ylim())
    least = 0.075
    place = 1.0
    for row in sorted(best, key=lambda row: -known_error(row, quantity)):
        if row["kind"] == "closed form":
            at = (row["seconds"], known_error(row, quantity))
            axes.annotate(row["point"], at, xytext=(3, 2), textcoords="offset points",
                          fontsize=5.5, va="bottom")  # fmt: skip
            continue
        own = (np.log(known_error(row, quantity)) - low) / (high - low)
        place = min(own, place - least)
        axes.annotate(
            row["point"],
            (row["seconds"], known_error(row, quantity)),
            xytext=(0.46, place),
            textcoords="axes fraction",
            fontsize=5.5,
            ha="right",
            va="center",
            arrowprops={"arrowstyle": "-", "color": "0.6", "linewidth": 0.4, "shrinkB": 2},
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
        f"The default column, {parcels} parcels where nothing else is said, fed for 0.25 s and",
        "emptied for 1 s (`elutria bench accuracy`). Seconds of processor time; errors with one",
        "standard deviation of what both curves do not know. Sharpness is d25/d75; the curve's",
        "error is its root-mean-square difference from 0.7 to 1.4 d50.",
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
        f"What d50 follows most is the mesh ({SLOW.name}): {by_points}. That is the interpolation",
        "of the gas to a particle (`cellPoint`), which is linear from the wall's zero to the first",
        "cell's centre, where the true profile is flat down to a thin layer. With the gas by cells",
        f"(`U.air cell`): {by_cells}, the reference {1e6 * table[SLOW.name].cut.d50:.0f} um.",
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
        "For every point of stock on the column, one of ours should be 100 times faster at its",
        "error or 10 times more accurate at its cost (an error below its noise counts as the",
        "noise, which is why tenfold accuracy cannot show here):",
        "",
        "| scene | stock | error of | ours is faster by | with | more accurate by | met |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for one in verdicts:
        lines.append(
            f"| {one['scene']} | {one['stock']} | {one['quantity']} | {one['faster']:.3g} | "
            f"{one['by']} | {one['more_accurate']:.2g} | {'yes' if one['met'] else 'no'} |"
        )
    met = sum(one["met"] for one in verdicts)
    return [*lines, "", f"Met for {met} of {len(verdicts)}.", ""]


def _tables(rows: Sequence[Row]) -> list[str]:
    """A table for each scene; (f): on the Pareto front of d50's error and seconds."""
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
