"""The scenes of the accuracy benchmark, and the settings that each is run with.

A scene is the default column at a gas velocity and a loading, fed for a quarter of a second and
emptied for four, so that grains near the cut leave too. A point is a scene's run with some entries
changed.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from elutria.case.case import Case
from elutria.classification.events import Run, read_run
from elutria.files import read_json, write_json, write_text
from elutria.running.run import is_finished, run_case
from elutria_validation.harness.cases import CLOUD, CONTACTS, CONTROL, MODELS, PARAMETERS, change
from elutria_validation.harness.programs import processor_time, project_root

FEED_TIME, DRAIN_TIME = 0.25, 4.0
"""s: of the feed, and from its end to the run's end."""
STEP, COURANT, COLLISIONS = 4e-3, 4.0, 0.05
"""Limits of the case's time step: s, cells that the gas crosses in it, collisions of a particle."""

Changes = Mapping[str, Any]


def fed(parcels: int, feed: float, drain: float) -> Changes:
    """So many parcels within `feed` s, emptied for `drain` s; nothing is written between."""
    return {
        f"{PARAMETERS}:particles": parcels,
        f"{PARAMETERS}:feedTime": feed,
        f"{PARAMETERS}:drainTime": drain,
        f"{CONTROL}:writeInterval": 1000,
    }


@dataclass(frozen=True)
class Scene:
    """The column at a gas velocity (m/s) and a loading (kg solids per kg gas)."""

    name: str
    velocity: float
    loading: float

    def changes(self, parcels: int) -> dict[str, Any]:
        """Entries of the case."""
        return {
            f"{PARAMETERS}:gasVelocity": self.velocity,
            f"{PARAMETERS}:loading": self.loading,
            **fed(parcels, FEED_TIME, DRAIN_TIME),
        }


SLOW = Scene("column, 4 m/s", 4, 0.2)
FAST = Scene("column, 7 m/s", 7, 0.2)
DENSE = Scene("dense column, 4 m/s, loading 5", 4, 5)


@dataclass(frozen=True)
class Point:
    """What is changed for a run. `parcels` multiplies the usual number, `mesh` the cells along
    each edge; `fast`, `dense` say whether those scenes are run with it too, `column` whether any
    but the dense one is; `once`, that it takes minutes and is run from one seed."""

    name: str
    changes: Changes = field(default_factory=dict)
    parcels: float = 1
    mesh: float = 1
    fast: bool = True
    dense: bool = True
    column: bool = True
    once: bool = False

    def belongs_to(self, scene: Scene) -> bool:
        """Whether the scene is run with it."""
        if scene == DENSE:
            return self.dense
        return self.column and (self.fast or scene != FAST)


def step(factor: float) -> Changes:
    """The time step over the case's, with all that limits it."""
    return {
        f"{CONTROL}:deltaT": factor * STEP,
        f"{CONTROL}:maxDeltaT": factor * STEP,
        f"{CONTROL}:maxCo": factor * COURANT,
        "system/scenePlan:collisionsPerStep": factor * COLLISIONS,
    }


def drag(law: str) -> Changes:
    """Another drag force."""
    return {f"{MODELS}/particleForces": {law: {}, "gravity": {}}}


GAS_ON = {"system/scenePlan:gas": True}
SOFT = {f"{CONTACTS}/treatment": "soft"}
NO_CONTACTS = {f"{MODELS}/collisionModel": "none"}
ONE_WAY = {f"{CLOUD}:solution/coupled": False}
BY_POINTS = {f"{CLOUD}:solution/interpolationSchemes/U.air": "cellPoint"}
REAL = {f"{PARAMETERS}:parcels": "particles"}
STOCK_MODELS: Changes = {
    **drag("sphereDrag"),
    f"{MODELS}/dispersionModel": "stochasticDispersionRAS",
    f"{CLOUD}:ownWake": {"undisturbed": False},
}
"""What stock DPMFoam has for the same things."""

