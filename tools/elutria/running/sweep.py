"""Runs over gas velocities and other settings, side by side; what is finished is never run again.

RESULTS/U<velocity> is the first run of a point (with other settings RESULTS/U5_loading=0.4),
RESULTS/U<velocity>-<r> replicate r with its own seed. A `concurrent.futures.Executor` works them
off; what it is, and where, is not known here. With a precision asked, a point gets replicates until
its cut size is known so well; which runs there are depends on results alone, so that a sweep that
is started again makes the same ones. The gas of a run starts from that of a run at a velocity
nearby, always the same one, as it has settled there.
"""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from elutria.case.case import SEED, Case, Setting
from elutria.classification.classify import Classification
from elutria.classification.events import join, read_run
from elutria.classification.precision import Precision, d50_half_width
from elutria.errors import ElutriaError, InputError, one_line
from elutria.estimates import machine, ranks
from elutria.estimates.price import Price, duration
from elutria.files import writing_to
from elutria.running import costs
from elutria.running.axes import Point, seed_of
from elutria.running.budget import Budget, Known
from elutria.running.gas import require_acting_velocity
from elutria.running.results import Results
from elutria.running.run import is_finished, plans, wall_time
from elutria.running.worker import EVERY, Asking, Job, asking, perform
from elutria.warned import Warned


@dataclass(frozen=True)
class Member:
    """One run of a sweep: its point, folder and settings.

    `neighbour` is the folder of the run whose settled gas it starts from.
    """

    point: Point
    replicate: int
    folder: Path
    settings: tuple[Setting, ...]
    neighbour: Path | None = None

    @property
    def name(self) -> str:
        """`5 m/s`, `5 m/s, loading 0.2, replicate 2`."""
        return self.point.title + (f", replicate {self.replicate}" if self.replicate > 1 else "")


@dataclass
class SweepResult:
    """Tables of the points whose runs are complete, and the failures of the others."""

    tables: Classification = field(default_factory=Classification)
    failures: dict[str, str] = field(default_factory=dict)
    skipped: int = 0
    imprecise: list[str] = field(default_factory=list)
    warnings: dict[str, list[Warned]] = field(default_factory=dict)
    ran: list[Path] = field(default_factory=list)


class Watcher(Protocol):
    """What a sweep tells while it runs; the command line shows it."""

    def progress(self, name: str, share: float, note: str) -> None:
        """A run is at `share` (0..1)."""

    def finished(self, name: str, line: str) -> None:
        """A run is complete or has failed."""

    def planned(self, runs: int) -> None:
        """There are so many runs in all."""

    def expected(self, cost: Price) -> None:
        """What the runs that are not finished are expected to cost; told before they begin."""


def plan(
    case: Case, folder: Path, points: list[Point], replicates: int, extra: Iterable[str]
) -> list[Member]:
    """The runs of a sweep, checked as far as possible without running anything."""
    if replicates < 1:
        raise InputError(f"--replicates {replicates}; allowed: a whole number >= 1")
    if replicates > 1:
        case.require_used(SEED)
    extra = list(extra)
    _refuse_set_twice(points, extra)
    members = []
    families: dict[tuple[tuple[str, str], ...], list[Path]] = {}
    for point in points:
        family = families.setdefault(point.others, [])
        settings = tuple(case.settings_for(point.velocity, [*extra, *point.settings()]))
        # two back: it is under way when this one's turn comes, also with two at a time
        neighbour = family[-2] if len(family) >= 2 else None
        first = Member(point, 1, folder / point.folder, settings, neighbour)
        family.append(first.folder)
        members += [first, *(_replicate(case, first, r) for r in range(2, replicates + 1))]
    _refuse_one_folder(members)
    case.check_settings(*(member.settings for member in members if member.replicate == 1))
    return members


def _refuse_one_folder(members: list[Member]) -> None:
    """Two words may look alike in the name of a folder, where one run would replace the other."""
    named: dict[Path, Member] = {}
    for member in members:
        other = named.setdefault(member.folder, member)
        if other is not member:
            raise InputError(
                f"--vary: '{other.name}' and '{member.name}' are both {member.folder.name} as the "
                "name of a folder; allowed: one of them, each in a folder of results of its own"
            )


