"""The columns of every csv file, written once. SI units, named in the columns."""

from __future__ import annotations

EVENTS = (
    "time_s", "outlet", "material", "id", "diameter_m", "density_kg_m3", "n_particle",
    "ux_m_s", "uy_m_s", "uz_m_s", "residence_time_s",
)  # fmt: skip
"""particles.csv and inside.csv, which the solver writes: a row per parcel."""

SUMMARY = (
    "gas_velocity_m_s", "material", "d25_m", "d50_m", "d50_low_m", "d50_high_m", "d75_m",
    "sharpness", "ecart_probable_m", "bypass", "fines_yield", "mass_closure_error",
    "particles_fed", "particles_lost", "wall_time_s",
)  # fmt: skip
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
FIT = (
    "gas_velocity_m_s", "material", "rank", "model", "d50_without_bypass_m", "shape", "bypass",
    "log_likelihood", "aic", "p_value", "events", "d25_low_m", "d25_high_m", "d50_low_m",
    "d50_high_m", "d75_low_m", "d75_high_m", "sharpness_low", "sharpness_high",
)  # fmt: skip
CURVE = (
    "gas_velocity_m_s", "material", "diameter_m", "partition_to_coarse", "ci_low", "ci_high",
)  # fmt: skip
THEORY = ("gas_velocity_m_s", "material", "law", "cut_size_m")

# of the csv files beside the figures, without the columns of the settings
PARTITION_FIGURE = (
    "material", "diameter_low_m", "diameter_high_m", "diameter_m", "partition_to_coarse", "ci_low",
    "ci_high", "curve_mean",
)  # fmt: skip
CUT_SIZE_FIGURE = ("material", "d25_m", "d50_m", "d50_low_m", "d50_high_m", "d75_m")
SIZE_FIGURE = ("diameter_low_m", "diameter_high_m", "feed_per_decade")
