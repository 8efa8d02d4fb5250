"""How fast this machine is, and what finished runs came to: kept between calls.

Files hold seconds of the reference machine, since the machines that read a file need not be the one
that wrote it: nodes of a cluster share a home.
"""

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
from math import exp, log1p, sqrt
from pathlib import Path
from time import process_time
from typing import Any

from elutria.estimates.price import MODEL, Price, Spent, price
from elutria.files import cache_folder

REFERENCE_S = 0.0249
"""Processor seconds of the probe's work on the machine on which the rates were measured: 0.0132 on
an AMD EPYC, on which default columns took 0.53 of their time, at loadings of 0.2 and 5."""
_KEPT = 400
_RUNS = "spent.jsonl"


def slowness() -> float:
    """Processor time of this machine over that of the reference; measured once, then kept."""
    name = f"{platform.node()} {platform.machine()} {os.cpu_count()} {MODEL}"
    file = cache_folder() / "machine.json"
    with suppress(OSError, ValueError, KeyError, TypeError):
        kept = json.loads(file.read_text())
        if kept["machine"] == name:
            return float(kept["probe_s"]) / REFERENCE_S
    seconds = probe()
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps({"machine": name, "probe_s": seconds}) + "\n")
    return seconds / REFERENCE_S


def probe() -> float:
    """Processor seconds of the probe's work on this machine, now."""
    return min(_timed(_work) for _ in range(5))


def _work() -> None:
    """What runs spend their time on: numbers of neighbours that lie anywhere, as a solver of the
    gas needs them in a small case; functions of one number after the other, as particles need them;
    branches that cannot be foreseen, as in a search. The interpreter takes little part in it."""
    import numpy as np

    cells = np.arange(20_000)
    neighbours = [(cells + apart) % len(cells) for apart in (-1000, -20, -1, 0, 1, 20, 1000)]
    field = np.linspace(0.0, 1.0, len(cells))
    for _ in range(20):
        field = np.mean([field[cell] for cell in neighbours], axis=0)
    numbers = (7919 * cells % 20_011 / 20_011).tolist()
    for _ in range(3):
        for function in (exp, log1p, sqrt):
            sum(map(function, numbers))
        sorted(numbers)


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


def scaled(run: Spent, factor: float) -> Spent:
    """The run on a machine that takes `factor` times as long."""
    return replace(run, processor_s=factor * run.processor_s)


def keep(run: Spent) -> None:
    """Add a run that was made on this machine to those that are known; a cache that cannot be
    written has none."""
    run = scaled(run, 1 / slowness())
    with suppress(OSError):
        file = cache_folder() / _RUNS
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


def finished(slow: float) -> list[Spent]:
    """The runs that are known, the latest last, as they would be on a machine that takes `slow`
    times as long as the reference."""
    names = [field.name for field in fields(Spent)]
    found = []
    with suppress(OSError):
        for line in (cache_folder() / _RUNS).read_text().splitlines()[-_KEPT:]:
            with suppress(ValueError, KeyError, TypeError):
                content = json.loads(line)
                run = Spent(**{name: content[name] for name in names})
                found.append(scaled(run, slow))
    return found


def delivered(slow: float) -> list[Spent]:
    """Runs of cases of the repository, as on a machine that takes `slow` times as long as the
    reference: the file says how they were made. `elutria bench price` makes them anew."""
    kept = json.loads(files("elutria.estimates").joinpath("delivered.json").read_text())
    return [scaled(Spent(**entries), slow) for entries in kept["runs"]]


def expected(plans: Sequence[Mapping[str, Any]]) -> list[Price]:
    """What a run with each of the plans is expected to cost on this machine: runs that were made
    by this user say it, or else those that are delivered, or else the rates."""
    slow = slowness()
    known = finished(slow)
    ours = {run.key for run in known}
    known += [run for run in delivered(slow) if run.key not in ours]
    return [price(plan, slow, known) for plan in plans]
