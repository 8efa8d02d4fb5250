"""The atlas: one page that answers between the runs of a sweep, and for other feeds.

A node is a setting that was run. Its curve of each material is kept over x = ln(d/d50), the logit
of T with its band; d50 is kept over that of plug-flow theory, which takes most of the curvature
over the velocity. Between nodes the page interpolates both linearly (in the logarithms of the
settings), and widens the band by what leaving out nodes says of that. A feed of the same materials
follows by weights: T(d) stays, the masses of sizes change. That holds while particles hardly feel
each other.
"""

from __future__ import annotations

from math import inf, isfinite, log
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria.case.case import Case
from elutria.case.feed import Material
from elutria.classification.events import Events, join, read_run
from elutria.errors import ElutriaError, InputError
from elutria.files import write_text
from elutria.output.results import Results, read_results
from elutria.output.settings import Row, Setting, column, materials_of, products_of
from elutria.output.style import MATERIAL_COLOURS
from elutria.pages.report import refuse_other_names, templates
from elutria.pages.runs import RunFolder, find_runs
from elutria.tables import VELOCITY, short

Array = NDArray[np.float64]
Theory = dict[str, list[list[float]]]
"""ln U and ln d of each material."""

LARGEST = 15_000_000
"""Bytes of the page."""
PER_DECADE = 80
"""Size bins in which a feed is weighted."""
POINTS, NEAR = 121, 0.004
"""Places at which a curve is kept; they are so near to each other (in ln d) at the cut."""
SURE = 1e-7
"""T is kept between this and 1 - this."""
GAS_CHANGE, COLLISIONS = 0.05, 1.0
"""Particles feel each other where they slow the gas by more, or collide more often."""


def write_atlas(folder: Path, to: Path) -> Path:
    """The atlas of RESULTS at `to`. Raises InputError when there is nothing to interpolate in,
    ElutriaError when the page would be too large."""
    refuse_other_names(to)
    results = read_results(folder)
    runs = find_runs(folder, results.settings)
    data = content(results, runs)
    page = (
        templates()
        .get_template("atlas.html.j2")
        .render(
            case=str(runs[0].marker.get("case", runs[0].name)),
            data=data,
            several=len(data["materials"]) > 1,
            colours=MATERIAL_COLOURS,
        )
    )
    if len(page.encode()) > LARGEST:
        size = len(page.encode()) / 1e6
        raise ElutriaError(
            f"{to}: would have {size:.1f} MB; allowed: {LARGEST / 1e6:g} MB. Use fewer settings."
        )
    write_text(to, page)
    return to


def content(results: Results, runs: list[RunFolder]) -> dict[str, Any]:
    """What the page knows; lengths in m, sizes and settings of curves as logarithms."""
    names = materials_of(results.partition)
    events = {
        setting: join([read_run(run.path) for run in runs if run.setting == setting]).events
        for setting in dict.fromkeys(run.setting for run in runs)
    }
    sizes = np.concatenate([one.diameter for one in events.values()])
    bins = _bins(float(sizes.min()), float(sizes.max()))
    reach = float(np.log(bins[-1] / bins[0]))
    grid = NEAR * np.sinh(np.linspace(-1, 1, POINTS) * np.arcsinh(reach / NEAR))
    theory = _theory(results, names)
    nodes = [
        _node(results, runs, setting, events[setting], bins, grid, theory) for setting in events
    ]
    axes = _axes(results, list(events))
    _add_curvature(nodes, axes, names)
    recorded = list(events.values())
    return {
        "axes": axes,
        "grid": _short(grid),
        "bins": _short(np.log(bins)),
        "materials": [_material(name, runs[0].case, recorded, bins) for name in names],
        "theory": theory,
        "nodes": nodes,
        "products": [results.products[name] for name in products_of(results.partition)],
    }


