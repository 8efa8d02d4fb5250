"""How fast this machine is, and what finished runs came to on it: kept between calls."""

from __future__ import annotations

import fcntl
import json
import os
import platform
import resource
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, fields, replace
from importlib.resources import files
from pathlib import Path
from time import process_time
from typing import Any

from elutria.estimates.price import Price, Spent, price
from elutria.files import cache_folder

REFERENCE_S = 0.0163
"""Processor seconds of the probe's work on the machine on which the rates were measured."""
_KEPT = 400


def slowness() -> float:
    """Processor time of this machine over that of the reference; measured once, then kept."""
    name = f"{platform.node()} {platform.machine()} {os.cpu_count()}"
    file = cache_folder() / "machine.json"
    with suppress(OSError, ValueError, KeyError, TypeError):
        kept = json.loads(file.read_text())
        if kept["machine"] == name:
            return float(kept["probe_s"]) / REFERENCE_S
    seconds = min(_timed(_work) for _ in range(5))
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps({"machine": name, "probe_s": seconds}) + "\n")
    return seconds / REFERENCE_S


def _work() -> None:
    """Sweeps over a grid of the size of a small case, as a solver of the gas makes them."""
    import numpy as np

    field = np.linspace(0.0, 1.0, 40_000).reshape(20, 20, 100)
    for _ in range(40):
        inner = field[1:-1, 1:-1, 1:-1]
        field[1:-1, 1:-1, 1:-1] = 0.7 * inner + 0.05 * (
            field[2:, 1:-1, 1:-1] + field[:-2, 1:-1, 1:-1] + field[1:-1, 2:, 1:-1]
            + field[1:-1, :-2, 1:-1] + field[1:-1, 1:-1, 2:] + field[1:-1, 1:-1, :-2]
        )  # fmt: skip


def _timed(work: Callable[[], None]) -> float:
    began = process_time()
    work()
    return process_time() - began


def processor_s() -> float:
    """Processor seconds of this process and of those that it has waited for."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def memory_mb() -> float:
    """The most memory that one of the processes of a run has had."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


def disk_mb(folder: Path) -> float:
    """What a folder takes on the disk."""
    files = [path for path in folder.rglob("*") if path.is_file() and not path.is_symlink()]
    return sum(path.stat().st_blocks for path in files) * 512 / 1e6


def keep(run: Spent) -> None:
    """Add a finished run to those that are known; a cache that cannot be written has none."""
    with suppress(OSError):
        file = cache_folder() / "runs.jsonl"
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("a+") as runs:
            fcntl.flock(runs, fcntl.LOCK_EX)
            runs.write(json.dumps(asdict(run)) + "\n")
            runs.flush()
            runs.seek(0)
            lines = runs.readlines()
            if len(lines) > 2 * _KEPT:
                runs.truncate(0)
                runs.writelines(lines[-_KEPT:])


def finished() -> list[Spent]:
    """The runs that are known, the latest last."""
    names = [field.name for field in fields(Spent)]
    found = []
    with suppress(OSError):
        for line in (cache_folder() / "runs.jsonl").read_text().splitlines()[-_KEPT:]:
            with suppress(ValueError, KeyError, TypeError):
                content = json.loads(line)
                found.append(Spent(**{name: content[name] for name in names}))
    return found


def delivered(slow: float) -> list[Spent]:
    """Runs of the column and of manganese on the reference machine, made by hand on 2026-11-27, as
    they would be on one that takes `slow` times as long. `elutria bench price` makes them anew."""
    kept = json.loads(files("elutria.estimates").joinpath("delivered.json").read_text())
    runs = [Spent(**entries) for entries in kept]
    return [replace(run, processor_s=slow * run.processor_s) for run in runs]


def expected(plans: Sequence[Mapping[str, Any]]) -> list[Price]:
    """What a run with each of the plans is expected to cost on this machine: runs that were made
    here say it, or else those that are delivered, or else the rates."""
    slow, known = slowness(), finished()
    ours = {run.key for run in known}
    known += [run for run in delivered(slow) if run.key not in ours]
    return [price(plan, slow, known) for plan in plans]
