"""What needs no simulation: closed forms for the partition in a vertical gas stream.

SI units. `U` gas velocity, `v_t` terminal velocity of a size.
"""

from __future__ import annotations

from math import nan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elutria import tables
from elutria.case.case import Case
from elutria.errors import InputError
from elutria.files import write_csv
from elutria.physics.drag import plug_flow_cut_size

Array = NDArray[np.float64]


def pipe_fines_share(terminal: ArrayLike, velocity: float) -> Array:
    """Laminar round pipe, feed uniform over the section, no lateral motion: 1 - v_t/(2U)."""
    return np.clip(1 - np.asarray(terminal) / (2 * velocity), 0, 1)


def channel_fines_share(terminal: ArrayLike, velocity: float) -> Array:
    """Laminar plane channel, fed and moving likewise: sqrt(1 - v_t/(1.5 U))."""
    return np.sqrt(np.clip(1 - np.asarray(terminal) / (1.5 * velocity), 0, 1))


def drift_dispersion_fines_share(
    terminal: ArrayLike, velocity: float, height: float, length: float, dispersion: float
) -> Array:
    """Drift w = U - v_t with axial dispersion D (m2/s) between absorbing ends.

    (1 - exp(-w x0/D))/(1 - exp(-w L/D)) for a feed at `height` x0 of `length` L (m).
    """
    w = velocity - np.asarray(terminal, dtype=float)
    peclet = w * length / dispersion
    feed = height / length
    # written with whichever exponentials stay below 1; at w = 0 the limit x0/L
    safe = np.where(np.abs(peclet) < 1e-9, 1.0, peclet)
    rising = np.expm1(-np.abs(safe) * feed) / np.expm1(-np.abs(safe))
    falling = np.exp(-np.abs(safe) * (1 - feed)) * rising
    return np.where(np.abs(peclet) < 1e-9, feed, np.where(peclet > 0, rising, falling))


def cut_sizes(case: Case, velocities: list[float]) -> list[dict[str, Any]]:
    """Rows of theory.csv: the plug-flow cut size of each material over the velocities' range."""
    try:
        gas, law, gravity = case.gas(), case.theory_law(), case.gravity()
        grains = {one.name: case.grain(one) for one in case.feed().materials}
    except InputError:
        return []  # no theory beside the curves where the gas is not known, or the laws not built
    around = np.geomspace(0.8 * min(velocities), 1.25 * max(velocities), 25)
    grid = np.unique([*velocities, *around])
    rows = []
    for name, grain in grains.items():
        for velocity in grid.tolist():
            size = nan
            if grain.density > gas.density:
                size = plug_flow_cut_size(velocity, grain, gas, law, gravity)
            rows.append(
                {
                    "gas_velocity_m_s": velocity,
                    "material": name,
                    "law": law,
                    "cut_size_m": size,
                }
            )
    return rows


def write_theory(case: Case, velocities: list[float], folder: Path) -> None:
    """theory.csv in `folder`, for the figure of cut sizes."""
    write_csv(folder / "theory.csv", tables.THEORY, cut_sizes(case, velocities))
