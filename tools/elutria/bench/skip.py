"""What each skip of the scene plan saves, and what it changes: every skip is taken back on its own,
and all of them together, with the same particles, on three scenes. Cost is processor time.

A column's answer is its cut; a bed's is where its spheres lie. Two runs of a turbulent, colliding
column differ by chance: `changed_outlets` counts the parcels that left through another outlet than
in the plan's run, and `d50_chance` is how far d50 can move by the chance of those alone. Beds start
from several states: median cost, mean change of height, and its standard error as `d50_chance`.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from math import nan, sqrt
from pathlib import Path
from statistics import median
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from elutria.bench.common import Options, processor_time, project_root, write_result
from elutria.bench.stability_scenes import bed, contacts
from elutria.case import Case, Setting
from elutria.classify import fit_events
from elutria.events import COLUMNS as EVENT_COLUMNS
from elutria.events import Run, read_run
from elutria.files import read_csv
from elutria.run import run_case
from elutria.verification.scene import CLOUD, CONTACTS

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
TAKEN_BACK: dict[str, Mapping[str, str]] = {
    "nothing: the plan": {},
    "gas at rest": GAS_EVERY_STEP,
    "contacts as impacts": SOFT,
    "all of it": {**GAS_EVERY_STEP, **SOFT},
}
ONE_WAY = "coupling (one-way)"
COLUMNS_SCENES = {"dilute column": 0.01, "default column": 0.2}


def run(options: Options) -> None:
    """Run every scene with every choice, the bed from as many starts as `--repeats`; writes
    skip.csv, .png and .json.

    `--option particles=N`: parcels fed to a column, as many in each size class (default 1000,
    quick 60).
    """
    number = int(options.extra.get("particles", "60" if options.quick else "1000"))
    rows: list[dict[str, Any]] = []
    for scene, loading in COLUMNS_SCENES.items():
        choices = {**TAKEN_BACK, ONE_WAY: {f"{CLOUD}:solution/coupled": "false"}}
        plan: Run | None = None
        for name, settings in choices.items():
            seconds, result = _column(options.folder / "runs", loading, number, settings)
            plan = plan or result
            momentum = _momentum(options.folder / "runs/column")
            rows.append(_row(scene, name, seconds, momentum, rows, result, plan))
            options.say(f"{scene}, {name}: {seconds:.1f} s")
    rows += _beds(options)
    write_result(options, NAME, COLUMNS, rows, _figure(rows), {"particles": number})
    shutil.rmtree(options.folder / "runs", ignore_errors=True)


def _column(
    folder: Path, loading: float, number: int, settings: Mapping[str, str]
) -> tuple[float, Run]:
    """Processor seconds and the events of the default column, fed for half a second."""
    shutil.rmtree(folder, ignore_errors=True)
    chosen = {
        "system/simulationParameters:loading": f"{loading:g}",
        "system/simulationParameters:feedTime": "0.5",
        "system/simulationParameters:particles": str(number),
        **settings,
    }
    before = processor_time()
    run_case(
        Case(project_root() / "cases/column"),
        folder / "column",
        [Setting(*key.split(":"), value) for key, value in chosen.items()],
    )
    return processor_time() - before, read_run(folder / "column")


def _row(
    scene: str,
    name: str,
    seconds: float,
    momentum: float,
    rows: list[dict[str, Any]],
    result: Run,
    plan: Run,
) -> dict[str, Any]:
    first = next((row for row in rows if row["scene"] == scene), None)
    fit = fit_events(result.events)
    reference = fit_events(plan.events)
    changed, left = _changed_outlets(result, plan)
    return {
        "scene": scene,
        "taken_back": name,
        "processor_s": round(seconds, 2),
        "cost_over_plan": seconds / first["processor_s"] if first else 1.0,
        "d50_m": fit.d50,
        "d50_change": fit.d50 / reference.d50 - 1,
        "d50_chance": _chance(changed, left, plan),
        "sharpness": fit.sharpness,
        "sharpness_change": fit.sharpness - reference.sharpness,
        "momentum_change": momentum / first["momentum_kg_m_s"] - 1 if first else 0.0,
        "momentum_kg_m_s": momentum,
        "changed_outlets": changed,
        "parcels": left,
    }


def _changed_outlets(result: Run, plan: Run) -> tuple[int, int]:
    """Parcels that left in both runs, through different outlets; and those that left in both."""

    def outlets(run: Run) -> dict[float, str]:
        left = run.events.select(run.events.has_left)
        return dict(zip(left.diameter.tolist(), left.outlet.tolist(), strict=True))

    one, other = outlets(result), outlets(plan)
    both = one.keys() & other.keys()
    return sum(one[key] != other[key] for key in both), len(both)


def _chance(changed: int, left: int, plan: Run) -> float:
    """Standard deviation of ln d50 when so many parcels near the cut change sides by chance."""
    events = plan.events.select(plan.events.has_left)
    center = fit_events(plan.events).d50
    near = np.abs(np.log(events.diameter / center)) < 0.15
    density = np.sum(near) / 0.3
    return sqrt(changed) / density if density > 0 and left else nan


def _momentum(folder: Path) -> float:
    """Vertical momentum (kg m/s) of the parcels of a run when they left, downwards counted too."""
    total = 0.0
    for table in folder.glob("postProcessing/outlets/*/particles.csv"):
        for row in read_csv(table, EVENT_COLUMNS, ("material", "outlet")):
            mass = float(row["density_kg_m3"]) * np.pi / 6 * float(row["diameter_m"]) ** 3
            total += float(row["n_particle"]) * mass * abs(float(row["uz_m_s"]))
    return total


def _beds(options: Options) -> list[dict[str, Any]]:
    """Settled beds from several starts: cost, and the relative change of their mean height."""
    number, end = (64, 0.3) if options.quick else (256, 2.0)
    starts = max(options.repeats, 2)
    seconds: dict[str, list[float]] = {name: [] for name in TAKEN_BACK}
    height: dict[str, list[float]] = {name: [] for name in TAKEN_BACK}
    momentum: dict[str, list[float]] = {name: [] for name in TAKEN_BACK}
    for start in range(starts):
        for name, settings in TAKEN_BACK.items():
            folder = options.folder / "runs" / "bed"
            shutil.rmtree(folder, ignore_errors=True)
            gas = {GAS: True if GAS in settings else "auto"}  # foamlib's word for on
            before = processor_time()
            _, spheres, _ = bed(
                folder, {**contacts(), **settings, **gas}, number=number, end=end, seed=4 + start
            )
            seconds[name].append(processor_time() - before)
            height[name].append(float(np.mean(spheres.position[:, 2])))
            unit = float(np.sum(spheres.mass) * 0.1)  # kg m/s, as if all moved at 0.1 m/s
            momentum[name].append(float(spheres.momentum[2]) / unit)
        options.say(f"beds, start {start + 1} of {starts}")

    plan = next(iter(TAKEN_BACK))
    rows = []
    for name in TAKEN_BACK:
        change = np.array(height[name]) / height[plan] - 1
        rows.append(
            {
                **dict.fromkeys(COLUMNS, nan),
                "scene": "bed at rest",
                "taken_back": name,
                "processor_s": round(median(seconds[name]), 2),
                "cost_over_plan": float(np.median(np.divide(seconds[name], seconds[plan]))),
                "d50_m": float(np.mean(height[name])),
                "d50_change": float(np.mean(change)),
                "d50_chance": float(np.std(change, ddof=1) / sqrt(starts)),
                "momentum_change": float(np.mean(np.subtract(momentum[name], momentum[plan]))),
                "parcels": number,
            }
        )
    return rows


def _figure(rows: list[dict[str, Any]]) -> plt.Figure:
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
        cost.set_title(scene, fontsize=8, loc="left")
        answer.errorbar(
            [100 * row["d50_change"] for row in here],
            names,
            xerr=[196 * row["d50_chance"] if row["d50_chance"] == row["d50_chance"] else 0
                  for row in here],
            fmt="o", color="#D55E00", markersize=4, capsize=2,
        )  # fmt: skip
        answer.axvline(0, color="0.7", linewidth=0.8)
        answer.set_yticklabels([])
        for axes in (cost, answer):
            axes.invert_yaxis()
            axes.tick_params(labelsize=7)
    panels[-1][0].set_xlabel("processor time over the plan's", fontsize=8)
    panels[-1][1].set_xlabel("change of d50 (bed: of its height), %", fontsize=8)
    return figure
