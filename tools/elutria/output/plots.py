"""The figures, drawn from the csv files alone, each with the numbers that it shows beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from elutria import tables
from elutria.files import write_csv
from elutria.output.contour_figure import contour_figure, contour_settings
from elutria.output.cut_size_figure import cut_size_figure
from elutria.output.partition_figure import partition_figure
from elutria.output.planes_figure import planes_figure
from elutria.output.results import OPTIONAL, Results, formats_of, optional, read_results
from elutria.output.settings import Row, Settings, products_of
from elutria.output.size_figure import size_figure
from elutria.output.style import STYLE, save


def write_figures(folder: Path, formats: Sequence[str] = ()) -> list[Path]:
    """All figures of RESULTS in each of `formats`, and the csv file of each; gives the figures."""
    formats = formats_of(formats)
    results = read_results(folder)
    drawn = figures(results)
    stages = optional(folder / "stages.csv", tables.STAGES)
    written = []
    if stages:
        with mpl.rc_context(STYLE):
            counted = planes_figure(optional(folder / "zones.csv", tables.ZONES), stages)
        written += [save_styled(counted, folder / f"planes.{suffix}") for suffix in formats]
    for name in sorted(drawn, key=lambda name: name not in OPTIONAL):
        figure, columns, rows = drawn[name]
        write_csv(folder / f"{name}.csv", columns, rows)
        written += [save_styled(figure, folder / f"{name}.{suffix}") for suffix in formats]
    return written


def save_styled(figure: Figure, path: Path) -> Path:
    """Save with the style with which it was drawn."""
    with mpl.rc_context(STYLE):
        return save(figure, path)


def figures(results: Results) -> dict[str, tuple[Figure, list[str], list[Row]]]:
    """Each figure by its name, with the columns and rows of what it shows."""
    settings, products = results.settings, results.products
    with mpl.rc_context(STYLE):
        curves, classes = partition_figure(
            settings, results.partition, results.curves, products["coarse"]
        )
        sizes, steps = size_figure(settings, results.partition, products)
        cut = cut_size_figure(settings, results.summary, results.theory)
        over = contour_settings(settings, results.summary)
        contours = (
            contour_figure(settings, results.summary, over, products["fines"]) if over else None
        )
    own = settings.columns
    amounts = [f"{name}_per_decade" for name in products_of(results.partition)]
    drawn = {
        "partition_curves": (curves, [*own, *tables.PARTITION_FIGURE], classes),
        "cut_size": (cut, [*own, *tables.CUT_SIZE_FIGURE], results.summary),
        "size_distributions": (sizes, [*own, *tables.SIZE_FIGURE, *amounts], steps),
    }
    if contours is not None:
        drawn["contours"] = (contours, [*own, *tables.CONTOUR_FIGURE], results.summary)
    for figure, *_ in drawn.values():
        _caption(figure, settings, results.summary)
    return drawn


def _caption(figure: Figure, settings: Settings, summary: list[Row]) -> None:
    """Below a figure: which runs have warnings."""
    warned = {settings.of(row) for row in summary if row.get("warnings", 0) > 0}
    if warned:
        labels = [settings.label(one) for one in settings.all if one in warned]
        runs = "; ".join(label.replace(" ", "\u00a0") for label in labels)  # lines break between
        said = f"With warnings (warnings.json of the runs): {runs}"
        figure.supxlabel(said, fontsize=7, color="0.35", wrap=True)
