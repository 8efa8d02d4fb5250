"""Do bands of partition curves, and intervals of d25, d50, d75 and sharpness, cover what they say?

Events are drawn from known curves (coverage_draws.py) and fitted as `classify` does.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from elutria.errors import InputError
from elutria.output.style import MATERIAL_COLOURS, STYLE, new_figure
from elutria_validation.benchmarks import coverage_draws as draws
from elutria_validation.benchmarks.coverage_draws import EVENTS, OTHERS, PLACES, SHAPES, Row
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.provenance import write_result

NAME = "coverage"
HELP = "how often bands and intervals of partition curves hold the truth, on synthetic curves"
COLUMNS = (
    "shape", "events", "draws", "band", "worst", "worst_at", "ends", "d25", "d50", "d75",
    "sharpness", "width", "width_over_ideal", "d50_width", "wide_bands", "seconds",
)  # fmt: skip
"""band: share of the sizes at T = PLACES whose limits hold the curve, over all draws; worst: at the
size where it is lowest; ends: where T is below 0.02 or above 0.98; width: of the band at PLACES;
wide_bands: share of draws with a band wider than 0.8 somewhere."""


@dataclass(frozen=True)
class Options:
    """Its own."""

    draws: int = option(1000, quick=20, least=1, unit="curves of a shape")
    shapes: str = option(",".join(SHAPES), unit=f"also {', '.join(OTHERS)}; with commas between")
    events: str = option(",".join(map(str, EVENTS)), quick="300,3000", unit="with commas between")
    jobs: int = option(len(os.sched_getaffinity(0)), least=1, unit="processes")


def run(job: Job, options: Options) -> None:
    """Draw what FOLDER/draws does not have, fit, count; writes coverage.csv, .png and .json."""
    words = options.events.split(",")
    if not all(word.isdecimal() and int(word) >= 10 for word in words):
        raise InputError(f"--option events={options.events}; allowed: whole numbers >= 10")
    shapes = options.shapes.split(",")
    if not set(shapes) <= {*SHAPES, *OTHERS}:
        raise InputError(
            f"--option shapes={options.shapes}; allowed: {', '.join((*SHAPES, *OTHERS))}"
        )
    events, folder = [int(word) for word in words], job.folder / "draws"
    draws.run(folder, shapes, events, range(options.draws), options.jobs, job.say)
    rows = [
        table_row(shape, count, draws.read(folder, shape, count)[: options.draws])
        for count in events
        for shape in shapes
    ]
    for row in rows:
        job.say(line(row))
    with mpl.rc_context(STYLE):
        write_result(job, NAME, COLUMNS, rows, figure(rows))


def table_row(shape: str, events: int, found: Sequence[Row]) -> Row:
    """What a kind's draws say together."""

    def column(name: str) -> draws.Array:
        values = np.array([row[name] for row in found], dtype=float)
        return np.asarray(values[np.isfinite(values)])

    def mean(name: str) -> float:
        values = column(name)
        return float(values.mean()) if values.size else nan

    places = [column(f"at_{share:g}") for share in PLACES]
    # a place that few curves have says little about the worst
    often = [values.mean() if values.size > len(found) / 4 else 2.0 for values in places]
    widest = np.maximum(column("widest"), 0)
    return {
        "shape": shape,
        "events": events,
        "draws": len(found),
        "band": float(np.concatenate(places).mean()),
        "worst": min(often),
        "worst_at": PLACES[int(np.argmin(often))],
        **{name: mean(name) for name in ("ends", "d25", "d50", "d75", "sharpness", "width")},
        "width_over_ideal": mean("width") / mean("ideal"),
        "d50_width": mean("d50_width"),
        "wide_bands": float(np.mean(widest > draws.WIDE)),
        "seconds": mean("seconds"),
    }


def line(row: Row) -> str:
    """A kind's numbers in a line."""
    names = ("band", "ends", "d25", "d50", "d75", "sharpness")
    covered = " ".join(f"{name} {100 * row[name]:.1f}" for name in names)
    return (
        f"{row['shape']}, {row['events']} events: covered % {covered}, worst "
        f"{100 * row['worst']:.1f} at T {row['worst_at']:g}; width {row['width']:.3f}, "
        f"{row['width_over_ideal']:.2f} of the ideal; {100 * row['wide_bands']:.1f} % wider than "
        f"{draws.WIDE:g}"
    )


def figure(rows: Sequence[Row]) -> Figure:
    """Coverage of band and sizes, and width over the ideal, against the number of events."""
    made, panels = new_figure(150, 3, sharex=True)
    shapes = dict.fromkeys(row["shape"] for row in rows)
    for shape, colour in zip(shapes, MATERIAL_COLOURS, strict=False):
        mine = [row for row in rows if row["shape"] == shape]
        events = [row["events"] for row in mine]
        for axes, columns in zip(panels, (("band",), ("d50",), ("width_over_ideal",)), strict=True):
            for name in columns:
                scale = 1 if name == "width_over_ideal" else 100
                axes.plot(events, [scale * row[name] for row in mine], "o-", ms=3, color=colour,
                          label=shape)  # fmt: skip
        panels[0].plot(events, [100 * row["worst"] for row in mine], "v:", ms=2.5, color=colour)
        panels[1].plot(events, [100 * row["sharpness"] for row in mine], "v:", ms=2.5, color=colour)
    for axes in panels[:2]:
        axes.axhspan(93, 97, color="0.9", zorder=0)
        axes.set_ylim(80, 100.5)
    panels[0].set_ylabel("band: mean, worst size (%)")
    panels[1].set_ylabel("$d_{50}$, sharpness (%)")
    panels[2].set_ylabel("width over the ideal")
    panels[2].set_ylim(bottom=0)
    panels[2].set_xscale("log")
    panels[2].set_xlabel("events")
    panels[0].legend(ncols=3, loc="lower right")
    return made
