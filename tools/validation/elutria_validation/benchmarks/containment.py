"""Where many parcels are in grating, zigzag and hood: none lost, in a wall, or at rest in mid-air.

Each case is run as delivered with `--option parcels` fed within a second (at its usual loading: so
many parcels stand for few particles each), and emptied for two. The ledger closes where what was
fed is in the products and inside. Every half second all particles are looked at: how deep one is in
a wall, over its radius, and how many have not moved since and touch nothing.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from elutria.case.case import Case, Setting
from elutria.errors import InputError, one_line, suggestion
from elutria.files import read_json
from elutria.output.style import COLUMN_WIDTH, STYLE
from elutria.running.run import run_case
from elutria_validation.chapters.budgets import ledger_errors
from elutria_validation.harness.cases import CONTROL, PARAMETERS, times
from elutria_validation.harness.clearance import watch
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.programs import project_root
from elutria_validation.harness.provenance import write_result

NAME = "containment"
HELP = "many parcels through grating, zigzag and hood: none lost, in a wall or at rest in mid-air"
CASES = ("grating", "zigzag", "hood")
COLUMNS = (
    "case", "parcels", "left", "inside", "lost", "number_error", "mass_error", "looked_at",
    "deepest", "hanging", "seconds",
)  # fmt: skip
FEED_TIME, DRAIN_TIME, LOOK = 1.0, 2.0, 0.5
"""s."""
COARSE = {"grating": 0.005, "zigzag": 0.01, "hood": 0.012}
"""Cell sizes (m) of a short run."""
Row = dict[str, Any]


@dataclass(frozen=True)
class Options:
    """Its own."""

    parcels: int = option(1_000_000, quick=200, least=10, unit="fed in each case")
    cases: str = option(",".join(CASES))


def run(job: Job, options: Options) -> None:
    """Run the cases; writes containment.csv, .png and .json."""
    rows = []
    for name in options.cases.split(","):
        if name not in CASES:
            raise InputError(
                f"--option cases={one_line(options.cases, 60)}{suggestion(name, CASES)}; "
                f"allowed: {', '.join(CASES)}"
            )
        rows.append(one_case(job, name, options.parcels))
        job.say(", ".join(f"{key} {value}" for key, value in rows[-1].items()))
    with mpl.rc_context(STYLE):
        write_result(job, NAME, COLUMNS, rows, figure(rows))


def one_case(job: Job, name: str, parcels: int) -> Row:
    """Run a case and look at its ledger and its particles; the run is removed."""
    folder = job.folder / "runs" / name
    settings = {
        f"{PARAMETERS}:particles": parcels,
        f"{PARAMETERS}:feedTime": FEED_TIME,
        f"{PARAMETERS}:drainTime": DRAIN_TIME,
        f"{CONTROL}:writeFormat": "ascii",
        f"{CONTROL}:writeInterval": LOOK,
        f"{CONTROL}:purgeWrite": 0,
        **({f"{PARAMETERS}:cellSize": COARSE[name]} if job.quick else {}),
    }
    case = Case(project_root() / "cases" / name)
    done = run_case(case, folder, [Setting.parse(f"{k}={v}") for k, v in settings.items()]).path
    row = looked_at(done)
    shutil.rmtree(folder)
    return {"case": name, "parcels": parcels, **row}


def looked_at(case: Path) -> Row:
    """What a finished run comes to."""
    total = read_json(case / "postProcessing/ledger.json")["total"]
    errors = ledger_errors(case)
    found = watch(case, [time for time in times(case)[1:] if float(time) % LOOK == 0])
    return {
        "left": sum(outlet["parcels"] for outlet in total["outlets"].values()),
        "inside": total["inside"]["parcels"],
        "lost": total["lost"]["parcels"],
        **{f"{kind.removesuffix('_kg')}_error": max(
            error for (_, of), error in errors.items() if of == kind
        ) for kind in ("number", "mass_kg")},
        "looked_at": found.particles,
        "deepest": found.deepest,
        "hanging": found.hanging,
        "seconds": read_json(case / "finished.json")["processor_s"],
    }  # fmt: skip


def figure(rows: list[Row]) -> Figure:
    """Where the parcels are at the end."""
    drawing = Figure(figsize=(COLUMN_WIDTH, 0.6 * COLUMN_WIDTH))
    axes = drawing.subplots()
    names = [f"{row['case']}" for row in rows]
    left, inside = ([row[key] / row["parcels"] for row in rows] for key in ("left", "inside"))
    axes.barh(names, left, label="left")
    axes.barh(names, inside, left=left, label="inside")
    axes.set_xlabel("share of the parcels")
    axes.legend()
    return drawing
