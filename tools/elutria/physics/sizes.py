"""Particle size distributions: cumulative shares by mass and by number, and their quantiles.

A distribution is given in one weighting; the other follows from dN ~ dM / d^3 by summing over a
fine grid. Sizes are diameters in m. Laws: Rosin-Rammler (RRSB, ISO 9276-3 / DIN 66145) and
log-normal (ISO 9276-5) from `fluids`, truncated to [min, max] and scaled so that they end at 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log

import numpy as np
from fluids.particle_size_distribution import cdf_lognormal, cdf_Rosin_Rammler
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

from elutria.openfoam.dictionary import Dictionary

Array = NDArray[np.float64]

SMALLEST, LARGEST = 1e-8, 0.5
"""Sizes (m) beyond which a number is more likely in another unit."""

_BOUNDS = ("type", "min", "max", "weighting")
ENTRIES = {
    "RosinRammler": (*_BOUNDS, "d63", "n"),
    "logNormal": (*_BOUNDS, "d50", "sigma"),
    "normal": (*_BOUNDS, "mean", "standardDeviation"),
    "uniform": _BOUNDS,
    "fixedValue": ("type", "value", "weighting"),
    "table": ("type", "diameters", "cumulative", "weighting"),
}


@dataclass(frozen=True)
class SizeDistribution:
    """Cumulative shares on a grid of diameters, between which they are linear.

    `diameters` (m) rises strictly; `by_mass` and `by_number` go from 0 to 1. A single size has one
    diameter and its shares are [1].
    """

    name: str
    diameters: Array
    by_mass: Array
    by_number: Array

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

    def mean_volume_diameter(self) -> float:
        """Diameter (m) of the particle with the mean volume: (number mean of d^3)^(1/3)."""
        if self.diameters.size == 1:
            return self.smallest
        middle = 0.5 * (self.diameters[1:] + self.diameters[:-1])
        return float(np.sum(np.diff(self.by_number) * middle**3) ** (1 / 3))

    def _share(self, diameter: ArrayLike, shares: Array) -> Array:
        at = np.asarray(diameter, dtype=float)
        if self.diameters.size == 1:
            return np.where(at >= self.smallest, 1.0, 0.0)
        return np.asarray(np.interp(at, self.diameters, shares, left=0.0, right=1.0))


def tabulated(
    name: str, diameters: Array, cumulative: Array, weighting: str = "mass"
) -> SizeDistribution:
    """A distribution from shares that rise from 0 to 1 over strictly rising `diameters` (m)."""
    if diameters.size == 1:
        one = np.ones(1)
        return SizeDistribution(name, diameters, one, one)
    middle = 0.5 * (diameters[1:] + diameters[:-1])
    factor = middle**-3 if weighting == "mass" else middle**3
    other = np.concatenate([[0.0], np.cumsum(np.diff(cumulative) * factor)])
    other /= other[-1]
    by_mass, by_number = (cumulative, other) if weighting == "mass" else (other, cumulative)
    return SizeDistribution(name, diameters, by_mass, by_number)


def truncated(
    name: str, cdf: Callable[[Array], Array], low: float, high: float, weighting: str
) -> SizeDistribution:
    """The part of a law between `low` and `high` (m), scaled to end at 1."""
    diameters = np.geomspace(low, high, 4001)
    shares = cdf(diameters)
    cumulative = (shares - shares[0]) / (shares[-1] - shares[0])
    return tabulated(name, diameters, cumulative, weighting)


def read_size_distribution(entry: Dictionary) -> SizeDistribution:
    """From a `sizeDistribution` dictionary. Raises InputError naming the entry and its range."""
    kind = entry.word("type", ENTRIES)
    entry.refuse_unknown(ENTRIES[kind])
    weighting = entry.word("weighting", ("mass", "number"), default="mass")
    if kind == "fixedValue":
        return tabulated(
            kind,
            np.array([entry.number("value", at_least=SMALLEST, at_most=LARGEST, unit="m")]),
            np.ones(1),
        )
    if kind == "table":
        return _read_table(entry, weighting)
    low = entry.number("min", at_least=SMALLEST, at_most=LARGEST, unit="m")
    high = entry.number("max", above=low, at_most=LARGEST, unit="m, above min")
    cdf = _law(kind, entry)
    ends = cdf(np.array([low, high]))
    if not ends[1] - ends[0] > 1e-9:
        raise entry.refuse("max", f"a range of the {kind} law that holds particles")
    return truncated(kind, cdf, low, high, weighting)


def _law(kind: str, entry: Dictionary) -> Callable[[Array], Array]:
    if kind == "RosinRammler":
        size = entry.number("d63", above=0, at_most=LARGEST, unit="m")
        exponent = entry.number("n", above=0, at_most=100)
        # in units of d63, where the law's coefficient is 1
        return np.vectorize(lambda d: cdf_Rosin_Rammler(d / size, 1.0, exponent))
    if kind == "logNormal":
        median = entry.number("d50", above=0, at_most=LARGEST, unit="m")
        deviation = entry.number("sigma", above=1, unit="geometric standard deviation")
        return np.vectorize(lambda d: cdf_lognormal(d, median, log(deviation)))
    if kind == "normal":
        mean = entry.number("mean", above=0, at_most=LARGEST, unit="m")
        width = entry.number("standardDeviation", above=0, at_most=LARGEST, unit="m")
        return lambda d: np.asarray(ndtr((d - mean) / width))
    return lambda d: d


def _read_table(entry: Dictionary, weighting: str) -> SizeDistribution:
    diameters = np.array(entry.numbers("diameters"))
    rising = diameters.size > 1 and bool(np.all(np.diff(diameters) > 0))
    if not rising or diameters[0] < SMALLEST or diameters[-1] > LARGEST:
        raise entry.refuse("diameters", f"rising sizes from {SMALLEST:g} to {LARGEST:g} (m)")
    shares = np.array(entry.numbers("cumulative", diameters.size))
    if shares[0] != 0 or abs(shares[-1] - 1) > 1e-12 or np.any(np.diff(shares) < 0):
        raise entry.refuse("cumulative", "rising shares from 0 to 1, one per diameter")
    # linear between the sieves in the given weighting: a fine grid keeps the other one exact
    fine = np.unique(np.concatenate([np.linspace(diameters[0], diameters[-1], 4001), diameters]))
    return tabulated("table", fine, np.interp(fine, diameters, shares), weighting)
