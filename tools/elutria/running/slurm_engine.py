"""Slurm as the engine of a sweep: job arrays, which submitit writes, submits and reads back.

Jobs and their results are files in RESULTS/.slurm, so that nothing but the file system and Slurm's
own commands is needed on the nodes. What waits when the watch comes round goes as one array. A job
is over when its result is there, or when `squeue` does not know it any more: that needs no
accounting of the site.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, ParamSpec, TypeVar

from elutria.errors import ElutriaError, InputError, one_line

EVERY = 1.0
"""Seconds between two looks for results."""
ASK_EVERY = 10.0
"""Seconds between two questions to Slurm, whose controller everyone asks."""
ANSWER_WITHIN = 30

P = ParamSpec("P")
T = TypeVar("T")


@contextmanager
def slurm_executor(options: str, jobs: int, np: int, folder: Path) -> Iterator[Executor]:
    """Arrays of `np` processors a job, at most `jobs` of an array at a time (0: Slurm decides),
    with sbatch's long `options` (`partition=short,time=60`). Raises InputError where Slurm refuses
    them."""
    from submitit import SlurmExecutor

    given = _parse(options)
    name = f"--engine slurm{':' if options else ''}{one_line(options, 80)}"
    if shutil.which("sbatch") is None or shutil.which("srun") is None:
        raise InputError(f"{name}: sbatch: not found on PATH; allowed: on a machine with Slurm")
    _try(name, given, np)
    arrays = SlurmExecutor(folder / ".slurm")
    at_once = {"array_parallelism": jobs} if jobs else {}
    arrays.update_parameters(
        job_name="elutria", cpus_per_task=np, use_srun=False, additional_parameters=given,
        time=None, **at_once,
    )  # fmt: skip
    executor = ArrayExecutor(arrays)
    try:
        yield executor
    finally:
        executor.shutdown(cancel_futures=True)
        shutil.rmtree(folder / ".slurm", ignore_errors=True)


def _parse(options: str) -> dict[str, str | bool]:
    """`partition=short,exclusive` as sbatch's long options."""
    given: dict[str, str | bool] = {}
    for part in filter(None, options.split(",")):
        key, equals, value = part.strip().lstrip("-").partition("=")
        if not key.replace("-", "").isalnum() or (equals and not value):
            raise InputError(
                f"--engine slurm:'{one_line(part, 60)}'; allowed: sbatch's long options, such as "
                "slurm:partition=short,time=60"
            )
        given[key] = value if equals else True
    return given


def _try(name: str, given: Mapping[str, str | bool], np: int) -> None:
    """Ask Slurm whether it would take such a job. Raises InputError with its reason."""
    flags = [f"--{key}" if value is True else f"--{key}={value}" for key, value in given.items()]
    command = ["sbatch", "--test-only", f"--cpus-per-task={np}", *flags, "--wrap=true"]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=ANSWER_WITHIN, check=False
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"{name}: Slurm does not answer within {ANSWER_WITHIN} s") from None
    if done.returncode != 0:
        raise InputError(f"{name}: Slurm refuses it ({one_line(done.stderr, 200)})")


def alone(function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """Call a function as if there were no Slurm around it: an MPI that finds it would have its
    processes started by `srun`, where they are to share the job's own processors."""
    for name in list(os.environ):
        if name.startswith(("SLURM_", "SLURMD_", "PMI_", "PMIX_")):
            del os.environ[name]
    return function(*args, **kwargs)


class ArrayExecutor(Executor):
    """`concurrent.futures` on top of submitit's jobs, which are to be asked for their results."""

    def __init__(self, arrays: Any):
        self._arrays = arrays
        self._new: SimpleQueue[tuple[Future[Any], Any]] = SimpleQueue()
        self._jobs: dict[Future[Any], Any] = {}
        self._unknown: set[str] = set()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Have `fn` called in a job of its own."""
        future: Future[T] = Future()
        self._new.put((future, (alone, fn, args, kwargs)))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the watch; with `cancel_futures` the jobs that are not done, too."""
        while wait and not cancel_futures and (self._jobs or not self._new.empty()):
            time.sleep(EVERY)
        self._stop.set()
        self._thread.join()
        for job in self._jobs.values():
            job.cancel(check=False)

    def _watch(self) -> None:
        asked = time.monotonic()
        while not self._stop.is_set():
            self._submit_new()
            if time.monotonic() - asked > ASK_EVERY:
                asked = time.monotonic()
                self._ask()
            for future in [f for f, job in self._jobs.items() if job.paths.result_pickle.exists()]:
                self._settle(future)
            self._stop.wait(EVERY)

    def _submit_new(self) -> None:
        new = []
        while True:
            try:
                new.append(self._new.get_nowait())
            except Empty:
                break
        new = [(future, call) for future, call in new if future.set_running_or_notify_cancel()]
        if not new:
            return
        try:
            with self._arrays.batch():
                jobs = [self._arrays.submit(call[0], call[1], *call[2], **call[3])
                        for _, call in new]  # fmt: skip
            self._jobs |= {future: job for (future, _), job in zip(new, jobs, strict=True)}
        except Exception as error:
            for future, _ in new:
                future.set_exception(ElutriaError(f"sbatch failed: {one_line(error, 300)}"))

    def _ask(self) -> None:
        """Give up the jobs that Slurm has not known twice, without a result."""
        if not self._jobs:
            return
        command = ["squeue", "--me", "--array", "--noheader", "--format=%i"]
        try:
            said = subprocess.run(
                command, capture_output=True, text=True, timeout=ANSWER_WITHIN, check=True
            ).stdout.split()
        except (OSError, subprocess.SubprocessError):
            return  # the controller may be away for a while; jobs go on
        gone = {job.job_id for job in self._jobs.values()} - set(said)
        for future, job in list(self._jobs.items()):
            if job.job_id in gone & self._unknown:
                self._settle(future)
        self._unknown = gone

    def _settle(self, future: Future[Any]) -> None:
        """Hand over the result of a job that is over, or that it has none."""
        job = self._jobs.pop(future)
        if job.paths.result_pickle.exists():
            try:
                future.set_result(job.result())
            except Exception as error:
                future.set_exception(ElutriaError(f"job {job.job_id}: {one_line(error, 300)}"))
            return
        said = [line for line in (job.stderr() or "").splitlines() if line.strip()]
        last = one_line(said[-1], 300) if said else "its nodes may not see the folder"
        future.set_exception(ElutriaError(f"job {job.job_id} ended without a result: {last}"))
