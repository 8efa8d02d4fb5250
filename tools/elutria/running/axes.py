"""What a sweep varies: gas velocity and any entry of the case, as a grid or as a list of points."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elutria import tables
from elutria.case.case import SEED, VELOCITY, Case, Setting
from elutria.errors import InputError, one_line
from elutria.files import read_rows

_MOST = 1000


@dataclass(frozen=True)
class Point:
    """Settings of one row of the tables: gas velocity (m/s), and other entries by FILE:ENTRY.

    `others` are in the order of their names; an entry that has the case's own value is left out, so
    that the same run has the same point however it was asked for.
    """

    velocity: float
    others: tuple[tuple[str, str], ...] = ()

    @property
    def title(self) -> str:
        """`5 m/s`, `5 m/s, loading 0.2`."""
        return ", ".join(
            [
                f"{self.velocity:g} m/s",
                *(f"{tables.short(name)} {value}" for name, value in self.others),
            ]
        )

    @property
    def folder(self) -> str:
        """`U5`, `U5_loading=0.2`: the name of the folder of its run."""
        parts = [f"U{self.velocity:.12g}"]
        parts += [f"{_in_names(name)}={_in_names(value)}" for name, value in self.others]
        return "_".join(parts)

    def settings(self) -> list[str]:
        """As `--set` takes them; the velocity is given apart from them."""
        return [f"{name}={value}" for name, value in self.others]


def _in_names(text: str) -> str:
    """`text` as part of a folder's name, also for a shell and for OpenFOAM."""
    text = text.removeprefix("system/simulationParameters:")
    return "-".join(part for part in re.split(r"[^A-Za-z0-9.+-]+", text) if part)


def parse_velocities(text: str) -> list[float]:
    """`A:B:N` (N values from A to B) or a comma-separated list, m/s; rising, without repeats."""
    allowed = "A:B:N such as 3:10:8, or a list such as 3,4.5,6 (m/s, > 0)"
    try:
        values = _values(text)
    except ValueError:
        raise InputError(f"--velocity '{one_line(text, 60)}'; allowed: {allowed}") from None
    for value in values:
        if not (math.isfinite(value) and 0 < value <= 1000):
            raise InputError(f"--velocity '{one_line(text, 60)}': {value:g}; allowed: {allowed}")
    return sorted({float(f"{value:.12g}") for value in values})


def _values(text: str) -> list[float]:
    if ":" not in text:
        return [float(part) for part in text.split(",")]
    first, last, count = text.split(":")
    if not 1 <= int(count) <= _MOST:
        raise ValueError
    values: list[float] = np.linspace(float(first), float(last), int(count)).tolist()
    return values


def parse_axis(case: Case, text: str, option: str = "--vary") -> tuple[str, list[str]]:
    """FILE:ENTRY and its values, from `FILE:ENTRY=A:B:N` or `FILE:ENTRY=V1,V2,...`.

    Raises InputError where the case has no such entry, or a value is no number where its own is.
    """
    setting = _split(text, option)
    name = f"{setting.file}:{setting.entry}"
    own = own_value(case, name, option)
    allowed = "A:B:N such as 0.1:0.5:3, or a list such as 0.1,0.2,0.5"
    shown = f"{option} '{one_line(text, 80)}'"
    if not _is_number(own):
        if ":" in setting.value:
            raise InputError(f"{shown}: {name} is '{own}', no number; allowed: a list of words")
        return name, list(dict.fromkeys(part.strip() for part in setting.value.split(",")))
    try:
        values = _values(setting.value)
    except ValueError:
        raise InputError(f"{shown}: '{setting.value}'; allowed: {allowed}") from None
    if not all(math.isfinite(value) for value in values):
        raise InputError(f"{shown}: a value is not finite; allowed: {allowed}")
    return name, list(dict.fromkeys(f"{value:.12g}" for value in values))


def _split(text: str, option: str) -> Setting:
    file, colon, rest = text.partition(":")
    entry, equals, value = rest.partition("=")
    if not (colon and equals and file.strip() and entry.strip() and value.strip()):
        raise InputError(
            f"{option} '{one_line(text, 60)}'; allowed: FILE:ENTRY=A:B:N or FILE:ENTRY=V1,V2, such "
            "as system/simulationParameters:loading=0.05,0.2,1"
        )
    return Setting(file.strip(), entry.strip(), value.strip())


