"""A bed packed by our own contacts: its pressure drop is Ergun's, at the void fraction that it has.

Beside walls a packing is looser, and gas goes there: the manual says by how much.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from elutria_validation.harness.box import BoxCase, Contacts, Material, Pair
from elutria_validation.harness.cases import CLOUD, read_gas, solve, times
from elutria_validation.harness.particles import Particles, read_particles

Array = NDArray[np.float64]

SIZE, ACROSS, SPHERES, FREE, CELL = 1e-3, 8, 1100, 8, 2  # m, then in diameters
DENSITY, NU, VELOCITY = 10.0, 1.5e-4, 1.5  # kg/m3, m2/s, m/s
SIDE = ACROSS * SIZE


def ergun(velocity: Array, void: Array) -> Array:
    """Pa/m at a superficial velocity; Ergun 1952."""
    viscous = 150 * (1 - void) ** 2 / void**3 * DENSITY * NU * velocity / SIZE**2
    return viscous + 1.75 * (1 - void) / void**3 * DENSITY * velocity**2 / SIZE


def packed(folder: Path, sides: str) -> Array:
    """Centres of spheres that fell and came to rest, m."""
    random = np.random.default_rng(1)
    across = int(ACROSS / 1.15)
    layers = -(-SPHERES // across**2)
    grid = np.indices((layers, across, across)).reshape(3, -1).T[:SPHERES, ::-1] + 0.5
    centres = grid * [SIDE / across, SIDE / across, 1.15 * SIZE]
    centres = centres + random.uniform(-0.06, 0.06, centres.shape) * SIZE
    contacts = Contacts(Pair(0.3, 0.3), treatment="soft", particle=Material(5e6))
    case = BoxCase(width=SIDE, depth=SIDE, height=np.ceil(1.2 * layers) * SIZE, sides=sides,
                   ends="wall", step=5e-4, end=0.12, contacts=contacts,
                   forces={"gravity": {}}).make(
        folder, Particles.of(centres, random.uniform(-0.2, 0.2, centres.shape), diameter=SIZE)
    )  # fmt: skip
    solve(case)
    return read_particles(case, times(case)[-1]).position


def void_between(centres: Array, low: float, high: float) -> float:
    """Of the whole section between two heights (m), from the spheres' caps."""

    def below(height: float) -> Array:
        t = np.clip((height - centres[:, 2]) / (SIZE / 2), -1, 1)
        return np.pi * (SIZE / 2) ** 3 * (2 / 3 + t - t**3 / 3)

    return float(1 - np.sum(below(high) - below(low)) / (SIDE**2 * (high - low)))


@pytest.mark.slow
@pytest.mark.parametrize(("sides", "short"), [("cyclic", 0.06), ("wall", 0.14)])
def test_pressure_drop_is_that_of_the_void_fraction(
    tmp_path: Path, measured, sides: str, short: float
) -> None:
    centres = packed(tmp_path / "pack", sides)
    top = centres[:, 2].max() / SIZE
    layers = int(np.ceil(top / CELL)) + 2 * FREE // CELL
    step = CELL * SIZE / VELOCITY
    case = BoxCase(width=SIDE, depth=SIDE, height=layers * CELL * SIZE, sides=sides,
                   cells=(ACROSS // CELL, ACROSS // CELL, layers), gas_velocity=VELOCITY, gravity=0,
                   gas_density=DENSITY, gas_viscosity=NU, solve_gas=True, coupled=True,
                   most_solids=0.9, forces={"GidaspowDrag": {"alphac": "alpha.air"}},
                   tolerance=(1e-9, 1e-4), step=step, end=60 * step,
                   more={f"{CLOUD}:solution/interpolationSchemes/DUcDt": "cell"}).make(
        tmp_path / "flow",
        Particles.of(centres + np.array([0, 0, FREE * SIZE]), diameter=SIZE, density=1e12),
    )  # fmt: skip
    solve(case)

    end = times(case)[-1]
    pressure, void = (
        read_gas(case, end, name)[:, 0].reshape(layers, -1) for name in ("p", "alpha.air")
    )
    speed = read_gas(case, end)[:, 2].reshape(layers, -1)
    low, high = FREE // CELL + 2, FREE // CELL + int(top - 5) // CELL
    here = slice(low, high + 1)
    weights = np.ones(high + 1 - low)
    weights[[0, -1]] = 0.5
    weights /= weights.sum()
    drop = DENSITY * (pressure[low].mean() - pressure[high].mean()) / ((high - low) * CELL * SIZE)

    # what the drag sees is the spheres' volume, and its sum is the pressure drop
    exact = void_between(centres, (low + 0.5) * CELL * SIZE - FREE * SIZE,
                         (high + 0.5) * CELL * SIZE - FREE * SIZE)  # fmt: skip
    measured("void fraction of the drag", abs(weights @ void[here].mean(1) - exact), 0.006)
    law = weights @ ergun(speed[here] * void[here], void[here]).mean(1)
    measured("pressure drop over the law's in the cells", abs(drop / law - 1), 0.02)

    # less than Ergun's at the mean, since gas goes where the bed is loose
    missing = 1 - drop / float(ergun(np.array(VELOCITY), np.array(exact)))
    measured("missing of Ergun's at the mean void fraction", missing, short)
    assert missing > -0.01
