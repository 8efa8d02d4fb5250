"""Contours of the cut size and of the yield over two settings, with the points that were run."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from elutria.output.settings import Row, Settings, column, materials_of
from elutria.output.style import log_if_wide, new_figure
from elutria.tables import VELOCITY, short

Array = NDArray[np.float64]
Names = tuple[str, str]

WIDE = 10.0
"""Ratio of a setting's values from which on logarithms tell them apart better."""


def contour_settings(settings: Settings, rows: Sequence[Row]) -> Names | None:
    """The two settings over which contours can be drawn: exactly two vary, both are numbers, and
    the points do not lie on one line."""
    names = settings.varied
    if len(names) != 2 or any(isinstance(row[name], str) for row in rows for name in names):
        return None
    x, y = (_scaled(rows, name) for name in names)
    spread = np.linalg.svd(np.column_stack([x - x.mean(), y - y.mean()]), compute_uv=False)
    return (names[0], names[1]) if spread[-1] > 1e-6 * spread[0] else None


def contour_figure(
    settings: Settings, rows: Sequence[Row], names: Names, fines: str = "fines"
) -> Figure:
    """d50 of each material and the yield of `fines` over the settings `names`.

    Between the points it is linear; beyond them nothing is drawn.
    """
    materials = materials_of(rows)
    panels = [(name, "d50_m", 1e6, f"$d_{{50}}$ (µm){_of(name, materials)}") for name in materials]
    panels.append(("all", "fines_yield", 1.0, f"yield of {fines}"))
    figure, axes = new_figure(58 * len(panels), len(panels), sharex=True)
    for place, (material, name, scale, title) in zip(axes, panels, strict=True):
        known = [row for row in rows if row["material"] == material and np.isfinite(row[name])]
        x, y = (column(known, name) for name in names)
        value = column(known, name) * scale
        if known and contour_settings(settings, known) == names and np.ptp(value) > 0:
            triangles = Triangulation(_scaled(known, names[0]), _scaled(known, names[1])).triangles
            filled = place.tricontourf(
                Triangulation(x, y, triangles), value, levels=9, cmap="viridis"
            )
            figure.colorbar(filled, ax=place)
        place.plot(x, y, "o", ms=3, color="white", mec="black", mew=0.6, clip_on=False, zorder=5)
        place.set_title(title, fontsize=mpl.rcParams["axes.labelsize"])
        place.set_ylabel(_label(names[1]))
        for other, axis in zip(names, "xy", strict=True):
            values = column(rows, other)
            log_if_wide(place, float(values.min()), float(values.max()), axis)
    axes[-1].set_xlabel(_label(names[0]))
    return figure


def _label(name: str) -> str:
    return "gas velocity  $U$  (m/s)" if name == VELOCITY else short(name)


def _of(name: str, materials: list[str]) -> str:
    return f", {name}" if len(materials) > 1 else ""


def _scaled(rows: Sequence[Row], name: str) -> Array:
    """A setting's values from 0 to 1 as the figure's axis has them."""
    values = column(rows, name)
    if values.min() > 0 and values.max() / values.min() >= WIDE:
        values = np.log(values)
    scaled: Array = (values - values.min()) / max(float(np.ptp(values)), 1e-300)
    return scaled
