"""T(d) of all settings: the reported curves with their bands, and what was measured in classes."""

from __future__ import annotations

from math import nan

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from elutria.output.settings import Row, Settings, column, materials_of
from elutria.output.style import Look, legend_above, looks, new_figure, size_axis

LEAST_KNOWN = 0.5
"""A class with a wider interval is not drawn."""
FEW, WELL_KNOWN = 3, 0.1
"""Up to so many settings, classes are drawn also where T does not change and is known so well."""
OFF = 0.01
"""Where the curve's mean over a class is so far from the curve at its mean size, it is drawn."""
PLAIN = 0.005
"""T below this, or above 1 - this, does not change."""

TICK = "0.1"


def partition_figure(
    settings: Settings, partition: list[Row], curves: list[Row], coarse: str = "coarse"
) -> tuple[Figure, list[Row]]:
    """One panel per material, and the rows that are drawn, with the curve's mean over each class.

    A point's horizontal bar is its class. Where the class is wider than the cut is sharp, a tick
    shows the curve's mean over it, with which the point compares.
    """
    materials = materials_of(partition)
    drawn: list[Row] = []
    number = len(settings.all)
    legend_rows = -(-number // 4) + 1
    figure, panels = new_figure(12 + 4 * legend_rows + 58 * len(materials), len(materials),
                                sharex=True)  # fmt: skip
    styles = looks(number)
    for axes, material in zip(panels, materials, strict=True):
        for k, (setting, look) in enumerate(zip(settings.all, styles, strict=True)):
            curve = settings.select(curves, setting, material)
            classes = compared(settings.select(partition, setting, material), curve, number)
            drawn += classes
            shown = [row for row in classes if row["is_shown"]]
            _draw_curve(axes, _within(curve, classes), look, f"setting{k}-{material}")
            _draw_classes(axes, shown, look, f"setting{k}-{material}")
        axes.axhline(0.5, color="0.6", linewidth=0.5, linestyle=":", zorder=0)
        axes.set_ylim(-0.03, 1.03)
        axes.set_ylabel(f"mass share to {coarse}  $T$")
        if len(materials) > 1:
            axes.text(0.03, 0.93, material, transform=axes.transAxes, va="top")
        size_axis(axes, *_range(drawn or partition))
    panels[-1].set_xlabel("particle diameter  $d$  (µm)")
    handles = [_handle(look) for look in styles]
    labels = [settings.label(setting) for setting in settings.all]
    if any(abs(row["curve_mean"] - row["curve_at_mean"]) > OFF for row in drawn):
        handles.append(Line2D([], [], color=TICK, marker="_", ms=4.5, mew=0.9, linestyle="none"))
        labels.append("class mean")
    legend_above(figure, handles, labels)
    return figure, drawn


def compared(classes: list[Row], curve: list[Row], number: int) -> list[Row]:
    """The classes of which anything is known, each with the curve's mean over it, and whether it is
    drawn among the classes of `number` settings."""
    known = [row for row in classes if row["ci_high"] - row["ci_low"] < LEAST_KNOWN]
    place, share = np.log(column(curve, "diameter_m")), column(curve, "partition_to_coarse")
    found = []
    for row in known:
        at_mean = float(np.interp(np.log(row["diameter_m"]), place, share)) if curve else nan
        row = {**row, "curve_mean": class_mean(row, curve), "curve_at_mean": at_mean}
        found.append({**row, "is_shown": _is_shown(row, number)})
    return found


def class_mean(row: Row, curve: list[Row]) -> float:
    """Mean of a curve over a class, whose mass is taken to be linear in ln d, about its mean."""
    if not curve:
        return nan
    low, high, mean = (np.log(row[f"diameter{end}_m"]) for end in ("_low", "_high", ""))
    y = np.linspace(low, high, 65)
    middle, width = (low + high) / 2, high - low
    density = np.maximum(1 + 12 * (mean - middle) / width**2 * (y - middle), 0)
    share = np.interp(y, np.log(column(curve, "diameter_m")), column(curve, "partition_to_coarse"))
    return float(np.average(share, weights=density))


def _is_shown(row: Row, number: int) -> bool:
    shares = (row["partition_to_coarse"], row["curve_mean"])
    if any(PLAIN < share < 1 - PLAIN for share in shares):
        return True
    return number <= FEW and bool(row["ci_high"] - row["ci_low"] < WELL_KNOWN)


def _within(curve: list[Row], classes: list[Row]) -> list[Row]:
    """The part of a curve over the classes that are known."""
    if not classes:
        return []
    low, high = classes[0]["diameter_low_m"], classes[-1]["diameter_high_m"]
    return [row for row in curve if low <= row["diameter_m"] <= high]


def _draw_classes(axes: Axes, rows: list[Row], look: Look, name: str) -> None:
    if not rows:
        return
    size, share = column(rows, "diameter_m") * 1e6, column(rows, "partition_to_coarse")
    faint = (*look.colour[:3], 0.6)
    axes.hlines(
        share, column(rows, "diameter_low_m") * 1e6, column(rows, "diameter_high_m") * 1e6,
        color=faint, linewidth=0.7, gid=f"{name}-widths",
    )  # fmt: skip
    axes.vlines(
        size, column(rows, "ci_low"), column(rows, "ci_high"), color=faint, linewidth=0.7,
        gid=f"{name}-intervals",
    )  # fmt: skip
    means = [row for row in rows if abs(row["curve_mean"] - row["curve_at_mean"]) > OFF]
    axes.plot(
        column(means, "diameter_m") * 1e6, column(means, "curve_mean"), "_", ms=4.5, mew=0.9,
        color=TICK, zorder=6, gid=f"{name}-means",
    )  # fmt: skip
    axes.plot(
        size, share, look.marker, ms=2.8, mew=0.4, mec="white", color=look.colour, zorder=5,
        gid=f"{name}-classes",
    )  # fmt: skip


def _draw_curve(axes: Axes, rows: list[Row], look: Look, name: str) -> None:
    size = column(rows, "diameter_m") * 1e6
    axes.fill_between(
        size, column(rows, "ci_low"), column(rows, "ci_high"), color=look.colour, alpha=0.25,
        linewidth=0, gid=f"{name}-band",
    )  # fmt: skip
    share = column(rows, "partition_to_coarse")
    axes.plot(size, share, color=look.colour, linestyle=look.line, gid=f"{name}-curve")


def _handle(look: Look) -> Line2D:
    return Line2D([], [], color=look.colour, linestyle=look.line, marker=look.marker, ms=2.8,
                  mew=0.4, mec="white")  # fmt: skip


def _range(rows: list[Row]) -> tuple[float, float]:
    """Limits of the size axis, um."""
    low = min(row["diameter_low_m"] for row in rows) * 1e6
    high = max(row["diameter_high_m"] for row in rows) * 1e6
    return low / 1.03, high * 1.03
