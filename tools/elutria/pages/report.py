"""The report: one page without a network that says what was asked, what came out, and how."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from math import isfinite, isinf, nan
from pathlib import Path
from typing import Any

import jinja2
import matplotlib as mpl
import numpy as np

from elutria import tables
from elutria.case.case import SEED, VELOCITY
from elutria.errors import InputError
from elutria.files import write_text
from elutria.output.partition_figure import compared
from elutria.output.plots import figures
from elutria.output.results import Results, optional, read_results
from elutria.output.settings import Row, materials_of
from elutria.output.style import MATERIAL_COLOURS, STYLE, looks
from elutria.pages.geometry import outline_figure, read_outline
from elutria.pages.runs import RunFolder, find_runs
from elutria.pages.svg import inline_svg


def write_report(folder: Path, to: Path) -> Path:
    """The report of RESULTS at `to`. Raises InputError when its tables or runs are not there."""
    refuse_other_names(to)
    results = read_results(folder)
    runs = find_runs(folder, results.settings)
    page = templates().get_template("report.html.j2").render(content(folder, results, runs))
    write_text(to, page)
    return to


def refuse_other_names(to: Path) -> None:
    """Raise InputError unless `to` is the name of a page, which a PDF beside it would overwrite."""
    if to.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--to {to}; allowed: a name that ends in .html")


def templates() -> jinja2.Environment:
    """The package's templates; what they are given is escaped."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("elutria.pages"),
        autoescape=lambda name: name is not None and name.endswith(".html.j2"),
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {"um": micrometres, "um_interval": _um_interval, "percent": percent,
                            "number": number, "interval": _interval, "share": share}  # fmt: skip
    return environment


def content(folder: Path, results: Results, runs: list[RunFolder]) -> dict[str, Any]:
    """What the template shows."""
    settings = results.settings
    several = len(materials_of(results.summary)) > 1
    products = optional(folder / "products.csv", tables.PRODUCTS)
    return {
        "case": str(runs[0].marker.get("case", runs[0].name)),
        "written": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "materials": materials_of(results.summary),
        "several": several,
        "fines": results.products["fines"],
        "coarse": results.products["coarse"],
        "nan": nan,
        "settings": [
            {"label": settings.label(setting), "look": look.colour, "rows": shown(rows, several)}
            for setting, look in zip(settings.all, looks(len(settings.all)), strict=True)
            if (rows := settings.select(results.summary, setting))
        ],
        "products": [
            {"label": settings.label(setting), "rows": shown(rows, several)}
            for setting in settings.all
            if (rows := settings.select(products, setting))
        ],
        "figures": drawn(results),
        "asked": _asked(runs[0]),
        "outline": _outline(runs[0]),
        "decisions": decisions(runs),
        "needed": [{"run": run.name, "rows": run.log.needed} for run in runs if run.log.needed],
        "warnings": _warnings(runs),
        "ledger": [_ledger(run, settings.label(run.setting)) for run in runs],
        "seconds": [
            {"run": run.name, "label": settings.label(run.setting), "seconds": run.wall_time}
            for run in runs
        ],
        "versions": _versions(runs),
        "repeat": repeat(runs, settings.columns, folder),
    }  # fmt: skip


def shown(rows: list[Row], several: bool) -> list[Row]:
    """`all` is left out where there is one material."""
    return [row for row in rows if several or row["material"] != "all"]


def drawn(results: Results) -> dict[str, str]:
    """The figures as SVG, with words on each measured class."""
    made = figures(results)
    titles: dict[str, list[str]] = {}
    settings = results.settings
    for k, setting in enumerate(settings.all):
        for material in materials_of(results.partition):
            rows = compared(
                settings.select(results.partition, setting, material),
                settings.select(results.curves, setting, material),
                len(settings.all),
            )
            kept = [row for row in rows if row["is_shown"]]
            name = f"{settings.label(setting)}, {material}"
            titles[f"setting{k}-{material}-classes"] = [
                _title(name, row, results.products["coarse"]) for row in kept
            ]
    labels = {
        "partition_curves": "Partition curves with their 95 % bands",
        "cut_size": "Cut size with its 95 % interval",
        "size_distributions": "Size distributions of feed and products",
    }
    return {name: inline_svg(made[name][0], label, titles) for name, label in labels.items()}


