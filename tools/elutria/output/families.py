"""Figures of runs that differ in more than their gas velocity: families of curves, and contours."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from elutria import tables

Array = NDArray[np.float64]
Row = dict[str, Any]


def varied(rows: list[Row]) -> list[str]:
    """The settings of which rows have more than one value, gas velocity first."""
    names = [tables.VELOCITY, *tables.axes(rows)]
    return [name for name in names if len({row[name] for row in rows}) > 1]


def along(rows: list[Row]) -> str:
    """The setting that the figures' x axis shows: the gas velocity, or the one that varies."""
    numbers = [name for name in varied(rows) if _is_number(rows, name)]
    return numbers[0] if numbers else tables.VELOCITY


def families(rows: list[Row], apart: str = "") -> list[tuple[str, list[Row]]]:
    """Rows that differ in the gas velocity, or the setting `apart`, alone: with what they share."""
    apart = apart or tables.VELOCITY
    names = [name for name in varied(rows) if name != apart]
    found: dict[str, list[Row]] = {}
    for row in rows:
        shared = ", ".join(f"{label(name)} {tables.shown(row[name])}" for name in names)
        found.setdefault(shared, []).append(row)
    return list(found.items())


def label(name: str) -> str:
    """A setting as legends name it."""
    return "m/s" if name == tables.VELOCITY else tables.short(name)


def axis_label(name: str) -> str:
    """A setting as an axis names it."""
    return "gas velocity  $U$  (m/s)" if name == tables.VELOCITY else tables.short(name)


def contour_axes(rows: list[Row]) -> tuple[str, str] | None:
    """The two settings over which contours can be drawn: exactly two vary, both numbers, and the
    points do not lie on one line."""
    names = varied(rows)
    if len(names) != 2 or not all(_is_number(rows, name) for name in names):
        return None
    x, y = (_scaled(rows, name) for name in names)
    spread = np.linalg.svd(np.column_stack([x - x.mean(), y - y.mean()]), compute_uv=False)
    return (names[0], names[1]) if spread[-1] > 1e-6 * spread[0] else None


def contour_figure(rows: list[Row], width: float) -> Figure:
    """d50 of each material and the yield of fines over two settings, with the points that were
    run. Between the points it is linear; beyond them nothing is drawn."""
    names = contour_axes(rows)
    assert names is not None
    materials = [m for m in dict.fromkeys(row["material"] for row in rows) if m != "all"]
    panels = [(name, "d50_m", 1e6, f"$d_{{50}}$ (µm){_of(name, materials)}") for name in materials]
    panels.append(("all", "fines_yield", 1.0, "yield of fines"))
    figure = Figure(figsize=(width, 2.3 * len(panels)))
    axes = figure.subplots(len(panels), 1, squeeze=False, sharex=True)[:, 0]
    for place, (material, column, scale, title) in zip(axes, panels, strict=True):
        known = [row for row in rows if row["material"] == material and np.isfinite(row[column])]
        x, y = (np.array([row[name] for row in known], dtype=float) for name in names)
        value = np.array([row[column] for row in known], dtype=float) * scale
        if contour_axes(known) == names and np.ptp(value) > 0:
            triangles = Triangulation(_scaled(known, names[0]), _scaled(known, names[1])).triangles
            filled = place.tricontourf(x, y, triangles, value, levels=9, cmap="viridis")
            figure.colorbar(filled, ax=place)
        place.plot(x, y, "o", ms=3, color="white", mec="black", mew=0.6, clip_on=False, zorder=5)
        place.set_title(title, fontsize=mpl.rcParams["axes.labelsize"])
        place.set_ylabel(axis_label(names[1]))
        for name, scale_of, axis in (
            (names[0], place.set_xscale, place.xaxis),
            (names[1], place.set_yscale, place.yaxis),
        ):
            if _is_wide(rows, name):
                scale_of("log")
                axis.set_major_locator(LogLocator(base=10, subs=(1.0, 2.0, 5.0)))
                axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
                axis.set_minor_formatter(NullFormatter())
    axes[-1].set_xlabel(axis_label(names[0]))
    return figure


def _of(name: str, materials: list[str]) -> str:
    return f", {name}" if len(materials) > 1 else ""


def _is_number(rows: list[Row], name: str) -> bool:
    return all(isinstance(row[name], (int, float)) for row in rows)


def _is_wide(rows: list[Row], name: str) -> bool:
    """Whether a setting's values are better told apart by their logarithms."""
    values = [float(row[name]) for row in rows]
    return min(values) > 0 and max(values) / min(values) >= 8


def _scaled(rows: list[Row], name: str) -> Array:
    """A setting's values from 0 to 1 as the figure's axis has them."""
    values = np.array([row[name] for row in rows], dtype=float)
    if _is_wide(rows, name):
        values = np.log(values)
    scaled: Array = (values - values.min()) / max(float(np.ptp(values)), 1e-300)
    return scaled
