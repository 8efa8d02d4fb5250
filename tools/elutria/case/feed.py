"""constant/feed: what is fed, where, and through which patches it leaves."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from pathlib import Path

import numpy as np

from elutria.case.feed_rate import check_table, is_table
from elutria.errors import InputError, one_line
from elutria.files import read_text
from elutria.openfoam.dictionary import Dictionary, read_dictionary
from elutria.physics.densities import read_density
from elutria.physics.laws import Grain, ellipsoid_sphericity, terminal_velocities
from elutria.physics.sizes import SizeDistribution, read_size_distribution

ENTRIES = (
    "FoamFile", "outlets", "planes", "partitionTo", "patch", "zone", "loading", "massFlowRate",
    "start", "duration", "particles", "particlesPerParcel", "parcels", "focus", "drainTime",
    "velocity", "seed", "materials",
)  # fmt: skip
MOST_PLANES = 200
MATERIAL_ENTRIES = (
    "density", "densityDistribution", "sphericity", "flatness", "elongation", "measuredVelocity",
    "massFraction", "sizeDistribution",
)  # fmt: skip


@dataclass(frozen=True)
class Material:
    """One material of the feed: its grains, and its share of the feed's mass 0..1."""

    name: str
    grain: Grain
    mass_fraction: float
    sizes: SizeDistribution


@dataclass(frozen=True)
class Feed:
    """The feed as constant/feed states it. What the solver makes of it is in its plan. SI units.

    `loading` is kg of solids per kg of gas, `mass_flow_rate` kg/s: one of them is None, both are
    where the rate changes over time by a table.
    `outlets` gives each product's patches, `partition_to` the product whose share the curve is.
    """

    outlets: dict[str, list[str]]
    partition_to: str
    place: str
    place_is_patch: bool
    loading: float | None
    mass_flow_rate: float | None
    start: float
    duration: float
    particles: int | None
    particles_per_parcel: float  # at most, where they crowd
    parcels: str  # particles: each parcel is one; evenMass, evenSizes: see Feed.H
    focus: str  # none, auto or a size in m, around which half of evenSizes' parcels lie
    drain_time: float
    velocity: tuple[float, float, float]
    seed: int
    materials: list[Material]


def read_feed(case: Path) -> Feed:
    """Read CASE/constant/feed. Raises InputError for the first entry that is not allowed."""
    entries = read_dictionary(case / "constant" / "feed", case, with_included=True)
    entries.refuse_repeated()
    entries.refuse_unknown(ENTRIES)
    outlets = _read_outlets(entries.sub("outlets"))
    _check_planes(entries)
    place, is_patch = _read_place(entries)
    loading, rate = _read_rate(entries)
    duration = entries.number("duration", inf, above=0, at_most=1e9, unit="s")
    particles = entries.number("particles", None, at_least=1, at_most=1e12)
    if particles is not None and particles != int(particles):
        raise entries.refuse("particles", "a whole number >= 1")
    by_table = loading is None and rate is None
    if duration == inf and particles is None and not by_table:
        raise InputError(
            f"{entries.where()}: neither duration nor particles is given; "
            "allowed: duration (s), particles (a whole number) or both"
        )
    velocity = entries.numbers("velocity", 3) if "velocity" in entries else [0.0, 0.0, 0.0]
    return Feed(
        outlets=outlets,
        partition_to=_read_partition_to(entries, list(outlets)),
        place=place,
        place_is_patch=is_patch,
        loading=loading,
        mass_flow_rate=rate,
        start=entries.number("start", 0.0, at_least=0, at_most=1e9, unit="s"),
        duration=duration,
        particles=None if particles is None else int(particles),
        particles_per_parcel=entries.number("particlesPerParcel", inf, above=0),
        parcels=entries.word("parcels", ("particles", "evenMass", "evenSizes"), "particles"),
        focus=_read_focus(entries),
        drain_time=entries.number("drainTime", inf, at_least=0, unit="s"),
        velocity=(velocity[0], velocity[1], velocity[2]),
        seed=_read_seed(entries),
        materials=_read_materials(entries.sub("materials"), case),
    )


def _read_place(entries: Dictionary) -> tuple[str, bool]:
    if ("patch" in entries) == ("zone" in entries):
        raise InputError(
            f"{entries.where('patch')}: allowed: either 'patch NAME;' or 'zone NAME;', one of them"
        )
    name = "patch" if "patch" in entries else "zone"
    return entries.word(name), name == "patch"


def _read_rate(entries: Dictionary) -> tuple[float | None, float | None]:
    """Either of both. Where an included file has a variable of the other's name, what stands in
    constant/feed itself."""
    names = [name for name in ("loading", "massFlowRate") if name in entries]
    if len(names) > 1:
        names = [name for name in names if name in entries.own]
    if len(names) != 1:
        raise InputError(
            f"{entries.where('loading')}: allowed: either 'loading X;' (kg/kg) or "
            "'massFlowRate X;' (kg/s), one of them"
        )
    if names == ["loading"]:
        return entries.number("loading", above=0, at_most=1000, unit="kg solids per kg gas"), None
    if is_table(entries):
        check_table(entries)
        return None, None
    return None, entries.number("massFlowRate", above=0, at_most=1e6, unit="kg/s")


def _read_focus(entries: Dictionary) -> str:
    allowed = "none, auto or a size > 0 m"
    value = entries.raw("focus", "none", allowed=allowed)
    if value in ("none", "auto"):
        return str(value)
    if isinstance(value, (str, bool)):
        raise entries.refuse("focus", allowed)
    return f"{entries.number('focus', above=0, at_most=1, unit='m'):g} m"


