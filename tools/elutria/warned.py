"""Warnings of a run as data: RUN/warnings.json, which the solver and the tool write.

Each says what is wrong, by how much, and what to set. See docs/user/outputs.md.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from elutria.errors import InputError, one_line
from elutria.files import read_text, write_json

WARNINGS = "warnings.json"
TOOL = "elutria"


@dataclass(frozen=True)
class Warned:
    """A warning. Of several with the same `name` and `what`, the one of the largest `size` is the
    worst; it was said `times` times, first and last at these times (s) of the run, by a program.
    """

    name: str
    what: str
    how_much: str
    what_to_set: str
    size: float = 0.0
    first_time_s: float | None = None
    last_time_s: float | None = None
    times: int = 1
    by: str = TOOL

    @property
    def text(self) -> str:
        """One line."""
        return f"{self.what}: {self.how_much}; {self.what_to_set}"


def read_warnings(run: Path) -> list[Warned]:
    """The warnings of a run; none where there is no file, as in runs of earlier versions.

    Raises InputError for a file that is not one of warnings.
    """
    file = run / WARNINGS
    if not file.exists():
        return []
    try:
        return [Warned(**_known(entry)) for entry in json.loads(read_text(file))]
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{file}: is not a list of warnings ({one_line(error)})") from error


def solver_warnings(run: Path) -> list[Warned]:
    """Those of the solver alone."""
    return [warning for warning in read_warnings(run) if warning.by != TOOL]


def _known(entry: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in entry.items() if name in Warned.__dataclass_fields__}


def set_tool_warnings(run: Path, found: Iterable[Warned]) -> None:
    """Write the tool's own warnings of a run beside the solver's, instead of its earlier ones."""
    whole = [*solver_warnings(run), *found]
    write_json(run / WARNINGS, [asdict(warning) for warning in whole])


def grouped(runs: Mapping[str, Iterable[Warned]]) -> list[str]:
    """A line for each kind of warning, with the runs that have it and the worst of them."""
    kinds: dict[tuple[str, str], dict[str, Warned]] = {}
    for run, warnings in runs.items():
        for warning in warnings:
            kinds.setdefault((warning.name, warning.what), {})[run] = warning
    lines = []
    for by_run in kinds.values():
        worst = max(by_run, key=lambda run: by_run[run].size)
        at_worst = f" (worst at {worst})" if len(by_run) > 1 else ""
        lines.append(f"{'; '.join(by_run)}: {by_run[worst].text}{at_worst}")
    return lines
