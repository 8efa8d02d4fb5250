"""Runs over gas velocities, side by side; what is finished is never run again.

RESULTS/U<velocity> is the first run of a velocity, RESULTS/U<velocity>-<r> replicate r with its own
seed. Each is a process of its own, so that one that fails or is killed leaves the others alone.
With a precision asked, a velocity gets replicates until its cut size is known so well; which
runs there are depends on results alone, so that a sweep that is started again makes the same ones.
The gas of a run starts from that of a run at a velocity nearby, always the same one, as it has
settled there.
"""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np

from elutria.case.case import PARAMETERS, SEED, Case, Setting
from elutria.classification.classify import Classification, classify
from elutria.classification.events import join, read_run
from elutria.classification.precision import Precision
from elutria.errors import ElutriaError, InputError, one_line
from elutria.estimates.theory import write_theory
from elutria.files import write_json, writing_to
from elutria.running.run import is_finished, wall_time


@dataclass(frozen=True)
class Member:
    """One run of a sweep: its velocity (m/s), folder and settings.

    `neighbour` is the folder of the run whose settled gas it starts from.
    """

    velocity: float
    replicate: int
    folder: Path
    settings: tuple[Setting, ...]
    neighbour: Path | None = None

    @property
    def name(self) -> str:
        """`5 m/s`, `5 m/s, replicate 2`."""
        return f"{self.velocity:g} m/s" + (
            f", replicate {self.replicate}" if self.replicate > 1 else ""
        )


@dataclass
class SweepResult:
    """Tables of the velocities that are whole, and the reasons of those that are not."""

    tables: Classification = field(default_factory=Classification)
    failures: dict[str, str] = field(default_factory=dict)
    skipped: int = 0
    imprecise: list[float] = field(default_factory=list)


class Watcher(Protocol):
    """What a sweep tells while it runs; the command line shows it. Called from several threads."""

    def progress(self, name: str, share: float, note: str) -> None:
        """A run is at `share` (0..1)."""

    def finished(self, name: str, line: str) -> None:
        """A run is whole or failed."""

    def planned(self, runs: int) -> None:
        """There are so many runs in all."""


def parse_velocities(text: str) -> list[float]:
    """`A:B:N` (N values from A to B) or a comma-separated list, m/s; rising, without repeats."""
    allowed = "A:B:N such as 3:10:8, or a list such as 3,4.5,6 (m/s, > 0)"
    try:
        if ":" in text:
            first, last, count = text.split(":")
            if not 1 <= int(count) <= 1000:
                raise ValueError
            values = np.linspace(float(first), float(last), int(count)).tolist()
        else:
            values = [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"--velocity '{one_line(text, 60)}'; allowed: {allowed}") from None
    for value in values:
        if not (math.isfinite(value) and 0 < value <= 1000):
            raise InputError(f"--velocity '{one_line(text, 60)}': {value:g}; allowed: {allowed}")
    return sorted({float(f"{value:.12g}") for value in values})


def plan(
    case: Case, folder: Path, velocities: list[float], replicates: int, extra: Iterable[str]
) -> list[Member]:
    """The runs of a sweep, checked as far as possible without running anything."""
    if replicates < 1:
        raise InputError(f"--replicates {replicates}; allowed: a whole number >= 1")
    extra = list(extra)
    members = []
    folders = [folder / f"U{velocity:.12g}" for velocity in velocities]
    for k, velocity in enumerate(velocities):
        settings = tuple(case.settings_for(velocity, extra))
        # two back: it is under way when this one's turn comes, also with two at a time
        neighbour = folders[k - 2] if k >= 2 else None
        first = Member(velocity, 1, folders[k], settings, neighbour)
        members += [first, *(_replicate(case, first, r) for r in range(2, replicates + 1))]
    case.check_settings(members[0].settings)
    return members


def _replicate(case: Case, first: Member, number: int) -> Member:
    """Replicate `number` (2, 3, ...) of a velocity's first run: the same with another seed."""
    parameters = case.dictionary(PARAMETERS, with_included=True)
    seed = int(parameters.number("seed", at_least=0)) + number - 1
    return Member(
        first.velocity,
        number,
        first.folder.with_name(f"{first.folder.name}-{number}"),
        (*first.settings, Setting.parse(f"{SEED}={seed}")),
        first.folder,
    )


def run_sweep(
    case: Case,
    folder: Path,
    members: list[Member],
    jobs: int,
    np: int,
    watcher: Watcher,
    precision: Precision | None = None,
) -> SweepResult:
    """Run what is not finished, `jobs` at a time, and write the tables of what is whole."""
    with writing_to(folder):
        folder.mkdir(parents=True, exist_ok=True)
    result = SweepResult()
    course = _Course(case, np, list(members), precision, result)
    todo = course.not_finished(members)
    with _Pool(case, jobs, np, watcher) as pool:
        pool.run(todo, course)
    members = course.members
    for velocity in sorted({member.velocity for member in members}):
        group = [m for m in members if m.velocity == velocity and m.name not in result.failures]
        if group:
            try:
                run = join([read_run(member.folder) for member in group])
                seconds = sum(wall_time(member.folder) for member in group)
                result.tables.extend(classify(run, velocity, seconds))
            except InputError as error:
                result.failures[group[0].name] = str(error)
    result.tables.write(folder)
    write_theory(case, [member.velocity for member in members], folder)
    write_json(
        folder / "sweep.json",
        {
            "case": case.name,
            "velocities_m_s": sorted({member.velocity for member in members}),
            "replicates": max(member.replicate for member in members),
            "failed": result.failures,
        },
    )
    return result


