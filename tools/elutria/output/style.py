"""How figures look: at the width of a paper's column (85 mm), told apart without colour too."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from elutria.files import atomic_write

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
    "hatch.linewidth": 0.4,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "legend.frameon": False,
    "legend.handlelength": 2.2,
    "savefig.dpi": 300,
    "svg.hashsalt": "elutria",
    "pdf.fonttype": 42,
    "figure.constrained_layout.use": True,
}
# Okabe and Ito's colours, told apart by all
MATERIAL_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
LINES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (5, 1.5, 1, 1.5)), (0, (1.2, 1.2)))
HATCHES = ("////", "\\\\\\\\", "....", "xxxx", "||||", "----")


@dataclass(frozen=True)
class Look:
    """Colour, marker and line style of one series."""

    colour: Any
    marker: str
    line: Any


def looks(number: int) -> list[Look]:
    """Of an ordered series: viridis from dark to light, without its faintest end."""
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, max(number, 2)))
    return [
        Look(tuple(colours[k]), MARKERS[k % len(MARKERS)], LINES[k % len(LINES)])
        for k in range(number)
    ]


def save(figure: Figure, path: Path) -> Path:
    """Write a figure atomically; the format is the suffix'."""
    dated = path.suffix in (".svg", ".pdf")
    with atomic_write(path) as temporary:
        # without a date: the same tables give the same file
        key = {".svg": "Date", ".pdf": "CreationDate"}.get(path.suffix, "")
        figure.savefig(temporary, metadata={key: None} if dated else None)
    return path


def new_figure(height_mm: float, rows: int = 1, **options: Any) -> tuple[Figure, list[Axes]]:
    """A figure of column width with `rows` axes above each other."""
    figure = Figure(figsize=(COLUMN_WIDTH, height_mm / 25.4))
    axes = figure.subplots(rows, 1, squeeze=False, **options)[:, 0]
    return figure, list(axes)


def size_axis(axes: Axes, low: float, high: float, marks: Sequence[float] = ()) -> None:
    """Logarithmic x axis in um, labelled with plain numbers at 1, 2, 5 of each decade."""
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    marks = marks or ((1.0, 2.0, 3.0, 5.0) if high / low < 30 else (1.0, 2.0, 5.0))
    _plain_log(axes.xaxis, marks)


def log_if_wide(axes: Axes, low: float, high: float, axis: str) -> bool:
    """Make the axis (`x` or `y`) logarithmic when values from `low` to `high` cross a decade."""
    if not (low > 0 and high / low >= 10):
        return False
    axes.set(**{f"{axis}scale": "log"})
    _plain_log(getattr(axes, f"{axis}axis"), (1.0, 2.0, 5.0))
    return True


def _plain_log(axis: Any, marks: Sequence[float]) -> None:
    axis.set_major_locator(LogLocator(base=10, subs=tuple(marks)))
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.set_minor_locator(LogLocator(base=10, subs=tuple(range(1, 10))))
    axis.set_minor_formatter(NullFormatter())


def legend_above(figure: Figure, handles: Sequence[Any], labels: Sequence[str]) -> None:
    """The legend of all figures: above the axes, in as few rows as fit."""
    longest = max((len(re.sub(r"[${}_\\]", "", label)) for label in labels), default=1)
    most = max(int(68 / (longest + 7)), 1)
    rows = -(-len(labels) // most)
    figure.legend(
        handles, labels, loc="outside upper center", ncols=-(-len(labels) // max(rows, 1)),
        columnspacing=1.0, handletextpad=0.4,
    )  # fmt: skip
