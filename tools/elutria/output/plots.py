"""The figures, drawn from the csv files alone, at the width of a paper's column (85 mm)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from elutria import tables
from elutria.errors import InputError
from elutria.files import atomic_write, read_csv

Array = NDArray[np.float64]
Row = dict[str, Any]

COLUMN_WIDTH = 85 / 25.4
"""Inches."""

STYLE: Any = {
    "font.size": 8,
    "axes.labelsize": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.1,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "legend.frameon": False,
    "legend.handlelength": 1.4,
    "savefig.dpi": 300,
    "figure.constrained_layout.use": True,
}
# Okabe and Ito's colours, told apart by all
MATERIAL_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")


def write_figures(folder: Path) -> list[Path]:
    """All figures of RESULTS from its csv files. Raises InputError when they are not there."""
    # of results of before warnings were counted, too
    columns = [name for name in tables.SUMMARY if name != "warnings"]
    summary = read_csv(folder / "summary.csv", columns)
    partition = read_csv(folder / "partition.csv", tables.PARTITION)
    if not summary or not partition:
        raise InputError(f"{folder / 'summary.csv'}: holds no rows; nothing to draw")
    curves = _optional(folder / "curve.csv", tables.CURVE)
    lines = _optional(folder / "theory.csv", tables.THEORY)
    with mpl.rc_context(STYLE):
        figures = {
            "partition_curves.png": partition_figure(partition, curves),
            "cut_size.png": cut_size_figure(summary, lines),
            "size_distributions.png": size_figure(partition),
        }
        for figure in figures.values():
            _caption(figure, summary)
        return [save(figure, folder / name) for name, figure in figures.items()]


def _caption(figure: Figure, summary: list[Row]) -> None:
    """Below a figure: at which velocities runs have warnings."""
    warned = {row["gas_velocity_m_s"] for row in summary if row.get("warnings", 0) > 0}
    if warned:
        speeds = ", ".join(f"{speed:g}" for speed in sorted(warned))
        figure.supxlabel(
            f"With warnings (warnings.json of the runs): {speeds} m/s", fontsize=6, color="0.35"
        )


def save(figure: Figure, path: Path) -> Path:
    """Write a figure atomically."""
    with atomic_write(path) as temporary:
        figure.savefig(temporary)
    return path


def new_figure(height_mm: float, rows: int = 1, **options: Any) -> tuple[Figure, list[Axes]]:
    """A figure of column width with `rows` axes above each other."""
    figure = Figure(figsize=(COLUMN_WIDTH, height_mm / 25.4))
    axes = figure.subplots(rows, 1, squeeze=False, **options)[:, 0]
    return figure, list(axes)


def velocity_colours(velocities: list[float]) -> dict[float, Any]:
    """Viridis from dark to light, without its faintest end."""
    shares = np.linspace(0.0, 0.88, max(len(velocities), 2))
    colours = mpl.colormaps["viridis"](shares)
    return dict(zip(velocities, colours, strict=False))


def size_axis(axes: Axes, low: float, high: float) -> None:
    """Logarithmic x axis in um, labelled with plain numbers at 1, 2, 5 of each decade."""
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    marks = (1.0, 2.0, 3.0, 5.0) if high / low < 30 else (1.0, 2.0, 5.0)
    axes.xaxis.set_major_locator(LogLocator(base=10, subs=marks))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes.xaxis.set_minor_locator(LogLocator(base=10, subs=tuple(range(1, 10))))
    axes.xaxis.set_minor_formatter(NullFormatter())


def partition_figure(partition: list[Row], curves: list[Row]) -> Figure:
    """T(d) of all velocities, one panel per material: fitted curves with 95 % bands, and classes
    with theirs.

    Classes of which next to nothing is known are left out; partition.csv has them.
    """
    materials = _materials(partition)
    velocities = _velocities(partition)
    colours = velocity_colours(velocities)
    known = [row for row in partition if row["ci_high"] - row["ci_low"] < 0.5]
    figure, panels = new_figure(16 + 58 * len(materials), len(materials), sharex=True)
    for axes, material in zip(panels, materials, strict=True):
        for velocity in velocities:
            colour = colours[velocity]
            classes = _select(known, velocity, material)
            _draw_classes(axes, classes, colour)
            _draw_curve(axes, _within(_select(curves, velocity, material), classes), colour)
            axes.plot([], [], "o-", ms=2.2, mew=0, color=colour, label=f"{velocity:g} m/s")
        axes.axhline(0.5, color="0.6", linewidth=0.5, linestyle=":", zorder=0)
        axes.set_ylim(-0.02, 1.02)
        axes.set_ylabel("mass share to coarse  $T$")
        if len(materials) > 1:
            axes.text(0.03, 0.93, material, transform=axes.transAxes, va="top")
        size_axis(axes, *_size_range(known or partition))
    panels[-1].set_xlabel("particle diameter  $d$  (µm)")
    _legend_above(figure, panels[0])
    return figure


def _within(curve: list[Row], classes: list[Row]) -> list[Row]:
    """The part of a curve over the classes that are drawn."""
    if not classes:
        return []
    low, high = classes[0]["diameter_m"], classes[-1]["diameter_m"]
    return [row for row in curve if low <= row["diameter_m"] <= high]


def _draw_classes(axes: Axes, rows: list[Row], colour: Any) -> None:
    share = _column(rows, "partition_to_coarse")
    bars = np.array([share - _column(rows, "ci_low"), _column(rows, "ci_high") - share])
    axes.errorbar(
        _column(rows, "diameter_m") * 1e6, share, yerr=np.maximum(bars, 0), fmt="o", ms=2.2, mew=0,
        color=colour, ecolor=(*colour[:3], 0.45), elinewidth=0.6,
    )  # fmt: skip


def _draw_curve(axes: Axes, rows: list[Row], colour: Any) -> None:
    size = _column(rows, "diameter_m") * 1e6
    axes.fill_between(
        size, _column(rows, "ci_low"), _column(rows, "ci_high"),
        color=colour, alpha=0.25, linewidth=0,
    )  # fmt: skip
    axes.plot(size, _column(rows, "partition_to_coarse"), color=colour)


def cut_size_figure(summary: list[Row], lines: list[Row]) -> Figure:
    """d50 with its interval, and d25 to d75, against gas velocity beside the plug-flow theory."""
    materials = _materials(summary)
    figure, (axes,) = new_figure(66)
    for number, material in enumerate(materials):
        colour = MATERIAL_COLOURS[number % len(MATERIAL_COLOURS)]
        rows = [row for row in summary if row["material"] == material]
        speed = _column(rows, "gas_velocity_m_s")
        cut, d25, d75, low, high = (
            _column(rows, name) * 1e6
            for name in ("d50_m", "d25_m", "d75_m", "d50_low_m", "d50_high_m")
        )
        axes.vlines(speed, d25, d75, color=colour, linewidth=3.5, alpha=0.3)
        bars = np.array([cut - low, high - cut])
        bars[~np.isfinite(bars)] = 0  # an interval that is open at this end
        axes.errorbar(
            speed, cut, yerr=np.maximum(bars, 0), fmt="o", ms=3, color=colour,
            capsize=2, elinewidth=0.8, capthick=0.8,
        )  # fmt: skip
        curve = [row for row in lines if row["material"] == material]
        axes.plot(
            _column(curve, "gas_velocity_m_s"), _column(curve, "cut_size_m") * 1e6, "--",
            color=colour, linewidth=0.9,
        )  # fmt: skip
    axes.set_xlabel("gas velocity  $U$  (m/s)")
    axes.set_ylabel("cut size  $d_{50}$  (µm)")
    axes.set_xlim(left=0)
    axes.set_ylim(0, 1.2 * axes.get_ylim()[1])  # room for the legend
    _cut_size_legend(axes, materials, lines)
    return figure


def _cut_size_legend(axes: Axes, materials: list[str], lines: list[Row]) -> None:
    """What the marks mean, and the colours where there is more than one material."""
    colour = MATERIAL_COLOURS[0] if len(materials) == 1 else "0.35"
    handles: list[Any] = [
        axes.errorbar([], [], yerr=[], fmt="o", ms=3, capsize=2, elinewidth=0.8, color=colour),
        Line2D([], [], color=colour, linewidth=3.5, alpha=0.3),
    ]
    labels = ["$d_{50}$ with 95 % interval", "$d_{25}$ to $d_{75}$"]
    if lines:
        handles.append(Line2D([], [], color=colour, linewidth=0.9, linestyle="--"))
        labels.append(f"terminal velocity $= U$ ({lines[0]['law']})")
    if len(materials) > 1:
        for name, shade in zip(materials, MATERIAL_COLOURS, strict=False):
            handles.append(Line2D([], [], color=shade, linewidth=2))
            labels.append(name)
    axes.legend(handles, labels, loc="upper left")


def size_figure(partition: list[Row]) -> Figure:
    """Mass of feed, fines and coarse per decade of size, relative to the feed; per velocity."""
    velocities = _velocities(partition)
    colours = velocity_colours(velocities)
    figure, panels = new_figure(110, 2, sharex=True, sharey=True)
    products = (("fines", "fines_kg"), ("coarse", "coarse_kg"))
    for axes, (product, column) in zip(panels, products, strict=True):
        for number, velocity in enumerate(velocities):
            rows = _select(partition, velocity, "all")
            width = np.log10(_column(rows, "diameter_high_m") / _column(rows, "diameter_low_m"))
            feed = _column(rows, "feed_kg")
            if number == 0:
                _outline(axes, rows, feed / feed.sum() / width, "0.35", "feed", 0.9)
            colour, share = colours[velocity], _column(rows, column) / feed.sum() / width
            _outline(axes, rows, share, colour, f"{velocity:g} m/s", 1.1)
        axes.set_ylabel(r"$\mathrm{d}m / (m_\mathrm{feed}\,\mathrm{d}\log_{10} d)$")
        axes.text(0.03, 0.93, product, transform=axes.transAxes, va="top")
        size_axis(axes, *_size_range(partition))
    panels[0].set_ylim(bottom=0)
    panels[-1].set_xlabel("particle diameter  $d$  (µm)")
    _legend_above(figure, panels[0])
    return figure


def _outline(
    axes: Axes, rows: list[Row], values: Array, colour: Any, label: str, width: float
) -> None:
    """Stairs over the classes; classes that hold nothing are gaps at zero."""
    low, high = _column(rows, "diameter_low_m") * 1e6, _column(rows, "diameter_high_m") * 1e6
    x = np.column_stack([low, low, high, high]).ravel()
    zero = np.zeros_like(values)
    y = np.column_stack([zero, values, values, zero]).ravel()
    joined = np.isclose(low[1:], high[:-1])
    keep = np.ones(x.size, dtype=bool)
    keep[3:-1:4] = ~joined
    keep[4::4] = ~joined
    axes.plot(x[keep], y[keep], color=colour, label=label, linewidth=width)


def _legend_above(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    columns = len(labels) if len(labels) < 5 else min(5, -(-len(labels) // 2))
    figure.legend(
        handles, labels, loc="outside upper center", ncols=columns,
        columnspacing=1.0, handletextpad=0.4,
    )  # fmt: skip


def _optional(path: Path, columns: tuple[str, ...]) -> list[Row]:
    return read_csv(path, columns) if path.exists() or path.is_symlink() else []


def _column(rows: list[Row], name: str) -> Array:
    return np.array([row[name] for row in rows], dtype=float)


def _select(rows: list[Row], velocity: float, material: str) -> list[Row]:
    return [
        row for row in rows
        if row["gas_velocity_m_s"] == velocity and row["material"] == material
    ]  # fmt: skip


def _velocities(rows: list[Row]) -> list[float]:
    return sorted({row["gas_velocity_m_s"] for row in rows})


def _materials(rows: list[Row]) -> list[str]:
    """Materials in their order, without `all`."""
    return [name for name in dict.fromkeys(row["material"] for row in rows) if name != "all"]


def _size_range(partition: list[Row]) -> tuple[float, float]:
    """Limits of the size axis, um."""
    low = min(row["diameter_low_m"] for row in partition) * 1e6
    high = max(row["diameter_high_m"] for row in partition) * 1e6
    return low / 1.05, high * 1.05
