"""The accuracy benchmark's page and its figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, isfinite
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from elutria.bench import uncertainty
from elutria.bench.accuracy_error import ERRORS, beside_stock, known_error
from elutria.bench.accuracy_reference import Reference
from elutria.bench.common import Options, machine, write_result
from elutria.plots import COLUMN_WIDTH, STYLE

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
QUANTITIES = {"d50": "error of d50", "curve": "error of the curve (rms)"}

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


def advice(rows: Sequence[Row], within: float = 0.01) -> str:
    """The cheapest settings whose d50 is `within` the converged one wherever they were run."""
    ours = [row for row in rows if row["kind"] == "elutriaFoam" and isfinite(row["seconds"])]
    scenes = {row["scene"] for row in ours}
    sums: dict[str, float] = {}
    for name in {row["point"] for row in ours}:
        here = [row for row in ours if row["point"] == name]
        good = all(abs(row["d50_error"]) <= within for row in here)
        if good and {row["scene"] for row in here} == scenes:
            sums[name] = sum(row["seconds"] for row in here)
    if not sums:
        return f"No settings were within {100 * within:g} % of d50 in all scenes."
    best = min(sums, key=lambda name: sums[name])
    chosen = [row for row in ours if row["point"] == best]
    noise = max(row["d50_noise"] for row in chosen)
    parcels = chosen[0]["parcels"]
    needed = max(parcels, ceil(parcels * (1.96 * noise / within) ** 2 / 100) * 100)
    return (
        f"For d50 to {100 * within:g} % use **{best}** ({sums[best] / len(chosen):.0f} s a run on "
        f"average); chance alone then asks for some {needed} parcels, or `--precision {within:g}`."
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
    for row in best:
        axes.annotate(row["point"], (row["seconds"], known_error(row, quantity)), fontsize=5.5,
                      xytext=(3, -4), textcoords="offset points", va="top")  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylabel(QUANTITIES[quantity])


def tornado(rows: Sequence[uncertainty.Row]) -> Figure:
    """Bars of the change of d50 and of the sharpness, the widest at the top."""
    shown = [row for row in rows if isfinite(row["d50_change"])]
    shown.sort(key=lambda row: abs(row["d50_change"]))
    names = [f"{row['group']}: {row['what']}" for row in shown]
    result, panels = plt.subplots(
        1, 2, figsize=(2 * COLUMN_WIDTH, 0.15 * len(shown) + 0.6), sharey=True
    )
    colours = [{"numerics": "#009E73", "chance": "0.6"}.get(row["group"], "#0072B2")
               for row in shown]  # fmt: skip
    for axes, quantity, factor in zip(panels, ("d50", "sharpness"), (100, 1), strict=True):
        axes.barh(
            names,
            [factor * row[f"{quantity}_change"] for row in shown],
            xerr=[factor * row[f"{quantity}_noise"] for row in shown],
            color=colours, error_kw={"linewidth": 0.6, "ecolor": "0.3"}, height=0.7,
        )  # fmt: skip
        axes.axvline(0, color="0.3", linewidth=0.6)
        axes.tick_params(axis="y", length=0, labelsize=6.5)
        axes.margins(y=0.01)
    panels[0].set_xlabel("change of d50, %")
    panels[1].set_xlabel("change of sharpness d25/d75")
    return result


def write_uncertainty(options: Options, rows: Sequence[uncertainty.Row]) -> None:
    """uncertainty.csv, .png and .json."""
    with mpl.rc_context(STYLE):
        drawn = tornado(rows)
        write_result(options, "uncertainty", uncertainty.COLUMNS, rows, drawn)


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
        advice(rows),
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
        *_target_lines(target(rows)),
        *_tables(rows),
        "# What moves the cut",
        "",
        "The column at 4 m/s, one thing changed at a time, against the plan with three times the",
        "parcels. Changes with one standard deviation of chance.",
        "",
        "| what | d50 | sharpness |",
        "| --- | --- | --- |",
        *(_moved(row) for row in sorted(moved, key=_width, reverse=True)),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _width(row: uncertainty.Row) -> float:
    return abs(row["d50_change"]) if isfinite(row["d50_change"]) else -1.0


def _moved(row: uncertainty.Row) -> str:
    name = f"{row['group']}: {row['what']}"
    if row["note"]:
        return f"| {name} | {row['note']} | |"
    return (
        f"| {name} | {100 * row['d50_change']:+.1f} +- {100 * row['d50_noise']:.1f} % | "
        f"{row['sharpness_change']:+.3f} +- {row['sharpness_noise']:.3f} |"
    )


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