def _refuse_set_twice(points: list[Point], extra: list[str]) -> None:
    given = {text.partition("=")[0].strip() for text in extra}
    for name in {name for point in points for name, _ in point.others} & given:
        raise InputError(f"--set {name}: is varied too; allowed: either of both")


def _replicate(case: Case, first: Member, number: int) -> Member:
    """Replicate `number` (2, 3, ...) of a point's first run: the same with another seed."""
    seed = seed_of(case, first.settings) + number - 1
    return Member(
        first.point,
        number,
        first.folder.with_name(f"{first.folder.name}-{number}"),
        (*first.settings, Setting.parse(f"{SEED}={seed}")),
        first.folder,
    )


def paying(case: Case, members: list[Member], np: int) -> ranks.Choice:
    """How many of `np` processors pay here for the first run that is not finished."""
    todo = [m for m in members if not is_finished(m.folder, case.fingerprint(m.settings, np))]
    if np == 1 or not todo or ranks.exact():
        return ranks.Choice(np)
    return ranks.paying(plans(case, [todo[0].settings])[0], np, ranks.cores())


def run_sweep(
    results: Results,
    members: list[Member],
    executor: Executor,
    np: int,
    watcher: Watcher,
    goal: Precision | Budget | None = None,
    threads: int | None = None,
) -> SweepResult:
    """Have the executor run what is not finished, each processor with so many `threads` at most,
    and write the tables of all that is complete in the folder of the results, by this call or an
    earlier one."""
    case = results.case
    if goal is not None:
        case.require_used(SEED)
    with writing_to(results.folder):
        results.folder.mkdir(parents=True, exist_ok=True)
    results.write_identity()
    result = SweepResult()
    todo = [m for m in members if not is_finished(m.folder, case.fingerprint(m.settings, np))]
    if todo:
        _look_ahead(case, members, todo, watcher, goal)
    try:
        with asking(results.folder) as asked:
            course = _Course(results, np, list(members), goal, result, asked, threads)
            _work_off(course, executor, watcher)
    except KeyboardInterrupt:
        results.write_tables(result.failures)
        raise
    result.tables, unreadable, result.warnings = results.write_tables(result.failures)
    result.failures |= unreadable
    return result


def _look_ahead(
    case: Case,
    members: list[Member],
    todo: list[Member],
    watcher: Watcher,
    goal: Precision | Budget | None,
) -> None:
    """Have some runs planned: whether their gas is that of their velocity, and what they cost.

    Raises InputError where it is not, or where they cost more than the budget.
    """
    planned = costs.chosen(len(todo))
    answers = plans(case, [todo[number].settings for number in planned])
    require_acting_velocity(
        case,
        [(m.point.velocity, m.settings) for m in members],
        [(todo[n].point.velocity, plan) for n, plan in zip(planned, answers, strict=True)],
    )
    cost = costs.total(costs.spread(len(todo), planned, machine.expected(answers)))
    watcher.expected(cost)
    spent = costs.came_to([m.folder for m in members if m not in todo]).processor_s
    if isinstance(goal, Budget) and spent + cost.processor_s > goal.processor_s:
        raise InputError(
            f"--budget: {duration(goal.processor_s)}, but the runs asked for take "
            f"{duration(spent + cost.processor_s)} of processor; allowed: that, or fewer "
            "points or particles"
        )


def _work_off(course: _Course, executor: Executor, watcher: Watcher) -> None:
    """Run all, and what the course adds; one that fails leaves the others going on.

    A run is handed over once the gas that it starts from has settled, or never will.
    """
    waiting = course.not_finished(course.members)
    active: dict[Future[str | None], tuple[Member, Job]] = {}
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
                line = f"finished in {wall_time(member.folder):.0f} s{course.left_out(member)}"
                course.result.ran.append(member.folder)
            watcher.finished(member.name, line)
            waiting += course.ended(member, failure)
            watcher.planned(len(course.members))


