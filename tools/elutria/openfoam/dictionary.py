"""OpenFOAM dictionaries, read without executing anything, edited without losing a comment.

A case's dictionaries are read by the solver, which is asked (asked.py). Where none is at hand, and
for files that it does not read, foamlib parses, and `#include` and `$name` are resolved here.
foamlib edits. Entries are checked as they are taken: type, range, spelling. `#calc`, `#codeStream`
and the like are never evaluated: an entry that needs one is refused when asked for.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from foamlib import FoamFile

from elutria.errors import InputError, one_line, suggestion
from elutria.files import read_text, writing_to
from elutria.openfoam.asked import ask
from elutria.openfoam.text import values_of, with_value

_MISSING = object()
_TWICE = re.compile(r"Duplicate .* entry for keyword: '?([^' ]+)'? ")
"""foamlib's warning."""
_INCLUDES = {"#include": True, "#sinclude": False, "#includeIfPresent": False}


class Dictionary:
    """One (sub)dictionary: entries taken from it are checked, those left over can be refused."""

    def __init__(
        self,
        entries: Mapping[str, Any],
        file: str,
        path: tuple[str, ...] = (),
        included: tuple[str, ...] = (),
        repeated: tuple[str, ...] = (),
        own: Iterable[str] | None = None,
    ):
        self.entries = dict(entries)
        self.own = set(self.entries if own is None else own)
        """Names of the entries that stand in the file itself."""
        self.file = file
        self.path = path
        self.included = included
        self.repeated = repeated
        self._taken: set[str] = set()

    def where(self, name: str = "") -> str:
        """`constant/feed: materials/quartz/density`, as messages begin."""
        entry = "/".join((*self.path, name) if name else self.path)
        return f"{self.file}: {entry}" if entry else self.file

    def refuse(self, name: str, allowed: str) -> InputError:
        """The error that `name` has a value which is not allowed."""
        value = one_line(self.entries.get(name, "is missing"), 60)
        return InputError(f"{self.where(name)}: {value}; allowed: {allowed}{self._also()}")

    def _also(self) -> str:
        """Where else a value may come from."""
        return f" (included: {', '.join(self.included)})" if self.included else ""

    def __contains__(self, name: str) -> bool:
        return name in self.entries

    def raw(self, name: str, default: Any = _MISSING, *, allowed: str = "an entry") -> Any:
        """The entry as foamlib parsed it. Raises InputError when absent or not evaluated."""
        self._taken.add(name)
        if name not in self.entries:
            if default is not _MISSING:
                return default
            others = [key for key in self.entries if key not in self._taken]
            close = [key for key in others if suggestion(key, [name])]
            hint = f" (found '{close[0]}', did you mean '{name}'?)" if close else ""
            raise InputError(f"{self.where(name)}: is missing{hint}; allowed: {allowed}")
        value = self.entries[name]
        for token in value if isinstance(value, (list, tuple)) else [value]:
            if isinstance(token, str) and token.startswith("#"):
                raise InputError(
                    f"{self.where(name)}: {one_line(token, 40)} is not evaluated by elutria; "
                    f"allowed: {allowed}, written out"
                )
            if isinstance(token, str) and token.startswith("$"):
                raise InputError(
                    f"{self.where(name)}: {one_line(token, 40)} is defined nowhere; "
                    f"allowed: {allowed}, or the name of an entry above it{self._also()}"
                )
        return value

    def number(
        self,
        name: str,
        default: Any = _MISSING,
        *,
        above: float = -math.inf,
        at_least: float = -math.inf,
        at_most: float = math.inf,
        unit: str = "",
    ) -> float:
        """A finite number within its bounds (``above`` is exclusive)."""
        allowed = _range_in_words(above, at_least, at_most, unit)
        value = self.raw(name, default, allowed=allowed)
        if value is default:
            return value  # type: ignore[no-any-return]
        value = getattr(value, "value", value)
        good = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not (good and math.isfinite(value) and above < value and at_least <= value <= at_most):
            raise self.refuse(name, allowed)
        return float(value)

    def word(self, name: str, choices: Iterable[str] = (), default: Any = _MISSING) -> str:
        """A single word, one of `choices` where there are any."""
        options = list(choices)
        allowed = " | ".join(options) if options else "a word"
        value = self.raw(name, default, allowed=allowed)
        if not isinstance(value, str) or (options and value not in options and value != default):
            hint = suggestion(str(value), options)
            raise self.refuse(name, allowed + hint)
        return value.strip('"')

    def numbers(self, name: str, length: int | None = None) -> list[float]:
        """A list of finite numbers, of the given length."""
        allowed = f"a list of {'' if length is None else f'{length} '}numbers: (a b ...)"
        value = self.raw(name, allowed=allowed)
        items = list(value) if isinstance(value, (list, tuple)) or hasattr(value, "tolist") else []
        good = bool(items) and (length is None or len(items) == length)
        if not good or not all(_is_number(item) for item in items):
            raise self.refuse(name, allowed)
        return [float(item) for item in items]

    def words(self, name: str) -> list[str]:
        """A list of words: patches of a product, for example."""
        value = self.raw(name, allowed="a list of words: (a b)")
        items = [value] if isinstance(value, str) else value
        if not isinstance(items, list) or not items or not all(isinstance(i, str) for i in items):
            raise self.refuse(name, "a list of words: (a b)")
        return [item.strip('"') for item in items]

    def sub(self, name: str, default: Any = _MISSING) -> Dictionary:
        """A subdictionary."""
        value = self.raw(name, default, allowed="a dictionary { ... }")
        if not isinstance(value, Mapping):
            raise self.refuse(name, "a dictionary { ... }")
        return Dictionary(value, self.file, (*self.path, name), self.included)

    def refuse_unknown(self, known: Iterable[str]) -> None:
        """Raise InputError for the first entry of the file itself that is none of `known`: a
        misspelling is found. What it includes belongs to others too."""
        names = list(known)
        for name in self.entries:
            if name in self.own and name not in names and not str(name).startswith("#"):
                raise InputError(
                    f"{self.where(str(name))}: unknown entry{suggestion(str(name), names)}; "
                    f"allowed: {', '.join(names)}"
                )

    def refuse_repeated(self) -> None:
        """Raise InputError where the file has an entry twice, of which OpenFOAM takes the last."""
        for name in self.repeated:
            raise InputError(f"{self.file}: {name}: is there twice; allowed: once")


