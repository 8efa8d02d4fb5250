"""A measured partition curve from a csv file: sizes, shares to coarse, and how well they are known.

A table gives the size of each row or the limits of its class, and either the share to coarse or the
masses of both products. What it says of its setting or material by columns of the result tables
selects the results that it is compared with.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria.errors import InputError, one_line, suggestion
from elutria.files import read_csv

Array = NDArray[np.float64]
Row = dict[str, Any]

LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
MASSES = {"kg": 1.0, "g": 1e-3}
SHARES = {"": 1.0, "_percent": 0.01}
NORMAL = 1.959964
"""Standard deviations in an uncertainty, which is half of a 95 % interval."""
FEWEST, MOST = 2, 1000
KNOWN = (
    "diameter_m", "diameter_low_m", "diameter_high_m", "partition", "uncertainty", "fines_kg",
    "coarse_kg", "fines_uncertainty_kg", "coarse_uncertainty_kg", "feed", "material",
)  # fmt: skip
"""Columns by their names in SI units."""


@dataclass(frozen=True)
class Measured:
    """Rows in order of size. `low` and `high` limit a class (m), or are both the row's size;
    `share` goes to coarse; `deviation` is its standard deviation, None where it is not known;
    `mass` is what both products or the feed have in the class (any unit), None likewise;
    `chosen` holds what the file says of its setting and material."""

    low: Array
    high: Array
    share: Array
    deviation: Array | None
    mass: Array | None
    chosen: dict[str, Any]

    @property
    def diameter(self) -> Array:
        """The size of each row, m; of a class the geometric mean of its limits."""
        return np.asarray(np.sqrt(self.low * self.high))

    @property
    def of_classes(self) -> bool:
        """Whether any row is a class."""
        return bool(np.any(self.high > self.low))


def read_measured(path: Path, selectors: list[str]) -> Measured:
    """The table of a measurement. `selectors` are the results' columns of settings.

    Raises InputError with the file, the column, the value and what is allowed.
    """
    table = _Table(path, read_csv(path, (), words=()), selectors)
    low, high = table.limits()
    share, deviation, mass = table.products() if table.has("fines", MASSES) else table.partition()
    order = np.argsort(low, kind="stable")
    low, high = low[order], high[order]
    if np.any(low[1:] < high[:-1] * (1 - 1e-9)) or np.any(np.diff(low) <= 0):
        raise InputError(f"{path}: sizes overlap or are there twice; allowed: each size once")
    return Measured(
        low, high, share[order], None if deviation is None else deviation[order],
        None if mass is None else mass[order], table.chosen(),
    )  # fmt: skip


class _Table:
    """The rows of a measurement's file, asked for by quantity."""

    def __init__(self, path: Path, rows: list[Row], selectors: list[str]):
        self.path = path
        self.rows = rows
        self.selectors = [*selectors, "material"]
        if not FEWEST <= len(rows) <= MOST:
            raise InputError(f"{path}: holds {len(rows)} rows; allowed: {FEWEST} to {MOST}")
        known = {
            *(f"diameter{end}_{unit}" for end in ("", "_low", "_high") for unit in LENGTHS),
            *(f"{name}_{unit}" for name in ("fines", "coarse", "fines_uncertainty",
                                             "coarse_uncertainty", "feed") for unit in MASSES),
            *(f"{name}{unit}" for name in ("partition", "uncertainty", "feed") for unit in SHARES),
            *self.selectors,
        }  # fmt: skip
        for name in rows[0]:
            if name not in known:
                raise InputError(
                    f"{path}: column '{one_line(name, 40)}'{suggestion(name, known)}; allowed: "
                    f"{', '.join(dict.fromkeys([*KNOWN, *selectors]))}, lengths also in mm or um, "
                    "masses in g, shares as _percent"
                )

    def has(self, name: str, units: dict[str, float]) -> bool:
        return self._column(name, units) is not None

    def limits(self) -> tuple[Array, Array]:
        """Limits of the rows' classes, m; twice the size where there are none."""
        ends = [self._column(f"diameter_{end}", LENGTHS) for end in ("low", "high")]
        if None not in ends:
            low, high = (self._numbers(end, least=0.0, above=True) for end in ends if end)
            if np.any(low >= high):
                k = int(np.flatnonzero(low >= high)[0])
                raise InputError(
                    f"{self.path}: diameter_low in line {k + 2} is not below diameter_high"
                )
            return low, high
        size = self._column("diameter", LENGTHS)
        if size is None:
            raise InputError(
                f"{self.path}: names no size; allowed: a column diameter_m, diameter_mm or "
                "diameter_um, or both limits diameter_low_um and diameter_high_um"
            )
        diameter = self._numbers(size, least=0.0, above=True)
        return diameter, diameter

    def partition(self) -> tuple[Array, Array | None, Array | None]:
        """Share to coarse, its standard deviation and the feed's mass in each row."""
        share = self._column("partition", SHARES)
        if share is None:
            raise InputError(
                f"{self.path}: has no result; allowed: a column partition (share to coarse, 0 to "
                "1) or partition_percent, or the masses fines_kg and coarse_kg"
            )
        feed = self._column("feed", MASSES) or self._column("feed", SHARES)
        mass = None if feed is None else self._numbers(feed, least=0.0)
        return self._numbers(share, least=0.0, most=1.0), self._uncertainty(), mass

    def products(self) -> tuple[Array, Array | None, Array]:
        """The same from the masses of both products in each row."""
        names = [self._column(name, MASSES) for name in ("fines", "coarse")]
        if names[1] is None:
            raise InputError(f"{self.path}: coarse_kg: is missing; allowed: it beside fines_kg")
        fines, coarse = (self._numbers(name, least=0.0) for name in names if name)
        total = fines + coarse
        if np.any(total <= 0):
            k = int(np.flatnonzero(total <= 0)[0])
            raise InputError(f"{self.path}: fines and coarse in line {k + 2} are both 0; "
                             "allowed: a mass in one of them")  # fmt: skip
        deviation = self._uncertainty()
        unsure = [self._column(f"{name}_uncertainty", MASSES) for name in ("fines", "coarse")]
        if deviation is None and None not in unsure:
            of_fines, of_coarse = (self._numbers(name, least=0.0) for name in unsure if name)
            spread = np.hypot(coarse * of_fines, fines * of_coarse) / total**2 / NORMAL
            if np.any(spread <= 0):
                k = int(np.flatnonzero(spread <= 0)[0])
                raise InputError(
                    f"{self.path}: the uncertainty of the share in line {k + 2} is 0, where one "
                    "product has no mass and the other's uncertainty is all there is; allowed: a "
                    "column uncertainty, or more than 0 in both"
                )
            deviation = spread
        return coarse / total, deviation, total

    def chosen(self) -> dict[str, Any]:
        """What the file says of its setting and material: one value a column."""
        found = {}
        for name in self.selectors:
            values = dict.fromkeys(row[name] for row in self.rows if name in row)
            if len(values) > 1:
                raise InputError(
                    f"{self.path}: {name}: has {len(values)} values; allowed: one in a file"
                )
            if values:
                found[name] = next(iter(values))
        return found

    def _uncertainty(self) -> Array | None:
        """Standard deviation of the share, from half of its 95 % interval."""
        name = self._column("uncertainty", SHARES)
        if name is None:
            return None
        return self._numbers(name, least=0.0, above=True, most=1.0) / NORMAL

    def _column(self, name: str, units: dict[str, float]) -> tuple[str, float] | None:
        """A quantity's column and its unit; None without one."""
        joints = {unit if not unit or unit.startswith("_") else f"_{unit}": scale
                  for unit, scale in units.items()}  # fmt: skip
        found = [(name + unit, scale) for unit, scale in joints.items() if name + unit in
                 self.rows[0]]  # fmt: skip
        if len(found) > 1:
            raise InputError(f"{self.path}: has both {found[0][0]} and {found[1][0]}; allowed: one")
        return found[0] if found else None

    def _numbers(
        self, column: tuple[str, float], least: float, above: bool = False, most: float = np.inf
    ) -> Array:
        """The column's values in SI units, or shares of 1."""
        name, scale = column
        for line, row in enumerate(self.rows, start=2):
            value = row[name]
            sound = isinstance(value, float) and isfinite(value)
            if not (sound and (value > least if above else value >= least)
                    and value * scale <= most):  # fmt: skip
                allowed = f"{'above' if above else 'from'} {least:g}"
                allowed += f" to {most / scale:g}" if isfinite(most) else ""
                raise InputError(
                    f"{self.path}: {name}: '{one_line(value, 40)}' in line {line}; allowed: a "
                    f"number {allowed}"
                )
        return np.array([row[name] for row in self.rows], dtype=float) * scale
