"""Stability maps: a short run of elutriaFoam at each of many extreme points, and what came of it.

A point is `right`, `off` (stable, but further from what is known than the map allows; `warned` or
not), `refused` (before it started, or ended with a reason and its last sound state written) or
`failed`. Stable means finite, nothing lost, the ledger closed, the void fraction within its bounds,
energy within what was put in.
"""

from __future__ import annotations

import math
import shutil
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from elutria.errors import ElutriaError, InputError
from elutria.files import write_text
from elutria.output.style import COLUMN_WIDTH, STYLE
from elutria_validation.benchmarks.stability_points import MAPS, Map
from elutria_validation.book.page import templates
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.provenance import machine, write_result
from elutria_validation.harness.scenes import EndedEarly, Verdict

NAME = "stability"
HELP = "stability maps: extreme steps, stiffness, loading, sizes, gas that jumps"
COLUMNS = ("map", "x_name", "x", "y_name", "y", "class", "off_by", "warned", "what", "seconds")
KINDS = ("right", "off", "refused", "failed")


@dataclass(frozen=True)
class Options:
    """Its own."""

    maps: str = option("all", unit="names, with commas between them")


def run(job: Job, options: Options) -> None:
    """Runs all points; writes stability.csv, .png, .json and .md."""
    known = [m.name for m in MAPS]
    names = known if options.maps == "all" else options.maps.split(",")
    unknown = [name for name in names if name not in known]
    if unknown:
        raise InputError(f"--option maps={','.join(unknown)}; allowed: all, {', '.join(known)}")
    chosen = [thinned(m) if job.quick else m for m in MAPS if m.name in names]
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as work:
        for one in chosen:
            rows += measure(one, Path(work) / one.name, job.say)
    with mpl.rc_context(STYLE):
        write_result(job, NAME, COLUMNS, rows, figure(chosen, rows), {"counts": counts(rows)})
    write_text(job.folder / f"{NAME}.md", text(chosen, rows))


def thinned(whole: Map) -> Map:
    """First and last of each quantity."""
    return Map(**{**vars(whole), "x": (whole.x[0], whole.x[-1]), "y": (whole.y[0], whole.y[-1])})


def measure(one: Map, place: Path, say: Callable[[str], None]) -> list[dict[str, Any]]:
    """A row per point."""
    rows: list[dict[str, Any]] = []
    place.mkdir()
    for x in one.x:
        for y in one.y:
            start = time.monotonic()
            folder = place / f"{one.x.index(x)}-{one.y.index(y)}"
            try:
                verdict = one.point(folder, x, y)
            except EndedEarly as end:
                verdict = end.verdict
            except ElutriaError as error:
                verdict = Verdict("failed", note=str(error))
            shutil.rmtree(folder, ignore_errors=True)
            seconds = time.monotonic() - start
            rows.append({
                "map": one.name, "x_name": one.x_name, "x": x, "y_name": one.y_name, "y": y,
                "class": verdict.kind, "off_by": verdict.off, "warned": verdict.warned,
                "what": verdict.note, "seconds": round(seconds, 2),
            })  # fmt: skip
            say(f"{one.name} {one.x_name} {x}, {one.y_name} {y}: {verdict.kind}"
                f"{' (warned)' if verdict.warned else ''}: {verdict.note}")  # fmt: skip
    shutil.rmtree(place)
    return rows


def unmarked(row: dict[str, Any]) -> bool:
    """Whether a point is wrong and nothing said so."""
    return row["class"] == "failed" or (row["class"] == "off" and not row["warned"])


def counts(rows: Sequence[dict[str, Any]]) -> dict[str, int]:
    """Points of each class."""
    by_kind = {kind: sum(row["class"] == kind for row in rows) for kind in KINDS}
    return {"points": len(rows), **by_kind, "wrong without a warning": sum(map(unmarked, rows))}


def text(maps: Sequence[Map], rows: Sequence[dict[str, Any]]) -> str:
    """The page: counts by map, every point that is not right, and the limits."""
    groups = {f"{m.title} ({m.name})": [r for r in rows if r["map"] == m.name] for m in maps}
    by_map = {name: counts(group) for name, group in {**groups, "all": list(rows)}.items()}
    template = templates("benchmarks").get_template("stability.md.j2")
    return template.render(made=machine(), counts=by_map, rows=rows)


LOOKS = {  # Okabe and Ito's colours, and a shape of its own
    "right": ("#0072B2", "o"),
    "off": ("#E69F00", "s"),
    "refused": ("#999999", "D"),
    "failed": ("#D55E00", "X"),
}


def figure(maps: Sequence[Map], rows: Sequence[dict[str, Any]]) -> Figure:
    """A panel per map, a mark per point; open squares are off without a warning."""
    across = min(3, len(maps))
    down = math.ceil(len(maps) / across)
    drawing = Figure(figsize=(2 * COLUMN_WIDTH, 0.62 * COLUMN_WIDTH * down))
    panels = drawing.subplots(down, across, squeeze=False).ravel()
    for axes, one in zip(panels, maps, strict=False):
        _draw(axes, one, [row for row in rows if row["map"] == one.name])
    for axes in panels[len(maps) :]:
        axes.set_axis_off()
    names = {**{kind: kind for kind in KINDS}, "open": "off, no warning"}
    for kind, label in names.items():
        colour, shape = LOOKS.get(kind, LOOKS["off"])
        face = "none" if kind == "open" else colour
        drawing.axes[0].plot([], [], shape, color=colour, mfc=face, ms=5, ls="", label=label)
    handles, labels = drawing.axes[0].get_legend_handles_labels()
    drawing.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return drawing


def _draw(axes: Axes, one: Map, rows: Sequence[dict[str, Any]]) -> None:
    for row in rows:
        colour, shape = LOOKS[row["class"]]
        face = "none" if row["class"] == "off" and not row["warned"] else colour
        place = one.x.index(row["x"]), one.y.index(row["y"])
        axes.plot(*place, shape, color=colour, mfc=face, ms=5)
    axes.set_xticks(range(len(one.x)), [_short(x) for x in one.x], fontsize=5.5)
    axes.set_yticks(range(len(one.y)), [_short(y) for y in one.y], fontsize=5.5)
    axes.set_xlim(-0.5, len(one.x) - 0.5)
    axes.set_ylim(-0.5, len(one.y) - 0.5)
    axes.set_xlabel(one.x_name, fontsize=6.5)
    axes.set_ylabel(one.y_name, fontsize=6.5)
    axes.set_title(one.title, fontsize=7)


def _short(value: Any) -> str:
    return value.replace(", ", "\n") if isinstance(value, str) else f"{value:g}".replace("e+0", "e")
