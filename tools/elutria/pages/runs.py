"""The runs behind the tables of RESULTS: where each is, and what it says of itself."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import isclose
from pathlib import Path
from typing import Any

from elutria.case.case import Case
from elutria.errors import InputError
from elutria.files import read_json, read_text
from elutria.openfoam.dictionary import Dictionary
from elutria.output.settings import Setting, Settings
from elutria.running.marker import FINISHED, MARKER, identity_of, runs_of
from elutria.running.run import PLAN, SOLVER
from elutria.tables import VELOCITY

LEDGER = "postProcessing/ledger.json"
WARNINGS = "warnings.json"
LOG_LIMIT = 500_000_000


@dataclass(frozen=True)
class RunFolder:
    """A complete run."""

    path: Path
    setting: Setting

    @property
    def name(self) -> str:
        """Its folder's name."""
        return self.path.resolve().name

    @cached_property
    def case(self) -> Case:
        """The case as it was run."""
        return Case(self.path)

    @cached_property
    def plan(self) -> dict[str, Any]:
        """What the solver planned; {} of a run that has no plan."""
        return _optional(self.path / PLAN)

    @cached_property
    def ledger(self) -> dict[str, Any]:
        """The account of all that was fed."""
        return read_json(self.path / LEDGER)

    @cached_property
    def marker(self) -> dict[str, Any]:
        """What it is a run of."""
        return _optional(self.path / MARKER)

    @property
    def wall_time(self) -> float | None:
        """Seconds; None where it is not known."""
        value = _optional(self.path / FINISHED).get("wall_time_s")
        return float(value) if isinstance(value, (int, float)) else None

    @cached_property
    def warnings(self) -> list[str]:
        """Lines: those of warnings.json, or else those of the plan."""
        file = self.path / WARNINGS
        if not file.is_file():
            return [str(line) for line in self.plan.get("warnings", [])]
        try:
            entries = json.loads(read_text(file))
            if not isinstance(entries, list):
                raise TypeError
            return [_warning(entry) for entry in entries]
        except (ValueError, TypeError, AttributeError) as error:
            raise InputError(f"{file}: is not a list of warnings") from error

    @cached_property
    def log(self) -> Log:
        """What the solver's log says of versions and of what was needed."""
        path = self.path / f"log.{SOLVER}"
        return Log.read(path) if path.is_file() else Log({}, [])


@dataclass(frozen=True)
class Log:
    """Head of a solver's log by its names, and the lines of what was needed in the end."""

    head: dict[str, str]
    needed: list[tuple[str, str, str]]

    @classmethod
    def read(cls, path: Path) -> Log:
        """From log.elutriaFoam."""
        text = path.read_text(errors="replace")[:LOG_LIMIT]
        pairs = re.findall(r"^(Build|Exec|Date|Host|nProcs) *: *(.*)$", text[:20_000], re.M)
        head = {key: value.strip('" ') for key, value in pairs}
        end = re.search(r"^Scene plan: what was needed.*\n((?: {4}.*\n)+)", text, re.M)
        rows = []
        for line in end[1].splitlines() if end else []:
            cells = [*re.split(r" {2,}", line.strip(), maxsplit=2), "", ""]
            rows.append((cells[0], cells[1], cells[2]))
        return cls(head, rows)


def find_runs(folder: Path, settings: Settings) -> list[RunFolder]:
    """The complete runs of RESULTS, in the order of their settings; of a run: itself."""
    known: dict[tuple[Setting, str], RunFolder] = {}
    for path, which in _complete(folder):
        setting = _listed(_setting(path, settings.columns), settings.all)
        if setting is not None:  # two of a kind are one
            known.setdefault((setting, which), RunFolder(path, setting))
    if not known:
        raise InputError(
            f"{folder}: none of the runs of its tables is there; allowed: the folder of a sweep or "
            "a run with its runs in it"
        )
    return sorted(
        known.values(), key=lambda run: (settings.all.index(run.setting), len(run.name), run.name)
    )


def _complete(folder: Path) -> Iterator[tuple[Path, str]]:
    """The complete runs of RESULTS, and which replicate each is; by its name where they do not say
    what they are of."""
    if (folder / LEDGER).is_file():
        yield folder, folder.name
        return
    identity = identity_of(folder)
    if identity is not None:
        found = [(path, str(run.replicate)) for path, run in runs_of(folder, identity)]
    else:
        found = [(file.parent, file.parent.name) for file in sorted(folder.glob(f"*/{FINISHED}"))]
    yield from ((path, which) for path, which in found if (path / LEDGER).is_file())


def _setting(path: Path, columns: list[str]) -> Setting:
    """The run's values in the columns that part the tables' rows."""
    case = Case(path)
    return tuple(case.velocity() if name == VELOCITY else _entry(case, name) for name in columns)


def _listed(setting: Setting, listed: list[Setting]) -> Setting | None:
    """The setting as the tables have it, with fewer digits; None where they do not."""

    def same(one: Any, other: Any) -> bool:
        both = isinstance(one, float) and isinstance(other, float)
        return isclose(one, other, rel_tol=1e-7) if both else one == other

    for entry in listed:
        if all(map(same, setting, entry)):
            return entry
    return None


def _entry(case: Case, name: str) -> Any:
    """The value of FILE:ENTRY in a case; None where it has none."""
    file, _, entry = name.partition(":")
    *above, last = entry.split("/")
    try:
        dictionary: Dictionary = case.dictionary(file, with_included=True)
        for part in above:
            dictionary = dictionary.sub(part)
        value = dictionary.raw(last)
    except InputError:
        return None
    try:
        return float(value)
    except (TypeError, ValueError):
        return str(value)


def _optional(path: Path) -> dict[str, Any]:
    return read_json(path) if path.is_file() else {}


def _warning(entry: dict[str, Any]) -> str:
    """One line of an entry of warnings.json."""
    what = f"{entry.get('what', '')}: {entry.get('how_much', '')}; {entry.get('what_to_set', '')}"
    times = entry.get("times", 1)
    return what + (f" ({times} times)" if times and times > 1 else "")