def _failure(future: Future[str | None]) -> str | None:
    """Why a job failed, also when it is the executor that failed it; None when it did not."""
    try:
        return future.result()
    except CancelledError:
        return "given up by the engine"
    except ElutriaError as error:
        return str(error)
    except Exception as error:
        return one_line(f"{type(error).__name__}: {error}", 400)


class _Course:
    """Which runs a sweep has, and which it needs after one has ended."""

    def __init__(
        self,
        results: Results,
        np: int,
        members: list[Member],
        goal: Precision | Budget | None,
        result: SweepResult,
        asked: Asking,
        threads: int | None,
    ):
        self.results = results
        self.case = results.case
        self.np = np
        self.members = members
        self.goal = goal
        self.result = result
        self.asked = asked
        self.threads = threads
        self.running: set[str] = set()

    def job(self, member: Member) -> Job:
        """A run as the executor gets it."""
        case = self.case.path.resolve()
        return Job(
            case, member.folder, member.settings, self.np, member.neighbour, member.replicate,
            self.asked, self.threads,
        )  # fmt: skip

    def left_out(self, member: Member) -> str:
        """That a finished run did not take all processors, where it did not."""
        with suppress(InputError):
            if (used := costs.number(member.folder, "np")) < self.np:
                return f", on {used:.0f} of {self.np} processors"
        return ""

    def not_finished(self, members: list[Member]) -> list[Member]:
        """Those of `members`, and of what follows from the finished ones, that are to be run."""
        fingerprint = self.case.fingerprint
        complete = [m for m in members if is_finished(m.folder, fingerprint(m.settings, self.np))]
        self.result.skipped += len(complete)
        todo = [member for member in members if member not in complete]
        self.running |= {member.name for member in todo}
        points = list(dict.fromkeys(member.point for member in complete))
        if isinstance(self.goal, Budget):
            points = points[:1]  # it looks at all of them
        for point in points:
            todo += self._further(point)
        return todo

    def ended(self, member: Member, failure: str | None) -> list[Member]:
        """A run ended; the runs to start now."""
        self.running.discard(member.name)
        if failure is not None:
            self.result.failures[member.name] = failure
        return self._further(member.point)

    def _further(self, point: Point) -> list[Member]:
        if isinstance(self.goal, Budget):
            return self._within(self.goal)
        group = self._group(point)
        if not self._is_complete(group):
            return []
        count = None
        try:
            if self.goal is not None:
                run = join([read_run(member.folder) for member in group])
                count = self.goal.further_runs(run, len(group))
            if count is None and self.running:  # the others' processors are at work meanwhile
                self.results.classified(point, [member.folder for member in group])
        except InputError:
            return []  # told when the tables are made
        if count == 0:
            self.result.imprecise.append(point.title)
        return self.not_finished(self._add(group, count or 0))

    def _within(self, budget: Budget) -> list[Member]:
        """What a budget allows, once nothing runs any more."""
        if self.running:
            return []
        known = {}
        for point in dict.fromkeys(member.point for member in self.members):
            group = self._group(point)
            with suppress(InputError):
                if self._is_complete(group):
                    folders = [member.folder for member in group]
                    width = d50_half_width(join([read_run(folder) for folder in folders]))
                    each = costs.came_to(folders).processor_s / len(folders)
                    known[point] = Known(width, len(folders), each)
        further = budget.further_runs(known)
        added = [self._add(self._group(point), count) for point, count in further.items()]
        return self.not_finished([member for members in added for member in members])

    def _group(self, point: Point) -> list[Member]:
        return [member for member in self.members if member.point == point]

    def _is_complete(self, group: list[Member]) -> bool:
        return not any(m.name in self.running or m.name in self.result.failures for m in group)

    def _add(self, group: list[Member], count: int) -> list[Member]:
        """So many more replicates of a point."""
        first = len(group) + 1
        further = [_replicate(self.case, group[0], first + k) for k in range(count)]
        self.members += further
        return further
