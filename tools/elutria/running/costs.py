"""What runs are expected to cost, and what they came to, in words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import reduce
from math import isfinite
from operator import add
from pathlib import Path
from typing import Any

from elutria.errors import InputError
from elutria.estimates import machine
from elutria.estimates.price import Price, price, spent
from elutria.files import read_json
from elutria.running.marker import FINISHED

PLANNED = 6
"""Runs of a sweep that are planned for its price; the others cost what the nearest of them does."""


def number(folder: Path, name: str) -> float:
    """A number of a finished run's finished.json. Raises InputError when it is not there."""
    value = read_json(folder / FINISHED).get(name)
    if not isinstance(value, (int, float)):
        raise InputError(f"{folder / FINISHED}: {name}: must be a number")
    return float(value)


def learn(folder: Path, content: Mapping[str, Any]) -> None:
    """Keep what a finished run came to, for the price of the next one."""
    with suppress(InputError, KeyError, TypeError):
        plan = read_json(folder / "postProcessing/plan.json")
        paid = [float(content[name]) for name in ("processor_s", "memory_mb", "disk_mb")]
        machine.keep(spent(plan, *paid))


def expected(plans: Sequence[Mapping[str, Any]]) -> list[Price]:
    """Of a run with each of the plans, on this machine."""
    slowness, finished = machine.slowness(), machine.finished()
    return [price(plan, slowness, finished) for plan in plans]


def chosen(count: int) -> list[int]:
    """Which of so many runs are planned: the first, the last, some between."""
    if count <= PLANNED:
        return list(range(count))
    return [round(number * (count - 1) / (PLANNED - 1)) for number in range(PLANNED)]


def spread(count: int, planned: Sequence[int], prices: Sequence[Price]) -> list[Price]:
    """A price for each of so many runs, from those that were planned."""
    return [
        prices[min(range(len(planned)), key=lambda i: abs(planned[i] - number))]
        for number in range(count)
    ]


def total(prices: Iterable[Price]) -> Price:
    """Of all of them."""
    return reduce(add, prices, Price(0.0, 0.0, 0.0, 0.0, 0))


def came_to(folders: Iterable[Path]) -> Price:
    """What finished runs came to; those that do not say it are left out."""
    found = []
    for folder in folders:
        with suppress(InputError):
            found.append(
                Price(
                    number(folder, "processor_s"),
                    number(folder, "wall_time_s"),
                    number(folder, "memory_mb"),
                    number(folder, "disk_mb"),
                )
            )
    return total(found)


def in_words(cost: Price, at_once: int) -> str:
    """`12 runs: 4 min of processor, 2 min with 2 at a time, 0.5 GB of memory, 0.3 GB of disk`."""
    runs = f"{cost.runs} run{'s' if cost.runs != 1 else ''}"
    together = max(1, min(at_once, cost.runs))
    wall = duration(cost.wall_s(at_once)) + (f" with {together} at a time" if together > 1 else "")
    return (
        f"{runs}: {duration(cost.processor_s)} of processor, {wall}, "
        f"{amount(together * cost.memory_mb)} of memory, {amount(cost.disk_mb)} of disk"
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
