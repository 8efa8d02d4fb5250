"""Runs over gas velocities, side by side; what is finished is never run again.

RESULTS/U<velocity> is the first run of a velocity, RESULTS/U<velocity>-<r> replicate r with its own
seed. A `concurrent.futures.Executor` works them off; what it is, and where, is not known here.
With a precision asked, a velocity gets replicates until its cut size is known so well; which
runs there are depends on results alone, so that a sweep that is started again makes the same ones.
The gas of a run starts from that of a run at a velocity nearby, always the same one, as it has
settled there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
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
from elutria.running.gas import label_warnings, require_acting_velocity, write_gas
from elutria.running.run import is_finished, wall_time
from elutria.running.worker import EVERY, Job, perform
from elutria.warned import TOOL, Warned, read_warnings, set_tool_warnings


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
    """Tables of the velocities whose runs are complete, and the failures of the others."""

    tables: Classification = field(default_factory=Classification)
    failures: dict[str, str] = field(default_factory=dict)
    skipped: int = 0
    imprecise: list[float] = field(default_factory=list)
    warnings: dict[str, list[Warned]] = field(default_factory=dict)


class Watcher(Protocol):
    """What a sweep tells while it runs; the command line shows it."""

    def progress(self, name: str, share: float, note: str) -> None:
        """A run is at `share` (0..1)."""

    def finished(self, name: str, line: str) -> None:
        """A run is complete or has failed."""

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
    executor: Executor,
    np: int,
    watcher: Watcher,
    precision: Precision | None = None,
) -> SweepResult:
    """Have the executor run what is not finished, and write the tables of what is complete."""
    with writing_to(folder):
        folder.mkdir(parents=True, exist_ok=True)
    result = SweepResult()
    finished = [is_finished(m.folder, case.fingerprint(m.settings, np)) for m in members]
    if not all(finished):
        require_acting_velocity(case, [(m.velocity, m.settings) for m in members])
    course = _Course(case, np, list(members), precision, result)
    _work_off(course, executor, watcher)
    members = course.members
    for velocity in sorted({member.velocity for member in members}):
        group = [m for m in members if m.velocity == velocity and m.name not in result.failures]
        if group:
            try:
                run = join([read_run(member.folder) for member in group])
                seconds = sum(wall_time(member.folder) for member in group)
                solvers = {m.folder: _of_solver(m.folder) for m in group}
                labels = label_warnings(group[0].folder, velocity)
                number = sum(map(len, solvers.values())) + len(labels)
                tables = classify(run, velocity, seconds, number)
                for member in group:
                    set_tool_warnings(member.folder, [*labels, *tables.notes])
                result.warnings |= {m.name: solvers[m.folder] for m in group}
                result.warnings[group[0].name] += [*labels, *tables.notes]
                result.tables.extend(tables)
            except InputError as error:
                result.failures[group[0].name] = str(error)
    result.tables.write(folder)
    complete = [(m.velocity, m.folder) for m in members if m.name not in result.failures]
    write_gas(folder, complete)
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


def _of_solver(run: Path) -> list[Warned]:
    return [warning for warning in read_warnings(run) if warning.by != TOOL]


def _work_off(course: _Course, executor: Executor, watcher: Watcher) -> None:
    """Run all, and what the course adds; one that fails leaves the others going on.

    A run is handed over once the gas that it starts from has settled, or never will.
    """
    waiting = course.not_finished(course.members)
    active: dict[Future[None], tuple[Member, Job]] = {}
    watcher.planned(len(course.members))
    while waiting or active:
        unsettled = {member.folder for member in waiting}
        for member, job in active.values():
            progress = job.progress()
            if progress is None:
                unsettled.add(member.folder)
            else:
                watcher.progress(member.name, *progress)
        for member in [member for member in waiting if member.neighbour not in unsettled]:
            waiting.remove(member)
            job = course.job(member)
            job.forget_progress()
            active[executor.submit(perform, job)] = member, job
        for future in wait(active, EVERY, FIRST_COMPLETED).done:
            member, _ = active.pop(future)
            failure = _failure(future)
            line = f"FAILED: {failure}"
            if failure is None:
                line = f"finished in {wall_time(member.folder):.0f} s"
            watcher.finished(member.name, line)
            waiting += course.ended(member, failure)
            watcher.planned(len(course.members))


def _failure(future: Future[None]) -> str | None:
    """Why a job failed, also when it is the executor that failed it; None when it did not."""
    error = future.exception()
    if error is None:
        return None
    return str(error) if isinstance(error, ElutriaError) else f"{type(error).__name__}: {error}"


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

    def job(self, member: Member) -> Job:
        """A run as the executor gets it."""
        case = self.case.path.resolve()
        return Job(case, member.folder, member.settings, self.np, member.neighbour)

    def not_finished(self, members: list[Member]) -> list[Member]:
        """Those of `members`, and of what follows from the finished ones, that are to be run."""
        fingerprint = self.case.fingerprint
        complete = [m for m in members if is_finished(m.folder, fingerprint(m.settings, self.np))]
        self.result.skipped += len(complete)
        todo = [member for member in members if member not in complete]
        self.running |= {member.name for member in todo}
        for velocity in dict.fromkeys(member.velocity for member in complete):
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
