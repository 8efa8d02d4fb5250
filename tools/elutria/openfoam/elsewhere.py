"""What a case's dictionaries name and that lies outside of their folders: files that they include,
those that an entry `file` names, and variables of the environment. A run depends on them as on the
case's own files."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

FOLDERS = ("0", "0.orig", "constant", "system")
"""Where a case has its dictionaries, fields and tables."""
LARGEST_DICTIONARY = 1_000_000
"""Bytes; larger files are fields or meshes, which name no others."""
_DEEPEST = 10
"""An include within so many others goes round in a circle."""
_NAMED = re.compile(
    r"""(?P<how>\#(?:s?include|includeIfPresent)|(?<![\w.])file)\s+
        (?: "(?P<quoted>[^"\n]+)" | (?P<bare>[^\s;{}()"]+) )
        | "(?:\\.|[^"\\\n])*" | //[^\n]* | /\*.*?\*/""",
    re.DOTALL | re.VERBOSE,
)
_VARIABLE = re.compile(r"\$\{?(\w+)")
_OF_OPENFOAM = ("FOAM_", "WM_")
"""How variables of an installation begin: another place of it is no other input."""


def named_elsewhere(case: Path) -> dict[str, Path]:
    """The files by the names that the dictionaries have for them; only those that are there."""
    found: dict[str, Path] = {}
    for file in dictionaries(case):
        _follow(case.resolve(), file.resolve(), _text(file), found, 0)
    return found


def named_environment(case: Path) -> dict[str, str]:
    """The environment's variables that the dictionaries may take by `$NAME`, with their values."""
    files = [*dictionaries(case), *named_elsewhere(case).values()]
    texts = [_text(file) for file in files if file.stat().st_size <= LARGEST_DICTIONARY]
    names = {name for text in texts for name in _VARIABLE.findall(text)}
    return {
        name: os.environ[name]
        for name in sorted(names & set(os.environ))
        if not name.startswith(_OF_OPENFOAM)
    }


def name_the_same(case: Path, copy: Path) -> None:
    """Have the dictionaries of a `copy` of a case, in another place, name the same files outside of
    it: their relative names become absolute ones."""
    place = case.resolve()
    for file in dictionaries(copy):
        own = place / file.relative_to(copy)

        def whole(match: re.Match[str], own: Path = own) -> str:
            target = _target(place, own, match)
            if target is None or target.is_relative_to(place):
                return match[0]
            return f'{match["how"]} "{target}"'

        text = _text(file)
        named = _NAMED.sub(whole, text)
        if named != text:
            file.write_text(named, "latin-1")


def dictionaries(case: Path) -> Iterator[Path]:
    """The files of a case that may name others, in a fixed order."""
    for folder in FOLDERS:
        for file in sorted((case / folder).glob("*")):
            if file.is_file() and file.stat().st_size <= LARGEST_DICTIONARY:
                yield file


def in_case(name: str, case: Path) -> str:
    """A file's name as a dictionary has it, with the case's folder where OpenFOAM puts it."""
    for own, folder in (("<case>", ""), ("$FOAM_CASE", ""), ("${FOAM_CASE}", ""),
                        ("<constant>", "constant"), ("<system>", "system")):  # fmt: skip
        if name.startswith(own):
            return f"{case / folder}{name.removeprefix(own)}"
    return name


def _text(file: Path) -> str:
    return file.read_text("latin-1")


def _follow(case: Path, file: Path, text: str, found: dict[str, Path], depth: int) -> None:
    for match in _NAMED.finditer(text):
        target = _target(case, file, match)
        if target is None or (within := _part(case, target)) in FOLDERS:
            continue
        name = match["quoted"] or match["bare"]
        if within is not None:
            name = target.relative_to(case).as_posix()
        if found.setdefault(name, target) != target:
            found[str(target)] = target
        if (
            match["how"] != "file"
            and depth < _DEEPEST
            and target.stat().st_size <= LARGEST_DICTIONARY
        ):
            _follow(case, target, _text(target), found, depth + 1)


def _part(case: Path, target: Path) -> str | None:
    """The first folder below the case's that a file lies in; None outside of the case."""
    return target.relative_to(case).parts[0] if target.is_relative_to(case) else None


def _target(case: Path, file: Path, match: re.Match[str]) -> Path | None:
    """The file that is named; None where there is none, or where its place cannot be told."""
    name = match["quoted"] or match["bare"]
    if name is None:
        return None
    name = os.path.expandvars(in_case(name, case))
    if name.startswith("~/"):
        name = str(Path.home() / name.removeprefix("~/"))
    if "$" in name or name.startswith(("~", "<")):
        return None
    within = case if match["how"] == "file" else file.parent
    target = Path(os.path.normpath(within / name))
    return target if target.is_file() else None
