"""Particles as arrays, and the files of OpenFOAM's cloud that hold them. SI units."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

HEADER = 'FoamFile {{ version 2.0; format ascii; class {0}; location "{1}"; object {2}; }}\n\n'
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|nan|inf)")


@dataclass
class Particles:
    """Position (m), velocity (m/s) and spin (rad/s), shape (n, 3); diameter (m) and density
    (kg/m3), shape (n,)."""

    position: Array
    velocity: Array
    spin: Array
    diameter: Array
    density: Array

    @classmethod
    def of(
        cls,
        position: ArrayLike,
        velocity: ArrayLike = 0.0,
        spin: ArrayLike = 0.0,
        diameter: ArrayLike = 1e-3,
        density: ArrayLike = 2650.0,
    ) -> Particles:
        """From whatever numpy can spread to the positions' shape (n, 3)."""
        where = np.atleast_2d(np.asarray(position, dtype=float))

        def spread(values: ArrayLike, shape: tuple[int, ...]) -> Array:
            return np.array(np.broadcast_to(np.asarray(values, dtype=float), shape))

        number = where.shape[:1]
        return cls(
            where,
            spread(velocity, where.shape),
            spread(spin, where.shape),
            spread(diameter, number),
            spread(density, number),
        )

    @property
    def mass(self) -> Array:
        """Mass of each, kg."""
        return self.density * pi / 6 * self.diameter**3

    @property
    def inertia(self) -> Array:
        """Moment of inertia of each, kg m2."""
        return self.mass * self.diameter**2 / 10

    @property
    def momentum(self) -> Array:
        """Of all together, kg m/s, shape (3,)."""
        return np.asarray(self.mass @ self.velocity)

    @property
    def kinetic_energy(self) -> float:
        """Of all together with their spin, J."""
        linear = self.mass @ np.sum(self.velocity**2, axis=1)
        return float(0.5 * (linear + self.inertia @ np.sum(self.spin**2, axis=1)))


def lattice(number: int, side: float) -> Array:
    """Places (n, 3) in a cube of `side` (m), as far apart as can be."""
    across = int(np.ceil(round(number ** (1 / 3), 9)))
    grid = np.stack(np.meshgrid(*[np.arange(across)] * 3), axis=-1).reshape(-1, 3)
    return np.asarray((grid[:number] + 0.5) / across * side)


def write_particles(case: Path, particles: Particles, time: str = "0") -> None:
    """The particles as the cloud of a time folder; number i has origId i."""
    folder = case / time / "lagrangian/kinematicCloud"
    folder.mkdir(parents=True)
    n = len(particles.diameter)

    def write(name: str, kind: str, content: str) -> None:
        header = HEADER.format(kind, f"{time}/lagrangian/kinematicCloud", name)
        (folder / name).write_text(header + content + "\n")

    def scalars(values: Array) -> str:
        return f"{n}\n(\n" + "\n".join(repr(float(v)) for v in values) + "\n)"

    def vectors(values: Array, suffix: str = "") -> str:
        rows = (f"({x!r} {y!r} {z!r}){suffix}" for x, y, z in values.tolist())
        return f"{n}\n(\n" + "\n".join(rows) + "\n)"

    write("positions", "Cloud<basicKinematicCollidingParcel>", vectors(particles.position, " -1"))
    write("origId", "labelField", f"{n}\n(\n" + "\n".join(map(str, range(n))) + "\n)")
    for name, value in {"origProcId": 0, "active": 1, "typeId": 0}.items():
        write(name, "labelField", f"{n}{{{value}}}")
    for name, value in {"nParticle": 1, "age": 0, "tTurb": 0}.items():
        write(name, "scalarField", f"{n}{{{value}}}")
    for name in ("f", "torque", "UTurb", "UCorrect"):  # UCorrect: read from v2012 on
        write(name, "vectorField", f"{n}{{(0 0 0)}}")
    for name, numbers in {
        "d": particles.diameter, "dTarget": particles.diameter, "rho": particles.density
    }.items():  # fmt: skip
        write(name, "scalarField", scalars(numbers))
    write("U", "vectorField", vectors(particles.velocity))
    turning = particles.inertia[:, None] * particles.spin
    write("angularMomentum", "vectorField", vectors(turning))
    for name, kind in {
        "PairAccessed": "label", "PairOrigProcOfOther": "label", "PairOrigIdOfOther": "label",
        "PairData": "vector", "WallAccessed": "label", "WallPRel": "vector", "WallData": "vector",
    }.items():  # fmt: skip
        write(f"collisionRecords{name}", f"{kind}FieldCompactField", f"{n + 1}{{0}}\n0()")

    # without it OpenFOAM looks for barycentric `coordinates`
    properties = case / time / "uniform/lagrangian/kinematicCloud/cloudProperties"
    properties.parent.mkdir(parents=True)
    properties.write_text(
        HEADER.format("dictionary", properties.parent.relative_to(case), properties.name)
        + f"geometry positions;\nprocessor0 {{ particleCount {n}; }}\n"
    )


def read_particles(case: Path, time: str) -> Particles:
    """The cloud as written at a time, in order of origId; none where OpenFOAM wrote no file."""
    folder = case / time / "lagrangian/kinematicCloud"
    if not (folder / "origId").is_file():
        return Particles.of(np.empty((0, 3)))
    order = np.argsort(_read(folder / "origId", 1)[:, 0])
    found = Particles.of(
        _read(folder / "positions", 4)[order, :3],
        _read(folder / "U", 3)[order],
        0.0,
        _read(folder / "d", 1)[order, 0],
        _read(folder / "rho", 1)[order, 0],
    )
    found.spin = _read(folder / "angularMomentum", 3)[order] / found.inertia[:, None]
    return found


def _read(path: Path, width: int) -> Array:
    """An ASCII list of n entries of `width` numbers, also when written n{value}."""
    body = path.read_text().partition("}")[2]
    count, *values = _NUMBER.findall(body)
    table = np.array([float(value) for value in values]).reshape(-1, width)
    return np.broadcast_to(table, (int(count), width)) if len(table) == 1 else table
