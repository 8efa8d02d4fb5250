"""The folder of a sweep: which case it is of, which runs it holds, the tables of all of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from elutria.case.case import SEED, VELOCITY, Case, Setting
from elutria.classification.classify import Classification, classify
from elutria.classification.events import Run, join, read_run
from elutria.errors import InputError
from elutria.estimates.model_error import model_errors
from elutria.estimates.theory import write_theory
from elutria.files import write_json
from elutria.running.axes import Point, number_or_word, own_value, same_value
from elutria.running.gas import gas_warnings, write_gas
from elutria.running.marker import SWEEP, Identity, Marker, open_results, runs_of
from elutria.running.run import wall_time
from elutria.warned import Warned, set_tool_warnings, solver_warnings


class Results:
    """The results of a case with settings, in a folder. Raises InputError where the folder is of
    another case, or of this one before it was changed."""

    def __init__(self, case: Case, folder: Path, extra: Iterable[str] = ()):
        self.case = case
        self.folder = folder
        self.identity = Identity.of(case, map(Setting.parse, extra))
        self.before = open_results(folder, self.identity)
        self._classified: dict[tuple[Point, tuple[Path, ...]], _Rows] = {}

    def write_identity(self) -> None:
        """Say at once whose results these are."""
        write_json(self.folder / SWEEP, {**self.before, **asdict(self.identity)})

    def finished(self) -> dict[Point, list[Path]]:
        """The runs of the case that are complete, of whatever call; replicates in their order."""
        found: dict[tuple[Point, int], Path] = {}
        for path, marker in runs_of(self.folder, self.identity):  # two of a kind are one
            found.setdefault((self._point(marker), marker.replicate), path)
        runs: dict[Point, list[Path]] = {}
        for (point, _), path in sorted(found.items(), key=lambda run: run[0][1]):
            runs.setdefault(point, []).append(path)
        names = _axes(runs)
        in_order = sorted(runs, key=lambda point: (self._rank(point, names), point.velocity))
        return {point: runs[point] for point in in_order}

    def _rank(self, point: Point, names: Iterable[str]) -> list[tuple[bool, float | str]]:
        """By the values of the settings: numbers rise, words follow by letters."""
        return [(isinstance(v, str), v) for v in self._values(point, names).values()]

    def _point(self, marker: Marker) -> Point:
        """The point of a run, from the settings that it was given beside those of all runs."""
        own = [Setting.parse(s) for s in marker.identity.settings[len(self.identity.settings) :]]
        entries = {f"{setting.file}:{setting.entry}": setting.value for setting in own}
        if marker.replicate > 1:
            entries.pop(SEED, None)
            seeds = [s.value for s in own if f"{s.file}:{s.entry}" == SEED]
            if len(seeds) > 1:
                entries[SEED] = seeds[0]
        velocity = entries.pop(VELOCITY, None)
        others = {
            name: value
            for name, value in entries.items()
            if not same_value(value, own_value(self.case, name))
        }
        return Point(
            self.case.velocity() if velocity is None else float(velocity),
            tuple(sorted(others.items())),
        )

    def write_tables(
        self, failures: Mapping[str, str]
    ) -> tuple[Classification, dict[str, str], dict[str, list[Warned]]]:
        """The tables of all complete runs, written; by name what could not be read, and warnings.

        A run's warnings.json gets those of its tables; those of replicates together are in each.
        """
        runs, unreadable = self.finished(), {}
        warnings: dict[str, list[Warned]] = {}
        axes = _axes(runs)
        tables = Classification(axes=tuple(axes))
        for point, folders in runs.items():
            try:
                rows = self.classified(point, folders)
            except InputError as error:
                unreadable[point.title] = str(error)
                continue
            warnings[point.title] = rows.warnings
            tables.extend(rows.tables.with_settings(self._values(point, axes)))
        tables.write(self.folder)
        write_gas(
            self.folder,
            [({"gas_velocity_m_s": point.velocity, **self._values(point, axes)}, folder)
             for point, folders in runs.items() for folder in folders],
            axes,
        )  # fmt: skip
        if runs:
            write_theory(self.case, [point.velocity for point in runs], self.folder)
        content = {
            **asdict(self.identity),
            "velocities_m_s": sorted({point.velocity for point in runs}),
            "varied": {name: _distinct(self._values(p, [name])[name] for p in runs)
                       for name in axes},
            "replicates": max((len(folders) for folders in runs.values()), default=0),
            "failed": {**failures, **unreadable},
        }  # fmt: skip
        write_json(self.folder / SWEEP, content)
        return tables, unreadable, warnings

    def classified(self, point: Point, folders: Iterable[Path]) -> _Rows:
        """The rows of a point's runs, made once; the runs' files get their warnings. Raises
        InputError for what is incomplete."""
        folders = tuple(folders)
        known = self._classified.get((point, folders))
        if known is None:
            run = join([read_run(folder) for folder in folders])
            known = self._classified[point, folders] = _classify(point, folders, run)
        return known

    def _values(self, point: Point, axes: Iterable[str]) -> dict[str, float | str]:
        """The value that a point has for each axis, its own or the case's."""
        own = dict(point.others)
        return {name: number_or_word(own.get(name) or self._own[name]) for name in axes}

    @cached_property
    def _own(self) -> Mapping[str, str]:
        return _OwnValues(self.case)


@dataclass(frozen=True)
class _Rows:
    """Of a point's runs: the rows of the tables, and the warnings."""

    tables: Classification
    warnings: list[Warned]


def _classify(point: Point, folders: Sequence[Path], run: Run) -> _Rows:
    labels = gas_warnings(folders[0], point.velocity)
    solvers = [solver_warnings(folder) for folder in folders]
    warned = sum(map(len, solvers)) + len(labels)
    seconds = sum(wall_time(folder) for folder in folders)
    rows = classify(run, point.velocity, seconds, warned, model_errors(Case(folders[0])))
    own = [*labels, *rows.notes]
    for folder in folders:
        set_tool_warnings(folder, own)
    return _Rows(rows, [*(warning for some in solvers for warning in some), *own])


class _OwnValues(dict[str, str]):
    """The case's own values of entries, read when they are asked for."""

    def __init__(self, case: Case):
        super().__init__()
        self.case = case

    def __missing__(self, name: str) -> str:
        self[name] = own_value(self.case, name)
        return self[name]


def _axes(points: Iterable[Point]) -> list[str]:
    return sorted({name for point in points for name, _ in point.others})


def _distinct(values: Iterable[Any]) -> list[Any]:
    return sorted(set(values), key=lambda value: (isinstance(value, str), value))
