"""The gas of a run as it was solved: what passes each inlet and outlet, and whether the gas
velocity that a result is called after is that of its gas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from elutria import tables
from elutria.case.case import PARAMETERS, VELOCITY, Case, Setting
from elutria.errors import InputError
from elutria.files import read_csv, write_csv
from elutria.running.run import PLAN, plans, read_plan
from elutria.warned import Warned

ALLOWED = 0.01
"""By how much, relatively, the gas may differ from the velocity that a result is called after."""


def write_gas(
    folder: Path, runs: Sequence[tuple[Mapping[str, Any], Path]], axes: Sequence[str] = ()
) -> None:
    """gas.csv in `folder`, of runs and their settings: gas_velocity_m_s, and `axes`."""
    rows = [{**row, **settings} for settings, run in runs for row in mean_gas(run)]
    write_csv(folder / "gas.csv", (*tables.GAS, *axes), rows)


def mean_gas(run: Path) -> list[dict[str, Any]]:
    """A row per inlet and outlet of a run, and one for all that flows in: means over time."""
    rows = sorted(_patch_flows(run), key=lambda row: str(row["patch"]))
    means = []
    for patch, group in groupby(rows, key=lambda row: str(row["patch"])):
        of_patch = list(group)
        mean = {name: sum(row[name] for row in of_patch) / len(of_patch)
                for name in tables.PATCH_FLOWS[2:]}  # fmt: skip
        means.append({"patch": patch, **mean})
    return means


def _patch_flows(run: Path) -> list[dict[str, Any]]:
    """What the starts of a run wrote, each until the next one began."""
    starts = sorted(
        (float(file.parent.name), file) for file in (run / "postProcessing/gas").glob("*/gas.csv")
    )
    ends = [time for time, _ in starts[1:]] + [inf]
    words = ("patch",)
    return [
        row
        for (_, file), end in zip(starts, ends, strict=False)
        for row in read_csv(file, tables.PATCH_FLOWS, words)
        if row["time_s"] < end
    ]


def require_acting_velocity(
    case: Case,
    labels: Sequence[tuple[float, Sequence[Setting]]],
    planned: Sequence[tuple[float, Mapping[str, Any]]] = (),
) -> None:
    """Raise InputError where the gas of a run is not that of its velocity (m/s) and does not follow
    it either. The first and the last run are planned, unless `planned` ones of two velocities are
    known; nothing is solved.

    Where the gas goes with the velocity but differs from it, the case has its own notion of it:
    that is a warning of the run, see gas_warnings.
    """
    if planned and planned[0][0] != planned[-1][0]:
        (low, first), (high, last) = planned[0], planned[-1]
        tried, gases = high, [first["gas"], last["gas"]]
    else:
        (low, settings), (high, others) = labels[0], labels[-1]
        tried = high
        if low == high:
            tried = 1.25 * low
            others = [*settings, Setting.parse(f"{VELOCITY}={tried:.12g}")]
        gases = [plan["gas"] for plan in plans(case, [settings, others])]
    if not all(gas["inflow_is_fixed"] for gas in gases):
        return  # known when the gas has settled: require_found
    found = gases[1]["superficial_m_s"] / gases[0]["superficial_m_s"]
    if abs(found / (tried / low) - 1) <= ALLOWED:
        return
    for label, gas in zip((low, high) if low != high else (low,), gases, strict=False):
        if not _matches(gas, label):
            raise InputError(_refusal(case.path, label, gas, "does not act on it"))


def gas_warnings(run: Path, velocity: float) -> list[Warned]:
    """What is wrong with the gas of a run that is called after a velocity (m/s)."""
    return [*_label_warnings(run, velocity), *_change_warnings(run)]


def _change_warnings(run: Path) -> list[Warned]:
    """A warning where the inflow changed on the way: the run's gas velocity and a feed by `loading`
    are those of its first gas."""
    rows = sorted(
        (row["time_s"], row["velocity_m_s"]) for row in _patch_flows(run) if row["patch"] == "all"
    )
    time, speed = np.array(rows, dtype=float).reshape(-1, 2).T
    if len(rows) < 2 or not time[-1] > time[0] or not speed[0] > 0:
        return []
    mean = float(np.trapezoid(speed, time) / (time[-1] - time[0]))
    if abs(mean / speed[0] - 1) <= ALLOWED:
        return []
    return [
        Warned(
            name="gasChanges",
            what="the gas that flows in changed while the run went on",
            how_much=f"{speed[0]:.4g} m/s at first, {mean:.4g} m/s on average "
            f"({speed.min():.4g} to {speed.max():.4g})",
            what_to_set="keep the inlet as it begins, or read the results as those of no one gas "
            "velocity; loading is that of the first gas: give massFlowRate",
            size=abs(mean / float(speed[0]) - 1),
        )
    ]


def _label_warnings(run: Path, velocity: float) -> list[Warned]:
    """A warning where the gas of a run has not the velocity (m/s) that the run is called after."""
    if not (run / PLAN).is_file():
        return []
    gas = read_plan(run).get("gas", {})
    if not gas.get("superficial_m_s") or _matches(gas, velocity):
        return []
    found = gas["superficial_m_s"]
    return [
        Warned(
            name="gasVelocity",
            what="the gas has another velocity than the one that the run is called after",
            how_much=f"{_found(gas)} instead of {velocity:.4g} m/s",
            what_to_set=f"make gasVelocity the velocity of the column's section or of an inlet, or "
            f"read the results as those of {found:.4g} m/s",
            size=abs(found / velocity - 1),
        )
    ]


def require_found(case: Path, label: float, plan: dict[str, Any]) -> None:
    """Raise InputError where a gas that pressure drives has settled at another velocity than the
    one (m/s) that the run is called after."""
    gas = plan.get("gas", {})
    driven = gas.get("basis") == "settled" and not gas.get("inflow_is_fixed", True)
    if driven and not _matches(gas, label):
        raise InputError(_refusal(case, label, gas, "does not act on it, pressure does"))


def _matches(gas: dict[str, Any], label: float) -> bool:
    """Whether the gas has this velocity (m/s): over the column's section, or at an inlet."""
    inlets = [inlet["velocity_m_s"] for inlet in gas.get("inlets", [])]
    speeds = [gas["superficial_m_s"] or 0.0, *inlets]
    return any(abs(speed / label - 1) <= ALLOWED for speed in speeds)


def _found(gas: dict[str, Any]) -> str:
    at = ", ".join(f"{i['velocity_m_s']:.4g} m/s at {i['patch']}" for i in gas.get("inlets", []))
    return f"{gas['superficial_m_s'] or 0.0:.4g} m/s over the column's section ({at})"


def _refusal(case: Path, label: float, gas: dict[str, Any], why: str) -> str:
    field = "0.orig" if (case / "0.orig").is_dir() else "0"
    return (
        f"{case / PARAMETERS}: gasVelocity is {label:g} m/s, but the gas that flows in has "
        f"{_found(gas)}: the entry {why}; allowed: a difference of {100 * ALLOWED:g} %, by "
        f"$gasVelocity in the inlet's condition in {field}, or by the gasVelocity that was found"
    )
