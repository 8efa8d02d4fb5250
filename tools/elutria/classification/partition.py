"""The measured partition curve: mass share to coarse per size class, with Wilson intervals."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from elutria.classification.events import Events

Array = NDArray[np.float64]

# Renard series of ISO 3, the nominal apertures of ISO 565 sieves: 20 per decade
R20 = (1.0, 1.12, 1.25, 1.4, 1.6, 1.8, 2.0, 2.24, 2.5, 2.8, 3.15, 3.55,
       4.0, 4.5, 5.0, 5.6, 6.3, 7.1, 8.0, 9.0)  # fmt: skip


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


def class_limits(smallest: float, largest: float) -> Array:
    """Limits (m) that cover the sizes: the same grid for all velocities and materials."""
    decades = range(int(np.floor(np.log10(smallest))) - 1, int(np.ceil(np.log10(largest))) + 1)
    rising = np.array([float(f"{x}e{k}") for k in decades for x in R20])
    first = np.searchsorted(rising, smallest, side="right") - 1
    last = np.searchsorted(rising, largest, side="left")
    if last == first:  # a single size that is a limit itself
        last += 1
    return rising[first : last + 1]


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
                inside=float(mass[here & ~events.has_left].sum()),
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
    z = float(ndtri(0.5 + confidence / 2))
    center = (share + z**2 / (2 * number)) / (1 + z**2 / number)
    half = z / (1 + z**2 / number) * sqrt(share * (1 - share) / number + z**2 / (4 * number**2))
    return max(center - half, 0.0), min(center + half, 1.0)
