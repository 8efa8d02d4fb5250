"""The columns of every csv file, written once. SI units, named in the columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

EVENTS = (
    "time_s", "outlet", "material", "id", "diameter_m", "density_kg_m3", "n_particle",
    "ux_m_s", "uy_m_s", "uz_m_s", "residence_time_s",
)  # fmt: skip
"""particles.csv and inside.csv, which the solver writes: a row per parcel."""

PATCH_FLOWS = (
    "time_s", "patch", "area_m2", "volume_flow_m3_s", "mass_flow_kg_s", "velocity_m_s",
    "pressure_pa", "asked_volume_flow_m3_s",
)  # fmt: skip
"""gas.csv of a run, which the solver writes: a row per inlet or outlet and written time."""

CROSSINGS = (
    "time_s", "plane", "height_m", "direction", "material", "id", "diameter_m", "n_particle",
)  # fmt: skip
"""crossings.csv of a run, which the solver writes: a row per crossing of a plane."""

RANKS = (
    "rank", "cells", "particles", "particle_steps", "ghost_steps", "shared_islands", "exchanges",
    "exchange_s", "sent_bytes",
)  # fmt: skip
"""ranks.csv of a run, which the solver writes: a row per processor."""

_CLASS = ("material", "diameter_low_m", "diameter_high_m")
PLANES = ("plane", "height_m", *_CLASS, "up_number", "up_kg", "down_number", "down_kg")
ZONES = ("zone", "low_m", "high_m", *_CLASS, "residence_time_s", "holdup_kg_s")
STAGES = (
    *_CLASS, "parcels", "steps", "step_up", "step_up_after_up", "step_up_after_down",
    "partition_by_stages", "partition_by_memory", "partition", "partition_error",
)  # fmt: skip

GAS = ("gas_velocity_m_s", *PATCH_FLOWS[1:])
SUMMARY = (
    "gas_velocity_m_s", "material", "d25_m", "d50_m", "d50_low_m", "d50_high_m", "d75_m",
    "sharpness", "ecart_probable_m", "bypass", "fines_yield", "mass_closure_error",
    "particles_fed", "particles_lost", "wall_time_s", "warnings", "d50_model_error",
)  # fmt: skip
LATER = ("warnings", "d50_model_error")
"""Columns of summary.csv that results of before do not have."""
FIRST = tuple(name for name in SUMMARY if name not in LATER)
"""Those that all results have."""
PARTITION = (
    "gas_velocity_m_s", "material", "diameter_low_m", "diameter_high_m", "diameter_m", "feed_kg",
    "fines_kg", "coarse_kg", "inside_kg", "partition_to_coarse", "ci_low", "ci_high",
)  # fmt: skip
PRODUCTS = (
    "gas_velocity_m_s", "product", "material", "mass_kg", "mass_low_kg", "mass_high_kg", "yield",
    "yield_low", "yield_high", "recovery", "recovery_low", "recovery_high", "grade", "grade_low",
    "grade_high", "d10_m", "d10_low_m", "d10_high_m", "d50_m", "d50_low_m", "d50_high_m", "d90_m",
    "d90_low_m", "d90_high_m",
)  # fmt: skip
PRODUCT_PARTITION = (
    "gas_velocity_m_s", "material", "product", "diameter_low_m", "diameter_high_m", "diameter_m",
    "product_kg", "partition", "ci_low", "ci_high", "cumulative",
)  # fmt: skip
FIT = (
    "gas_velocity_m_s", "material", "rank", "model", "d50_without_bypass_m", "shape", "bypass",
    "log_likelihood", "aic", "p_value", "events", "d25_low_m", "d25_high_m", "d50_low_m",
    "d50_high_m", "d75_low_m", "d75_high_m", "sharpness_low", "sharpness_high",
)  # fmt: skip
CURVE = (
    "gas_velocity_m_s", "material", "diameter_m", "partition_to_coarse", "ci_low", "ci_high",
)  # fmt: skip
THEORY = ("gas_velocity_m_s", "material", "law", "cut_size_m")
COMPARISON = (
    "diameter_low_m", "diameter_high_m", "diameter_m", "measured", "measured_low", "measured_high",
    "ours", "ours_low", "ours_high", "difference", "standardised_difference",
)  # fmt: skip
"""comparison.csv: a row per size of a measurement."""

# of the csv files beside the figures, without the columns of the settings
PARTITION_FIGURE = (
    "material", "diameter_low_m", "diameter_high_m", "diameter_m", "partition_to_coarse", "ci_low",
    "ci_high", "curve_mean",
)  # fmt: skip
CUT_SIZE_FIGURE = ("material", "d25_m", "d50_m", "d50_low_m", "d50_high_m", "d75_m")
SIZE_FIGURE = ("diameter_low_m", "diameter_high_m", "feed_per_decade")
CONTOUR_FIGURE = ("material", "d50_m", "fines_yield")


VELOCITY = "gas_velocity_m_s"


def axes(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """The settings that rows have as columns beside the gas velocity: FILE:ENTRY."""
    return list(dict.fromkeys(name for row in rows for name in row if ":" in name))


def setting(row: Mapping[str, Any]) -> tuple[Any, ...]:
    """What a row's run was given: gas velocity, then its other settings."""
    return (row[VELOCITY], *(row[name] for name in axes([row])))


def product_names(
    partition: Sequence[Mapping[str, Any]], product_partition: Sequence[Mapping[str, Any]]
) -> dict[str, str]:
    """What a case calls the product of the curve, `coarse` in partition.csv, and all the others
    together, `fines` there. By their masses; as they are where product_partition.csv is empty."""
    masses: dict[str, float] = {}
    for row in product_partition:
        if row["material"] == "all":
            masses[row["product"]] = masses.get(row["product"], 0.0) + row["product_kg"]
    if not masses:
        return {"fines": "fines", "coarse": "coarse"}
    mass = sum(row["coarse_kg"] for row in partition if row["material"] == "all")
    coarse = min(reversed(masses), key=lambda name: abs(masses[name] - mass))
    return {"fines": " + ".join(name for name in masses if name != coarse), "coarse": coarse}


def short(name: str) -> str:
    """FILE:ENTRY without what the eye can do without: `loading`, `quartz/density`."""
    entry = name.rpartition(":")[2]
    return "/".join(part for part in entry.split("/")[-2:] if part != "materials")


def title(row: Mapping[str, Any]) -> str:
    """`5 m/s`, `5 m/s, loading 0.2`."""
    varied = [f"{short(name)} {shown(row[name])}" for name in axes([row])]
    return ", ".join([f"{shown(row[VELOCITY])} m/s", *varied])


def shown(value: Any) -> str:
    """A cell as it is read: `0.2`, `evenSizes`; whole numbers with all their digits."""
    if not isinstance(value, (int, float)):
        return str(value)
    return f"{value:.15g}" if float(value).is_integer() else f"{value:g}"
