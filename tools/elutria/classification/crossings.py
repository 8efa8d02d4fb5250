"""What planes inside the column count: fluxes up and down by size, hold-up and residence by height,
and the stage model that follows from the crossings.

A parcel that has crossed a plane next reaches the plane above, the plane below, or leaves: a walk
whose steps are counted here, to and fro across one plane left out. The chance of a step upwards,
taken as the same at all planes, makes the column a cascade of equal stages (gambler's ruin): its
share to the last product is worked out from the crossings alone and stands beside what left. A step
may also be likelier after one of its kind: a walk with memory, of equal stages too.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, nan, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from elutria import tables
from elutria.errors import InputError, one_line
from elutria.files import reading, write_csv

Array = NDArray[np.float64]
Row = dict[str, Any]

CLASSES_PER_DECADE = 20
"""Of size, as in ISO 3's series R20."""


@dataclass(frozen=True)
class Counted:
    """Crossings in order of parcel and time, and the parcels that left, by their number `id`."""

    crossings: pd.DataFrame
    parcels: pd.DataFrame
    heights: Array  # m, of the planes that were crossed, rising
    partition_to: str


def read_counted(run: Path, partition_to: str) -> Counted | None:
    """None for a run without planes. Raises InputError for files that are not whole."""
    folder = run / "postProcessing"
    crossings = _read(folder / "crossings", "crossings.csv", tables.CROSSINGS)
    if crossings is None:
        return None
    parcels = _read(folder / "outlets", "particles.csv", tables.EVENTS)
    if parcels is None:
        raise InputError(f"{folder / 'outlets'}: no particles.csv; allowed: a run of elutriaFoam")
    known = parcels["id"]
    crossings = crossings[crossings["id"].isin(known)]
    crossings = crossings.sort_values(["id", "time_s"], kind="stable").reset_index(drop=True)
    planes = crossings.groupby("plane")["height_m"].first()
    heights = np.full(int(planes.index.max()) + 1 if len(planes) else 0, nan)
    heights[planes.index.to_numpy()] = planes.to_numpy()
    return Counted(crossings, parcels.set_index("id"), heights, partition_to)


def _read(folder: Path, name: str, columns: tuple[str, ...]) -> pd.DataFrame | None:
    files = sorted(folder.glob(f"*/{name}"), key=lambda file: float(file.parent.name))
    frames = []
    for file in files:
        with reading(file, limit=4_000_000_000):
            try:
                frame = pd.read_csv(file)
            except ValueError as error:
                raise InputError(f"{file}: {one_line(error)}") from error
        if tuple(frame.columns) != columns:
            raise InputError(f"{file}: first line must be {','.join(columns)}")
        frames.append(frame)
    return pd.concat(frames, ignore_index=True) if frames else None


def write_crossings(run: Path, to: Path, partition_to: str) -> bool:
    """planes.csv, zones.csv and stages.csv in `to`; False for a run without planes."""
    counted = read_counted(run, partition_to)
    if counted is None:
        return False
    write_csv(to / "planes.csv", tables.PLANES, plane_rows(counted))
    write_csv(to / "zones.csv", tables.ZONES, zone_rows(counted))
    write_csv(to / "stages.csv", tables.STAGES, stage_rows(counted))
    return True


def _classes(counted: Counted) -> Iterator[tuple[Row, pd.DataFrame, pd.DataFrame]]:
    """Of each material and size class its key, its parcels that left, and their crossings."""
    parcels = counted.parcels
    number = np.floor(np.log10(parcels["diameter_m"].to_numpy()) * CLASSES_PER_DECADE + 1e-9)
    names = parcels["material"].to_numpy()
    for material in sorted(set(names.tolist())):
        for index in np.unique(number[names == material]).tolist():
            members = parcels[(names == material) & (number == index)]
            key = {
                "material": material,
                "diameter_low_m": 10 ** (index / CLASSES_PER_DECADE),
                "diameter_high_m": 10 ** ((index + 1) / CLASSES_PER_DECADE),
            }
            yield key, members, counted.crossings[counted.crossings["id"].isin(members.index)]


def _mass(rows: pd.DataFrame, parcels: pd.DataFrame) -> Array:
    """kg, of the parcels of rows."""
    density = parcels["density_kg_m3"].reindex(rows["id"]).to_numpy()
    volume = pi / 6 * rows["diameter_m"].to_numpy() ** 3
    return np.asarray(rows["n_particle"].to_numpy() * density * volume)


def plane_rows(counted: Counted) -> list[Row]:
    """planes.csv: what crossed each plane upwards and downwards, of what left."""
    rows = []
    for key, members, crossings in _classes(counted):
        mass = _mass(crossings, members)
        for plane, height in enumerate(counted.heights):
            row: Row = {"plane": plane, "height_m": height, **key}
            for name, direction in (("up", 1), ("down", -1)):
                here = (crossings["plane"] == plane) & (crossings["direction"] == direction)
                row[f"{name}_number"] = float(crossings["n_particle"][here].sum())
                row[f"{name}_kg"] = float(mass[here].sum())
            rows.append(row)
    return rows


def _visits(members: pd.DataFrame, crossings: pd.DataFrame) -> tuple[Array, Array, Array]:
    """Of each stay in a zone: the parcel's number, the zone (0: below the lowest plane), seconds.
    Parcels that crossed no plane stayed in one zone that is not known: they have none."""
    plane, direction = crossings["plane"].to_numpy(), crossings["direction"].to_numpy()
    times, ids = crossings["time_s"].to_numpy(), crossings["id"].to_numpy()
    after, before = plane + (direction > 0), plane + (direction < 0)
    first = np.r_[True, ids[1:] != ids[:-1]] if ids.size else np.empty(0, bool)
    last = np.r_[first[1:], True] if ids.size else first
    left = members["time_s"].reindex(ids).to_numpy()
    entered = left - members["residence_time_s"].reindex(ids).to_numpy()
    ends = np.where(last, left, np.r_[times[1:], nan] if ids.size else times)
    return (
        np.r_[ids[first], ids],
        np.r_[before[first], after],
        np.r_[(times - entered)[first], ends - times],
    )


