"""`elutria compare`: which results a measurement is of, their comparison, and its files."""

from __future__ import annotations

from collections.abc import Sequence
from math import isclose, isfinite
from pathlib import Path
from typing import Any

from elutria import tables
from elutria.classification.classify import fit_events
from elutria.classification.events import Events, join, read_run
from elutria.comparing.compare import Comparison, Difference, compare, interval, within
from elutria.comparing.figure import comparison_figure
from elutria.comparing.measured import FEWEST, read_measured
from elutria.errors import InputError, one_line
from elutria.files import write_csv, write_json
from elutria.output.plots import save_styled
from elutria.output.results import Results, formats_of, read_results
from elutria.output.settings import Row, Setting, materials_of
from elutria.pages.runs import find_runs
from elutria.tables import VELOCITY, shown

NAME = "comparison"
DIFFERS = 0.05
"""Chance below which curves are said to differ."""


def write_comparison(
    folder: Path, file: Path, to: Path, velocity: float | None = None, material: str | None = None,
    formats: Sequence[str] = (),
) -> tuple[list[str], list[Path]]:  # fmt: skip
    """Compare RESULTS with a measurement's `file`: lines that say what came out, and the figures.

    Writes comparison.csv, comparison.json and the figures to `to`. Raises InputError for what
    cannot be compared.
    """
    formats = formats_of(formats)
    results = read_results(folder)
    measured = read_measured(file, results.settings.columns)
    chosen = {**({} if velocity is None else {VELOCITY: velocity}), **measured.chosen}
    if velocity is not None and not _same(chosen[VELOCITY], velocity):
        raise InputError(f"{file}: {VELOCITY} is {shown(chosen[VELOCITY])}, --velocity {velocity}; "
                         "allowed: one of them")  # fmt: skip
    setting = _setting(results, chosen, folder)
    name = _material(results, material or chosen.get("material", "all"))
    events = _events(folder, results, setting).of_material(name)
    fit = fit_events(events)
    if fit.curve is None:
        raise InputError(
            f"{folder}: {results.settings.label(setting)}, {name}: one product is empty; allowed: "
            "results with a partition curve"
        )
    kept = within(fit.curve, measured)
    if kept.share.size < FEWEST:
        raise InputError(
            f"{file}: {kept.share.size} of its sizes are within those that left in {folder} "
            f"({1e6 * events.diameter.min():.4g} to {1e6 * events.diameter.max():.4g} um); "
            f"allowed: at least {FEWEST}"
        )
    found = compare(fit.curve, kept)
    title = f"{results.settings.label(setting)}, {name}"
    curve = [row for row in results.settings.select(results.curves, setting) if
             row["material"] == name]  # fmt: skip
    figure = comparison_figure(found, curve, title, results.products["coarse"])
    write_csv(to / f"{NAME}.csv", tables.COMPARISON, _rows(found))
    left_out = measured.share.size - kept.share.size
    write_json(to / f"{NAME}.json", _content(found, results, setting, name, file, left_out))
    pictures = [save_styled(figure, to / f"{NAME}.{suffix}") for suffix in formats]
    return _lines(found, title, left_out), pictures


def _setting(results: Results, chosen: dict[str, Any], folder: Path) -> Setting:
    """The one setting of the results that has the values that were chosen."""
    columns = results.settings.columns
    wanted = {name: value for name, value in chosen.items() if name in columns}
    fitting = [
        setting for setting in results.settings.all
        if all(_same(setting[columns.index(name)], value) for name, value in wanted.items())
    ]  # fmt: skip
    if len(fitting) == 1:
        return fitting[0]
    has = "; ".join(results.settings.label(setting) for setting in results.settings.all)
    asked = ", ".join(f"{name} {shown(value)}" for name, value in wanted.items()) or "no setting"
    how = "is not in" if not fitting else f"fits {len(fitting)} settings of"
    raise InputError(
        f"{folder}: {asked} {how} the results; allowed: one of {one_line(has, 200)}, by --velocity "
        "or by columns of the measurement"
    )


def _same(one: Any, other: Any) -> bool:
    both = isinstance(one, float) and isinstance(other, float)
    return isclose(one, other, rel_tol=1e-6) if both else str(one) == str(other)


def _material(results: Results, name: Any) -> str:
    allowed = [*materials_of(results.summary), "all"]
    if name not in allowed:
        raise InputError(
            f"material '{one_line(name, 40)}' is not in the results; allowed: {', '.join(allowed)}"
        )
    return str(name)


def _events(folder: Path, results: Results, setting: Setting) -> Events:
    """The parcels of all runs of a setting."""
    runs = [run for run in find_runs(folder, results.settings) if run.setting == setting]
    if not runs:
        raise InputError(f"{folder}: {results.settings.label(setting)}: its run is not there")
    return join([read_run(run.path) for run in runs]).events


def _rows(found: Comparison) -> list[Row]:
    measured = found.measured
    low, high = interval(measured)
    columns = (
        measured.low, measured.high, measured.diameter, measured.share, low, high, found.ours,
        found.low, found.high, found.ours - measured.share, found.standardised,
    )  # fmt: skip
    return [
        dict(zip(tables.COMPARISON, map(float, row), strict=True))
        for row in zip(*columns, strict=True)
    ]


def _content(
    found: Comparison, results: Results, setting: Setting, material: str, file: Path, left_out: int
) -> dict[str, Any]:  # fmt: skip
    """What comparison.json holds."""
    return {
        "measured": file.name,
        "setting": dict(zip(results.settings.columns, setting, strict=True)),
        "material": material,
        "rows": found.sizes,
        "rows_left_out": left_out,
        "chi_square": _json(found.chi_square),
        "degrees_of_freedom": found.degrees,
        "p_value": _json(found.p_value),
        "differences": {
            one.name: {
                "measured": _json(one.measured), "ours": _json(one.ours),
                "difference": _json(one.value), "low": _json(one.low), "high": _json(one.high),
            }
            for one in found.differences
        },
    }  # fmt: skip


def _json(value: float) -> float | None:
    return value if isfinite(value) else None


def _lines(found: Comparison, title: str, left_out: int) -> list[str]:
    """What the terminal says."""
    lines = [f"{title}: {found.sizes} sizes compared"]
    if left_out:
        lines[0] += f", {left_out} beyond those that left are not"
    if isfinite(found.chi_square):
        verdict = "they differ" if found.p_value < DIFFERS else "no difference is seen"
        lines.append(
            f"chi-square {found.chi_square:.4g} with {found.degrees} degrees of freedom, chance "
            f"of as much or more {found.p_value:.3g}: {verdict}"
        )
    else:
        lines.append("no chi-square: the measurement names no uncertainty (column uncertainty)")
    return [*lines, *map(_line, found.differences)]


def _line(one: Difference) -> str:
    names = {"d50_m": ("d50", 1e6, " um"), "sharpness": ("d25/d75", 1.0, ""),
             "fines_yield": ("fines yield", 100.0, " %")}  # fmt: skip
    name, scale, unit = names[one.name]
    if not isfinite(one.value):
        return f"{name}: not reached by both within the sizes compared"
    limits = "interval not known"
    if isfinite(one.low):
        limits = f"95 %: {scale * one.low:+.4g} .. {scale * one.high:+.4g}"
    return (f"{name}: measured {scale * one.measured:.4g}{unit}, computed "
            f"{scale * one.ours:.4g}{unit}, difference {scale * one.value:+.4g} ({limits})"
            )  # fmt: skip
