"""Figures of the book: axes with their names and legend."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from elutria.output.style import MATERIAL_COLOURS as COLOURS
from elutria.output.style import new_figure

__all__ = ["BLUE", "COLOURS", "GREEN", "RED", "label", "new_figure"]

BLUE, RED, GREEN = COLOURS[:3]


def label(axes: Axes, x: str, y: str, lines: str = "", **legend: Any) -> None:
    """Names of both axes and a legend; `lines` says what lines stand for, where dots are ours."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if lines:
        legend |= {"title": f"lines: {lines}; dots: elutriaFoam", "title_fontsize": 7}
    axes.legend(**legend)
