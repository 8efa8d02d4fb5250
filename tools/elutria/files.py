"""Files, read with checks and written atomically: beside their place, then renamed."""

from __future__ import annotations

import csv
import errno
import io
import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from elutria.errors import ElutriaError, InputError, one_line

NOT_THE_PLACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EMFILE, errno.ENOMEM)


def cache_folder() -> Path:
    """$ELUTRIA_CACHE, or elutria in the user's cache."""
    if own := os.environ.get("ELUTRIA_CACHE"):
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "elutria"


@contextmanager
def writing_to(folder: Path) -> Iterator[None]:
    """Turn an operating system's refusal to write in `folder` into one line.

    Raises InputError where the place is at fault, ElutriaError for the rest (a full disk).
    """
    try:
        yield
    except OSError as error:
        place, reason = error.filename or folder, error.strerror or one_line(error)
        if error.errno in NOT_THE_PLACE:
            raise ElutriaError(f"{place}: writing failed ({reason})") from error
        raise InputError(
            f"{place}: cannot be written ({reason}); choose a folder you may write to with --to"
        ) from error


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """A temporary path in the folder of `path`, renamed to `path` when the block succeeds."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}{path.suffix}")
    try:
        with writing_to(path.parent):
            path.parent.mkdir(parents=True, exist_ok=True)
            yield temporary
            with temporary.open("rb") as written:
                os.fsync(written.fileno())
            temporary.replace(path)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` atomically."""
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, content: Any) -> None:
    """Write `content` as indented JSON; numbers that are not finite become null."""
    write_text(path, json.dumps(content, indent=2, ensure_ascii=False) + "\n")


def write_csv(path: Path, columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> None:
    """Write `rows` (a mapping per row with at least `columns`) with a header line.

    Numbers are written so that they read back to the same value; a missing one is ``nan``. A table
    that is there already keeps its time: what was made of it is still new.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns)
    for row in rows:
        table.writerow([_cell(row[name]) for name in columns])
    content = text.getvalue().encode()
    if not (path.is_file() and path.read_bytes() == content):
        with atomic_write(path) as temporary:
            temporary.write_bytes(content)


def _cell(value: Any) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)


WORDS = ("material", "product", "model", "law")
"""Columns that hold words."""


def read_csv(
    path: Path, columns: Sequence[str], words: Sequence[str] = WORDS
) -> list[dict[str, Any]]:
    """Rows of a csv file that `write_csv` wrote; every cell that is a number becomes one. Without
    `columns` it may be a user's, with rows of empty cells.

    Raises InputError when the file is missing, has other columns, ends within a row or has one of
    `columns` that is neither a number nor among the `words`.
    """
    text = read_text(path)
    numbered = _rows(path, text, with_empty=bool(columns))
    rows = [row for _, row in numbered]
    if not rows or [name for name in columns if name not in rows[0]]:
        raise InputError(f"{path}: first line must name the columns {','.join(columns)}")
    if not text.endswith("\n") or any(len(row) != len(rows[0]) for row in rows):
        raise InputError(f"{path}: ends within a row or has rows of different length")
    table = [dict(zip(rows[0], map(_number_or_text, row), strict=True)) for row in rows[1:]]
    for (number, _), entries in zip(numbered[1:], table, strict=True):
        for name in columns:
            if name not in words and not isinstance(entries[name], float):
                shown = one_line(entries[name], 40)
                raise InputError(f"{path}: {name}: '{shown}' in line {number}; allowed: a number")
    return table


def _number_or_text(cell: str) -> float | str:
    try:
        return float(cell)
    except ValueError:
        return cell


def read_text(path: Path, limit: int = 50_000_000) -> str:
    """Text of a regular file of at most `limit` bytes, without the byte order mark that
    spreadsheets put before it. Raises InputError naming the file."""
    with reading(path, limit):
        return path.read_text(encoding="utf-8-sig")


def read_rows(path: Path) -> list[tuple[int, list[str]]]:
    """Rows of a csv file and the lines that they stand in; those of empty cells are left out.
    Raises InputError where the first one has its columns parted by other than commas."""
    return _rows(path, read_text(path), with_empty=False)


def _rows(path: Path, text: str, with_empty: bool) -> list[tuple[int, list[str]]]:
    reader = csv.reader(text.splitlines())
    rows = [
        (reader.line_num, row) for row in reader if with_empty or any(cell.strip() for cell in row)
    ]
    if rows and len(rows[0][1]) == 1 and (other := {";", "\t"} & {*rows[0][1][0]}):
        raise InputError(
            f"{path}: columns are parted by {other.pop()!r}; allowed: commas, and points in numbers"
        )
    return rows


@contextmanager
def reading(path: Path, limit: int = 50_000_000) -> Iterator[None]:
    """Turn what keeps a regular file of at most `limit` bytes from being read into one line.

    Raises InputError naming the file.
    """
    try:
        if not path.exists():
            raise InputError(f"{path}: file not found")
        if not path.is_file():
            raise InputError(f"{path}: is not a regular file")
        if path.stat().st_size > limit:
            raise InputError(f"{path}: is larger than {limit / 1e6:g} MB")
        yield
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not a text file (byte {error.start})") from error
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be read ({one_line(error)})") from error


def read_json(path: Path) -> dict[str, Any]:
    """A JSON object from a file. Raises InputError naming the file."""
    try:
        content = json.loads(read_text(path))
    except (json.JSONDecodeError, RecursionError) as error:
        raise InputError(f"{path}: is not complete JSON ({one_line(error)})") from error
    if not isinstance(content, dict):
        raise InputError(f"{path}: must hold a JSON object, not {type(content).__name__}")
    return content
