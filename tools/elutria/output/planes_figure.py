"""What planes counted: where material sits, and the stage model beside what left."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, sqrt
from typing import Any

from matplotlib.figure import Figure

from elutria.output.style import looks, new_figure, size_axis

Row = dict[str, Any]


def planes_figure(zones: Sequence[Row], stages: Sequence[Row]) -> Figure:
    """Seconds a grain spends in each zone, for a fine, a middling and a coarse class, above; shares
    to the last product over size, below. Of the material with most parcels."""
    material = _main_material(stages)
    stages = [row for row in stages if row["material"] == material]
    figure, (held, shares) = new_figure(110, rows=2, gridspec_kw={"height_ratios": (1, 1)})
    own = [row for row in zones if row["material"] == material]
    chosen = _chosen(stages)
    for stage, look in zip(chosen, looks(len(chosen)), strict=True):
        rows = [row for row in own if row["diameter_low_m"] == stage["diameter_low_m"]]
        held.stairs(
            [row["residence_time_s"] for row in rows],
            [k - 0.5 for k in range(len(rows) + 1)],
            color=look.colour, ls=look.line, label=f"{1e6 * _middle(stage):.0f} µm",
        )  # fmt: skip
    held.set_xlabel("zone, 0 below the lowest plane")
    held.set_ylabel("stay of a grain  (s)")
    held.set_yscale("symlog", linthresh=0.01)
    held.legend(frameon=False, ncols=len(chosen), loc="lower center", bbox_to_anchor=(0.5, 1.0))
    size = [1e6 * _middle(row) for row in stages]
    shares.errorbar(
        size, [row["partition"] for row in stages],
        [2 * row["partition_error"] for row in stages],
        fmt="o", ms=3, color="0.2", label="left (95 %)",
    )  # fmt: skip
    shares.plot(
        size, [row["partition_by_stages"] for row in stages], "-", color="C0", label="equal stages"
    )
    shares.plot(
        size, [row["partition_by_memory"] for row in stages], "--", color="C1", label="with memory"
    )
    size_axis(shares, 0.95 * min(size), 1.05 * max(size))
    shares.set_ylim(-0.05, 1.05)
    shares.set_xlabel("diameter  (µm)")
    shares.set_ylabel("share to the last product")
    shares.legend(frameon=False)
    figure.suptitle(material, fontsize="medium")
    return figure


def _main_material(stages: Sequence[Row]) -> str:
    names = list(dict.fromkeys(str(row["material"]) for row in stages))
    return max(names, key=lambda name: sum(r["parcels"] for r in stages if r["material"] == name))


def _middle(row: Row) -> float:
    return sqrt(row["diameter_low_m"] * row["diameter_high_m"])


def _chosen(stages: Sequence[Row]) -> list[Row]:
    """The classes whose share is nearest to 0.1, 0.5 and 0.9."""
    known = [row for row in stages if isfinite(row["partition"])]
    found = [min(known, key=lambda row: abs(row["partition"] - t)) for t in (0.1, 0.5, 0.9)]
    return list({row["diameter_low_m"]: row for row in found}.values())
