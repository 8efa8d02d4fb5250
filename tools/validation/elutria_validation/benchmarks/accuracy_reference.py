"""The converged curves that errors are counted from, and what refining them further changes: made
once, kept as two tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np

from elutria.classification.events import join
from elutria.errors import InputError
from elutria.files import read_csv, write_csv
from elutria_validation.benchmarks.accuracy_error import AROUND, Cut, cut_of_events
from elutria_validation.benchmarks.accuracy_runs import (
    DENSE,
    DENSE_REFERENCE,
    REFERENCE,
    Done,
    Point,
    Scene,
    replicates,
    step,
)
from elutria_validation.harness.programs import project_root, slug
from elutria_validation.harness.provenance import machine

COLUMNS = (
    "scene", "how", "parcels", "seeds", "seconds", "made", "commit",
    "d50_m", "d50_sd_m", "sharpness", "sharpness_sd",
    "diameter_m", "partition_to_coarse",
)  # fmt: skip
TEXTS = ("scene", "how", "made", "commit")
FILE = "accuracy_reference.csv"
PARCELS, SEEDS = 12000, (11, 12, 13, 14)
REFINED_COLUMNS = ("scene", "refined", "d50_m", "d50_change", "d50_noise", "seconds")
REFINED_FILE = "accuracy_refined.csv"

Row = dict[str, Any]


@dataclass(frozen=True)
class Reference:
    """A scene's converged curve, and how it was made."""

    cut: Cut
    how: str
    parcels: int
    seconds: float


def make(
    folder: Path, scenes: Sequence[Scene], say: Callable[[str], None]
) -> tuple[list[Row], list[Row]]:
    """Run the finest settings that can be afforded, and those refined further: both tables' rows.

    The dense scene, where the gas is solved on nearly every step, keeps its mesh, and has real
    particles.
    """
    made = machine()
    rows, refined = [], []
    for scene in scenes:
        point = _point(scene)
        runs = _runs(folder, scene, point, SEEDS, say)
        together = join([done.run for done in runs]).events
        how = {
            "scene": scene.name,
            "how": point.name,
            "parcels": len(together),
            "seeds": len(SEEDS),
            "seconds": round(sum(done.seconds for done in runs), 1),
            "made": made["made"],
            "commit": made["commit"],
        }
        cut = cut_of_events(together)
        rows += [{**how, **row} for row in _rows(cut)]
        for seed, done in zip(SEEDS, runs, strict=True):
            refined.append(_refined(scene, f"nothing: seed {seed} alone", done, cut))
        for finer in _refinements(scene):
            (done,) = _runs(folder, scene, finer, SEEDS[:1], say)
            refined.append(_refined(scene, finer.name, done, cut))
    return rows, refined


def _point(scene: Scene) -> Point:
    return DENSE_REFERENCE if scene == DENSE else REFERENCE


def _refinements(scene: Scene) -> list[Point]:
    """The reference with one thing finer."""
    point = _point(scene)
    tolerance = {"system/scenePlan:gasTolerance": 0.002}
    finer = [
        replace(point, name="step / 4", changes={**point.changes, **step(0.25)}),
        replace(point, name=f"mesh x {1.5 * point.mesh:g}", mesh=1.5 * point.mesh),
        replace(point, name="gas tolerance / 5", changes={**point.changes, **tolerance}),
    ]
    if scene != DENSE:
        finer.append(replace(point, name="parcels x 2", parcels=2))
    return finer


def _runs(
    folder: Path, scene: Scene, point: Point, seeds: Sequence[int], say: Callable[[str], None]
) -> list[Done]:
    place = folder / slug("reference", scene.name, point.name)
    return replicates(place, scene, point, PARCELS, seeds, say)


def _refined(scene: Scene, name: str, done: Done, reference: Cut) -> Row:
    cut = cut_of_events(done.run.events)
    return {
        "scene": scene.name,
        "refined": name,
        "d50_m": cut.d50,
        "d50_change": cut.d50 / reference.d50 - 1,
        "d50_noise": hypot(cut.d50_sd, reference.d50_sd) / reference.d50,
        "seconds": round(done.seconds, 1),
    }


def _rows(cut: Cut) -> list[dict[str, float]]:
    grid = AROUND * cut.d50
    return [
        {
            "d50_m": cut.d50,
            "d50_sd_m": cut.d50_sd,
            "sharpness": cut.sharpness,
            "sharpness_sd": cut.sharpness_sd,
            "diameter_m": diameter,
            "partition_to_coarse": share,
        }
        for diameter, share in np.column_stack([grid, cut.at(grid)]).tolist()
    ]


def kept() -> Path:
    """The folder of the tables that the repository keeps."""
    return project_root() / "docs/bench"


def read(folder: Path) -> tuple[dict[str, Reference], list[Row]]:
    """References by the scene's name, and the rows of what refining them changes. Raises
    InputError when there are no such tables."""
    for file in (folder / FILE, folder / REFINED_FILE):
        if not file.is_file():
            raise InputError(f"{file}: file not found; --option reference=make makes it")
    rows = read_csv(folder / FILE, COLUMNS, TEXTS)
    groups = groupby(rows, key=lambda row: str(row["scene"]))
    refined = read_csv(folder / REFINED_FILE, REFINED_COLUMNS, REFINED_COLUMNS[:2])
    return {name: _reference(list(group)) for name, group in groups}, refined


def write(folder: Path, rows: Sequence[Row], refined: Sequence[Row]) -> None:
    """The tables."""
    write_csv(folder / FILE, COLUMNS, rows)
    write_csv(folder / REFINED_FILE, REFINED_COLUMNS, refined)


def _reference(rows: list[dict[str, Any]]) -> Reference:
    first = rows[0]
    d50, d50_sd, sharpness, sharpness_sd = (
        float(first[name]) for name in ("d50_m", "d50_sd_m", "sharpness", "sharpness_sd")
    )
    diameter, share = (
        np.array([float(row[name]) for row in rows])
        for name in ("diameter_m", "partition_to_coarse")
    )
    cut = Cut(d50, d50_sd, sharpness, sharpness_sd, diameter, share)
    return Reference(cut, str(first["how"]), int(first["parcels"]), float(first["seconds"]))
