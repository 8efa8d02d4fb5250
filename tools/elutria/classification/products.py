"""From events to the rows of products.csv: masses, recoveries, grades and sizes, with intervals.

A share of masses is a ratio of two sums over parcels. Its variance is that of the linearised ratio
(Cochran 1977, section 6.4); Wilson's interval of as many trials as give that variance stays within
0 and 1. The interval of a quantile is that of the share below it, taken back to sizes (Woodruff
1952).
"""

from __future__ import annotations

from math import nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria.classification.events import Events
from elutria.classification.partition import wilson

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Row = dict[str, Any]

QUANTILES = {"d10": 0.10, "d50": 0.50, "d90": 0.90}


def product_rows(events: Events, materials: list[str]) -> list[Row]:
    """A row per product and material, then one for all materials of the product."""
    left = events.select(events.is_out)
    mass = left.mass
    everyone = np.ones(len(left), dtype=bool)
    rows = []
    for product in events.products:
        in_product = np.asarray(left.outlet == product)
        for material in [*materials, "all"]:
            of_material = everyone if material == "all" else np.asarray(left.material == material)
            both = in_product & of_material
            share = _share(mass, both, everyone)
            total = float(mass.sum())
            # of all materials it is 1 without a doubt
            grade = _share(mass, both, in_product) if material != "all" else [1.0, 1.0, 1.0]
            rows.append(
                {
                    "product": product,
                    "material": material,
                    **_named("mass{}_kg", [total * value for value in share]),
                    **_named("yield{}", share),
                    **_named("recovery{}", _share(mass, both, of_material)),
                    **_named("grade{}", grade),
                    **_sizes(left.diameter[both], mass[both]),
                }
            )
    return rows


def _named(name: str, values: list[float]) -> Row:
    return {
        name.format(end): value for end, value in zip(("", "_low", "_high"), values, strict=True)
    }


def _share(mass: Array, part: Flags, whole: Flags) -> list[float]:
    """Mass share of `part` in `whole`, which holds it, with its limits; nan of nothing."""
    total = float(mass[whole].sum())
    if total == 0:
        return [nan, nan, nan]
    share = float(mass[part].sum()) / total
    return [share, *wilson(share, _trials(share, mass[whole], part[whole]))]


def _trials(share: float, mass: Array, part: Flags) -> float:
    """Number of equal trials whose share would vary as much as that of these parcels."""
    total = float(mass.sum())
    variance = float(np.sum((mass * (part - share)) ** 2)) / total**2
    if 0 < share < 1 and variance > 0:
        return share * (1 - share) / variance
    return total**2 / float(np.sum(mass**2))


def _sizes(diameter: Array, mass: Array) -> Row:
    """Quantiles by mass with their limits, m."""
    found: Row = {}
    order = np.argsort(diameter, kind="stable")
    diameter, mass = diameter[order], mass[order]
    for name, level in QUANTILES.items():
        values = [nan, nan, nan]
        if diameter.size:
            middle = (np.cumsum(mass) - mass / 2) / mass.sum()
            place = float(np.interp(level, middle, diameter))
            trials = _trials(level, mass, diameter <= place)
            limits = [level, *wilson(level, trials)]
            values = [float(np.interp(share, middle, diameter)) for share in limits]
        found |= _named(name + "{}_m", values)
    return found