class _Course:
    """Which runs a sweep has, and which it needs after one has ended."""

    def __init__(
        self,
        case: Case,
        np: int,
        members: list[Member],
        precision: Precision | None,
        result: SweepResult,
    ):
        self.case = case
        self.np = np
        self.members = members
        self.precision = precision
        self.result = result
        self.running: set[str] = set()

    def not_finished(self, members: list[Member]) -> list[Member]:
        """Those of `members`, and of what follows from the finished ones, that are to be run."""
        fingerprint = self.case.fingerprint
        whole = [m for m in members if is_finished(m.folder, fingerprint(m.settings, self.np))]
        self.result.skipped += len(whole)
        todo = [member for member in members if member not in whole]
        self.running |= {member.name for member in todo}
        for velocity in dict.fromkeys(member.velocity for member in whole):
            todo += self._further(velocity)
        return todo

    def ended(self, member: Member, failure: str | None) -> list[Member]:
        """A run ended; the runs to start now."""
        self.running.discard(member.name)
        if failure is not None:
            self.result.failures[member.name] = failure
        return self._further(member.velocity)

    def _further(self, velocity: float) -> list[Member]:
        group = [member for member in self.members if member.velocity == velocity]
        bad = any(m.name in self.running or m.name in self.result.failures for m in group)
        if self.precision is None or bad:
            return []
        try:
            run = join([read_run(member.folder) for member in group])
        except InputError:
            return []  # told when the tables are made
        count = self.precision.further_runs(run, len(group))
        if count == 0:
            self.result.imprecise.append(velocity)
        first = len(group) + 1
        further = [_replicate(self.case, group[0], first + k) for k in range(count or 0)]
        self.members += further
        return self.not_finished(further)


class _Pool:
    """Worker processes, all ended when the block is left for whatever reason."""

    def __init__(self, case: Case, jobs: int, np: int, watcher: Watcher):
        self.case = case
        self.np = np
        self.watcher = watcher
        self.executor = ThreadPoolExecutor(max_workers=jobs)
        self.processes: set[subprocess.Popen[str]] = set()
        self.gas_is_there: dict[Path, threading.Event] = {}
        self.lock = threading.Lock()
        self.stopping = False

    def __enter__(self) -> _Pool:
        return self

    def __exit__(self, *_: object) -> None:
        with self.lock:
            self.stopping = True
            for process in self.processes:
                process.terminate()
        self.executor.shutdown(wait=True, cancel_futures=True)

    def run(self, members: list[Member], course: _Course) -> None:
        """Run all, and what the course adds; one that fails leaves the others going on."""
        pending: dict[Future[None], Member] = {}

        def start(members: list[Member]) -> None:
            self.gas_is_there.update({member.folder: threading.Event() for member in members})
            pending.update({self.executor.submit(self._one, member): member for member in members})
            self.watcher.planned(len(course.members))

        start(members)
        while pending:
            for future in wait(pending, return_when=FIRST_COMPLETED).done:
                member = pending.pop(future)
                failure = None
                try:
                    future.result()
                except ElutriaError as error:
                    failure = str(error)
                    self.watcher.finished(member.name, f"FAILED: {error}")
                else:
                    seconds = wall_time(member.folder)
                    self.watcher.finished(member.name, f"finished in {seconds:.0f} s")
                start(course.ended(member, failure))

    def _one(self, member: Member) -> None:
        try:
            self._run(member)
        finally:
            self.gas_is_there[member.folder].set()

    def _run(self, member: Member) -> None:
        if member.neighbour in self.gas_is_there:
            self.gas_is_there[member.neighbour].wait()
        settings = [f"{s.file}:{s.entry}={s.value}" for s in member.settings]
        command = [
            sys.executable, "-m", "elutria.running.worker", str(self.case.path), str(member.folder),
            str(self.np), str(member.neighbour or ""), *settings,
        ]  # fmt: skip
        if shutil.which("setpriv"):  # nothing goes on when the sweep is killed
            command = ["setpriv", "--pdeathsig", "TERM", *command]
        environment = {"OMP_NUM_THREADS": "1", **os.environ}
        with self.lock:
            if self.stopping:
                return
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                errors="replace",
                env=environment,
            )
            self.processes.add(process)

        def progress(share: float, note: str) -> None:
            self.gas_is_there[member.folder].set()
            self.watcher.progress(member.name, share, note)

        _follow(process, progress)
        message = process.stderr.read() if process.stderr else ""
        code = process.wait()
        with self.lock:
            self.processes.discard(process)
        if code != 0:
            lines = [line for line in message.splitlines() if line.strip()]
            raise ElutriaError(lines[-1] if lines else f"ended with exit code {code}")


def _follow(process: subprocess.Popen[str], progress: Callable[[float, str], None]) -> None:
    for line in process.stdout or ():
        words = line.split(maxsplit=2)
        if len(words) >= 2 and words[0] == "progress":
            progress(float(words[1]), words[2].strip() if len(words) > 2 else "")
