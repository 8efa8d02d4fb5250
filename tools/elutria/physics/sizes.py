"""Particle size distributions: cumulative shares by mass and by number, and their quantiles.

The laws and their curves are the solver's (solver/coupling/laws, SizeLaws.hpp and SizeCurves.hpp);
here stands what a dictionary may say. Sizes are diameters in m.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elutria.errors import InputError
from elutria.files import read_text
from elutria.openfoam.dictionary import Dictionary
from elutria.physics import laws

Array = NDArray[np.float64]

SMALLEST, LARGEST = 1e-8, 0.5
"""Sizes (m) beyond which a number is more likely in another unit."""

_NOT_SIZES = {"n": 100.0, "m": 100.0, "sigma": 1e3}
"""Parameters of the laws that are no sizes, and the largest value that makes sense."""


@dataclass(frozen=True)
class SizeDistribution:
    """Cumulative shares on a grid of diameters, between which they are linear.

    `diameters` (m) rises; `by_mass` and `by_number` go from 0 to 1. A single size stands
    there twice. `mean_cube` is the number mean of d^3 (m3).
    """

    name: str
    diameters: Array
    by_mass: Array
    by_number: Array
    mean_cube: float

    @property
    def smallest(self) -> float:
        """Smallest diameter, m."""
        return float(self.diameters[0])

    @property
    def largest(self) -> float:
        """Largest diameter, m."""
        return float(self.diameters[-1])

    def mass_share_below(self, diameter: ArrayLike) -> Array:
        """Share of the mass in particles not larger than `diameter` (m)."""
        return self._share(diameter, self.by_mass)

    def number_share_below(self, diameter: ArrayLike) -> Array:
        """Share of the number of particles not larger than `diameter` (m)."""
        return self._share(diameter, self.by_number)

    def mass_quantile(self, share: ArrayLike) -> Array:
        """Diameter (m) below which `share` of the mass lies."""
        return np.asarray(np.interp(np.asarray(share, dtype=float), self.by_mass, self.diameters))

    def number_quantile(self, share: ArrayLike) -> Array:
        """Diameter (m) below which `share` of the number lies."""
        return np.asarray(np.interp(np.asarray(share, dtype=float), self.by_number, self.diameters))

    def _share(self, diameter: ArrayLike, shares: Array) -> Array:
        at = np.asarray(diameter, dtype=float)
        if self.smallest == self.largest:
            return np.where(at >= self.smallest, 1.0, 0.0)
        return np.asarray(np.interp(at, self.diameters, shares, left=0.0, right=1.0))


def entries() -> dict[str, tuple[str, ...]]:
    """Of each `type`, what else its dictionary may hold."""
    bounds = ("type", "min", "max", "weighting")
    known = {law: (*bounds, *parameters) for law, parameters in laws.size_laws().items()}
    known["fixedValue"] = ("type", "value", "weighting")
    known["table"] = ("type", "diameters", "cumulative", "weighting")
    known["sieve"] = ("type", "file", "min", "weighting")
    known["sum"] = ("type", "parts", "weighting")
    return known


def read_size_distribution(entry: Dictionary, case: Path = Path()) -> SizeDistribution:
    """From a `sizeDistribution` dictionary; a file that it names is in the folder `case`. Raises
    InputError naming the entry and its range."""
    weighting = entry.word("weighting", ("mass", "number"), default="mass")
    return SizeDistribution(entry.word("type", entries()), *_read(entry, case, weighting).curves())


def _read(entry: Dictionary, case: Path, weighting: str, more: tuple[str, ...] = ()) -> laws.Sizes:
    known = entries()
    kind = entry.word("type", known)
    entry.refuse_unknown((*known[kind], *more))
    try:
        if kind == "fixedValue":
            return laws.single_size(_size(entry, "value"))
        if kind == "table":
            return laws.sieved_sizes(_sieves(entry), entry.numbers("cumulative"), weighting)
        if kind == "sieve":
            return _read_table(entry, case, weighting)
        if kind == "sum":
            return _read_sum(entry, case, weighting)
        return laws.law_sizes(
            kind,
            [_parameter(entry, name) for name in laws.size_laws()[kind]],
            _size(entry, "min"),
            _size(entry, "max"),
            weighting,
        )
    except ValueError as error:
        raise InputError(f"{entry.where()}: {error}") from error


def _read_table(entry: Dictionary, case: Path, weighting: str) -> laws.Sizes:
    file = case / entry.word("file")
    low = _size(entry, "min") if "min" in entry else 0.0
    try:
        return laws.sieve_table(read_text(file, limit=1_000_000), low, weighting)
    except ValueError as error:
        raise InputError(f"{entry.where('file')}: {file}: {error}") from error


def _read_sum(entry: Dictionary, case: Path, weighting: str) -> laws.Sizes:
    parts = entry.sub("parts")
    own = [parts.sub(name) for name in parts.entries]
    for part in own:
        part.number("share", above=0, at_most=1e6)
        if "weighting" in part:
            raise part.refuse("weighting", "that of the sum")
    curves = [_read(part, case, weighting, ("share",)) for part in own]
    return laws.Sizes.mixed(curves, [part.number("share") for part in own], weighting)


def _size(entry: Dictionary, name: str) -> float:
    return entry.number(name, at_least=SMALLEST, at_most=LARGEST, unit="m")


def _parameter(entry: Dictionary, name: str) -> float:
    if name in _NOT_SIZES:
        return entry.number(name, above=0, at_most=_NOT_SIZES[name])
    return entry.number(name, above=0, at_most=LARGEST, unit="m")


def _sieves(entry: Dictionary) -> list[float]:
    diameters = entry.numbers("diameters")
    if min(diameters) < SMALLEST or max(diameters) > LARGEST:
        raise entry.refuse("diameters", f"rising sizes from {SMALLEST:g} to {LARGEST:g} (m)")
    return diameters
