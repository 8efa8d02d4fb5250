"""Overlay of a measured partition curve on the computed one, and what parts them below it."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from elutria.comparing.compare import Comparison, interval
from elutria.output.settings import Row, column
from elutria.output.style import MATERIAL_COLOURS, STYLE, legend_above, new_figure, size_axis

OURS, THEIRS = MATERIAL_COLOURS[:2]
LIMIT = 1.959964


def comparison_figure(
    found: Comparison, curve: list[Row], title: str, coarse: str = "coarse"
) -> Figure:
    """The curve's rows (curve.csv) with their band, the measurement over them with its bars; below,
    the differences over their standard deviations, or alone where the measurement's is unknown."""
    with mpl.rc_context(STYLE):
        figure, (above, below) = new_figure(105, rows=2, sharex=True, height_ratios=(2.4, 1))
        size = column(curve, "diameter_m") * 1e6
        band = above.fill_between(
            size, column(curve, "ci_low"), column(curve, "ci_high"), color=OURS, alpha=0.25, lw=0
        )
        (line,) = above.plot(size, column(curve, "partition_to_coarse"), color=OURS)
        measured = found.measured
        at, share = measured.diameter * 1e6, measured.share
        low, high = interval(measured)
        bars = np.array([share - low, high - share])
        widths = np.array([at - measured.low * 1e6, measured.high * 1e6 - at])
        points = above.errorbar(
            at, share, yerr=bars if measured.deviation is not None else None,
            xerr=widths if measured.of_classes else None, fmt="o", ms=3, color=THEIRS, lw=0.8,
        )  # fmt: skip
        handles: list[Any] = [(band, line), points]
        labels = ["computed, 95 % band", "measured, 95 %"]
        if measured.of_classes:
            handles.append(above.plot(at, found.ours, "_", ms=5, color="0.1", zorder=6)[0])
            labels.append("computed, class mean")
        above.axhline(0.5, color="0.6", linewidth=0.5, linestyle=":", zorder=0)
        above.set_ylim(-0.03, 1.03)
        above.set_ylabel(f"mass share to {coarse}  $T$")
        above.text(0.03, 0.94, title, transform=above.transAxes, va="top", fontsize=7)
        known = measured.deviation is not None
        off = found.standardised if known else found.ours - share
        below.plot(at, off, "o", ms=3, color=THEIRS)
        below.axhline(0, color="0.4", linewidth=0.6)
        if known:
            below.axhspan(-LIMIT, LIMIT, color="0.9", zorder=0)
        below.set_ylabel("difference/\nstd. deviation" if known else "difference")
        below.set_xlabel("particle diameter  $d$  (µm)")
        ends = [*size[[0, -1]], at.min(), at.max()]
        size_axis(below, min(ends) / 1.03, max(ends) * 1.03)
        legend_above(figure, handles, labels)
        figure.align_ylabels()
    return figure