def own_value(case: Case, name: str, option: str = "--vary") -> str:
    """The case's own value of FILE:ENTRY. Raises InputError where there is no such entry."""
    file, _, entry = name.partition(":")
    case.refuse_other_files([file], option)
    return case.value(file, entry)


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def same_value(one: str, other: str) -> bool:
    """Whether two values of an entry are the same: numbers by what they are, words by letters."""
    if _is_number(one) and _is_number(other):
        return math.isclose(float(one), float(other), rel_tol=1e-11)
    return one.split() == other.split()


def number_or_word(text: str) -> float | str:
    """A value of an entry as a cell of a table."""
    try:
        return float(text)
    except ValueError:
        return text


def grid(case: Case, velocity: str | None, axes: Iterable[str]) -> list[Point]:
    """All combinations of gas velocities (`A:B:N|LIST`; None: the case's own) and axes."""
    values: dict[str, list[str]] = {}
    for text in axes:
        name, found = parse_axis(case, text)
        if name in values or (name == VELOCITY and velocity is not None):
            raise InputError(f"--vary {name}: is varied twice; allowed: once")
        values[name] = found
    velocities = [case.velocity()] if velocity is None else parse_velocities(velocity)
    if VELOCITY in values:
        velocities = parse_velocities(",".join(values.pop(VELOCITY)))
    total = math.prod([len(velocities), *map(len, values.values())])
    if total > _MOST:
        raise InputError(f"--vary: {total} runs; allowed: at most {_MOST}")
    return _points(
        case,
        [
            (u, dict(zip(values, chosen, strict=True)))
            for chosen in itertools.product(*values.values())
            for u in velocities
        ],
    )


def read_points(case: Case, file: Path) -> list[Point]:
    """A point for each row of a csv file, with columns gas_velocity_m_s or FILE:ENTRY."""
    rows = read_rows(file)
    if len(rows) < 2:
        raise InputError(f"{file}: holds no points; allowed: a line of names, then a row per run")
    names = [name.strip() for name in rows[0][1]]
    if {tables.VELOCITY, VELOCITY} <= {*names}:
        raise InputError(f"{file}: columns {tables.VELOCITY} and {VELOCITY}; allowed: one of both")
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{file}: column '{name}' is there twice")
        if name != tables.VELOCITY:
            if ":" not in name:
                raise InputError(
                    f"{file}: column '{one_line(name, 40)}'; allowed: {tables.VELOCITY}, "
                    "FILE:ENTRY such as system/simulationParameters:loading"
                )
            own_value(case, name, f"{file}: column")
    found = []
    for number, row in rows[1:]:
        if len(row) != len(names):
            raise InputError(f"{file}: line {number} has {len(row)} cells; allowed: {len(names)}")
        entries = {name: cell.strip() for name, cell in zip(names, row, strict=True)}
        for name, cell in entries.items():
            number_due = name == tables.VELOCITY or _is_number(own_value(case, name))
            if not cell or (number_due and not _is_number(cell)):
                raise InputError(f"{file}: {name}: '{cell}' in line {number}; allowed: a number")
        text = entries.pop(tables.VELOCITY, entries.pop(VELOCITY, None))
        velocity = case.velocity() if text is None else parse_velocities(text)[0]
        found.append((velocity, entries))
    return _points(case, found)


def _points(case: Case, found: Sequence[tuple[float, Mapping[str, str]]]) -> list[Point]:
    """Points as they are told apart, without repeats."""
    own = {name: own_value(case, name) for _, entries in found for name in entries}
    points = [
        Point(
            velocity,
            tuple(
                (name, value)
                for name, value in sorted(entries.items())
                if not same_value(value, own[name])
            ),
        )
        for velocity, entries in found
    ]
    return list(dict.fromkeys(points))


def seed_of(case: Case, settings: Iterable[Setting]) -> int:
    """The seed of the feed that a run with these settings has."""
    given = [s.value for s in settings if f"{s.file}:{s.entry}" == SEED]
    return int(float(given[-1] if given else case.value(*SEED.split(":"))))