def _title(name: str, row: Row, coarse: str) -> str:
    """What a browser shows over a class."""
    low, high = micrometres(row["diameter_low_m"]), micrometres(row["diameter_high_m"])
    return (
        f"{name}: {low} to {high} µm. To {coarse} {percent(row['partition_to_coarse'])} "
        f"({percent(row['ci_low'])} to {percent(row['ci_high'])}); "
        f"the curve's mean {percent(row['curve_mean'])}; fed {number(row['feed_kg'])} kg"
    )


def _asked(run: RunFolder) -> dict[str, Any]:
    """The case in numbers: of the solver's plan, where there is one."""
    plan = run.plan
    feed, gas, expected = (plan.get(name, {}) for name in ("feed", "gas", "expected"))
    mesh = plan.get("mesh", {})
    rows: list[tuple[str, str]] = []
    if gas:
        rows.append(("gas", f"{number(gas['density_kg_m3'])} kg/m3, "
                            f"{number(gas['viscosity_pa_s'])} Pa s"))  # fmt: skip
    if feed:
        rows.append(("fed through", str(feed["through"])))
        for outlet in feed["outlets"]:
            rows.append((f"{outlet['product']} leave through", ", ".join(outlet["patches"])))
        rows.append(("feed rate", f"{number(feed['rate_kg_s'] * 1e3)} g/s"))
        rows.append(("loading", f"{number(expected.get('loading'))} kg of solids per kg of gas"))
        rows.append(("fed from, to", f"{number(feed['start_s'])} s, {number(feed['end_s'])} s"))
        each = number(feed["particles_per_parcel"])
        rows.append(("parcels", f"{number(feed['parcels'])}, each {each} particles on average"))
        rows.append(("seed", number(feed["seed"])))
    if plan.get("drag"):
        rows.append(("drag", ", ".join(plan["drag"]["forces"])))
    if mesh:
        size = " x ".join(number(1e3 * length) for length in mesh["size_m"])
        cells = dict.fromkeys(
            number(1e3 * mesh[f"{name}_cell_m"]) for name in ("smallest", "largest")
        )
        of = f"{mesh['cells']:,} cells of {' to '.join(cells)} mm"
        rows.append(("column", f"{size} mm (x, y, z), {of}"))
    return {"rows": rows, "materials": feed.get("materials", []), "of": run.name}


def _outline(run: RunFolder) -> str | None:
    """The mesh's outline as SVG; None where it cannot be drawn."""
    feed = run.case.feed()
    roles = {
        patch: (product, MATERIAL_COLOURS[number % len(MATERIAL_COLOURS)])
        for number, (product, patches) in enumerate(feed.outlets.items())
        for patch in patches
    }
    if feed.place_is_patch:
        roles[feed.place] = ("feed", "0.5")
    outline = read_outline(run.path / "constant/polyMesh", set(roles))
    if outline is None or not len(outline.lines):
        return None
    down = np.array(run.case.dictionary("constant/g").numbers("value", 3))
    with mpl.rc_context(STYLE):
        figure = outline_figure(outline, roles, down)
    return inline_svg(figure, "Outline of the mesh")


def decisions(runs: list[RunFolder]) -> list[dict[str, Any]]:
    """What the solver decided, and why; with the runs where that is not the same in all."""
    found: dict[tuple[str, ...], list[str]] = {}
    for run in runs:
        for row in run.plan.get("decisions", []):
            found.setdefault(tuple(map(str, row)), []).append(run.name)
    order = list(dict.fromkeys(row[0] for row in found))
    rows = sorted(found, key=lambda row: order.index(row[0]))
    return [
        {"cells": row, "runs": "" if len(found[row]) == len(runs) else ", ".join(found[row])}
        for row in rows
    ]


def _warnings(runs: list[RunFolder]) -> list[dict[str, str]]:
    """Each warning with the runs that have it."""
    found: dict[str, list[str]] = {}
    for run in runs:
        for line in run.warnings:
            found.setdefault(line, []).append(run.name)
    return [{"line": line, "runs": ", ".join(names)} for line, names in found.items()]