def _bins(smallest: float, largest: float) -> Array:
    """Limits of size bins (m) that hold all sizes."""
    number = max(int(np.ceil(PER_DECADE * np.log10(largest / smallest))), 1)
    return np.geomspace(smallest * (1 - 1e-9), largest * (1 + 1e-9), number + 1)


def _axes(results: Results, settings: list[Setting]) -> list[dict[str, Any]]:
    """What was varied, by numbers; the page interpolates in the logarithms where all are > 0."""
    found = []
    for name in results.settings.varied:
        place = results.settings.columns.index(name)
        values = sorted({setting[place] for setting in settings}, key=str)
        if not all(isinstance(value, float) for value in values):
            raise InputError(
                f"{name}: was varied by words ({', '.join(map(str, values))}); allowed in an "
                "atlas: settings that are numbers"
            )
        values = sorted(values)
        unit = "m/s" if name == VELOCITY else ""
        label = "gas velocity" if name == VELOCITY else short(name)
        found.append({"name": name, "label": label, "unit": unit, "values": values,
                      "log": values[0] > 0, "place": place})  # fmt: skip
    if not any(len(axis["values"]) > 1 for axis in found):
        raise InputError(
            "an atlas answers between runs; allowed: results of a sweep with two settings or more"
        )
    return found


def _node(
    results: Results, runs: list[RunFolder], setting: Setting, events: Events, bins: Array,
    grid: Array, theory: Theory | None,
) -> dict[str, Any]:  # fmt: skip
    """A setting's curves and parcels by size, and the loading up to which feeds can be weighted."""
    own = [run for run in runs if run.setting == setting]
    left = events.select(events.has_left)
    curves = {}
    for name in materials_of(results.partition):
        (row,) = results.settings.select(results.summary, setting, name)
        curve = results.settings.select(results.curves, setting, name)
        parcels = np.histogram(left.of_material(name).diameter, bins)[0]
        expected = _expected(theory, name, row[VELOCITY])
        curves[name] = {"parcels": parcels.tolist(), **_curve(row, curve, grid, expected)}
    return {
        "at": list(setting),
        "runs": [run.name for run in own],
        "loading": _loading(own[0]),
        "sparse": _sparse_loading(own[0]),
        "curves": curves,
    }


def _curve(row: Row, curve: list[Row], grid: Array, expected: float) -> dict[str, Any]:
    """ln d50 less that of theory, and logits of T and of its band over the grid; nothing without a
    cut size."""
    if not curve or not isfinite(row["d50_m"]):
        return {"cut": None}
    place = np.log(column(curve, "diameter_m")) - log(row["d50_m"])

    def logits(name: str) -> list[float]:
        share = np.clip(column(curve, name), SURE, 1 - SURE)
        return _short(np.interp(grid, place, np.log(share / (1 - share))))

    return {
        "cut": log(row["d50_m"]) - expected,
        "t": logits("partition_to_coarse"),
        "low": logits("ci_low"),
        "high": logits("ci_high"),
    }


def _loading(run: RunFolder) -> float | None:
    value = run.plan.get("expected", {}).get("loading")
    return float(value) if isinstance(value, (int, float)) else None


def _sparse_loading(run: RunFolder) -> float | None:
    """The loading above which particles feel each other, from the solver's estimates."""
    expected, loading = run.plan.get("expected", {}), _loading(run)
    if loading is None:
        return None
    change, collisions = expected.get("gas_change"), expected.get("collisions")
    least = min(
        GAS_CHANGE / change if change else inf, COLLISIONS / collisions if collisions else inf
    )
    return loading * least if isfinite(least) else None


