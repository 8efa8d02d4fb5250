"""Workers of a Dask scheduler as the engine of a sweep."""

from __future__ import annotations

import logging
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from elutria.errors import InputError, one_line
from elutria.running.run import SOLVER

SLOTS = "slots"
"""The resource of a worker that says how many processors it has: `dask worker --resources`."""
ANSWER_WITHIN = 20
"""Seconds that a scheduler, and a first worker, have to answer."""


@contextmanager
def dask_executor(
    address: str, np: int, case: Path, say: Callable[[str], None]
) -> Iterator[Executor]:
    """The workers of the scheduler at `address` (or of the scheduler file `ADDRESS.json`), `np`
    slots a job. A job of a worker that is lost is begun again by another one."""
    import distributed

    name = f"--engine dask:{one_line(address, 80)}"
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # it is told in one line
    place = {"scheduler_file" if address.endswith(".json") else "address": address}
    connect: Any = distributed.Client
    try:
        client = connect(**place, timeout=ANSWER_WITHIN, set_as_default=False)
    except Exception as error:
        raise InputError(
            f"{name}: no scheduler answers ({_reason(error)}); allowed: the address that "
            "`dask scheduler` prints, or its scheduler file FILE.json"
        ) from None
    with client:
        resources, fit = _fit(client, name, np, case, say)
        options = {"resources": resources} if resources else {}
        executor = client.get_executor(pure=False, workers=fit, **options)
        try:
            yield executor
        finally:
            executor.shutdown(wait=False)


def _fit(
    client: Any, name: str, np: int, case: Path, say: Callable[[str], None]
) -> tuple[dict[str, int], list[str] | None]:
    """What a job asks of a worker, and the workers that can do jobs, None: all, also later ones."""
    try:
        client.wait_for_workers(1, timeout=ANSWER_WITHIN)
    except Exception:
        raise InputError(f"{name}: has no worker; allowed: after `dask worker`") from None
    workers = client.scheduler_info(n_workers=-1)["workers"]
    troubles: dict[str, str | None] = client.run(_trouble, str(case), on_error="return")
    slots = {worker: info.get("resources", {}).get(SLOTS) for worker, info in workers.items()}
    counted = any(count is not None for count in slots.values())
    for worker, count in slots.items():
        if troubles.get(worker) is None and ((count or 0) < np if counted else np > 1):
            troubles[worker] = (
                f"has {count or 0:g} slots, a run has --np {np}; "
                f"allowed: dask worker --resources {SLOTS}={np}"
            )
    bad = {worker: _reason(trouble) for worker, trouble in troubles.items() if trouble is not None}
    for worker, trouble in bad.items():
        say(f"worker {worker}: {trouble}; it is not used")
    fit = [worker for worker in workers if worker not in bad]
    if not fit:
        raise InputError(f"{name}: none of its {len(workers)} workers can be used")
    return ({SLOTS: np} if counted else {}), (fit if bad else None)


def _trouble(folder: str) -> str | None:
    """On a worker: why it cannot do jobs; None when it can. What it returns is told, not raised."""
    if shutil.which(SOLVER) is None:
        return f"{SOLVER}: not found on PATH; allowed: started after 'source etc/bashrc'"
    if not Path(folder).is_dir():
        return f"{folder}: is not there; allowed: a folder that all machines see"
    return None


def _reason(error: object) -> str:
    return one_line(str(error) or type(error).__name__, 200)
