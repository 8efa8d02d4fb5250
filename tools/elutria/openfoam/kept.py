"""What a program of OpenFOAM said of a case, kept in the user's cache by the contents of the files
that it read: it is not asked again about a case, or a copy of one, of which no file has changed."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from collections.abc import Iterable, Iterator
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

from elutria.files import cache_folder
from elutria.openfoam.elsewhere import FOLDERS, LARGEST_DICTIONARY, in_case

_MOST = 2000
"""Answers that are kept, a thousand runs of a sweep among them; the longest unused go first."""
_INCLUDED = re.compile(rb"#\w*[iI]nclude(\w*)\s*(\"[^\"\n]*\"|\S+)")
_NAMES = re.compile(rb"\$\{?(\w+)")
_CASE = "<<case>>"
"""Stands in what is kept for the case's folder."""


def dictionaries(case: Path) -> Iterator[Path]:
    """The files of a case that may be dictionaries, in a fixed order."""
    for part in ("constant", "system"):
        yield from sorted(path for path in (case / part).glob("*") if path.is_file())


def inputs(case: Path) -> Iterator[Path]:
    """The files of a case that decide its plan, in a fixed order."""
    yield from sorted(path for path in case.glob("All*") if path.is_file())
    for part in FOLDERS:
        yield from sorted(path for path in (case / part).rglob("*") if path.is_file())


def key(case: Path, files: Iterable[Path], program: str, *words: str) -> str | None:
    """Tells what `program`, started with `words`, reads in these files of a case from all else.

    None where that cannot be told: a file includes one that is none of them, or has a name that
    OpenFOAM replaces by what is elsewhere.
    """
    place, names = case.resolve(), set[str]()
    digest = hashlib.sha256(json.dumps([version("elutria"), *words]).encode())
    with suppress(OSError):
        digest.update(json.dumps(_program(program)).encode())
        for file in files:
            content = _content(file)
            names |= {found.decode() for found in _NAMES.findall(content)}
            name = file.relative_to(case)
            if not _includes_within(place, place / name, content):
                return None
            told = [name.as_posix(), hashlib.sha256(content).hexdigest()]
            digest.update(json.dumps(told).encode())
        if any(name.startswith("FOAM_") and name != "FOAM_CASE" for name in names):
            return None
        given = {name: os.environ[name] for name in sorted(names & set(os.environ))}
        digest.update(json.dumps(given).encode())
        return digest.hexdigest()
    return None


def _program(name: str) -> list[str]:
    """Tells a program, and the libraries that were built with it, from those of another build.
    Raises FileNotFoundError where it is not on PATH."""
    place = Path(shutil.which(name) or name).resolve(strict=True)
    stats = [
        (str(file), file.stat()) for file in (place, *sorted(place.parent.parent.glob("lib/*.so")))
    ]
    return [f"{name} {stat.st_mtime_ns} {stat.st_size}" for name, stat in stats]


def _content(file: Path) -> bytes:
    stat = file.stat()
    if stat.st_size > LARGEST_DICTIONARY:  # told apart by its date
        return f"{file.resolve()} {stat.st_mtime_ns} {stat.st_size}".encode()
    return file.read_bytes()


def _includes_within(case: Path, file: Path, content: bytes) -> bool:
    """Whether all that a file includes lies in the case's own constant or system."""
    for kind, written in _INCLUDED.findall(content):
        name = in_case(written.decode("utf-8", "replace").strip('";'), case)
        target = Path(os.path.normpath(file.parent / name))
        if kind in (b"Etc", b"Func") or set(name) & set("$<~"):
            return False
        if target.parent not in (case / "constant", case / "system"):
            return False
    return True


def read(name: str | None, case: Path) -> dict[str, Any] | None:
    """What was kept under a key, as of this case."""
    if name is None:
        return None
    file = _file(name)
    with suppress(OSError, ValueError, RecursionError):
        content = json.loads(file.read_text().replace(_CASE, _in_json(case)))
        os.utime(file)
        return content if isinstance(content, dict) else None
    return None


def keep(name: str | None, case: Path, content: dict[str, Any]) -> None:
    """Keep it, where it can be; a cache that cannot be written has none."""
    if name is None:
        return
    place, text = _in_json(case), json.dumps(content)
    if _CASE in text:
        return
    text = re.sub(rf"(?<![\w/.]){re.escape(place)}(?=[\"/ ])", _CASE, text)
    if place in text:
        return
    file = _file(name)
    temporary = file.with_suffix(f".{os.getpid()}")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        _make_room(file.parent)
        temporary.write_text(text)
        temporary.replace(file)
    except OSError:
        with suppress(OSError):
            temporary.unlink()


def _in_json(case: Path) -> str:
    return json.dumps(str(case.resolve()))[1:-1]


def _make_room(folder: Path) -> None:
    files = list(folder.iterdir())
    if len(files) >= _MOST:
        oldest = sorted(files, key=lambda file: file.stat().st_mtime)
        for file in oldest[: len(files) - _MOST * 9 // 10]:
            file.unlink(missing_ok=True)


def _file(name: str) -> Path:
    return cache_folder() / "cases" / f"{name}.json"