def _add_curvature(
    nodes: list[dict[str, Any]], axes: list[dict[str, Any]], names: list[str]
) -> None:
    """For each node, axis and material: what a linear interpolation of ln(d50) is off by, over the
    distances to both neighbours, from leaving the node out. At the ends: that of the next one."""
    by_place = {tuple(node["at"]): node for node in nodes}
    for node in nodes:
        node["curvature"] = {name: [] for name in names}
    for axis in axes:
        values, scale = axis["values"], np.log if axis["log"] else np.asarray
        at = np.asarray(scale(np.array(axis["values"])), dtype=float)
        for node in nodes:
            where = list(node["at"])
            lines = [by_place.get((*where[: axis["place"]], value, *where[axis["place"] + 1 :]))
                     for value in values]  # fmt: skip
            k = values.index(where[axis["place"]])
            for name in names:
                cuts = [line["curves"][name]["cut"] if line else None for line in lines]
                node["curvature"][name].append(_bend(at, cuts, k))


def _bend(at: Array, cuts: list[float | None], k: int) -> float:
    """Half of the second difference quotient at node k, or at the nearest one that has it. With
    two nodes alone, as much as they differ by."""
    found = {}
    for j in range(1, len(cuts) - 1):
        before, here, after = cuts[j - 1 : j + 2]
        if before is not None and here is not None and after is not None:
            left, right = at[j] - at[j - 1], at[j + 1] - at[j]
            line = (before * right + after * left) / (left + right)
            found[j] = abs(here - line) / (left * right)
    if found:
        return float(f"{found[min(found, key=lambda j: abs(j - k))]:.4g}")
    known = [cut for cut in cuts if cut is not None]
    width = float(at[-1] - at[0])
    return (max(known) - min(known)) / width**2 if len(known) > 1 and width > 0 else 0.0


def _material(name: str, case: Case, events: list[Events], bins: Array) -> dict[str, Any]:
    """What the case feeds of a material, as shares of its mass in the bins; the sizes that were
    run; and the Rosin-Rammler law from which the page's sliders start."""
    fed = next(material for material in case.feed().materials if material.name == name)
    sizes = np.concatenate([one.of_material(name).diameter for one in events])
    shares = np.diff(fed.sizes.mass_share_below(bins))
    d63, n = _rosin_rammler(case, fed)
    return {
        "name": name,
        "share": fed.mass_fraction,
        "fed": _short(shares / shares.sum()),
        "smallest": float(sizes.min()),
        "largest": float(sizes.max()),
        "d63": d63,
        "n": n,
    }


def _rosin_rammler(case: Case, fed: Material) -> tuple[float, float]:
    """d63 (m) and n: the case's own, or else of the law through 20 and 80 % of its sizes."""
    entry = case.dictionary("constant/feed").sub("materials").sub(fed.name).sub("sizeDistribution")
    if fed.sizes.name == "RosinRammler" and entry.raw("weighting", "mass") == "mass":
        return entry.number("d63"), entry.number("n")
    d20, d80 = fed.sizes.mass_quantile([0.2, 0.8]).tolist()
    n = log(log(0.2) / log(0.8)) / log(d80 / d20) if d80 > d20 else 20.0
    return d20 / (-log(0.8)) ** (1 / n), n


def _expected(theory: Theory | None, name: str, velocity: float) -> float:
    """ln d of theory at a velocity; 0 without a theory."""
    if theory is None:
        return 0.0
    speeds, sizes = theory[name]
    return float(np.interp(log(velocity), speeds, sizes))


def _theory(results: Results, names: list[str]) -> Theory | None:
    """ln U and ln d of plug-flow theory by material; None where that is not known for all."""
    found = {}
    for name in names:
        rows = [row for row in results.theory if row["material"] == name
                and isfinite(row["cut_size_m"])]  # fmt: skip
        if len(rows) < 2:
            return None
        found[name] = [_short(np.log(column(rows, VELOCITY))),
                       _short(np.log(column(rows, "cut_size_m")))]  # fmt: skip
    return found


def _short(values: Array) -> list[float]:
    """Numbers with as many digits as a picture or a percent needs."""
    return [float(f"{value:.7g}") for value in np.asarray(values).tolist()]
