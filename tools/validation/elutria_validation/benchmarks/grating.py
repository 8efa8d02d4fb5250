"""What a porous layer in the place of resolved bars does to the cut of the grating.

Both models of the delivered case, fed within half a second and emptied for eight, from the same
seed: pressure at the inlet, cut, sharpness, and how long grains touch the bars. A grain touches
where its surface is nearer to a bar's than a twentieth of its radius, of all that are inside at all
times of 50 ms. Differences are from the resolved bars.

Runs lie in the folder's grating-runs; what is finished there is read and not run again.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from elutria.case.case import Case, Setting
from elutria.classification.events import read_run
from elutria.files import read_json
from elutria.output.style import COLUMN_WIDTH, STYLE
from elutria.running.run import run_case
from elutria_validation.benchmarks.accuracy_error import cut_of_events
from elutria_validation.harness.cases import CONTROL, PARAMETERS, times
from elutria_validation.harness.clearance import distances, read_cloud, read_obj
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.programs import project_root
from elutria_validation.harness.provenance import write_result

NAME = "grating"
HELP = "resolved bars beside a porous layer with bars for particles alone: pressure, cut, contact"
COLUMNS = (
    "model", "parcels", "inside", "pressure_pa", "pressure_change", "d50_m", "d50_low_m",
    "d50_high_m", "d50_change", "sharpness", "sharpness_sd", "sharpness_change", "on_bars",
    "on_bars_change", "seconds",
)  # fmt: skip
MODELS = ("resolved", "porous")
FEED_TIME, DRAIN_TIME, LOOK = 0.5, 8.0, 0.05
"""s."""
TOUCHES = 0.05
"""Of a radius: nearer is in contact."""
Row = dict[str, Any]


@dataclass(frozen=True)
class Options:
    """Its own."""

    parcels: int = option(4000, quick=100, least=10)


def run(job: Job, options: Options) -> None:
    """Run both models; writes grating.csv, .png and .json."""
    runs = {name: job.folder / "grating-runs" / name for name in MODELS}
    for name, folder in runs.items():
        if not (folder / "finished.json").is_file():
            job.say(name)
            run_model(name, folder, options.parcels)
    bars = read_obj(runs["porous"] / "constant/polyMesh/bars.obj")
    rows = [row(name, folder, bars) for name, folder in runs.items()]
    for one in rows:
        for key in ("pressure_pa", "d50_m", "sharpness", "on_bars"):
            name = key.removesuffix("_pa").removesuffix("_m")
            one[f"{name}_change"] = one[key] / rows[0][key] - 1
    with mpl.rc_context(STYLE):
        write_result(job, NAME, COLUMNS, rows, figure(rows))


def run_model(name: str, folder: Path, parcels: int) -> None:
    """One of the models of the delivered case."""
    settings = {
        f"{PARAMETERS}:gratingModel": name,
        f"{PARAMETERS}:particles": parcels,
        f"{PARAMETERS}:feedTime": FEED_TIME,
        f"{PARAMETERS}:drainTime": DRAIN_TIME,
        f"{CONTROL}:writeFormat": "ascii",
        f"{CONTROL}:writeInterval": LOOK,
        f"{CONTROL}:purgeWrite": 0,
    }
    case = Case(project_root() / "cases/grating")
    run_case(case, folder, [Setting.parse(f"{k}={v}") for k, v in settings.items()])


def row(name: str, case: Path, bars: np.typing.NDArray[np.float64]) -> Row:
    """What a finished run of a model comes to."""
    events = read_run(case).events
    cut = cut_of_events(events)
    return {
        "model": name,
        "parcels": len(events),
        "inside": int(events.is_inside.sum()),
        "pressure_pa": inlet_pressure(case),
        "d50_m": cut.d50,
        "d50_low_m": cut.d50 - 1.96 * cut.d50_sd,
        "d50_high_m": cut.d50 + 1.96 * cut.d50_sd,
        "sharpness": cut.sharpness,
        "sharpness_sd": cut.sharpness_sd,
        "on_bars": touching(case, bars),
        "seconds": read_json(case / "finished.json")["processor_s"],
    }


def inlet_pressure(case: Path) -> float:
    """Mean over the run of the pressure (Pa) over the outlet's."""
    files = (case / "postProcessing/gas").glob("*/gas.csv")
    flows = pd.concat([pd.read_csv(file) for file in files])
    return float(flows[flows["patch"] == "bottom"]["pressure_pa"].mean())


def touching(case: Path, bars: np.typing.NDArray[np.float64]) -> float:
    """Share of the grains' time in the column that they touch a bar."""
    touch, all_of_them = 0, 0
    for time in times(case)[1:]:
        _, cloud = read_cloud(case, time)
        radius = cloud.diameter / 2
        gap = distances(cloud.position, bars) - radius
        touch += int(np.sum(gap < TOUCHES * radius))
        all_of_them += len(radius)
    return touch / all_of_them


def figure(rows: list[Row]) -> Figure:
    """The porous model's differences from the resolved bars."""
    drawing = Figure(figsize=(COLUMN_WIDTH, 0.6 * COLUMN_WIDTH))
    axes = drawing.subplots()
    names = ("pressure", "d50", "sharpness", "on_bars")
    axes.barh([n.replace("_", " ") for n in names], [100 * rows[1][f"{n}_change"] for n in names])
    axes.axvspan(-3, 3, color="0.9", zorder=0)
    axes.set_xlabel("porous over resolved  (%)")
    return drawing
