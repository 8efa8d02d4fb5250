"""What parts the rows of the result tables: the gas velocity, and what else a sweep varied."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria import tables
from elutria.tables import VELOCITY, short, shown

Array = NDArray[np.float64]
Row = dict[str, Any]
Setting = tuple[Any, ...]
"""Values of the columns that part the runs of a sweep, in their order."""

NOT_PRODUCTS = ("feed", "inside")


def setting_columns(summary: Sequence[Row], partition: Sequence[Row]) -> list[str]:
    """The velocity, and the columns that both tables have beside their own."""
    known = {*tables.SUMMARY, *tables.PARTITION}
    more = [name for name in (summary[0] if summary else {}) if name not in known]
    products = {f"{name}_kg" for name in products_of(partition)}
    both = partition[0] if partition else {}
    kept = [name for name in more if name in both and name not in products]
    return [VELOCITY, *kept]


class Settings:
    """The settings of a sweep's tables, rising, with the words for each."""

    def __init__(self, summary: Sequence[Row], partition: Sequence[Row]):
        self.columns = setting_columns(summary, partition)
        self.all: list[Setting] = sorted({self.of(row) for row in partition}, key=_order)

    def of(self, row: Row) -> Setting:
        """The setting of a row."""
        return tuple(row[name] for name in self.columns)

    def select(self, rows: Iterable[Row], setting: Setting, material: str = "") -> list[Row]:
        """Rows of a setting; of one material where it is named."""
        return [
            row for row in rows
            if self.of(row) == setting and (not material or row["material"] == material)
        ]  # fmt: skip

    def values(self, column: str) -> list[Any]:
        """The different values of one column, rising."""
        place = self.columns.index(column)
        return sorted({setting[place] for setting in self.all}, key=lambda value: _order((value,)))

    @property
    def varied(self) -> list[str]:
        """The columns with more than one value; the velocity when there is none."""
        return [name for name in self.columns if len(self.values(name)) > 1] or [VELOCITY]

    def label(self, setting: Setting) -> str:
        """`6 m/s`, `6 m/s, loading 0.2`: what is varied."""
        return ", ".join(spoken(name, setting[self.columns.index(name)]) for name in self.varied)


def spoken(column: str, value: Any) -> str:
    """A setting in words."""
    return f"{shown(value)} m/s" if column == VELOCITY else f"{short(column)} {shown(value)}"


def products_of(partition: Sequence[Row]) -> list[str]:
    """The products, by the columns PRODUCT_kg of partition.csv, in their order."""
    names = [name.removesuffix("_kg") for name in (partition[0] if partition else {})
             if name.endswith("_kg")]  # fmt: skip
    return [name for name in names if name not in NOT_PRODUCTS]


def materials_of(rows: Iterable[Row]) -> list[str]:
    """Materials in their order, without `all`."""
    return [name for name in dict.fromkeys(row["material"] for row in rows) if name != "all"]


def column(rows: Iterable[Row], name: str) -> Array:
    """A column's numbers."""
    return np.array([row[name] for row in rows], dtype=float)


def _order(setting: Setting) -> tuple[tuple[bool, Any], ...]:
    """Numbers before words."""
    return tuple((isinstance(value, str), value) for value in setting)
