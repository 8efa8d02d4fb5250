"""A mesh on disk, constant/polyMesh: complete and consistent. Nothing is repaired.

OpenFOAM follows the numbers of these files without looking; a wrong one ends in a memory fault.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria.errors import InputError, one_line
from elutria.openfoam.dictionary import Dictionary, read_list

FILES = ("points", "faces", "owner", "neighbour", "boundary")
LIMIT = 2_000_000_000
"""Bytes of a file that is looked into."""


@dataclass(frozen=True)
class _List:
    """A file's declared length and, where it is ASCII, its numbers and its count of brackets."""

    shown: str
    length: int
    values: NDArray[Any] | None
    brackets: int

    def refuse(self, found: object, allowed: str) -> InputError:
        return InputError(f"{self.shown}: {one_line(found, 60)}; allowed: {allowed}")


def check_mesh(folder: Path, shown: str) -> None:
    """Raise InputError naming the file of constant/polyMesh, called `shown`, that is not sound."""
    if any((folder / f"{name}.gz").is_file() for name in FILES):
        return  # compressed: left to OpenFOAM
    points = _read(folder / "points", shown, float)
    faces = _read(folder / "faces", shown, int)
    owner = _read(folder / "owner", shown, int)
    neighbour = _read(folder / "neighbour", shown, int)
    if points.values is not None and (points.brackets, points.values.size) != (
        points.length, 3 * points.length
    ):  # fmt: skip
        raise points.refuse(f"{points.brackets} points", f"the {points.length} that it announces")
    if points.values is not None and not np.all(np.isfinite(points.values)):
        raise points.refuse("a coordinate is not finite", "finite numbers (m)")
    if faces.values is not None:
        if faces.brackets != faces.length:
            raise faces.refuse(f"{faces.brackets} faces", f"the {faces.length} that it announces")
        _within(faces, points.length, "points")
        if owner.length != faces.length:
            raise owner.refuse(f"{owner.length} owners", f"{faces.length}, one for each face")
    if neighbour.length > owner.length:
        raise neighbour.refuse(f"{neighbour.length} cells", f"at most {owner.length}, the faces")
    for cells in (owner, neighbour):
        if cells.values is not None and cells.values.size != cells.length:
            raise cells.refuse(f"{cells.values.size} cells", f"the {cells.length} announced")
    if owner.values is not None and neighbour.values is not None:
        _check_cells(owner, neighbour)
    _check_boundary(folder / "boundary", shown, neighbour.length, owner.length)


def _check_cells(owner: _List, neighbour: _List) -> None:
    assert owner.values is not None
    assert neighbour.values is not None
    for cells in (owner, neighbour):
        # a cell has four faces at least
        _within(cells, (owner.length + neighbour.length) // 4, "cells")
    faces_of = np.bincount(np.concatenate([owner.values, neighbour.values]))
    if faces_of.size and faces_of.min() < 4:
        cell = int(faces_of.argmin())
        raise owner.refuse(f"cell {cell} has {faces_of[cell]} faces", "4 or more of each cell")


def _within(numbers: _List, end: int, what: str) -> None:
    assert numbers.values is not None
    wrong = (numbers.values < 0) | (numbers.values >= end)
    if np.any(wrong):
        raise numbers.refuse(numbers.values[wrong][0], f"0 to {end - 1}, the {what}")


def _check_boundary(path: Path, shown: str, first: int, last: int) -> None:
    start = first
    for entry in read_list(path):
        if not isinstance(entry, tuple) or len(entry) != 2 or not isinstance(entry[1], dict):
            raise InputError(f"{shown}/boundary: {one_line(entry, 60)}; allowed: NAME {{ ... }}")
        patch = Dictionary(entry[1], f"{shown}/boundary", (str(entry[0]),))
        patch.word("type")
        count = patch.number("nFaces", at_least=0, at_most=last - start, unit="faces that are left")
        patch.number("startFace", at_least=start, at_most=start, unit="after the patch before it")
        start += int(count)
    if start != last:
        raise InputError(
            f"{shown}/boundary: the patches end at face {start}; allowed: {last}, all faces"
        )


def _read(path: Path, shown: str, kind: type) -> _List:
    name = f"{shown}/{path.name}"
    if not path.is_file():
        what = "is not a regular file" if path.exists() else "file not found"
        raise InputError(f"{name}: {what}; allowed: a mesh with {', '.join(FILES)}")
    if path.stat().st_size > LIMIT:
        raise InputError(f"{name}: is larger than {LIMIT / 1e6:g} MB")
    content = path.read_bytes()
    head = re.search(rb"FoamFile\s*\{[^}]*\}", content)
    begin = re.compile(rb"(?:^|[\s/])(\d{1,12})\s*\(").search(content, head.end() if head else 0)
    if head is None or begin is None:
        raise InputError(f"{name}: is not a mesh file; allowed: FoamFile {{...}} and a list N(...)")
    length, body = int(begin[1]), content[begin.end() :]
    if len(body) < length or b")" not in body:
        raise InputError(f"{name}: ends within its list; allowed: {length} entries")
    if re.search(rb"format\s+binary", head[0]):
        return _List(name, length, None, 0)
    text, closing, _ = body.rpartition(b")")
    try:
        flat = text.replace(b"(", b" ").replace(b")", b" ")
        values: NDArray[Any] = np.array(flat.split(), dtype=kind)
    except (ValueError, OverflowError) as error:
        raise InputError(f"{name}: {one_line(error, 80)}; allowed: numbers") from error
    if len(body) - len(text) - len(closing) > 2000:
        raise InputError(f"{name}: its list has no end; allowed: {length} entries and ')'")
    return _List(name, length, values, text.count(b"("))