PLAN = "the plan"
COARSE = "one-way, step x 2, mesh x 0.6"
FINE = "one-way, mesh x 1.5, parcels x 3"
POINTS = (
    Point(PLAN),
    Point("parcels / 3", parcels=1 / 3, dense=False),
    Point("parcels x 3", parcels=3, fast=False, dense=False),
    Point("parcels x 10", parcels=10),
    Point("parcels of 12 particles", {"constant/feed:particlesPerParcel": 12}, column=False),
    Point("parcels of 35 particles", {"constant/feed:particlesPerParcel": 35}, column=False),
    Point("soft contacts", SOFT, fast=False, dense=False, once=True),
    Point("one-way", ONE_WAY),
    Point("one-way, parcels x 10", ONE_WAY, parcels=10, dense=False),
    Point("no contacts", NO_CONTACTS, dense=False),
    Point("step / 4", step(0.25)),
    Point("step / 2", step(0.5)),
    Point("step x 2", step(2)),
    Point("mesh x 0.6", mesh=0.6),
    Point("mesh x 0.8", mesh=0.8, dense=False),
    Point("mesh x 1.5", mesh=1.5, fast=False, dense=False),
    Point("gas on every step, mesh x 0.6", GAS_ON, mesh=0.6, fast=False, dense=False),
    Point("everything on, mesh x 0.6, parcels / 3", {**GAS_ON, **SOFT}, 1 / 3, 0.6,
          fast=False, dense=False, once=True),
    Point(FINE, ONE_WAY, 3, 1.5, dense=False),
    Point("step x 2, mesh x 0.6", step(2), mesh=0.6, dense=False),
    Point("one-way, step x 2, parcels / 3", {**ONE_WAY, **step(2)}, parcels=1 / 3, dense=False),
    Point("one-way, step x 2", {**ONE_WAY, **step(2)}, dense=False),
    Point("one-way, step x 2, mesh x 0.8", {**ONE_WAY, **step(2)}, mesh=0.8, dense=False),
    Point("one-way, parcels x 3", ONE_WAY, 3, dense=False),
    Point(f"{COARSE}, parcels / 3", {**ONE_WAY, **step(2)}, 1 / 3, 0.6, dense=False),
    Point(COARSE, {**ONE_WAY, **step(2)}, mesh=0.6, dense=False),
    Point(f"{COARSE}, parcels x 3", {**ONE_WAY, **step(2)}, 3, 0.6, dense=False),
    Point("gas by points", BY_POINTS, dense=False),
    Point("gas by points, mesh x 0.6", BY_POINTS, mesh=0.6, fast=False, dense=False),
    Point(f"gas by points, {FINE}", {**BY_POINTS, **ONE_WAY}, 3, 1.5, fast=False, dense=False),
    Point("emptied for 1 s", {f"{PARAMETERS}:drainTime": 1}, dense=False),
    Point("no focus", {"constant/feed:focus": "none"}, dense=False),
    Point("parcels evenMass", {f"{PARAMETERS}:parcels": "evenMass"}, fast=False, dense=False),
    Point("parcels particles", REAL, fast=False, dense=False),
    Point("parcels particles, step / 2", {**REAL, **step(0.5)}, column=False, once=True),
    Point("parcels particles, mesh x 0.6", REAL, mesh=0.6, column=False, once=True),
)  # fmt: skip
STOCK_LIKE = Point("stock's models", {**REAL, **STOCK_MODELS})
REFERENCE = Point(
    "mesh x 1.5, step / 2, emptied for 8 s", {**step(0.5), f"{PARAMETERS}:drainTime": 8}, mesh=1.5
)
DENSE_REFERENCE = Point(
    "parcels particles, step / 2, gas tolerance / 2",
    {**REAL, **step(0.5), "system/scenePlan:gasTolerance": 0.005},
)
"""The finest that a few minutes can pay; each is refined further to see what that changes."""


@dataclass(frozen=True)
class Done:
    """A run and the seconds of processor that it took."""

    run: Run
    seconds: float


def run_point(folder: Path, scene: Scene, point: Point, parcels: int, seed: int = 1) -> Done:
    """Run a point in FOLDER/run; what is finished there is not run again."""
    return measured(make_case(folder, scene, point, parcels, seed), folder / "run")


def measured(case: Path, folder: Path) -> Done:
    """The run of a case in `folder`, and the processor's seconds as first measured."""
    source, record = Case(case), folder.with_suffix(".json")
    if not is_finished(folder, source.fingerprint([])):
        before = processor_time()
        run_case(source, folder, [])
        write_json(record, {"seconds": processor_time() - before})
    return Done(read_run(folder), float(read_json(record)["seconds"]))


def make_case(folder: Path, scene: Scene, point: Point, parcels: int, seed: int = 1) -> Path:
    """FOLDER/case: the column with the changes of scene and point."""
    case = folder / "case"
    shutil.rmtree(case, ignore_errors=True)
    Case(project_root() / "cases/column").copy_to(case, [])
    number = max(round(point.parcels * parcels), 10)
    if point.changes.get(f"{PARAMETERS}:parcels") == "particles":
        number = 10**6  # as many as the feed has in its time
    change(case, {**scene.changes(number), f"{PARAMETERS}:seed": seed, **point.changes})
    if point.mesh != 1:
        refine(case, point.mesh)
    return case


def refine(case: Path, factor: float) -> None:
    """Multiply the cells of every block along its edges."""
    plan = case / "system/blockMeshDict"

    def cells(match: re.Match[str]) -> str:
        numbers = (max(round(factor * int(n)), 1) for n in match[2].split())
        return f"{match[1]}({' '.join(map(str, numbers))})"

    text, found = re.subn(r"(hex\s*\([^)]*\)\s*)\(([^)]*)\)", cells, plan.read_text())
    assert found, plan
    write_text(plan, text)


def replicates(
    folder: Path,
    scene: Scene,
    point: Point,
    parcels: int,
    seeds: Iterable[int],
    say: Callable[[str], None] = lambda _: None,
) -> list[Done]:
    """Runs that differ by their seed alone, in FOLDER/seedN."""
    runs = []
    for seed in seeds:
        runs.append(run_point(folder / f"seed{seed}", scene, point, parcels, seed))
        say(f"{scene.name}, {point.name}, seed {seed}: {runs[-1].seconds:.3g} s")
    return runs