def _ledger(run: RunFolder, label: str) -> dict[str, Any]:
    """Rows of number and mass: fed, each product, inside, lost; of all and of each material."""
    sections = {**run.ledger.get("materials", {}), "all": run.ledger.get("total", {})}
    rows = []
    for material, section in sections.items():
        if material == "all" and len(sections) == 2:
            continue
        try:
            places = {"fed": section["injected"], **section["outlets"],
                      "inside": section["inside"], "lost": section["lost"]}  # fmt: skip
            rows.append({"material": material, "places": places,
                         "closure": _closure(places)})  # fmt: skip
        except (KeyError, TypeError) as error:
            raise InputError(f"{run.path}: ledger.json: {material}: {error}") from error
    return {"run": run.name, "label": label, "rows": rows}


def _closure(places: Mapping[str, Any]) -> float:
    """Mass that is nowhere, over the mass fed."""
    fed, *others = (float(amount["mass_kg"]) for amount in places.values())
    return (fed - sum(others)) / fed if fed > 0 else 0.0


def _versions(runs: Sequence[RunFolder]) -> list[tuple[str, str]]:
    """Programs, and the machine."""

    def of_runs(name: str) -> str:
        return ", ".join(dict.fromkeys(run.log.head.get(name, "?") for run in runs))

    tool = ", ".join(dict.fromkeys(str(run.marker.get("elutria", "?")) for run in runs))
    return [
        ("elutria", f"{version('elutria')} (runs: {tool})"),
        ("OpenFOAM", of_runs("Build")),
        ("processors of a run", of_runs("nProcs")),
        ("run on", f"{of_runs('Host')}; {of_runs('Date')}"),
        ("Python", f"{platform.python_version()}, matplotlib {version('matplotlib')}"),
        ("inputs (SHA-256)", ", ".join(
            f"{run.name} {str(run.marker.get('inputs', '?'))[:12]}" for run in runs)),
    ]  # fmt: skip


def repeat(runs: Sequence[RunFolder], columns: list[str], folder: Path) -> str | None:
    """The command that makes these runs again; None where their settings were not recorded."""
    given = [run.marker.get("settings") for run in runs]
    if not all(isinstance(settings, list) for settings in given):
        return None
    parted = [dict(str(text).partition("=")[::2] for text in settings or []) for settings in given]
    values = [dict.fromkeys(_written(run.setting[k]) for run in runs) for k in range(len(columns))]
    words = [f"elutria sweep {runs[0].marker.get('case', 'CASE')} --velocity {','.join(values[0])}"]
    words += [f"--vary {_quoted(name)}={','.join(of)}"
              for name, of in zip(columns[1:], values[1:], strict=True)]  # fmt: skip
    varied = {VELOCITY, SEED, *columns}
    words += [f"--set {_quoted(f'{name}={value}')}" for name, value in parted[0].items()
              if name not in varied]  # fmt: skip
    number = max(sum(run.setting == setting for run in runs) for setting in
                 {run.setting for run in runs})  # fmt: skip
    if number > 1:
        words.append(f"--replicates {number}")
    if runs[0].marker.get("np", 1) > 1:
        words.append(f"--np {runs[0].marker['np']}")
    return " ".join([*words, f"--to {_quoted(f'results/{folder.resolve().name}')}"])


def _written(value: Any) -> str:
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _quoted(text: str) -> str:
    return f"'{text}'" if any(c in text for c in " ()$;&|<>*") else text


def number(value: Any) -> str:
    """Four digits; `-` where it is not known."""
    if value is None or (isinstance(value, float) and value != value):
        return "-"
    if isinstance(value, float) and isinf(value):
        return "open"
    return f"{value:.4g}" if abs(value) < 1e4 or isinstance(value, str) else f"{value:,.0f}"


def micrometres(value: float | None) -> str:
    """A size (m) in um."""
    return number(None if value is None else value * 1e6)


def share(value: float) -> str:
    """A share in percent, without the sign."""
    return percent(value).removesuffix(" %")


def percent(value: float) -> str:
    """A share in percent, with a tenth."""
    return f"{100 * value:.1f} %" if isfinite(value) else "-"


def _um_interval(row: Mapping[str, Any], name: str) -> str:
    low, high = row[f"{name}_low_m"], row[f"{name}_high_m"]
    return f"{micrometres(low)} .. {micrometres(high)}" if low == low or high == high else "-"


def _interval(row: Mapping[str, Any], name: str) -> str:
    low, high = row[f"{name}_low"], row[f"{name}_high"]
    return f"{100 * low:.1f} .. {100 * high:.1f}" if low == low else "-"
