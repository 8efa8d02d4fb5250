"""The converged curves that errors are counted from: made once, kept as a table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from elutria.bench.accuracy_error import AROUND, Cut, cut_of_events
from elutria.bench.accuracy_runs import (
    DENSE,
    DENSE_REFERENCE,
    REFERENCE,
    SLOW,
    Scene,
    replicates,
)
from elutria.bench.common import machine, project_root, slug
from elutria.errors import InputError
from elutria.files import read_csv, write_csv

COLUMNS = (
    "scene", "how", "parcels", "seeds", "seconds", "made", "commit",
    "d50_m", "d50_sd_m", "sharpness", "sharpness_sd",
    "diameter_m", "partition_to_coarse",
)  # fmt: skip
TEXTS = ("scene", "how", "made", "commit")
FILE = "accuracy_reference.csv"
PARCELS, SEEDS = 6000, 2


@dataclass(frozen=True)
class Reference:
    """A scene's converged curve, and how it was made."""

    cut: Cut
    how: str
    parcels: int
    seconds: float


def make(
    folder: Path, scenes: Sequence[Scene], parcels: int, seeds: int, say: Callable[[str], None]
) -> list[dict[str, Any]]:
    """Run the finest settings that can be afforded, with several seeds, and give the rows.

    The dense scene, where the gas is solved on nearly every step, keeps its mesh, and has real
    particles. `seeds` are of the first scene, the others get one.
    """
    made = machine()
    rows = []
    for scene in scenes:
        point = DENSE_REFERENCE if scene == DENSE else REFERENCE
        number = seeds if scene == SLOW else 1
        done = replicates(
            folder / slug("reference", scene.name), scene, point, parcels,
            range(11, 11 + number), say,
        )  # fmt: skip
        how = {
            "scene": scene.name,
            "how": point.name,
            "parcels": len(done.run.events),
            "seeds": number,
            "seconds": round(done.seconds, 1),
            "made": made["made"],
            "commit": made["commit"],
        }
        rows += [{**how, **row} for row in _rows(cut_of_events(done.run.events))]
    return rows


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
    """The table that the repository keeps."""
    return project_root() / "docs/bench" / FILE


def read(file: Path) -> dict[str, Reference]:
    """References by the scene's name. Raises InputError when there is no such table."""
    if not file.is_file():
        raise InputError(f"{file}: file not found; --option reference=make makes it")
    rows = read_csv(file, COLUMNS, TEXTS)
    groups = groupby(rows, key=lambda row: str(row["scene"]))
    return {name: _reference(list(group)) for name, group in groups}


def write(file: Path, rows: Sequence[dict[str, Any]]) -> None:
    """The table."""
    write_csv(file, COLUMNS, rows)


def _reference(rows: list[dict[str, Any]]) -> Reference:
    first = rows[0]
    columns = ("diameter_m", "partition_to_coarse")
    cut = Cut(
        *(float(first[name]) for name in ("d50_m", "d50_sd_m", "sharpness", "sharpness_sd")),
        *(np.array([float(row[name]) for row in rows]) for name in columns),
    )
    return Reference(cut, str(first["how"]), int(first["parcels"]), float(first["seconds"]))
