"""Warnings that follow from a run's tables: mass that is still inside, curves without a cut."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import isfinite, log
from typing import Any

from elutria.classification.events import DRAIN_TIME
from elutria.warned import Warned


def notes(
    summary: Iterable[Mapping[str, Any]],
    partition: Iterable[Mapping[str, Any]],
    curves: Iterable[Mapping[str, Any]],
    coarse: str = "coarse",
    ended_by: str = DRAIN_TIME,
) -> list[Warned]:
    """The warnings that follow from the rows of one gas velocity. `coarse`: the curve's product;
    `ended_by`: the entry that ended the run."""
    summary = list(summary)
    return [*inside(summary, partition, ended_by), *absent(summary, curves, coarse)]


def inside(
    summary: Iterable[Mapping[str, Any]],
    partition: Iterable[Mapping[str, Any]],
    ended_by: str,
    limit: float = 0.01,
) -> list[Warned]:
    """A warning where what had not left is more than `limit` of the feed's mass, or leaves d50 open
    by more than that: were all of it coarse, or all of it fines. Rows of one gas velocity."""
    here = [row for row in partition if row["material"] == "all"]
    fed = sum(row["feed_kg"] for row in here)
    if not fed:
        return []
    share = sum(row["inside_kg"] for row in here) / fed
    shift = 0.5 * sum(
        row["inside_kg"] / row["feed_kg"] * log(row["diameter_high_m"] / row["diameter_low_m"])
        for row in here
        if row["inside_kg"] > 0
    )
    if max(share, shift) <= limit:
        return []
    worst = max(here, key=lambda row: row["inside_kg"])
    has_cut = any(isfinite(row["d50_m"]) for row in summary)
    moved = f"; d50 may shift by up to {100 * shift:.3g} %" if has_cut else ""
    return [
        Warned(
            name="inside",
            what="a part of the feed is still in the column and left out of the curve",
            how_much=f"{100 * share:.3g} % of its mass, most of it near "
            f"{worst['diameter_m'] * 1e6:.4g} um{moved}",
            what_to_set=f"increase {ended_by}",
            size=max(share, shift),
        )
    ]


def absent(
    summary: Iterable[Mapping[str, Any]],
    curves: Iterable[Mapping[str, Any]],
    coarse: str = "coarse",
) -> list[Warned]:
    """A warning for each curve that lacks d25, d50 or d75. Rows of one gas velocity."""
    found = []
    summary, curves = list(summary), list(curves)
    alone = len({row["material"] for row in summary} - {"all"}) == 1
    for row in summary:
        if alone and row["material"] == "all":
            continue
        missing = [name for name in ("d25", "d50", "d75") if row[f"{name}_m"] != row[f"{name}_m"]]
        curve = [point for point in curves if point["material"] == row["material"]]
        if missing and curve:
            size, share = ([point[name] for point in (curve[0], curve[-1])]
                           for name in ("diameter_m", "partition_to_coarse"))  # fmt: skip
            found.append(
                Warned(
                    name="noCut",
                    what=f"the curve of {row['material']} has no {', '.join(missing)}",
                    how_much=f"of the sizes that left, {_per_cent(share[0])} % of "
                    f"{1e6 * size[0]:.4g} um and {_per_cent(share[1])} % of {1e6 * size[1]:.4g} um "
                    f"go to {coarse}",
                    what_to_set="feed sizes on both sides of the cut (sizeDistribution of "
                    "constant/feed), or choose another gas velocity",
                    size=len(missing),
                )
            )
    return found


def _per_cent(share: float) -> str:
    """Three digits, none of them below a hundredth of a per cent."""
    return f"{round(100 * share, 2):.3g}"
