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
