"""Size distributions: the feed behind, the products as filled steps, a panel per setting."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from elutria.classification.partition import class_limits
from elutria.output.settings import Array, Row, Settings, column, products_of
from elutria.output.style import (
    COLUMN_WIDTH,
    HATCHES,
    LINES,
    MATERIAL_COLOURS,
    legend_above,
    size_axis,
)

ONE_COLUMN = 3
"""Up to so many settings, the panels stand above each other; more are small multiples."""


def size_figure(
    settings: Settings, partition: list[Row], names: Mapping[str, str]
) -> tuple[Figure, list[Row]]:
    """Mass per decade of size, relative to the feed's, and the rows that are drawn. `names`: of
    the products, as the case has them."""
    products = products_of(partition)
    number = len(settings.all)
    across = 1 if number <= ONE_COLUMN else 2 if number <= 8 else 3
    down = -(-number // across)
    height = (14 + (40 if across == 1 else 32) * down) / 25.4
    figure = Figure(figsize=(COLUMN_WIDTH, height))
    panels = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    drawn = []
    for k, axes in enumerate(panels.ravel()):
        if k >= number:
            axes.set_visible(False)
            continue
        rows = densities(settings.select(partition, settings.all[k], "all"), products)
        drawn += rows
        _draw(axes, rows, products)
        axes.text(0.04, 0.94, settings.label(settings.all[k]), transform=axes.transAxes, va="top",
                  fontsize=7)  # fmt: skip
        size_axis(axes, *_range(partition), (1.0, 3.0) if across > 1 else ())
        if k + across >= number:
            axes.tick_params(labelbottom=True)
            axes.set_xlabel("particle diameter  $d$  (µm)" if across < 3 else "$d$  (µm)")
    panels[0, 0].set_ylim(0, 1.15 * panels[0, 0].get_ylim()[1])
    figure.supylabel(r"$\mathrm{d}m / (m_\mathrm{feed}\,\mathrm{d}\log_{10} d)$", fontsize=8)
    handles = [Patch(facecolor="0.85", edgecolor="0.5", linewidth=0.6)]
    legend_above(figure, [*handles, *(_patch(n) for n in range(len(products)))],
                 ["feed", *(names[product] for product in products)])  # fmt: skip
    return figure, drawn


def densities(rows: list[Row], products: list[str]) -> list[Row]:
    """Classes of R 20 with the feed's and the products' mass per decade over the feed's mass."""
    rows = _joined(rows, ("feed", *products))
    total = float(column(rows, "feed_kg").sum())
    found = []
    for row in rows:
        width = float(np.log10(row["diameter_high_m"] / row["diameter_low_m"])) * total
        amounts = {f"{name}_per_decade": row[f"{name}_kg"] / width for name in ("feed", *products)}
        found.append({**row, **amounts})
    return found


def _joined(rows: list[Row], names: tuple[str, ...]) -> list[Row]:
    """The rows of a partition table, whose classes follow the cut, in classes of R 20."""
    limits = class_limits(rows[0]["diameter_low_m"], rows[-1]["diameter_high_m"])
    middles = np.sqrt(column(rows, "diameter_low_m") * column(rows, "diameter_high_m"))
    place = np.searchsorted(limits, middles) - 1
    found = []
    for k in np.unique(place):
        own = [row for row, where in zip(rows, place, strict=True) if where == k]
        masses = {f"{name}_kg": float(column(own, f"{name}_kg").sum()) for name in names}
        ends = {"diameter_low_m": float(limits[k]), "diameter_high_m": float(limits[k + 1])}
        found.append({**own[0], **masses, **ends})
    return found


def _draw(axes: Axes, rows: list[Row], products: list[str]) -> None:
    x, y = steps(rows, column(rows, "feed_per_decade"))
    axes.fill_between(x, y, color="0.85", linewidth=0, zorder=1)
    axes.plot(x, y, color="0.5", linewidth=0.6, zorder=1)
    for number, product in enumerate(products):
        x, y = steps(rows, column(rows, f"{product}_per_decade"))
        colour = MATERIAL_COLOURS[number % len(MATERIAL_COLOURS)]
        axes.fill_between(x, y, facecolor=(colour, 0.3), linewidth=0, zorder=2)
        # apart from the fill: SVG hatches know no transparency
        axes.fill_between(x, y, facecolor="none", edgecolor=colour, linewidth=0,
                          hatch=HATCHES[number % len(HATCHES)], zorder=2)  # fmt: skip
        axes.plot(x, y, color=colour, linewidth=0.9, linestyle=LINES[number % len(LINES)], zorder=3)


def _patch(number: int) -> Any:
    colour = MATERIAL_COLOURS[number % len(MATERIAL_COLOURS)]
    red, green, blue = (0.3 * share + 0.7 for share in to_rgb(colour))
    return Patch(facecolor=(red, green, blue), edgecolor=colour, linewidth=0.6,
                 hatch=HATCHES[number % len(HATCHES)])  # fmt: skip


def steps(rows: list[Row], values: Array) -> tuple[Array, Array]:
    """Stairs over the classes (um); classes that hold nothing are gaps at zero."""
    low, high = column(rows, "diameter_low_m") * 1e6, column(rows, "diameter_high_m") * 1e6
    x = np.column_stack([low, low, high, high]).ravel()
    zero = np.zeros_like(values)
    y = np.column_stack([zero, values, values, zero]).ravel()
    joined = np.isclose(low[1:], high[:-1])
    keep = np.ones(x.size, dtype=bool)
    keep[3:-1:4] = ~joined
    keep[4::4] = ~joined
    return x[keep], y[keep]


def _range(partition: list[Row]) -> tuple[float, float]:
    low = min(row["diameter_low_m"] for row in partition) * 1e6
    high = max(row["diameter_high_m"] for row in partition) * 1e6
    return low / 1.03, high * 1.03
