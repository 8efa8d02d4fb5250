"""The accuracy benchmark's page: advice, the target beside stock, and all points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot, isfinite, sqrt
from typing import Any

from elutria_validation.benchmarks import uncertainty
from elutria_validation.benchmarks.accuracy_error import ERRORS, beside_stock, known_error
from elutria_validation.benchmarks.accuracy_figure import QUANTITIES
from elutria_validation.benchmarks.accuracy_reference import Reference
from elutria_validation.benchmarks.accuracy_runs import (
    COURANT,
    DENSE,
    DRAIN_TIME,
    FEED_TIME,
    FINE,
    PLAN,
    SLOW,
    STEP,
    STOCK_LIKE,
)
from elutria_validation.benchmarks.accuracy_stock import LATER
from elutria_validation.book.page import templates
from elutria_validation.harness.provenance import machine

TEXTS = ("scene", "point", "kind", "extrapolated", "note")
COLUMNS = (
    "scene", "point", "kind", "parcels", "runs", "seconds", "seconds_low", "seconds_high",
    "extrapolated", "d50_m", "sharpness",
    *ERRORS, "front_d50", "front_curve", "note",
)  # fmt: skip
LADDERS = (
    ("gas by points, mesh x 0.6", "gas by points", f"gas by points, {FINE}"),
    ("mesh x 0.6", "parcels x 3", FINE),
)

Row = dict[str, Any]


def line(row: Row) -> str:
    """One line for the terminal."""
    said = f"{row['scene']}, {row['point']}: "
    if not isfinite(row["seconds"]):
        return f"{said}{row['note']}"
    mark = " (extrapolated)" if row["extrapolated"] else ""
    return (
        f"{said}{row['seconds']:.3g} s{mark}, d50 {100 * row['d50_error']:+.1f} "
        f"+- {100 * row['d50_noise']:.1f} %, one run {100 * row['d50_run']:.2g} %"
    )


def target(rows: Sequence[Row]) -> list[Row]:
    """For every point of stock: the best run of elutriaFoam beside it, whether it is as many times
    faster at stock's error as asked or 10 times more accurate at its cost, and whether a closed
    form would have done."""
    found = []
    for stock in rows:
        if stock["kind"] != "stock" or not isfinite(stock["seconds"]):
            continue
        here = [row for row in rows if row["scene"] == stock["scene"]]
        runs = [row for row in here if row["kind"] == "elutriaFoam"]
        forms = [row for row in here if row["kind"] == "closed form"]
        for quantity in QUANTITIES:
            verdict = beside_stock(stock, runs, quantity)
            found.append({
                "scene": stock["scene"],
                "stock": stock["point"],
                "quantity": quantity,
                "faster": verdict.faster,
                "by": verdict.by,
                "more_accurate": verdict.more_accurate,
                "met": verdict.met(10 if stock["scene"] == DENSE.name else 100),
                "closed_form_as_good": beside_stock(stock, forms, quantity).by != "none",
            })  # fmt: skip
    return found


def advice(rows: Sequence[Row], within: float = 0.01) -> list[str]:
    """A line for the column and one for the dense scene: the cheapest settings of which one run's
    d50 is `within` the converged one in all such scenes; else those that come closest.
    """
    ours = [row for row in rows if row["kind"] == "elutriaFoam" and isfinite(row["seconds"])]
    ours = [row for row in ours if row["point"] != STOCK_LIKE.name]
    dense = [row for row in ours if row["scene"] == DENSE.name]
    column = [row for row in ours if row["scene"] != DENSE.name]
    found = [("in the default column", column), ("in the dense column", dense)]
    return [_advice(where, here, within) for where, here in found if here]


def _advice(where: str, rows: Sequence[Row], within: float) -> str:
    scenes = {row["scene"] for row in rows}
    points: dict[str, tuple[float, float]] = {}  # seconds a run, error
    for name in {row["point"] for row in rows}:
        here = [row for row in rows if row["point"] == name]
        if {row["scene"] for row in here} == scenes:
            seconds = sum(row["seconds"] for row in here) / len(here)
            points[name] = (seconds, max(known_error(row, "d50") for row in here))
    good = {name: cost for name, (cost, error) in points.items() if error <= within}
    if good:
        best = min(good, key=lambda name: good[name])
        return f"For d50 to {100 * within:g} % {where} use **{best}** ({good[best]:.0f} s a run)."
    best = min(points, key=lambda name: points[name][1])
    seconds, error = points[best]
    return (
        f"For d50 to {100 * within:g} % {where} none is known to be enough; **{best}** "
        f"({seconds:.0f} s a run) comes closest, {100 * error:.2f} %, chance included."
    )


def text(
    rows: Sequence[Row],
    table: Mapping[str, Reference],
    refined: Sequence[Row],
    moved: Sequence[uncertainty.Row],
    parcels: int,
    seeds: int,
) -> str:
    """The page: advice, the target, all points, and what moves the cut."""
    verdicts = target(rows)
    return templates("benchmarks").get_template("accuracy.md.j2").render(
        column={"step": STEP, "courant": COURANT, "feed": FEED_TIME, "drain": DRAIN_TIME,
                "later": LATER},
        parcels=parcels,
        seeds=seeds,
        made=machine(),
        rows=rows,
        advice=advice(rows),
        references=table,
        refined=refined,
        slow=SLOW.name,
        ladders=[_ladder(rows, names) for names in LADDERS],
        target=verdicts,
        met_with_forms=sum(one["met"] or one["closed_form_as_good"] for one in verdicts),
        default=default_lines(rows),
        moved=sorted(moved, key=uncertainty.width, reverse=True),
    )  # fmt: skip


def _ladder(rows: Sequence[Row], names: Sequence[str]) -> str:
    """d50 of the points of a ladder of meshes, in the slow column."""
    known = {
        row["point"]: f"{1e6 * row['d50_m']:.0f} um"
        for row in rows
        if row["scene"] == SLOW.name and isfinite(row["seconds"])
    }
    return ", ".join(f"{name} {known[name]}" for name in names if name in known)


def default_lines(rows: Sequence[Row]) -> list[str]:
    """Whether the default settings are on the front of the runs, and what is before them."""
    lines, better = [], []
    for default in rows:
        if default["point"] != PLAN or not isfinite(default["seconds"]):
            continue
        before = {
            quantity: _cheaper_and_as_good(rows, default, quantity) for quantity in QUANTITIES
        }
        for quantity, found in before.items():
            said = ", ".join(_before(row, default, quantity) for row in found)
            lines.append(
                f"- {default['scene']}, {quantity} "
                f"({100 * known_error(default, quantity):.2g} %): "
                f"{f'behind {said}' if found else 'on the front'}."
            )
            better += [row["point"] for row in found if _is_better(row, default, quantity)]
        names = [{row["point"] for row in found} for found in before.values()]
        both = ", ".join(sorted(set.intersection(*names)))
        lines.append(
            f"- {default['scene']}, front of seconds and both errors together: "
            f"{f'behind {both}' if both else 'on it'}."
        )
    if not lines:
        return []
    known = ", ".join(dict.fromkeys(better)) or "nothing"
    return [
        "The default settings, by what a single run is off by:",
        "",
        *lines,
        "",
        f"Cheaper than the default and more accurate by more than chance: {known}.",
        "",
    ]


def _cheaper_and_as_good(rows: Sequence[Row], default: Row, quantity: str) -> list[Row]:
    """Our runs of the same scene that beat the default in seconds and an error."""
    return [
        row
        for row in rows
        if row["scene"] == default["scene"]
        and row["kind"] not in ("closed form", "stock")
        and row["seconds"] < default["seconds"]
        and known_error(row, quantity) <= known_error(default, quantity)
    ]


def _before(row: Row, default: Row, quantity: str) -> str:
    """What is cheaper than the default, by how much, and whether more than chance says so."""
    saved = 1 - row["seconds"] / default["seconds"]
    always = row["seconds_high"] < default["seconds_low"]
    better = _is_better(row, default, quantity)
    return (
        f"{row['point']} ({100 * saved:.0f} % cheaper{', in every run' * always}, "
        f"{100 * known_error(row, quantity):.2g} %, "
        f"{'better' if better else 'as good within chance'})"
    )


def _is_better(row: Row, default: Row, quantity: str) -> bool:
    """Whether more than chance says that a point is the more accurate one."""
    # a root-mean-square of n runs is known to 1/sqrt(2 n) of itself
    chance = hypot(*(known_error(one, quantity) / sqrt(2 * one["runs"]) for one in (row, default)))
    return known_error(default, quantity) - known_error(row, quantity) > 2 * chance