def zone_rows(counted: Counted) -> list[Row]:
    """zones.csv: mean stay of a parcel in each zone between planes, and the mass held there times
    seconds."""
    edges = [-inf, *counted.heights, inf]
    rows = []
    for key, members, crossings in _classes(counted):
        ids, zones, stay = _visits(members, crossings)
        volume = pi / 6 * members["diameter_m"] ** 3
        mass = (members["n_particle"] * members["density_kg_m3"] * volume).reindex(ids).to_numpy()
        for zone, (low, high) in enumerate(itertools.pairwise(edges)):
            here = zones == zone
            rows.append({
                "zone": zone, "low_m": low, "high_m": high, **key,
                "residence_time_s": float(stay[here].sum()) / len(members),
                "holdup_kg_s": float((mass * stay)[here].sum()),
            })  # fmt: skip
    return rows


def steps(crossings: pd.DataFrame) -> tuple[Array, Array, Array]:
    """The walks over planes: of each step its plane, whether it went up (1), down (-1) or where it
    began (0), and the parcel. The last step of each parcel, out of the planes, is not there."""
    ids, plane = crossings["id"].to_numpy(), crossings["plane"].to_numpy()
    if not ids.size:
        return plane, plane, ids
    begins = np.r_[True, ids[1:] != ids[:-1]]
    touched = begins | np.r_[True, plane[1:] != plane[:-1]]  # to and fro across a plane is once
    plane, ids, begins = plane[touched], ids[touched], begins[touched]
    went = np.where(begins, 0, np.sign(np.r_[0, np.diff(plane)]))
    return plane, went, ids


def leave_below(up: Array) -> Array:
    """Chance to leave at the bottom from each of n planes in a row, where `up` is the chance of a
    step upwards at each: u_i = up_i u_(i+1) + (1 - up_i) u_(i-1), 1 below and 0 above."""
    n = up.size
    matrix = np.eye(n) - np.diag(up[:-1], 1) - np.diag(1 - up[1:], -1)
    right = np.zeros(n)
    right[0] = 1 - up[0]
    return np.asarray(np.linalg.solve(matrix, right))


def leave_below_with_memory(planes: int, up: dict[int, float]) -> Array:
    """The same from each of n equal planes where a parcel begins, where the chance of a step
    upwards is up[1] after one upwards, up[-1] after one downwards, and up[0] at the begin."""
    # of a plane and the step that led to it: up first, then down
    matrix, right = np.eye(2 * planes), np.zeros(2 * planes)
    for plane, (offset, went) in itertools.product(range(planes), ((0, 1), (planes, -1))):
        row = offset + plane
        if plane + 1 < planes:
            matrix[row, plane + 1] -= up[went]
        if plane > 0:
            matrix[row, planes + plane - 1] -= 1 - up[went]
        else:
            right[row] = 1 - up[went]
    after = np.linalg.solve(matrix, right)
    above = np.r_[after[1:planes], 0.0]
    below = np.r_[1.0, after[planes : 2 * planes - 1]]
    return np.asarray(up[0] * above + (1 - up[0]) * below)


def stage_rows(counted: Counted) -> list[Row]:
    """stages.csv: the chance of a step upwards, and the share to the last product by equal stages,
    by those of a walk with memory, and as it left."""
    rows = []
    for key, members, crossings in _classes(counted):
        found = float(np.mean(members["outlet"] == counted.partition_to))
        rows.append({
            **key, "parcels": len(members), **_walks(counted, members, crossings),
            "partition": found,
            "partition_error": sqrt(max(found * (1 - found), 0.25 / len(members)) / len(members)),
        })  # fmt: skip
    return rows


def _walks(counted: Counted, members: pd.DataFrame, crossings: pd.DataFrame) -> Row:
    """Chances of a step, and the shares that follow from them."""
    planes = counted.heights.size
    plane, came, ids = steps(crossings)
    is_coarse = members["outlet"] == counted.partition_to
    last = np.r_[ids[1:] != ids[:-1], True] if ids.size else np.empty(0, bool)
    # the step that follows: to the next plane, or out
    out = np.where(is_coarse.reindex(ids).to_numpy(dtype=bool), -1, 1)
    goes = np.where(last, out, np.r_[came[1:], 0] if ids.size else came)
    chance = _up(goes)
    up = {0: _up(goes[came == 0]), 1: _up(goes[came > 0]), -1: _up(goes[came < 0])}
    by_stages, by_memory = nan, nan
    if goes.size:
        start = np.bincount(plane[came == 0], minlength=planes) / len(members)
        away = float(np.mean(~members.index.isin(ids) & is_coarse))
        known = {kind: chance if np.isnan(one) else one for kind, one in up.items()}
        by_stages = float(start @ leave_below(np.full(planes, chance))) + away
        by_memory = float(start @ leave_below_with_memory(planes, known)) + away
    return {
        "steps": goes.size, "step_up": chance, "step_up_after_up": up[1],
        "step_up_after_down": up[-1], "partition_by_stages": by_stages,
        "partition_by_memory": by_memory,
    }  # fmt: skip


def _up(goes: Array) -> float:
    """Share of steps upwards; nan of none."""
    return float(np.mean(goes > 0)) if goes.size else nan
