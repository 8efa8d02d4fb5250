"""Run time against error: the accuracy benchmark's figure."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from math import isfinite
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from elutria.output.style import COLUMN_WIDTH
from elutria_validation.benchmarks.accuracy_error import known_error

KINDS = {
    "closed form": ("^", "#009E73"),
    "elutriaFoam": ("o", "#0072B2"),
    "ours in DPMFoam": ("s", "#CC79A7"),
    "stock": ("D", "#D55E00"),
}
QUANTITIES = {"d50": "error of d50, %", "curve": "error of the curve (rms), %"}

LINE = 0.052
"""Height of a line of the names, over a panel's."""

Row = dict[str, Any]


def figure(rows: Sequence[Row]) -> Figure:
    """Known error against seconds: a row of panels for each scene, d50 left, the curve right."""
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    size = (2 * COLUMN_WIDTH, 0.7 * COLUMN_WIDTH * len(scenes) + 0.35)
    result, panels = plt.subplots(len(scenes), 2, figsize=size, squeeze=False, sharex="row")
    for pair, scene in zip(panels, scenes, strict=True):
        here = [row for row in rows if row["scene"] == scene and isfinite(row["seconds"])]
        for axes, quantity in zip(pair, QUANTITIES, strict=True):
            _panel(axes, [row for row in here if isfinite(known_error(row, quantity))], quantity)
        pair[0].set_title(scene, fontsize=8, loc="left")
    for axes in panels[-1]:
        axes.set_xlabel("processor time, s (hollow: extrapolated)")
    handles = [
        Line2D([], [], marker=mark, color=colour, linestyle="", markersize=4, label=kind)
        for kind, (mark, colour) in KINDS.items()
    ]
    handles.append(Line2D([], [], color="0.5", linewidth=0.8, label="Pareto front of the runs"))
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
    axes.set_xlim(5e-5, 3 * max(row["seconds"] for row in rows))
    low, high = axes.get_ylim()
    axes.set_ylim(low / 1.5, high)
    _label(axes, best, quantity)
    percent = FuncFormatter(lambda value, _: f"{100 * value:g}")
    axes.yaxis.set_major_formatter(percent)
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_ylabel(QUANTITIES[quantity])


def _label(axes: Axes, best: Sequence[Row], quantity: str) -> None:
    """Names of the front's points in a column of their own, in their order from the top."""
    low, high = np.log(axes.get_ylim())
    order = sorted(best, key=lambda row: -known_error(row, quantity))
    names = [textwrap.wrap(row["point"].replace("gas by cells", "cells"), 25) for row in order]
    halves = [0.5 * LINE * len(lines) for lines in names]
    places = []
    top = 1.0
    for row, half in zip(order, halves, strict=True):
        own = (np.log(known_error(row, quantity)) - low) / (high - low)
        places.append(min(own, top - half))
        top = places[-1] - half - 0.01
    bottom = 0.01
    for k in reversed(range(len(places))):
        places[k] = max(places[k], bottom + halves[k])
        bottom = places[k] + halves[k] + 0.01
    for row, lines, place in zip(order, names, places, strict=True):
        name = axes.annotate(
            "\n".join(lines),
            (row["seconds"], known_error(row, quantity)),
            xytext=(0.42, place),
            textcoords="axes fraction",
            fontsize=5,
            ha="right",
            va="center",
            arrowprops={"arrowstyle": "-", "color": "0.6", "linewidth": 0.4, "shrinkB": 2},
        )
        name.set_in_layout(False)
