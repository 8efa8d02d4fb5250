"""What runs are expected to cost beside what they came to: the delivered cases and a dense column.

Each scene is run twice. The first time nothing is known but the rates of `elutria.estimates.price`
and the speed of this machine; the second time, with twice the parcels, the first run is known. What
the first runs came to is written as `delivered.json`, to take the place of the one in
`tools/elutria/estimates`: in seconds of the reference machine, by the probe that is made beside
each scene.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from elutria.case.case import PARAMETERS, Case, Setting
from elutria.errors import ElutriaError
from elutria.estimates import machine
from elutria.estimates.price import Spent, price, spent
from elutria.files import read_json, write_json
from elutria.running.marker import FINISHED
from elutria.running.run import plans
from elutria.running.worker import Job as Run
from elutria.running.worker import perform
from elutria_validation.harness import provenance
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.programs import project_root

NAME = "price"
HELP = "what runs are expected to cost, and what they come to"

COLUMNS = (
    "scene", "known", "parcels", "expected_s", "processor_s", "ratio", "expected_memory_mb",
    "memory_mb", "expected_disk_mb", "disk_mb",
)  # fmt: skip
SCENES: Mapping[str, Mapping[str, str]] = {
    "column": {},
    "column, loading 5": {"loading": "5"},
    "zigzag": {},
    "grating": {},
    "cascade": {},
    "manganese": {},
    "elutriator": {},
    "hood": {},
}
PROMISED = 1.5
"""Factor within which the price is to be."""


@dataclass(frozen=True)
class Options:
    """Its own. A dense scene feeds up to ten times as many. Fewer than 300 in the default column
    are so heavy that the gas is solved on every step: that takes over ten times as long."""

    particles: int = option(1000, quick=400, least=100, unit="asked for in each first run")


def run(job: Job, options: Options) -> None:
    """Run every scene twice; writes price.csv, .png, .json and delivered.json."""
    scenes = {"column": SCENES["column"]} if job.quick else SCENES
    rows: list[dict[str, Any]] = []
    made: list[Spent] = []
    probes: list[float] = []
    for scene, settings in scenes.items():
        known: list[Spent] = []
        probes.append(machine.probe())
        slow = probes[-1] / machine.REFERENCE_S
        for parcels in (options.particles, 2 * options.particles):
            parameters = {**settings, "particles": str(parcels)}
            row, came_to = _run(job, scene, parameters, slow, known)
            rows.append(row)
            known.append(came_to)
            job.say(f"{scene}: {row['expected_s']:.3g} s expected, {row['processor_s']:.3g} s")
        made.append(machine.scaled(known[0], 1 / slow))
    notes = {"particles": options.particles, "probe_s": probes, "reference_s": machine.REFERENCE_S}
    write_json(
        job.folder / "delivered.json",
        {"provenance": {**provenance.machine(), **notes}, "runs": list(map(asdict, made))},
    )
    provenance.write_result(job, NAME, COLUMNS, rows, _figure(rows), notes)
    shutil.rmtree(job.folder / "runs", ignore_errors=True)


def _run(
    job: Job, scene: str, parameters: Mapping[str, str], slow: float, known: list[Spent]
) -> tuple[dict[str, Any], Spent]:
    """A run of a scene, in a process of its own as in a sweep, on this machine, which takes `slow`
    times as long as the reference: its row, and what is known afterwards."""
    case = Case(project_root() / "cases" / scene.partition(",")[0])
    settings = [Setting.parse(f"{PARAMETERS}:{name}={value}") for name, value in parameters.items()]
    folder = job.folder / "runs" / scene.replace(", ", "-").replace(" ", "-")
    shutil.rmtree(folder, ignore_errors=True)
    foreseen = plans(case, [settings])[0]
    expected = price(foreseen, slow, known)
    if failed := perform(Run(case.path, folder, tuple(settings), 1, None)):
        raise ElutriaError(failed)
    paid = read_json(folder / FINISHED)
    cost = (paid["processor_s"], paid["memory_mb"], paid["disk_mb"])
    row = {
        "scene": scene,
        "known": len(known),
        "parcels": foreseen["feed"]["parcels"],
        "expected_s": expected.processor_s,
        "processor_s": cost[0],
        "ratio": expected.processor_s / cost[0],
        "expected_memory_mb": expected.memory_mb,
        "memory_mb": cost[1],
        "expected_disk_mb": expected.disk_mb,
        "disk_mb": cost[2],
    }
    return row, spent(foreseen, *cost)


def _figure(rows: list[dict[str, Any]]) -> Figure:
    """Expected over spent, by scene, with the factor that is promised."""
    figure, axes = plt.subplots(figsize=(6.5, 0.5 + 0.45 * len({row["scene"] for row in rows})))
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    for known, marker, label in ((0, "o", "first run"), (1, "s", "with the first run known")):
        chosen = [row for row in rows if row["known"] == known]
        axes.plot(
            [row["ratio"] for row in chosen],
            [scenes.index(row["scene"]) for row in chosen],
            marker, color="black", fillstyle="none" if known else "full", label=label,
        )  # fmt: skip
    axes.axvspan(1 / PROMISED, PROMISED, color="0.9")
    axes.set_xscale("log")
    axes.set_yticks(range(len(scenes)), scenes)
    axes.invert_yaxis()
    axes.set_xlabel("processor time, expected over spent")
    axes.legend(loc="best", fontsize=8)
    figure.tight_layout()
    return figure
