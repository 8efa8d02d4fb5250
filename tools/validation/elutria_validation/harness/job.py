"""What the command line asks for: a job, and options of its own as a typed dataclass."""

from __future__ import annotations

import types
import typing
from collections.abc import Callable, Iterable
from dataclasses import MISSING, Field, dataclass, field, fields
from math import isfinite
from pathlib import Path
from typing import Any, TypeVar

from elutria.errors import InputError, one_line, suggestion

T = TypeVar("T")


@dataclass(frozen=True)
class Job:
    """`folder` takes the results, `repeats` is how often each timed thing is run, `quick` asks for
    a short version, `say` takes lines for the terminal."""

    folder: Path
    repeats: int = 5
    quick: bool = False
    say: Callable[[str], None] = print


@dataclass(frozen=True)
class NoOptions:
    """Nothing to choose."""


def option(default: Any, quick: Any = MISSING, least: float | None = None, unit: str = "") -> Any:
    """A field of an options dataclass: its default, that of a short run, its least value."""
    shorter = default if quick is MISSING else quick
    return field(default=default, metadata={"quick": shorter, "least": least, "unit": unit})


def parse_options(kind: type[T], pairs: Iterable[str], quick: bool) -> T:
    """The options `kind` from texts KEY=VALUE. Raises InputError, with what is allowed, for a key
    that is none of its fields or a value that is none of its type."""
    known = {one.name: one for one in fields(typing.cast(Any, kind))}
    types_of = typing.get_type_hints(kind)
    found = {name: one.metadata.get("quick", one.default) for name, one in known.items() if quick}
    for text in pairs:
        key, equals, value = text.partition("=")
        if not (key and equals):
            raise InputError(f"--option {one_line(text, 60)}: is not KEY=VALUE")
        if key not in known:
            allowed = ", ".join(map(describe, known.values())) or "none"
            raise InputError(
                f"--option {one_line(key, 40)}{suggestion(key, known)}; allowed: {allowed}"
            )
        found[key] = _value(known[key], types_of[key], value)
    return kind(**found)


def describe(one: Field[Any]) -> str:
    """An option as it is listed: name, default, unit."""
    default = "" if one.default is None else one.default
    unit = one.metadata.get("unit", "")
    return f"{one.name}={default}{f' {unit}' if unit else ''}"


def _value(one: Field[Any], kind: Any, text: str) -> Any:
    kinds = typing.get_args(kind) if isinstance(kind, types.UnionType) else (kind,)
    least = one.metadata.get("least")
    (wanted,) = (k for k in kinds if k is not type(None))
    if typing.get_origin(wanted) is typing.Literal:
        words = typing.get_args(wanted)
        if text in words:
            return text
        expected = " or ".join(map(str, words))
    elif wanted is Path:
        return Path(text)
    elif wanted is str:
        return text
    else:
        expected = f"a {'whole ' if wanted is int else ''}number"
        expected += "" if least is None else f" >= {least:g}"
        try:
            value = wanted(text)
            if isfinite(value) and (least is None or value >= least):
                return value
        except ValueError:
            pass
    raise InputError(f"--option {one.name}={one_line(text, 40)}; allowed: {expected}")
