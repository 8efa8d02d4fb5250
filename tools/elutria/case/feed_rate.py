"""massFlowRate of constant/feed: a number, or a table over the run's time.

The solver reads a table by OpenFOAM's Function1 (feedRate.H); here its text is checked sooner.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from math import isfinite
from typing import Any

from elutria.openfoam.dictionary import Dictionary

NAME = "massFlowRate"
FILES = ("tableFile", "csvFile")
ALLOWED = "a number > 0 (kg/s), or table ((s kg/s) (s kg/s) ...) with rising times and rates >= 0"


def is_table(entries: Dictionary) -> bool:
    """Whether massFlowRate is other than a number."""
    value = entries.raw(NAME, None)
    return isinstance(value, (Mapping, list, tuple))


def check_table(entries: Dictionary) -> None:
    """Raise InputError for a table that cannot be right; a file's content is the solver's."""
    value = entries.raw(NAME)
    if isinstance(value, Mapping):
        entries.sub(NAME).word("type", FILES)
        return
    kind, *rest = value
    if kind != "table" or len(rest) != 1 or not _is_rate_over_time(rest[0]):
        raise entries.refuse(NAME, ALLOWED)


def _is_rate_over_time(rows: Any) -> bool:
    """Pairs of a time (s) and a rate (kg/s)."""
    good = isinstance(rows, (list, tuple)) or hasattr(rows, "tolist")
    pairs = [list(row) if hasattr(row, "__iter__") else [] for row in (rows if good else [])]
    return (
        len(pairs) >= 2
        and all(
            len(pair) == 2 and all(isinstance(x, (int, float)) and isfinite(x) for x in pair)
            for pair in pairs
        )
        and all(earlier[0] < later[0] for earlier, later in pairwise(pairs))
        and all(rate >= 0 for _, rate in pairs)
    )
