"""Densities of a material whose grains are not all alike. Shares are of the mass.

The curves are the solver's (solver/coupling/laws, DensityScatter.hpp); here stands what a
dictionary may say.
"""

from __future__ import annotations

import numpy as np

from elutria.errors import InputError
from elutria.openfoam.dictionary import Dictionary
from elutria.physics import laws

ENTRIES = {
    "normal": ("type", "min", "max", "mean", "standardDeviation"),
    "uniform": ("type", "min", "max"),
    "table": ("type", "densities", "cumulative"),
}
"""Of each `type` of a densityDistribution, what its dictionary may hold."""


def read_density(material: Dictionary) -> float:
    """A material's density, kg/m3: the mean over its mass where it scatters. Raises InputError
    naming the entry and its range."""
    if "densityDistribution" not in material:
        return _density(material, "density")
    for other in ("density", "measuredVelocity"):
        if other in material:
            raise material.refuse("densityDistribution", f"one of it and {other}")
    entry = material.sub("densityDistribution")
    kind = entry.word("type", ENTRIES)
    entry.refuse_unknown(ENTRIES[kind])
    try:
        density, lighter, *_ = _curve(entry, kind).curves()
    except ValueError as error:
        raise InputError(f"{entry.where()}: {error}") from error
    return float(np.sum(np.diff(lighter) * (density[1:] + density[:-1]) / 2))


def _curve(entry: Dictionary, kind: str) -> laws.Sizes:
    least, most = laws.least_density(), laws.largest_density()
    if kind == "table":
        densities = entry.numbers("densities")
        if min(densities) < least or max(densities) > most:
            raise entry.refuse("densities", f"rising, from {least:g} to {most:g} (kg/m3)")
        cumulative = entry.numbers("cumulative")
        return laws.sieved_sizes(densities, cumulative, "mass", most, "densities")
    names = ("mean", "standardDeviation") if kind == "normal" else ()
    parameters = [entry.number(name, above=0, at_most=most, unit="kg/m3") for name in names]
    low, high = (_density(entry, name) for name in ("min", "max"))
    return laws.law_sizes(kind, parameters, low, high, "mass", most)


def _density(entry: Dictionary, name: str) -> float:
    return entry.number(
        name, at_least=laws.least_density(), at_most=laws.largest_density(), unit="kg/m3"
    )
