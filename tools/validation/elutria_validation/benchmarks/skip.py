"""What each skip of the scene plan saves, and what it changes: every skip is taken back on its own,
and all of them together, with the same particles, on three scenes. Cost is processor time.

A column's answer is its cut; a bed's is where its spheres lie. Two runs of a turbulent, colliding
column differ by chance, and so do beds: each scene is run from several seeds, and its row has the
median cost, the mean change, and its standard error as `d50_chance`. `changed_outlets` counts the
parcels that left through another outlet than in the plan's run.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from math import nan, sqrt
from pathlib import Path
from statistics import mean, median, stdev
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from elutria import tables
from elutria.case.case import PARAMETERS, Case, Setting
from elutria.classification.classify import fit_events
from elutria.classification.events import read_run
from elutria.files import read_csv
from elutria.running.run import run_case
from elutria_validation.harness.cases import CLOUD, CONTACTS
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.programs import processor_time, project_root
from elutria_validation.harness.provenance import write_result
from elutria_validation.harness.scenes import contacts, settling_bed

NAME = "skip"
HELP = "what each skip of the scene plan saves, and what it changes"

COLUMNS = (
    "scene", "taken_back", "processor_s", "cost_over_plan", "d50_m", "d50_change", "d50_chance",
    "sharpness", "sharpness_change", "momentum_change", "momentum_kg_m_s",
    "changed_outlets", "parcels",
)  # fmt: skip

GAS = "system/scenePlan:gas"
GAS_EVERY_STEP = {GAS: "on"}
SOFT = {f"{CONTACTS}/treatment": "soft"}
Choices = Mapping[str, Mapping[str, str]]
PLAN = "nothing: the plan"
CONTACT_CHOICES: Choices = {
    PLAN: {},
    "contacts as impacts": SOFT,
    "all of it": {**GAS_EVERY_STEP, **SOFT},
}
GAS_CHOICES: Choices = {
    PLAN: {},
    "gas at rest": GAS_EVERY_STEP,
    "coupling (one-way)": {f"{CLOUD}:solution/coupled": "false"},
}
BED_CHOICES: Choices = {PLAN: {}, "gas at rest": GAS_EVERY_STEP, **CONTACT_CHOICES}
LOADINGS = {"dilute column": 0.01, "default column": 0.2}


@dataclass(frozen=True)
class Trial:
    """One run of a scene: processor time (s); d50, or a bed's mean height (m); sharpness; vertical
    momentum and the one that its changes are counted in (kg m/s); number of parcels that left (or
    are in the bed), and the outlet of each by its diameter, of which there are no two alike."""

    seconds: float
    size: float
    sharpness: float
    momentum: float
    momentum_unit: float
    parcels: int
    outlets: Mapping[float, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Options:
    """Its own. Runs with contact steps have a fifth of the parcels: they are slow."""

    particles: int = option(5000, quick=60, least=10, unit="fed to a column, as many in each class")


def run(job: Job, options: Options) -> None:
    """Run every scene with every choice, from as many seeds as `--repeats`, two at least; writes
    skip.csv, .png and .json."""
    number = options.particles
    spheres, end = (64, 0.3) if job.quick else (256, 2.0)
    folder = job.folder / "runs"
    rows: list[dict[str, Any]] = []
    for name, loading in LOADINGS.items():
        for choices, parcels in ((GAS_CHOICES, number), (CONTACT_CHOICES, number // 5)):
            usual = {"loading": f"{loading:g}", "feedTime": "0.5", "particles": str(parcels)}
            if job.quick:
                usual["drainTime"] = "0.2"
            column = partial(_column, folder / "column", usual)
            rows += _scene(job, f"{name}, {parcels} parcels", choices, column)
    rows += _scene(job, "bed at rest", BED_CHOICES, partial(_bed, folder / "bed", spheres, end))
    write_result(job, NAME, COLUMNS, rows, _figure(rows), {"particles": number})
    shutil.rmtree(folder, ignore_errors=True)


def _scene(
    job: Job, scene: str, choices: Choices, trial: Callable[[Mapping[str, str], int], Trial]
) -> list[dict[str, Any]]:
    """A row for each choice."""
    trials: dict[str, list[Trial]] = {name: [] for name in choices}
    for seed in range(1, 1 + max(job.repeats, 2)):
        for name, settings in choices.items():
            trials[name].append(trial(settings, seed))
            job.say(f"{scene}, seed {seed}, {name}: {trials[name][-1].seconds:.1f} s")
    return [_row(scene, name, trials[name], trials[PLAN]) for name in choices]


def _column(
    folder: Path, usual: Mapping[str, str], settings: Mapping[str, str], seed: int
) -> Trial:
    """The default column with its `usual` parameters and a choice's settings."""
    shutil.rmtree(folder, ignore_errors=True)
    parameters = {f"{PARAMETERS}:{name}": value for name, value in usual.items()}
    chosen = {**parameters, f"{PARAMETERS}:seed": str(seed), **settings}
    before = processor_time()
    run_case(
        Case(project_root() / "cases/column"),
        folder,
        [Setting.parse(f"{key}={value}") for key, value in chosen.items()],
    )
    seconds = processor_time() - before
    events = read_run(folder).events
    left = events.select(events.has_left)
    fit = fit_events(events)
    momentum = _momentum(folder)
    outlets = dict(zip(left.diameter.tolist(), left.outlet.tolist(), strict=True))
    return Trial(seconds, fit.d50, fit.sharpness, momentum, momentum, len(left), outlets)


