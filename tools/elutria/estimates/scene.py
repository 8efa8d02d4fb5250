"""What a case's numbers lead one to expect, from closed forms: nothing is run. SI units.

The estimates are of the right order, no more: they say which parts of the work will matter, and the
solver measures the rest while it runs (system/scenePlan).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nan, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria.case.case import Case
from elutria.case.feed import Feed
from elutria.errors import InputError
from elutria.physics.drag import Gas, terminal_velocity

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Box:
    """Extent (m) of a blockMesh along x, y, z, and its smallest and largest mean cell edge (m)."""

    size: Array
    smallest_cell: float
    largest_cell: float


def block_mesh_box(case: Case) -> Box | None:
    """From system/blockMeshDict; None when it is not there or not made of plain hex blocks."""
    if not (case.path / "system/blockMeshDict").is_file():
        return None
    try:
        entries = case.dictionary("system/blockMeshDict", with_included=True)
        scale = entries.number("scale", entries.number("convertToMeters", 1.0))
        points = np.array(entries.raw("vertices"), dtype=float) * scale
        edges = _cell_edges(entries.raw("blocks"), points)
    except (InputError, ValueError, TypeError, IndexError):
        return None
    if points.ndim != 2 or points.shape[1] != 3 or not edges or not min(edges) > 0:
        return None
    return Box(np.ptp(points, axis=0), min(edges), max(edges))


def _cell_edges(blocks: list[Any], points: Array) -> list[float]:
    """Mean cell edges of `hex (8 corners) (cells) ...` along the three directions of each block."""
    edges = []
    for place, word in enumerate(blocks):
        if word == "hex":
            corners, counts = blocks[place + 1], blocks[place + 2]
            for end, count in zip((1, 3, 4), counts, strict=True):
                side = points[int(corners[end])] - points[int(corners[0])]
                edges.append(float(np.linalg.norm(side)) / int(count))
    return edges


@dataclass(frozen=True)
class Scene:
    """Expected numbers of a run; nan where the column's size is not known beforehand."""

    feed_rate: float  # kg/s
    parcels: int | None  # fed in all; None: until the feed's time is over
    particle_rate: float  # 1/s
    residence: float  # s, mean over the particles, of half the column
    inside: float  # particles
    solids_fraction: float  # of the column's volume
    collision_time: float  # s between two collisions of a particle
    gas_change: float  # change of the gas velocity by the particles, relative
    shortest_relaxation: float  # s
    longest_relaxation: float  # s
    fastest_fall: float  # m/s

    @property
    def collisions(self) -> float:
        """Expected collisions of a particle with others before it leaves."""
        return self.residence / self.collision_time


def expect(case: Case, velocity: float, gas: Gas, feed: Feed, box: Box | None) -> Scene:
    """The scene of a case at a gas velocity (m/s)."""
    gravity, law = case.gravity(), case.theory_law()
    sizes, falls = [], []
    for material in feed.materials:
        diameter = material.sizes.number_quantile(np.linspace(0.01, 0.99, 25))
        sizes.append(diameter)
        falls.append(
            [
                terminal_velocity(d, material.density, gas, law, material.sphericity, gravity)
                if material.density > gas.density
                else 0.0
                for d in diameter.tolist()
            ]
        )
    fall, diameter = np.concatenate(falls), np.concatenate(sizes)
    height, area = _column(case, box)
    gas_flow = gas.density * velocity * area
    rate = feed.mass_flow_rate or (feed.loading or 0.0) * gas_flow
    number_rate = rate / feed.mean_particle_mass()
    # the slowest take as long as their own spread allows: no drift is below a tenth of the gas
    drift = np.maximum(np.abs(velocity - fall), 0.1 * velocity)
    residence = float(np.mean(0.5 * height / drift))
    inside = number_rate * residence
    density = inside / (area * height)
    slip = float(np.std(fall))
    cross_section = pi * float(np.mean(diameter**2))
    return Scene(
        feed_rate=rate,
        parcels=feed.parcels_fed(rate, rate / gas_flow),
        particle_rate=number_rate,
        residence=residence,
        inside=inside,
        solids_fraction=density * pi / 6 * float(np.mean(diameter**3)),
        collision_time=1 / (density * cross_section * slip) if slip > 0 else inf,
        gas_change=rate * residence * gravity / (gas_flow * velocity),
        shortest_relaxation=float(np.min(fall)) / gravity,
        longest_relaxation=float(np.max(fall)) / gravity,
        fastest_fall=float(np.max(fall)),
    )


def _column(case: Case, box: Box | None) -> tuple[float, float]:
    """Height (m) along gravity and section (m2) of the mesh's box."""
    if box is None:
        return nan, nan
    gravity = np.abs(case.dictionary("constant/g").numbers("value", 3))
    up = int(np.argmax(gravity))
    return float(box.size[up]), float(np.prod(np.delete(box.size, up)))
