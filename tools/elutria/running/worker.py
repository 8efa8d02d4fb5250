"""A run of a sweep as a job for any `concurrent.futures.Executor`, on any machine that sees the
same folders.

A job is done in a process of its own, so that one that fails or is killed leaves the others alone:
`python -m elutria.running.worker CASE FOLDER NP NEIGHBOUR REPLICATE SETTING...`. Wherever that is,
it says in the run's folder how far it is; on failure it writes one line to the error output and
ends with the exit code 1 or 2. It goes on for as long as someone asks for it (`asking`).
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from socket import gethostname
from typing import TYPE_CHECKING

from elutria.case.case import Case, Setting
from elutria.errors import ElutriaError
from elutria.estimates.price import duration
from elutria.files import writing_to
from elutria.openfoam.started import killed
from elutria.running.run import LockedError, run_case

if TYPE_CHECKING:
    from elutria.running.solver import Step

PROGRESS = "progress.txt"
EVERY = 0.5
"""Seconds between two words on the progress."""

ASKED_EVERY = 10.0
"""Seconds between two signs of life of a sweep."""
GONE_AFTER = 120.0
"""Seconds without one after which its runs end; a file may be seen late on another machine."""
PATIENCE = 15.0
"""Seconds that a run waits for the end of one that was moved away from a lost worker."""


@dataclass(frozen=True)
class Asking:
    """Who asks for runs: a file that is touched for as long as the answer is wanted."""

    file: Path
    host: str

    def mark(self) -> float | None:
        """The file's time; None when it is gone."""
        with suppress(OSError):
            return self.file.stat().st_mtime
        return None


@contextmanager
def asking(folder: Path) -> Iterator[Asking]:
    """Ask for runs in the folder of a sweep; they end when the block is left, on every machine, or
    some time after this process is no more."""
    with writing_to(folder), tempfile.NamedTemporaryFile(dir=folder, prefix=".asked-") as file:
        asked, left = Asking(Path(file.name), gethostname()), threading.Event()

        def touch() -> None:
            while not left.wait(ASKED_EVERY):
                with suppress(OSError):
                    asked.file.touch()

        thread = threading.Thread(target=touch, daemon=True)
        thread.start()
        try:
            yield asked
        finally:
            left.set()
            thread.join()


@dataclass(frozen=True)
class Job:
    """What `run_case` needs, and who asks for it.

    `neighbour` is the folder of the run whose settled gas this one starts from, `threads` what each
    of its processors takes at most.
    """

    case: Path
    folder: Path
    settings: tuple[Setting, ...]
    np: int
    neighbour: Path | None
    replicate: int = 1
    asked: Asking | None = None
    threads: int | None = None

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


def perform(job: Job) -> str | None:
    """Do a job in a process of its own; the line in which it failed, None when it did not."""
    command = [
        sys.executable, "-m", "elutria.running.worker", str(job.case), str(job.folder),
        str(job.np), str(job.neighbour or ""), str(job.replicate), *map(str, job.settings),
    ]  # fmt: skip
    if shutil.which("setpriv"):  # nothing goes on when this process is killed
        command = ["setpriv", "--pdeathsig", "TERM", *command]
    if job.asked and job.asked.mark() is None:
        return _placed(job, f"{job.asked.file.parent}: is not there, or nobody asks any more")
    with tempfile.TemporaryFile("w+", errors="replace") as said:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=said,
            env={"OMP_NUM_THREADS": "1", **_limited(job.threads), **os.environ},
        )
        _wait(process, job.asked)
        said.seek(0)
        lines = [line for line in said if line.strip()]
    if process.returncode == 0:
        return None
    ended = killed(process.returncode) or f"ended with exit code {process.returncode}"
    return _placed(job, lines[-1].strip() if lines else ended)


def _limited(threads: int | None) -> dict[str, str]:
    return {} if threads is None else {"OMP_THREAD_LIMIT": str(threads)}


def _wait(process: subprocess.Popen[bytes], asked: Asking | None) -> None:
    """Until it ends; it is ended when nobody asks for it any more."""
    last, seen = asked.mark() if asked else None, time.monotonic()
    while True:
        with suppress(subprocess.TimeoutExpired):
            process.wait(0.1)
            return
        if asked is None:
            continue
        mark = asked.mark()
        if mark != last:
            last, seen = mark, time.monotonic()
        if mark is None or time.monotonic() - seen > GONE_AFTER:
            process.terminate()
            process.wait()
            return


def _placed(job: Job, line: str) -> str:
    """`line`, with the machine where that is another one than that of who asked."""
    host = gethostname()
    return f"{host}: {line}" if job.asked and job.asked.host != host else line


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
        _run(job, on_step)
    except ElutriaError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    finally:
        job.forget_progress()
    return 0


def _run(job: Job, on_step: Callable[[float, Step], None]) -> None:
    """`run_case`; where it is locked, until its other run has ended or this one loses patience."""
    began = time.monotonic()
    while True:
        try:
            run_case(
                Case(job.case), job.folder, job.settings, job.np, on_step, job.neighbour,
                job.replicate,
            )  # fmt: skip
            return
        except LockedError:
            if time.monotonic() - began > PATIENCE:
                raise
            time.sleep(0.2)


def note(step: Step) -> str:
    """The solver's numbers, short."""
    left = " ".join(f"{product} {number}" for product, number in step.left.items())
    ends = f", {duration(step.ends_in_s)} left" if isfinite(step.ends_in_s) else ""
    return f"{left} inside {step.inside}{ends}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
