"""A run of a sweep as a job for any `concurrent.futures.Executor`, and the executor of one machine.

A job is done in a process of its own, so that one that fails or is killed leaves the others alone:
`python -m elutria.running.worker CASE FOLDER NP NEIGHBOUR REPLICATE SETTING...`. Wherever that is,
it says in the run's folder how far it is; on failure it writes one line to the error output and
ends with the exit code 1 or 2.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from elutria.case.case import Case, Setting
from elutria.errors import ElutriaError
from elutria.running.run import run_case

if TYPE_CHECKING:
    from elutria.running.solver import Step

PROGRESS = "progress.txt"
EVERY = 0.5
"""Seconds between two words on the progress."""

_thread = threading.local()


@dataclass(frozen=True)
class Job:
    """What `run_case` needs; it may be sent to another machine that sees the same folders.

    `neighbour` is the folder of the run whose settled gas this one starts from.
    """

    case: Path
    folder: Path
    settings: tuple[Setting, ...]
    np: int
    neighbour: Path | None
    replicate: int = 1

    def progress(self) -> tuple[float, str] | None:
        """Share done (0..1) and the solver's numbers; None before the first time step."""
        with suppress(OSError, ValueError):
            share, _, note = (self.folder / PROGRESS).read_text().partition(" ")
            return float(share), note
        return None

    def forget_progress(self) -> None:
        """Remove what an earlier start or this one said."""
        with suppress(OSError):
            (self.folder / PROGRESS).unlink(missing_ok=True)


def perform(job: Job) -> None:
    """Do a job in a process of its own. Raises ElutriaError with the line in which that ended."""
    command = [
        sys.executable, "-m", "elutria.running.worker", str(job.case), str(job.folder),
        str(job.np), str(job.neighbour or ""), str(job.replicate), *map(str, job.settings),
    ]  # fmt: skip
    if shutil.which("setpriv"):  # nothing goes on when this process is killed
        command = ["setpriv", "--pdeathsig", "TERM", *command]
    stop: threading.Event = getattr(_thread, "stop", None) or threading.Event()
    if stop.is_set():
        raise ElutriaError("stopped before it began")
    with tempfile.TemporaryFile("w+", errors="replace") as said:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=said,
            env={"OMP_NUM_THREADS": "1", **os.environ},
        )
        while process.poll() is None:
            if stop.wait(0.05):
                process.terminate()
                process.wait()
        said.seek(0)
        lines = [line for line in said if line.strip()]
    if process.returncode != 0:
        last = lines[-1].strip() if lines else f"ended with exit code {process.returncode}"
        raise ElutriaError(last)


@contextmanager
def local_executor(jobs: int) -> Iterator[Executor]:
    """This machine, `jobs` at a time; when the block is left, those that still run are ended."""
    stop = threading.Event()
    executor = ThreadPoolExecutor(jobs, initializer=setattr, initargs=(_thread, "stop", stop))
    try:
        yield executor
    finally:
        stop.set()
        executor.shutdown(cancel_futures=True)


def main(arguments: list[str]) -> int:
    """Run the case; the exit code is the error's, 0 without one."""
    case, folder, np, neighbour, replicate, *settings = arguments
    job = Job(
        Path(case),
        Path(folder).resolve(),
        tuple(Setting.parse(text) for text in settings),
        int(np),
        Path(neighbour).resolve() if neighbour else None,
        int(replicate),
    )
    last = 0.0

    def on_step(share: float, step: Step) -> None:
        nonlocal last
        if time.monotonic() - last > EVERY:
            last = time.monotonic()
            (job.folder / PROGRESS).write_text(f"{share:.4f} {note(step)}")

    try:
        run_case(
            Case(job.case), job.folder, job.settings, job.np, on_step, job.neighbour, job.replicate
        )
    except ElutriaError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    finally:
        job.forget_progress()
    return 0


def note(step: Step) -> str:
    """The solver's numbers, short."""
    left = " ".join(f"{product} {number}" for product, number in step.left.items())
    return f"{left} inside {step.inside}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
