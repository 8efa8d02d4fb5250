"""What the runs of a sweep are expected to cost, and what finished ones came to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any

from elutria.errors import InputError
from elutria.estimates import machine
from elutria.estimates.price import Price, spent
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
