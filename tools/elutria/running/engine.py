"""Where the runs of a sweep are done: `local`, `dask:ADDRESS` or `slurm[:OPTIONS]`.

Each is a `concurrent.futures.Executor` for jobs (`worker.perform`); what does the scheduling is the
standard library, dask.distributed or Slurm. A job of `np` processors gets as many slots.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from importlib.util import find_spec
from pathlib import Path

from elutria.errors import InputError, one_line

ALLOWED = "local, dask:ADDRESS such as dask:tcp://10.0.0.1:8786, or slurm[:OPTION=VALUE,...]"
EXTRA = "after etc/setup/cluster of the clone, or pip install 'elutria[cluster]'"


@contextmanager
def local_executor(jobs: int) -> Iterator[Executor]:
    """This machine, `jobs` at a time; those that wait when the block is left are not begun."""
    executor = ThreadPoolExecutor(jobs)
    try:
        yield executor
    finally:
        executor.shutdown(cancel_futures=True)


def slots(text: str, jobs: int, np: int) -> int:
    """How many runs an engine is thought to do at a time; many, where nothing says it."""
    if jobs:
        return jobs
    return max(1, len(os.sched_getaffinity(0)) // np) if text == "local" else 1000


def threads_each(at_once: int, np: int) -> int:
    """This machine's cores for the threads of each processor of so many runs at a time."""
    return max(1, len(os.sched_getaffinity(0)) // (at_once * np))


def open_engine(
    text: str, jobs: int, np: int, folders: tuple[Path, Path], say: Callable[[str], None]
) -> AbstractContextManager[Executor]:
    """The engine that `--engine` names, for `jobs` runs at a time (0: as many as it has slots for)
    of `np` processors; `folders` are the case and that of its sweep. `say` gets a line for each
    worker that cannot be used. Raises InputError where it does not answer."""
    case, folder = folders
    kind, colon, rest = text.partition(":")
    if jobs < 0:
        raise InputError(f"--jobs {jobs}; allowed: a whole number >= 1, or 0 for all there are")
    if text == "local":
        return local_executor(slots(text, jobs, np))
    if kind == "dask" and rest:
        _need("distributed", text)
        from elutria.running.dask_engine import dask_executor

        return dask_executor(rest, np, case.resolve(), say)
    if kind == "slurm" and (rest or not colon):
        _need("submitit", text)
        from elutria.running.slurm_engine import slurm_executor

        return slurm_executor(rest, jobs, np, folder)
    raise InputError(f"--engine '{one_line(text, 60)}'; allowed: {ALLOWED}")


def _need(package: str, engine: str) -> None:
    """Raises InputError where the package of an engine is not installed."""
    if find_spec(package) is None:
        raise InputError(
            f"--engine {one_line(engine, 80)}: {package} is not installed; allowed: {EXTRA}"
        )