def _read_seed(entries: Dictionary) -> int:
    seed = entries.number("seed", 1.0, at_least=0, at_most=2**31 - 1)
    if seed != int(seed):
        raise entries.refuse("seed", "a whole number >= 0")
    return int(seed)


def _read_outlets(entries: Dictionary) -> dict[str, list[str]]:
    """Any number of products, each with patches that no other has."""
    if not entries.entries:
        raise entries.refuse("", "NAME (patches); for each product")
    outlets: dict[str, list[str]] = {}
    for product in entries.entries:
        if product == "inside" or not re.fullmatch(r"[A-Za-z_][\w.+-]*", product):
            raise InputError(
                f"{entries.where()}: '{one_line(product, 40)}' cannot be a product; allowed: a "
                "word that begins with a letter, but not inside, which is what has not left"
            )
        outlets[product] = entries.words(product)
        for patch in outlets[product]:
            others = [name for name, patches in outlets.items() if patch in patches]
            if others != [product]:
                raise entries.refuse(
                    product, f"patches that are not in {others[0]} too ('{patch}' is)"
                )
            if outlets[product].count(patch) > 1:
                raise entries.refuse(product, f"each patch once ('{patch}' is there twice)")
    return outlets


def _check_planes(entries: Dictionary) -> None:
    """Heights of planes that count: a list, or evenly spaced ones."""
    if "planes" not in entries:
        return
    if isinstance(entries.raw("planes"), Mapping):
        planes = entries.sub("planes")
        planes.refuse_unknown(("first", "spacing", "number"))
        planes.number("first", at_least=-1e3, at_most=1e3, unit="m")
        planes.number("spacing", above=0, at_most=1e3, unit="m")
        number = planes.number("number", at_least=1, at_most=MOST_PLANES)
        if number != int(number):
            raise planes.refuse("number", f"a whole number from 1 to {MOST_PLANES}")
        return
    heights = entries.numbers("planes")
    rising = all(low < high for low, high in pairwise(heights))
    if not (rising and 1 <= len(heights) <= MOST_PLANES):
        raise entries.refuse("planes", f"up to {MOST_PLANES} rising heights (m)")


def _read_partition_to(entries: Dictionary, products: list[str]) -> str:
    """The last product (`other` aside) unless the feed says otherwise; where that is not the one
    named coarse, it must say so: the curve would fall."""
    usual = [name for name in products if name != "other"] or products
    if "partitionTo" not in entries and "coarse" in usual[:-1]:
        raise InputError(
            f"{entries.where('outlets')}: the partition curve is the share to the last product, "
            f"{usual[-1]}, although there is coarse; allowed: coarse as the last, or "
            "'partitionTo NAME;'"
        )
    return entries.word("partitionTo", products, usual[-1])


def _read_materials(entries: Dictionary, case: Path) -> list[Material]:
    if not entries.entries:
        raise entries.refuse("", "at least one material { ... }")
    materials = []
    for name in entries.entries:
        entry = entries.sub(name)
        entry.refuse_unknown(MATERIAL_ENTRIES)
        if name == "all" or "," in name or '"' in name:
            raise InputError(f"{entry.where()}: '{name}' cannot be a material; allowed: a word")
        materials.append(
            Material(
                name=name,
                grain=_read_grain(entry, case),
                mass_fraction=entry.number("massFraction", 1.0, above=0, at_most=1),
                sizes=read_size_distribution(entry.sub("sizeDistribution"), case),
            )
        )
    _check_shares(entries, materials)
    return materials


def _check_shares(entries: Dictionary, materials: list[Material]) -> None:
    total = sum(material.mass_fraction for material in materials)
    if abs(total - 1) > 1e-6:
        raise InputError(
            f"{entries.where()}: massFraction adds up to {total:.6g} over "
            f"{', '.join(material.name for material in materials)}; allowed: 1"
        )


def _read_grain(entry: Dictionary, case: Path) -> Grain:
    density = read_density(entry)
    shape = [name for name in ("sphericity", "flatness", "elongation") if name in entry]
    if shape not in ([], ["sphericity"], ["flatness", "elongation"]):
        raise entry.refuse(shape[0], "sphericity, or both flatness and elongation")
    flat, slender = (entry.number(k, 1.0, above=0, at_most=1) for k in ("flatness", "elongation"))
    sphericity = entry.number("sphericity", 1.0, above=0, at_most=1)
    if len(shape) == 2:
        sphericity = ellipsoid_sphericity(flat, slender)
    text, gas = _read_velocities(entry, case, density)
    return Grain(density, sphericity, flat, slender, text, gas)


def _read_velocities(
    entry: Dictionary, case: Path, density: float
) -> tuple[str | None, tuple[float, float]]:
    """The table of measured terminal velocities, and density and viscosity of its gas."""
    own = entry.sub("measuredVelocity") if "measuredVelocity" in entry else None
    if own is None:
        return None, (1.2, 1.8e-5)
    own.refuse_unknown(("file", "gasDensity", "gasViscosity"))
    gas = (
        own.number("gasDensity", 1.2, above=0, at_most=0.999 * density, unit="kg/m3"),
        own.number("gasViscosity", 1.8e-5, above=0, at_most=1, unit="Pa s"),
    )
    file = case / own.word("file")
    text = read_text(file, limit=1_000_000)
    try:
        terminal_velocities("MeasuredVelocityDrag", np.array([]), Grain(density, velocities=text,
                            measured_in=gas), gas, 9.81)  # fmt: skip
    except ValueError as error:
        raise InputError(f"{own.where('file')}: {file}: {error}") from error
    return text, gas