def in_words(value: Any) -> str:
    """A parsed value as a dictionary has it: `5`, `word`, `(0 0 1)`."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, float)):
        return f"{value:.12g}"
    if isinstance(value, (list, tuple)) or hasattr(value, "tolist"):
        return f"({' '.join(in_words(item) for item in value)})"
    return one_line(value)


def _is_number(value: Any) -> bool:
    good = isinstance(value, (int, float)) and not isinstance(value, bool)
    return good and math.isfinite(value)


def _range_in_words(above: float, at_least: float, at_most: float, unit: str) -> str:
    words = "a finite number"
    limits = []
    if above > -math.inf:
        limits.append(f"> {above:g}")
    if at_least > -math.inf:
        limits.append(f">= {at_least:g}")
    if at_most < math.inf:
        limits.append(f"<= {at_most:g}")
    if limits:
        words += " " + " and ".join(limits)
    return f"{words} ({unit})" if unit else words


def read_dictionary(
    path: Path, case: Path | None = None, *, with_included: bool = False
) -> Dictionary:
    """Read a dictionary file with its includes and macros resolved; nothing is executed.

    The solver reads a case's dictionaries where one is at hand: see asked.py. Entries that an
    `#include` brought are there for macros only, unless `with_included`. Raises InputError naming
    the file.
    """
    shown = _shown(path, case)
    if case is not None and path.is_relative_to(case):
        try:
            asked = ask(case, path.relative_to(case).as_posix())
        except InputError as refused:
            named = _undefined(path, case)
            if named is None:
                raise
            raise named from refused
        if asked is not None:
            return Dictionary(
                {k: v for k, v in asked.entries.items() if with_included or k in asked.own},
                shown,
                included=tuple(asked.included),
                repeated=tuple(asked.repeated),
                own=asked.own,
            )
    return _from_text(path, case, with_included=with_included)


def _from_text(path: Path, case: Path | None, *, with_included: bool) -> Dictionary:
    shown = _shown(path, case)
    raw, repeated = _parse(path, shown)
    resolved: dict[str, Any] = {}
    included = _load(raw, path, case, resolved, depth=0)
    entries = {k: v for k, v in resolved.items() if with_included or k in raw}
    own = [key for key in raw if isinstance(key, str)]
    return Dictionary(entries, shown, included=tuple(included), repeated=repeated, own=own)


def _undefined(path: Path, case: Path) -> InputError | None:
    """The entry with a macro that stands for nothing, of which the solver tells only the macro."""
    try:
        _take_all(_from_text(path, case, with_included=True))
    except InputError as error:
        return error if "is defined nowhere" in str(error) else None
    return None


def _take_all(entries: Dictionary) -> None:
    for name, value in entries.entries.items():
        _take_all(entries.sub(name)) if isinstance(value, Mapping) else entries.raw(name)


def read_list(path: Path, case: Path | None = None) -> list[Any]:
    """A file that holds one list, such as constant/polyMesh/boundary."""
    value = _parse(path, _shown(path, case))[0].get(None)
    if not isinstance(value, list):
        raise InputError(f"{_shown(path, case)}: must hold a list ( ... )")
    return value


def _shown(path: Path, case: Path | None) -> str:
    if case is not None and path.is_relative_to(case):
        return str(Path(case.name) / path.relative_to(case)) if case.name else str(path)
    return str(path)


def _parse(path: Path, shown: str) -> tuple[Mapping[Any, Any], tuple[str, ...]]:
    """The entries of a file as foamlib gives them, and those of which it has two; those that
    include are lists of names."""
    try:
        return _parse_text(read_text(path, limit=5_000_000))
    except InputError:
        raise
    except RecursionError as error:
        raise InputError(f"{shown}: brackets are nested too deeply") from error
    except Exception as error:  # whatever a parser makes of rubbish, the user is told the file
        raise InputError(f"{shown}: is not an OpenFOAM dictionary: {one_line(error)}") from error


@lru_cache(maxsize=64)
def _parse_text(text: str) -> tuple[Mapping[Any, Any], tuple[str, ...]]:
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        parsed: Any = FoamFile.loads(re.sub(r"\$\{([\w.:]+)\}", r"$\1", text))
    twice = [found[1] for warning in said if (found := _TWICE.match(str(warning.message)))]
    if not isinstance(parsed, Mapping):
        return {None: parsed}, ()
    every = getattr(parsed, "getall", lambda key: [parsed[key]])
    entries = {key: every(key) if key in _INCLUDES else parsed[key] for key in parsed}
    return entries, tuple(twice)


def _load(
    raw: Mapping[Any, Any], path: Path, case: Path | None, scope: dict[str, Any], depth: int
) -> list[str]:
    """Put the entries of included files and of `raw` into `scope`, in order, macros resolved.

    As in OpenFOAM a macro stands for what was read before it: `seed $seed;` takes an included one.
    Returns the names of the included files.
    """
    if depth > 10:
        raise InputError(f"{_shown(path, case)}: #include goes round in a circle")
    included: list[str] = []
    for key, value in raw.items():
        if key in _INCLUDES:
            for word in value:
                name = str(word).strip('"')
                target = path.parent / name.replace("<case>", str(case or "."))
                if target.is_file():
                    nested, _ = _parse(target, _shown(target, case))
                    included += [name, *_load(nested, target, case, scope, depth + 1)]
                elif _INCLUDES[key]:
                    shown = one_line(name, 60)
                    raise InputError(f"{_shown(path, case)}: {key} {shown}: file not found")
        elif isinstance(key, str) and key.startswith("$"):
            merged = _look_up(key, [scope])
            scope.update(merged if isinstance(merged, Mapping) else {})
        elif isinstance(key, str) and not key.startswith("#"):
            scope[key] = _resolve(value, [scope])
    return included


def _resolve(value: Any, scopes: list[Mapping[str, Any]]) -> Any:
    """`value` with each `$name` replaced by what it stands for, as seen from `scopes`."""
    if isinstance(value, Mapping):
        resolved: dict[str, Any] = {}
        inner = [*scopes, resolved]
        for key, item in value.items():
            if isinstance(key, str) and key.startswith("$"):
                merged = _look_up(key, inner)
                resolved.update(merged if isinstance(merged, Mapping) else {})
            else:
                resolved[key] = _resolve(item, inner)
        return resolved
    if type(value) in (list, tuple):  # not the named tuples of dimensioned values
        return type(value)(_resolve(item, scopes) for item in value)
    if isinstance(value, str) and value.startswith("$"):
        return _look_up(value, scopes)
    return value


def _look_up(macro: str, scopes: list[Mapping[str, Any]]) -> Any:
    """The entry that `$name`, `$:a.b` or `$..name` stands for; `macro` itself when there is none"""
    name = macro[1:].strip("{}")
    if name.startswith(":"):
        found: Any = scopes[0]
        for part in name[1:].split("."):
            if not isinstance(found, Mapping) or part not in found:
                return macro
            found = found[part]
        return found
    ups = len(name) - len(name.lstrip("."))
    visible = scopes[: len(scopes) - ups + 1] if ups > 1 else scopes
    for scope in reversed(visible):
        if name.lstrip(".") in scope:
            return scope[name.lstrip(".")]
    return macro


def set_entry(path: Path, entry: str, text: str, case: Path | None = None) -> None:
    """Give an existing entry (`a/b/c` for nested ones) a new value; comments stay.

    Raises InputError when the entry does not exist or the value is not one OpenFOAM value.
    """
    shown = _shown(path, case)
    keys = entry.split("/")
    try:
        current: Any = _parse(path, shown)[0]
    except InputError as unread:  # what foamlib does not read, such as #ifeq
        _one_value(shown, entry, text)
        _set_in_text(path, keys, text, unread)
        return
    for depth, key in enumerate(keys):
        if not isinstance(current, Mapping) or key not in current:
            names = [str(k) for k in current] if isinstance(current, Mapping) else []
            raise InputError(
                f"{shown}: {'/'.join(keys[: depth + 1])}: no such entry"
                f"{suggestion(key, names)}; allowed: {', '.join(names) or 'nothing below a value'}"
            )
        current = current[key]
    value = _one_value(shown, entry, text)
    # of an entry that is there twice the last is set, and read
    silent = warnings.catch_warnings(action="ignore")
    with writing_to(path.parent), silent, FoamFile(path) as file:
        file[(keys[0], *keys[1:])] = value


def _set_in_text(path: Path, keys: list[str], value: str, unread: InputError) -> None:
    """Raises `unread` where the text has no such entry either."""
    text = read_text(path, limit=5_000_000)
    if not values_of(text, keys):
        raise unread
    with writing_to(path.parent):
        path.write_text(with_value(text, keys, value), encoding="utf-8")


def _one_value(shown: str, entry: str, text: str) -> Any:
    """What foamlib makes of a value. Raises InputError unless it is one OpenFOAM value."""
    try:
        parsed: Any = FoamFile.loads(f"value {text};")
        good = isinstance(parsed, Mapping) and list(parsed) == ["value"]
        value: Any = parsed["value"] if good else None
    except Exception:
        value = None
    if value is None or isinstance(value, Mapping) or any(c in text for c in ";{}#$\n"):
        raise InputError(
            f"{shown}: {entry}: '{one_line(text, 60)}'; allowed: one value, "
            "such as 5, word or (0 0 1)"
        )
    return value
