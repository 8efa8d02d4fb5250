"""What a run will cost: processor time, memory and disk, from the solver's plan of it.

The work is counted in cells and parcels that are dealt with; what each of them takes was measured
(`elutria bench price`), on a machine whose speed is known by `machine.probe`. Runs of the same mesh
that were made on this machine correct the count: the nearer they are, the more they say.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from math import exp, inf, isfinite, log
from typing import Any

NOT_KNOWN = "not known yet"
"""Of the gas by itself, in a plan: the run finds out."""
MODEL = 2
"""Counts up when the rates or the count change: what was kept before says nothing then."""
STAY = 8.0
"""Passages of the gas through the mesh in which a parcel leaves, those around the cut included."""
SOLVED, MOST, ONCE = 0.012, 0.35, 20
"""Share of the steps in which the gas is solved while parcels enter and leave, where they change it
by `gasTolerance`, and at most; and how often it is solved anyway where they do."""
SOLVED_LATE, MOST_LATE = 7e-5, 0.1
"""That share while the last ones hover; it rises with the square of the change, up to the second
number."""

HEAVY, FEW = 0.13, 23
"""Of that change the share of one parcel, in units of `gasTolerance`, above which the gas is solved
on every step while fewer than the second number are inside: more add up to an even load. Default
columns of 100 to 400 parcels, loading 0.08 to 0.4, at 4 and 6 m/s: three were solved on 81 to 90 %
of their steps (shares 0.16 to 0.33, 8 to 21 inside), five on 10 % at most (shares up to 0.11, or 25
inside). Both numbers are fitted to these eight runs."""


@dataclass(frozen=True)
class Work:
    """What a run has to do: cells whose gas settles, and times that a cell's gas is solved later;
    time steps; times that a parcel is moved; collisions; parcels."""

    settled: float
    solved: float
    steps: float
    moved: float
    collided: float
    parcels: float


@dataclass(frozen=True)
class Price:
    """Of one run, or of several: processor s, the time of the longest (s), memory and disk (MB);
    how many more processor s where the gas, of which that is not known, is never steady."""

    processor_s: float
    longest_s: float
    memory_mb: float
    disk_mb: float
    runs: int = 1
    unsteady_s: float = 0.0

    def __add__(self, other: Price) -> Price:
        return Price(
            self.processor_s + other.processor_s,
            max(self.longest_s, other.longest_s),
            max(self.memory_mb, other.memory_mb),
            self.disk_mb + other.disk_mb,
            self.runs + other.runs,
            self.unsteady_s + other.unsteady_s,
        )

    def wall_s(self, at_once: int) -> float:
        """Time that the runs take, so many of them at a time (s)."""
        at_once = max(1, min(at_once, self.runs))
        return max(self.longest_s, self.processor_s / at_once)


@dataclass(frozen=True)
class Rates:
    """Processor seconds of a run's start and end, and of each part of the work, on the machine of
    `machine.REFERENCE_S`."""

    start: float = 1.2
    settled: float = 1.7e-4
    solved: float = 5e-6
    unsteady: float = 1.5e-5
    """Of a cell in each step while the gas is never steady: it takes more iterations then."""
    steps: float = 9e-4
    moved: float = 5e-6
    collided: float = 1.2e-3
    """Of an expected collision of a parcel: there are 25 impacts for each, walls included."""
    parcels: float = 1.5e-4


RATES = Rates()


def work(plan: Mapping[str, Any]) -> Work:
    """Counted from a plan: see docs/user/outputs.md. A run that does not say when it ends is
    counted until its parcels have left, a feed that does not for as long as one stays."""
    gas, feed, expected = plan["gas"], plan["feed"], plan["expected"]
    cells, step = float(plan["mesh"]["cells"]), _step(plan["step"])
    parcels = float(feed["parcels"] or 0.0)
    start = feed["start_s"]
    stay = STAY * (gas["through_time_s"] or 0.0)
    fed = stay if feed["end_s"] is None else feed["end_s"] - start
    lasts = fed + stay if feed["run_ends_s"] is None else feed["run_ends_s"] - start
    stay = min(stay, lasts)
    busy = min(fed + stay, lasts)
    change = (expected["gas_change"] or 0.0) / gas["changes_at"]
    late = lasts - busy
    solved = busy * min(MOST, SOLVED * change) + late * min(MOST_LATE, SOLVED_LATE * change**2)
    inside = parcels * (min(1.0, (gas["through_time_s"] or 0.0) / fed) if fed > 0 else 1.0)
    if change > HEAVY * inside and 0 < inside < FEW:
        solved = lasts
    return Work(
        settled=cells,
        solved=cells * (ONCE + solved / step) if change >= 1 else 0.0,
        steps=lasts / step,
        moved=parcels * max(1.0, stay / step),
        collided=parcels * (expected["collisions"] or 0.0),
        parcels=parcels,
    )


def _step(step: Mapping[str, Any]) -> float:
    """The time step (s) that a run settles to."""
    first: float = step["first_s"]
    if step["adjusts"] and step["courant"] and step["largest_courant"]:
        first *= min(1.0, step["largest_courant"] / step["courant"])
    return min(first, step["largest_by_collisions_s"] or inf)


def model(done: Work, rates: Rates = RATES) -> float:
    """Processor seconds on the reference machine."""
    names = [field.name for field in fields(Work)]
    return rates.start + float(sum(getattr(rates, n) * getattr(done, n) for n in names))


@dataclass(frozen=True)
class Spent:
    """What a finished run came to, and what was counted of it: `key` tells its mesh."""

    key: str
    gas_velocity_m_s: float
    loading: float
    parcels: float
    model_s: float
    processor_s: float
    memory_mb: float
    disk_mb: float


def mesh_key(plan: Mapping[str, Any]) -> str:
    """Tells runs on one mesh, with the same forces, from others."""
    known = json.dumps([MODEL, plan["mesh"], plan["drag"]["forces"]], sort_keys=True)
    return hashlib.sha256(known.encode()).hexdigest()[:16]


def spent(plan: Mapping[str, Any], processor_s: float, memory_mb: float, disk_mb: float) -> Spent:
    """Of a finished run with this plan."""
    return Spent(
        mesh_key(plan),
        plan["gas"]["superficial_m_s"] or 0.0,
        plan["expected"]["loading"] or 0.0,
        plan["feed"]["parcels"] or 0.0,
        model(work(plan)),
        processor_s,
        memory_mb,
        disk_mb,
    )


def price(plan: Mapping[str, Any], slowness: float, finished: Iterable[Spent] = ()) -> Price:
    """Of a run with this plan, on a machine that takes `slowness` times the reference's time;
    `finished` are runs on this machine, of any case."""
    asked = spent(plan, 0.0, 0.0, 0.0)
    near = [(_nearness(asked, run), run) for run in finished if run.key == asked.key]
    if near:
        seconds = asked.model_s * _mean(
            (nearness, run.processor_s / run.model_s) for nearness, run in near
        )
        memory = _mean((nearness, run.memory_mb) for nearness, run in near)
        disk = _mean((nearness, run.disk_mb) for nearness, run in near)
        return Price(seconds, seconds, memory, disk)
    cells, steps = plan["mesh"]["cells"], work(plan).steps
    seconds = slowness * asked.model_s
    memory = 100.0 + 4e-3 * cells + 1e-3 * asked.parcels
    disk = 1.0 + 5e-4 * cells + 1.5e-4 * asked.parcels + 2.3e-4 * steps
    may_be_unsteady = plan["gas"]["by_itself"]["what"] == NOT_KNOWN
    unsteady = slowness * RATES.unsteady * cells * steps if may_be_unsteady else 0.0
    return Price(seconds, seconds, memory, disk, unsteady_s=unsteady)


def _nearness(one: Spent, other: Spent) -> float:
    """Weight of a run for the price of another: falls with the ratios of their settings."""
    ratios = (
        log(max(one.gas_velocity_m_s, 1e-6) / max(other.gas_velocity_m_s, 1e-6)),
        log((one.loading + 0.01) / (other.loading + 0.01)),
        log((one.parcels + 1) / (other.parcels + 1)),
    )
    return 1.0 / (0.01 + sum(ratio**2 for ratio in ratios))


def _mean(weighted: Iterable[tuple[float, float]]) -> float:
    """The weighted geometric mean."""
    pairs = [(weight, log(value)) for weight, value in weighted if value > 0]
    total = sum(weight for weight, _ in pairs)
    return exp(sum(weight * value for weight, value in pairs) / total) if total else 0.0


def in_words(cost: Price, at_once: int) -> str:
    """`12 runs: 4 min of processor, 2 min with 2 at a time, 0.5 GB of memory, 0.3 GB of disk`, and
    what it may come to instead."""
    runs = f"{cost.runs} run{'s' if cost.runs != 1 else ''}"
    together = max(1, min(at_once, cost.runs))
    wall = duration(cost.wall_s(at_once)) + (f" with {together} at a time" if together > 1 else "")
    return (
        f"{runs}: {duration(cost.processor_s)} of processor, {wall}, "
        f"{amount(together * cost.memory_mb)} of memory, {amount(cost.disk_mb)} of disk"
        + (
            f"; {duration(cost.processor_s + cost.unsteady_s)} of processor where the gas is never "
            "steady"
            if cost.unsteady_s > cost.processor_s
            else ""
        )
    )


def duration(seconds: float) -> str:
    """Two digits of it: `35 s`, `4.2 min`, `3.1 h`."""
    if not isfinite(seconds):
        return "?"
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * size:
            return f"{float(f'{seconds / size:.2g}'):g} {unit}"
    return f"{float(f'{seconds:.2g}'):g} s"


def amount(megabytes: float) -> str:
    """Two digits of it: `35 MB`, `1.2 GB`."""
    value, unit = (megabytes / 1000, "GB") if megabytes >= 1000 else (megabytes, "MB")
    return f"{float(f'{value:.2g}'):g} {unit}"
