"""How many processors a run pays for: what it takes on each number of them, from its plan.

Cells and parcels are shared; messages are added, and what every processor does by itself stays. The
work and its rates are those of `price`. What several processors add is partly counted, partly
assumed (docs/developers/parallel.md).
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from math import ceil, log2
from pathlib import Path
from typing import Any

from elutria.errors import InputError, one_line
from elutria.estimates.price import RATES, duration, work

INSIST, EXACT = "ELUTRIA_EXACT", "yes"
"""Variable of the environment, and its value, by which a user insists on the number asked for; the
solver knows it too."""

CPUS = Path("/sys/devices/system/cpu")


@dataclass(frozen=True)
class Shared:
    """What several processors add. On n of them a time step has `calls` in which each tells all
    others of its particles, and a solve of the gas `reductions` in which all wait for all; with one
    other processor each of both takes `message` s on the machine of `machine.REFERENCE_S`. The
    busiest one has `uneven`/n of the parcels' work, at most all of it; decomposition and the start
    of so many programs take `start` s each."""

    message: float = 1e-5
    calls: float = 20.0
    reductions: float = 300.0
    uneven: float = 1.5
    start: float = 0.3


SHARED = Shared()


@dataclass(frozen=True)
class Choice:
    """So many processors, and why not as many as were asked for; "" where they are."""

    np: int
    why: str = ""


def run_s(plan: Mapping[str, Any], np: int, shared: Shared = SHARED) -> float:
    """Seconds that a run with this plan takes on `np` processors of the reference machine, each
    with a core of its own."""
    done, cells = work(plan), float(plan["mesh"]["cells"])
    each = RATES.start + RATES.steps * done.steps + RATES.parcels * done.parcels
    gas = RATES.settled * done.settled + RATES.solved * done.solved
    particles = RATES.moved * done.moved + RATES.collided * done.collided
    busiest = min(1.0, shared.uneven / np) if np > 1 else 1.0
    told = 0.0
    if np > 1:
        solves = gas / (RATES.solved * cells)
        told = shared.start * np + shared.message * (
            shared.calls * (np - 1) * done.steps + shared.reductions * ceil(log2(np)) * solves
        )
    return each + gas / np + particles * busiest + told


def paying(plan: Mapping[str, Any], asked: int, cores: int) -> Choice:
    """The number of processors up to `asked` on which a run with this plan ends first; more than
    there are `cores` never pay. Times are told of a machine as fast as the reference."""
    most = max(1, min(asked, cores))
    best = min(range(1, most + 1), key=lambda np: (run_s(plan, np), np))
    if best == asked:
        return Choice(asked)
    has = f"there {'is' if cores == 1 else 'are'} {cores} core{'' if cores == 1 else 's'} here"
    reasons = [has] if most < asked else []
    if best < most:
        cells, parcels = plan["mesh"]["cells"], plan["feed"]["parcels"] or 0
        reasons.append(
            f"{cells:.0f} cells and {parcels:.0f} parcels take {duration(run_s(plan, most))} on "
            f"{most}, {duration(run_s(plan, best))} on {best}"
        )
    told = f"--np {asked} -> {best}: {'; '.join(reasons)}"
    return Choice(best, f"{told} ({INSIST}={EXACT} takes {asked})")


def exact() -> bool:
    """Does the user insist on the number asked for? Raises InputError for another word."""
    word = os.environ.get(INSIST, "")
    if word not in ("", EXACT):
        raise InputError(f"{INSIST}={one_line(word, 40)}; allowed: {EXACT}, or not set")
    return word == EXACT


def cores() -> int:
    """Physical cores that this process may use; where it cannot be told, its logical ones."""
    mine = os.sched_getaffinity(0)
    siblings = set()
    for cpu in mine:
        found = str(cpu)
        with suppress(OSError):
            found = (CPUS / f"cpu{cpu}/topology/thread_siblings_list").read_text().strip()
        siblings.add(found)
    return len(siblings)
