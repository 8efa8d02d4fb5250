"""The verification book's parts: a row is checked, a section is a case, a chapter is a module's."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Row:
    """One thing that is checked: reference and ours in SI units, `error` against `allowed`.

    Without `allowed` the row is for information and not judged.
    """

    case: str
    checked: str
    reference: float
    ours: float
    error: float
    allowed: float | None
    peers: str = ""

    @classmethod
    def relative(
        cls, case: str, checked: str, reference: float, ours: float, allowed: float | None,
        peers: str = "",
    ) -> Row:  # fmt: skip
        """With the relative difference as error."""
        return cls(case, checked, reference, ours, abs(ours / reference - 1), allowed, peers)

    @classmethod
    def size(
        cls, case: str, checked: str, value: float, allowed: float | None, peers: str = ""
    ) -> Row:
        """Something that should be 0: its size is the error."""
        return cls(case, checked, 0, value, abs(value), allowed, peers)

    @classmethod
    def worst(
        cls, case: str, checked: str, at: Iterable[str], reference: ArrayLike, ours: ArrayLike,
        allowed: float | None, peers: str = "",
    ) -> Row:  # fmt: skip
        """The value whose relative difference is the largest; `at` names the values."""
        references, values = np.asarray(reference, dtype=float), np.asarray(ours, dtype=float)
        errors = np.abs(values / references - 1)
        k = int(errors.argmax())
        where = f"{checked}, worst of {errors.size} ({list(at)[k]})"
        return cls(case, where, float(references[k]), float(values[k]), float(errors[k]), allowed,
                   peers)  # fmt: skip

    @property
    def verdict(self) -> str:
        """pass, FAIL or info; an error that is no number fails."""
        if self.allowed is None:
            return "info"
        return "pass" if self.error <= self.allowed else "FAIL"

    @property
    def failure(self) -> str:
        """The line that names a judged row that fails."""
        return f"FAIL {self.case}: {self.checked}: {self.error:.3g}, allowed {self.allowed:.3g}"


@dataclass
class Section:
    """A case: `text` says what it is; `found` what this run found, in numbers that it computed."""

    title: str
    text: str
    found: str = ""
    rows: list[Row] = field(default_factory=list)
    figures: dict[str, tuple[Figure, str]] = field(default_factory=dict)  # figure and caption


MakeSection = Callable[[Path, bool], Section]
"""Runs a section's cases in a folder, or a short version of them."""


@dataclass
class Chapter:
    """What one module found."""

    name: str
    title: str
    sections: list[Section] = field(default_factory=list)

    @property
    def rows(self) -> list[Row]:
        """Of all sections."""
        return [row for section in self.sections for row in section.rows]

    @property
    def judged(self) -> list[Row]:
        """Rows that are not for information."""
        return [row for row in self.rows if row.allowed is not None]

    @property
    def failed(self) -> list[Row]:
        """Judged rows that fail."""
        return [row for row in self.rows if row.verdict == "FAIL"]
