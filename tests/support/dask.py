"""A Dask scheduler with workers on loopback, each in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest


def need() -> None:
    """Skip the test where dask.distributed is not installed."""
    pytest.importorskip("distributed", reason="no Dask: etc/setup/cluster installs it")


@contextmanager
def dask(
    place: Path,
    workers: Sequence[Mapping[str, str]] = ({}, {}),
    options: Sequence[str] = ("--nthreads", "1"),
) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler's address and its workers, one for each environment in `workers`."""
    place.mkdir()
    file = place / "scheduler.json"
    loopback = ["--host", "127.0.0.1", "--no-dashboard"]
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", *loopback,
               "--scheduler-file", str(file)]  # fmt: skip
    with ExitStack() as ends:
        ends.callback(_end, _started(command, place / "scheduler.log", {}))
        _wait_for(file)
        started = []
        for number, environment in enumerate(workers):
            log = place / f"worker{number}.log"
            command = [sys.executable, "-m", "distributed.cli.dask_worker", *loopback,
                       "--scheduler-file", str(file), "--no-nanny", "--name", f"w{number}",
                       "--local-directory", str(place), *options]  # fmt: skip
            started.append(_started(command, log, environment))
            ends.callback(_end, started[-1])
        for number in range(len(workers)):
            _wait_for(place / f"worker{number}.log", "Registered to")
        yield f"dask:{file}", started


def _started(
    command: list[str], log: Path, environment: Mapping[str, str]
) -> subprocess.Popen[bytes]:
    with log.open("w") as output:
        return subprocess.Popen(
            command, stdout=output, stderr=output, env={**os.environ, **environment}
        )


def _wait_for(file: Path, text: str = "") -> None:
    end = time.monotonic() + 60
    while not (file.is_file() and text in file.read_text()):
        if time.monotonic() > end:
            raise RuntimeError(f"no Dask: see {file}")
        time.sleep(0.1)


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