def _momentum(folder: Path) -> float:
    """Vertical momentum (kg m/s) of the parcels of a run when they left, downwards counted too."""
    total = 0.0
    for table in folder.glob("postProcessing/outlets/*/particles.csv"):
        for row in read_csv(table, tables.EVENTS, ("material", "outlet")):
            mass = float(row["density_kg_m3"]) * np.pi / 6 * float(row["diameter_m"]) ** 3
            total += float(row["n_particle"]) * mass * abs(float(row["uz_m_s"]))
    return total


def _bed(folder: Path, number: int, end: float, settings: Mapping[str, str], seed: int) -> Trial:
    """A settled bed; changes of its momentum are counted in that of all at 0.1 m/s."""
    shutil.rmtree(folder, ignore_errors=True)
    gas = {GAS: True if GAS in settings else "auto"}  # foamlib's word for on
    before = processor_time()
    _, spheres, _ = settling_bed(
        folder, contacts(), number=number, end=end, seed=seed, more={**settings, **gas}
    )
    seconds = processor_time() - before
    height, unit = float(np.mean(spheres.position[:, 2])), 0.1 * float(np.sum(spheres.mass))
    return Trial(seconds, height, nan, float(spheres.momentum[2]), unit, number)


def _row(scene: str, name: str, trials: list[Trial], plan: list[Trial]) -> dict[str, Any]:
    pairs = list(zip(trials, plan, strict=True))
    change = [one.size / other.size - 1 for one, other in pairs]
    return {
        "scene": scene,
        "taken_back": name,
        "processor_s": round(median(one.seconds for one in trials), 2),
        "cost_over_plan": median(one.seconds / other.seconds for one, other in pairs),
        "d50_m": mean(one.size for one in trials),
        "d50_change": mean(change),
        "d50_chance": stdev(change) / sqrt(len(change)),
        "sharpness": mean(one.sharpness for one in trials),
        "sharpness_change": mean(one.sharpness - other.sharpness for one, other in pairs),
        "momentum_change": mean(
            (one.momentum - other.momentum) / other.momentum_unit for one, other in pairs
        ),
        "momentum_kg_m_s": mean(one.momentum for one in trials),
        "changed_outlets": sum(_changed_outlets(one, other) for one, other in pairs),
        "parcels": sum(one.parcels for one in trials),
    }


def _changed_outlets(one: Trial, other: Trial) -> int:
    """Parcels that left in both runs, through different outlets."""
    both = one.outlets.keys() & other.outlets.keys()
    return sum(one.outlets[key] != other.outlets[key] for key in both)


def _figure(rows: list[dict[str, Any]]) -> Figure:
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    figure, panels = plt.subplots(
        len(scenes), 2, figsize=(174 / 25.4, 40 / 25.4 * len(scenes)), layout="constrained"
    )
    for (cost, answer), scene in zip(panels, scenes, strict=True):
        here = [row for row in rows if row["scene"] == scene]
        names = [row["taken_back"] for row in here]
        cost.barh(names, [row["cost_over_plan"] for row in here], color="#0072B2")
        if max(row["cost_over_plan"] for row in here) > 3:
            cost.set_xscale("log")
            cost.set_xlim(left=0.5)
            cost.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            cost.xaxis.set_minor_locator(NullLocator())
            cost.xaxis.set_major_formatter("{x:g}")
        cost.set_title(scene, fontsize=8, loc="left")
        answer.errorbar(
            [100 * row["d50_change"] for row in here],
            names,
            xerr=[100 * row["d50_chance"] for row in here],
            fmt="o", color="#D55E00", markersize=4, capsize=2,
        )  # fmt: skip
        answer.axvline(0, color="0.7", linewidth=0.8)
        answer.set_yticklabels([])
        for axes in (cost, answer):
            axes.invert_yaxis()
            axes.tick_params(labelsize=7)
    panels[-1][0].set_xlabel("processor time over the plan's", fontsize=8)
    panels[-1][1].set_xlabel("change of d50 (bed: height), %, ± s.e.", fontsize=8)
    return figure
