"""A case's dictionaries as the solver reads them (`elutriaFoam -dictionaries`).

OpenFOAM resolves included files, macros, `#eval` and `#ifeq`; nothing is executed.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

from elutria.errors import InputError, one_line
from elutria.openfoam import kept
from elutria.openfoam.started import started_in
from elutria.openfoam.text import line_with

SOLVER = "elutriaFoam"
_MARK = "elutria: dictionaries "
_LONGEST_WAIT, _LONGEST_WORK = 20.0, 20.0
"""s, and s of processor; a file of a case is read in milliseconds, an included pipe for ever."""
_SWITCHES = {"yes": True, "on": True, "true": True, "no": False, "off": False, "false": False}


class Asked:
    """A dictionary as the solver reads it: `entries`, the names of those that stand in the file
    itself (`own`), of those that stand there twice, at any depth (`repeated`), and of the files
    that it includes."""

    def __init__(self, answer: Mapping[str, Any]):
        self.entries: dict[str, Any] = _value(answer["entries"])
        self.own: list[str] = answer["own"]
        self.repeated: list[str] = answer["repeated"]
        self.included: list[str] = answer["included"]


def ask(case: Path, file: str) -> Asked | None:
    """What the solver reads in a `file` of a case, such as ``constant/feed``; None where no solver
    is at hand, or the file is none that it reads as a dictionary. Raises InputError with the
    solver's reason where it refuses the file."""
    program = shutil.which(SOLVER)
    if program is None or not re.fullmatch(r"(constant|system)/[^/]+", file):
        return None
    answer = _answers(program, case.resolve(), _state(case)).get(file)
    if answer is None:
        return None
    if "error" in answer:
        raise InputError(_shown(answer["error"], case, file))
    return Asked(answer)


def _state(case: Path) -> tuple[object, ...]:
    """What tells that a case's dictionaries have not changed."""
    stats = [(path.name, path.stat()) for path in kept.dictionaries(case)]
    return tuple((name, stat.st_mtime_ns, stat.st_size, stat.st_ino) for name, stat in stats)


@lru_cache(maxsize=256)
def _answers(program: str, case: Path, _files: tuple[object, ...]) -> dict[str, dict[str, Any]]:
    """By the names of the files; from an earlier call where the same ones were read."""
    name = kept.key(case, kept.dictionaries(case), program, "-dictionaries")
    answers: dict[str, dict[str, Any]] | None = kept.read(name, case)
    if answers is None:
        answers = _told(program, case)
        if answers:
            kept.keep(name, case, answers)
    return answers


def _told(program: str, case: Path) -> dict[str, dict[str, Any]]:
    try:
        with (
            started_in(case, [program, "-dictionaries"]) as command,
            subprocess.Popen(
                command, cwd=case, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL, text=True, errors="replace",
            ) as process,
        ):  # fmt: skip
            said = _waited(process, case)
    except OSError:
        return {}
    _, mark, text = said.partition(_MARK)
    try:
        answers: dict[str, dict[str, Any]] = json.loads(text) if mark else {}
    except (json.JSONDecodeError, RecursionError):
        return {}
    return answers


def _waited(process: subprocess.Popen[str], case: Path) -> str:
    """What it says. On a machine that is busy with others it may take long; one that waits for
    something else than the processor, or has worked for so long, reads what has no end."""
    worked = -1.0
    while True:
        try:
            return process.communicate(timeout=_LONGEST_WAIT / 2)[0]
        except subprocess.TimeoutExpired as error:
            before, (waits, worked) = worked, _at_work(process.pid)
            if worked < _LONGEST_WORK and (worked > before or not waits):
                continue
            process.kill()
            raise InputError(
                f"{case}: a dictionary takes more than {_LONGEST_WAIT:g} s to read; allowed: files "
                "that end"
            ) from error


def _at_work(pid: int) -> tuple[bool, float]:
    """Whether a process waits for something else than the processor, and the processor time (s)
    that it took; the longest where that is not known."""
    with suppress(OSError, ValueError, IndexError):
        words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return words[0] == "S", sum(map(int, words[11:13])) / os.sysconf("SC_CLK_TCK")
    return True, _LONGEST_WORK


def _shown(reason: str, case: Path, file: str) -> str:
    """The solver's reason, with names of files as the tool says them."""
    name = case.resolve().name
    said = reason.replace(f"{case.resolve()}/", f"{name}/")
    said = re.sub(r"[^\s\"]*/(?=(?:constant|system)/)", lambda _: f"{name}/", said)
    text = (case / file).read_text("latin-1")
    included = re.findall(r'#include\w*\s+"([^"]+)"', text)
    if "environment variable name" in said and included:  # a name that one of them lacks
        said = f"{name}/{file}, which includes {', '.join(included)}: {said}"
    expression = re.search(r"in expression <<<< (.*?) >>>>", said, re.DOTALL)
    if expression and (line := line_with(text, expression[1])):
        said = f"{name}/{file} on line {line}: {said}"
    return one_line(said if Path(file).name in said else f"{name}/{file}: {said}", 400)


def _value(item: Any) -> Any:
    """A value of the answer as a parser of text would give it."""
    if isinstance(item, str):
        # the name of what was not executed comes as a quoted text
        return item.strip('"') if item.startswith('"#') else _SWITCHES.get(item, item)
    if isinstance(item, list):
        for at, part in enumerate(item):
            if isinstance(part, dict) and "[]" in part:  # dimensions, which come before a value
                rest = [_value(value) for value in item[at + 1 :]]
                return rest[0] if len(rest) == 1 else rest
        return [_value(part) for part in item]
    if isinstance(item, dict):
        if "{}" in item:  # a dictionary in a list
            name, entries = item["{}"]
            return name, _value(entries)
        return {name: _value(part) for name, part in item.items()}
    return item
