"""d50 with its interval, and d25 to d75, over what was varied, beside the plug-flow theory."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from elutria.output.settings import Array, Row, Settings, column, materials_of, spoken
from elutria.output.style import (
    LINES,
    MARKERS,
    MATERIAL_COLOURS,
    legend_above,
    log_if_wide,
    new_figure,
)
from elutria.tables import VELOCITY, short, shown

Series = tuple[str, tuple[Any, ...]]


def cut_size_figure(settings: Settings, summary: list[Row], lines: list[Row]) -> Figure:
    """A series per material and combination of the other settings, over the first one varied."""
    along = settings.varied[0]
    others = [name for name in settings.varied if name != along]
    series: dict[Series, list[Row]] = {}
    for row in summary:
        if row["material"] != "all":
            key = (row["material"], tuple(row[name] for name in others))
            series.setdefault(key, []).append(row)
    figure, (axes,) = new_figure(62 + 4 * (len(series) if len(series) > 1 else 0) // 2)
    words = words_of(settings, along)
    for number, rows in enumerate(series.values()):
        at = [float(words.index(row[along]) if words else row[along]) for row in rows]
        _draw(axes, rows, np.array(at), number)
    if along == VELOCITY and lines:
        _draw_theory(axes, materials_of(summary), lines, [material for material, _ in series])
    axes.set_xlabel("gas velocity  $U$  (m/s)" if along == VELOCITY else short(along))
    axes.set_ylabel("cut size  $d_{50}$  (µm)")
    _scale(axes, "y", column(summary, "d50_m") * 1e6)
    if words:
        axes.set_xticks(range(len(words)), [shown(word) for word in words])
        axes.set_xlim(-0.5, len(words) - 0.5)
    else:
        _scale(axes, "x", column(summary, along))
    names = [_name(key, others) for key in series] if len(series) > 1 else []
    _legend(figure, names, lines if along == VELOCITY else [])
    return figure


def words_of(settings: Settings, along: str) -> list[Any]:
    """The values of a setting that are not all numbers, which stand side by side; else none."""
    values = settings.values(along)
    return values if any(isinstance(value, str) for value in values) else []


def _draw(axes: Axes, rows: list[Row], at: Array, number: int) -> None:
    colour = MATERIAL_COLOURS[number % len(MATERIAL_COLOURS)]
    cut, d25, d75, low, high = (
        column(rows, name) * 1e6 for name in ("d50_m", "d25_m", "d75_m", "d50_low_m", "d50_high_m")
    )
    axes.vlines(at, d25, d75, color=colour, linewidth=3.5, alpha=0.3)
    bars = np.array([cut - low, high - cut])
    bars[~np.isfinite(bars)] = 0  # an interval that is open at this end
    axes.errorbar(
        at, cut, yerr=np.maximum(bars, 0), fmt=MARKERS[number % len(MARKERS)], color=colour,
        capsize=2, elinewidth=0.8, capthick=0.8, **_marks(number),
    )  # fmt: skip


def _marks(number: int) -> dict[str, Any]:
    """Marks of a series: those of all but the first are hollow, and hide none below them."""
    full = {"ms": 3.4, "mew": 0.4, "mec": "white"}
    return full if number == 0 else {"ms": 4.2 + 0.8 * (number - 1), "mew": 0.9, "mfc": "none"}


def _draw_theory(axes: Axes, materials: list[str], lines: list[Row], drawn: list[str]) -> None:
    for material in materials:
        rows = [row for row in lines if row["material"] == material]
        number = drawn.index(material)
        axes.plot(
            column(rows, VELOCITY), column(rows, "cut_size_m") * 1e6, linestyle=LINES[1],
            color=MATERIAL_COLOURS[number % len(MATERIAL_COLOURS)], linewidth=0.8, zorder=1,
        )  # fmt: skip


def _scale(axes: Axes, axis: str, values: Array) -> None:
    """From 0, or logarithmic where a decade is crossed."""
    values = values[np.isfinite(values) & (values > 0)]
    if not values.size or not log_if_wide(axes, values.min(), values.max(), axis):
        axes.set(**{f"{axis}lim": (0, None)})


def _name(key: Series, others: list[str]) -> str:
    material, values = key
    words = [spoken(name, value) for name, value in zip(others, values, strict=True)]
    return ", ".join([material, *words])


def _legend(figure: Figure, names: list[str], lines: list[Row]) -> None:
    """What the marks mean, and the series where there is more than one."""
    colour = "0.35" if names else MATERIAL_COLOURS[0]
    handles: list[Any] = [
        Line2D([], [], color=colour, marker="|", ms=7, mew=0.8, linestyle="none"),
        Line2D([], [], color=colour, linewidth=3.5, alpha=0.3, solid_capstyle="butt"),
    ]
    labels = ["95 % interval of $d_{50}$", "$d_{25}$ to $d_{75}$"]
    if lines:
        handles.append(Line2D([], [], color=colour, linewidth=0.8, linestyle=LINES[1]))
        labels.append(f"$v_t = U$ ({lines[0]['law']})")
    for number, name in enumerate(names):
        shade = MATERIAL_COLOURS[number % len(MATERIAL_COLOURS)]
        marker = MARKERS[number % len(MARKERS)]
        handles.append(
            Line2D([], [], color=shade, marker=marker, linestyle="none", **_marks(number))
        )
        labels.append(name)
    legend_above(figure, handles, labels)
