"""The measured partition curve: mass share to coarse per size class, with Wilson intervals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import nan, sqrt
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from elutria.classification.events import Events

Array = NDArray[np.float64]

# Renard series R 80 of ISO 3; every second of it is R 40, every fourth R 20, the nominal apertures
# of ISO 565 sieves
R80 = (1.0, 1.03, 1.06, 1.09, 1.12, 1.15, 1.18, 1.22, 1.25, 1.28, 1.32, 1.36, 1.4, 1.45, 1.5, 1.55,
       1.6, 1.65, 1.7, 1.75, 1.8, 1.85, 1.9, 1.95, 2.0, 2.06, 2.12, 2.18, 2.24, 2.3, 2.36, 2.43,
       2.5, 2.58, 2.65, 2.72, 2.8, 2.9, 3.0, 3.07, 3.15, 3.25, 3.35, 3.45, 3.55, 3.65, 3.75, 3.87,
       4.0, 4.12, 4.25, 4.37, 4.5, 4.62, 4.75, 4.87, 5.0, 5.15, 5.3, 5.45, 5.6, 5.8, 6.0, 6.15,
       6.3, 6.5, 6.7, 6.9, 7.1, 7.3, 7.5, 7.75, 8.0, 8.25, 8.5, 8.75, 9.0, 9.25, 9.5,
       9.75)  # fmt: skip
COARSEST = 4
"""Steps of R 80 in a class of R 20."""
STEEP = 0.15
"""A class over which the curve changes by more is halved,"""
FEWEST = 25
"""where each half holds so many parcels."""


@dataclass(frozen=True)
class Cut:
    """A curve that classes are to follow: T (n) at diameters (n, m), and the parcels' diameters."""

    share: Callable[[Array], Array]
    diameter: Array


@dataclass(frozen=True)
class ProductShare:
    """A product in a size class: its mass (kg), its share of what has left with Wilson's interval,
    and the share of it and of all products before it."""

    product: str
    mass: float
    share: float
    share_low: float
    share_high: float
    cumulative: float


@dataclass(frozen=True)
class SizeClass:
    """One class. Diameters in m, masses in kg. `diameter` is the mass-weighted geometric mean of
    what is in the class, since a class at the feed's end is not filled evenly.

    `coarse` is what left with the product whose share the curve is, `fines` what left with others.
    `share` is the mass share to coarse of what has left, nan when nothing has. `products` says the
    same of each product, in the order of the feed.
    """

    low: float
    high: float
    diameter: float
    fines: float
    coarse: float
    inside: float
    share: float
    share_low: float
    share_high: float
    products: tuple[ProductShare, ...] = ()

    @property
    def feed(self) -> float:
        """Mass fed in this class, kg."""
        return self.fines + self.coarse + self.inside


def class_limits(smallest: float, largest: float, cuts: Sequence[Cut] = ()) -> Array:
    """Limits (m) that cover the sizes: those of R 20; of R 40 or R 80 where one of `cuts` changes.

    What is finer divides what is coarser, so that classes of two grids can be joined.
    """
    decades = range(int(np.floor(np.log10(smallest))) - 1, int(np.ceil(np.log10(largest))) + 1)
    rising = np.array([float(f"{x}e{k}") for k in decades for x in R80])
    coarse = rising[::COARSEST]
    first = int(np.searchsorted(coarse, smallest, side="right")) - 1
    last = int(np.searchsorted(coarse, largest, side="left"))
    if last == first:  # a single size that is a limit itself
        last += 1
    ends = range(COARSEST * first, COARSEST * last, COARSEST)
    kept = [k for end in ends for k in _divided(rising, end, end + COARSEST, cuts)]
    return rising[[*kept, COARSEST * last]]


def _divided(rising: Array, low: int, high: int, cuts: Sequence[Cut]) -> list[int]:
    """Lower limits of the classes from `low` to `high`, as places in `rising`."""
    middle = (low + high) // 2
    if high - low > 1 and any(_asks_for(cut, rising[[low, middle, high]]) for cut in cuts):
        return [*_divided(rising, low, middle, cuts), *_divided(rising, middle, high, cuts)]
    return [low]


def _asks_for(cut: Cut, limits: Array) -> bool:
    """Whether a class is to be halved: `limits` are its ends and its middle."""
    shares = cut.share(limits)
    held = np.histogram(cut.diameter, limits)[0]
    return bool(np.ptp(shares) > STEEP and held.min() >= FEWEST)


def partition_table(events: Events, limits: Array) -> list[SizeClass]:
    """The classes [low, high) that hold anything (the last one closed), rising."""
    index = np.clip(np.searchsorted(limits, events.diameter, side="right") - 1, 0, limits.size - 2)
    mass = events.mass
    classes = []
    for k in range(limits.size - 1):
        here = index == k
        if not here.any():
            continue
        left = here & events.has_left
        total, heavy = float(mass[left].sum()), float(mass[here & events.is_coarse].sum())
        share = heavy / total if total > 0 else nan
        number = total**2 / float(np.sum(mass[left] ** 2)) if total > 0 else 0.0
        masses = {
            product: float(mass[here & (events.outlet == product)].sum())
            for product in events.products
        }
        classes.append(
            SizeClass(
                low=float(limits[k]),
                high=float(limits[k + 1]),
                diameter=_mean_diameter(events.diameter[here], mass[here]),
                fines=total - heavy,
                coarse=heavy,
                inside=float(mass[here & events.is_inside].sum()),
                share=share,
                share_low=wilson(share, number)[0],
                share_high=wilson(share, number)[1],
                products=_product_shares(masses, number),
            )
        )
    return classes


def _product_shares(masses: dict[str, float], number: float) -> tuple[ProductShare, ...]:
    """Of each product's mass; `number` is how many parcels of equal mass have left."""
    total, before, shares = sum(masses.values()), 0.0, []
    for product, mass in masses.items():
        share = mass / total if total > 0 else nan
        before += mass
        cumulative = min(before / total, 1.0) if total > 0 else nan
        shares.append(ProductShare(product, mass, share, *wilson(share, number), cumulative))
    return tuple(shares)


def _mean_diameter(diameter: Array, mass: Array) -> float:
    return float(np.exp(np.average(np.log(diameter), weights=mass)))


def wilson(share: float, number: float, confidence: float = 0.95) -> tuple[float, float]:
    """Wilson's interval of a share seen in `number` (effective) trials. Wilson 1927."""
    if number <= 0:
        return nan, nan
    from scipy.special import ndtri  # the figures, which need the classes alone, start sooner

    z = float(ndtri(0.5 + confidence / 2))
    center = (share + z**2 / (2 * number)) / (1 + z**2 / number)
    half = z / (1 + z**2 / number) * sqrt(share * (1 - share) / number + z**2 / (4 * number**2))
    return max(center - half, 0.0), min(center + half, 1.0)
