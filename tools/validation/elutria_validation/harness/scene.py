"""A box of gas with given particles: makes the case, runs the solver, reads what came out.

`cases/verification/box` is an ordinary case; a scene is a copy of it with other entries and with
the particles' files in its start time. SI units throughout.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from foamlib import FoamFile
from numpy.typing import ArrayLike, NDArray

from elutria.errors import ElutriaError
from elutria.openfoam.started import started_in
from elutria_validation.harness.common import project_root, run_program

Array = NDArray[np.float64]

CLOUD = "constant/kinematicCloudProperties"
MODELS = f"{CLOUD}:subModels"
CONTACTS = f"{MODELS}/cellListCoeffs"
BOX = "system/simulationParameters"
CONTROL = "system/controlDict"

_HEADER = 'FoamFile {{ version 2.0; format ascii; class {0}; location "{1}"; object {2}; }}\n\n'
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|nan|inf)")


@dataclass
class Particles:
    """Particles as arrays: vectors (n, 3), the others (n,)."""

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


PERIODIC = {
    f"{BOX}:sides": "cyclic",
    f"{BOX}:ends": "cyclic",
    f"{BOX}:bottomGroup": "closed",
    f"{BOX}:topGroup": "closed",
}
"""Settings of a box without walls and without flow through it."""
WEIGHTLESS = {**PERIODIC, f"{BOX}:gravity": 0}


def make_scene(
    folder: Path,
    particles: Particles | None = None,
    settings: Mapping[str, Any] | None = None,
    mesh: str = "blockMeshDict",
) -> Path:
    """Copy cases/verification/box to `folder` and mesh it by its system/MESH.

    `settings` maps FILE:ENTRY to a value (a mapping for a dictionary).
    """
    shutil.copytree(project_root() / "cases/verification/box", folder)
    change(folder, settings or {})
    shutil.copytree(folder / "0.orig", folder / "0")
    if particles is not None:
        write_particles(folder, particles)
    run_program(["blockMesh", "-dict", f"system/{mesh}"], folder)
    return folder


def change(case: Path, settings: Mapping[str, Any]) -> None:
    """Give entries FILE:ENTRY of a case other values; nested ones as a/b/c."""
    for name, value in settings.items():
        file, _, entry = name.partition(":")
        with FoamFile(case / file) as dictionary:
            first, *rest = entry.split("/")
            dictionary[(first, *rest)] = value


def cell_centres(case: Path) -> tuple[Array, dict[str, Array]]:
    """Centres of the cells (n, 3), and of the faces of each patch."""
    run_program(["postProcess", "-func", "writeCellCentres", "-time", "0"], case)
    with FoamFile(case / "0/C") as centres:
        patches = {
            name: np.asarray(patch["value"], dtype=float)
            for name, patch in centres["boundaryField"].items()
            if "value" in patch
        }
        inside = np.asarray(centres["internalField"], dtype=float)
    for name in ("C", "Cx", "Cy", "Cz"):
        (case / "0" / name).unlink()
    return inside, patches


def add_feed(case: Path, feed: Mapping[str, Any]) -> None:
    """Write constant/feed with these entries and let the cloud inject it.

    Unless `feed` says otherwise it enters through the west wall, at rest, with seed 1, and leaves
    for fines at the top and for coarse at the bottom.
    """
    usual: dict[str, Any] = {
        "outlets": {"fines": ["top"], "coarse": ["bottom"]},
        "velocity": [0, 0, 0],
        "start": 0,
        "duration": 1000,
        "seed": 1,
    }
    text = _HEADER.format("dictionary", "constant", "feed")
    (case / "constant/feed").write_text(text)
    if "zone" not in feed:
        usual["patch"] = "west"
    change(case, {f"constant/feed:{name}": value for name, value in {**usual, **feed}.items()})
    change(case, {f"{MODELS}/injectionModels": {"feed": {"type": "feed"}}})


def add_zone(case: Path, name: str, low: ArrayLike, high: ArrayLike) -> None:
    """Name the cells whose centres lie in a box (m) a cell zone."""
    path = case / "system/topoSetDict"
    corners = " ".join(f"({x:g} {y:g} {z:g})" for x, y, z in (np.asarray(low), np.asarray(high)))
    path.write_text(
        _HEADER.format("dictionary", "system", "topoSetDict")
        + "actions (\n"
        + f"{{ name set; type cellSet; action new; source boxToCell; box {corners}; }}\n"
        + f"{{ name {name}; type cellZoneSet; action new; source setToCellZone; set set; }}\n);\n"
    )
    run_program(["topoSet"], case)


def write_particles(case: Path, particles: Particles, time: str = "0") -> None:
    """The particles as the cloud of a time folder; number i has origId i."""
    folder = case / time / "lagrangian/kinematicCloud"
    folder.mkdir(parents=True)
    n = len(particles.diameter)

    def write(name: str, kind: str, content: str) -> None:
        header = _HEADER.format(kind, f"{time}/lagrangian/kinematicCloud", name)
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
        _HEADER.format("dictionary", properties.parent.relative_to(case), properties.name)
        + f"geometry positions;\nprocessor0 {{ particleCount {n}; }}\n"
    )


def patch_mean(patch: str, field: str) -> dict[str, Any]:
    """Settings that write a field's mean over a patch on every step, to postProcessing/PATCH."""
    mean = {
        "type": "surfaceFieldValue",
        "libs": ['"libfieldFunctionObjects.so"'],
        "regionType": "patch",
        "name": patch,
        "operation": "areaAverage",
        "fields": [field],
        "writeFields": False,
        "log": False,
    }
    return {f"{CONTROL}:functions": {patch: mean}}


def read_patch_mean(case: Path, patch: str) -> Array:
    """What patch_mean() wrote in a run: rows of time (s) and mean."""
    found = case.glob(f"postProcessing/{patch}/*/surfaceFieldValue.dat")
    return np.loadtxt(next(found), ndmin=2)


def run_scene(case: Path, processors: int = 1, solver: str = "elutriaFoam") -> str:
    """Run the solver in `case`; its output, also kept in log.SOLVER. Raises ElutriaError."""
    command = [solver]
    if processors > 1:
        run_program(["decomposePar", "-force"], case)
        # decomposePar turns positions into coordinates and forgets to say so
        for file in case.glob("processor*/0/uniform/lagrangian/*/cloudProperties"):
            change(file.parent, {f"{file.name}:geometry": "coordinates"})
        command = ["mpirun", "-np", str(processors), solver, "-parallel"]
    with started_in(case, command) as placed:
        done = subprocess.run(placed, cwd=case, capture_output=True, text=True, check=False)
    (case / f"log.{solver}").write_text(done.stdout + done.stderr)
    if done.returncode != 0:
        reasons = re.findall(r"elutria: failed: (.*)", done.stdout)
        said = reasons[-1] if reasons else f"exit code {done.returncode}"
        raise ElutriaError(f"{solver} failed in {case}: {said}")
    return done.stdout


def times(case: Path) -> list[str]:
    """Names of the written times, in order."""
    names = [
        entry.name for entry in case.iterdir() if re.fullmatch(r"\d+(\.\d+)?(e-?\d+)?", entry.name)
    ]
    return sorted(names, key=float)


def read_particles(case: Path, time: str) -> Particles:
    """The cloud as written at a time, in order of origId."""
    folder = case / time / "lagrangian/kinematicCloud"
    order = np.argsort(_read(folder / "origId", 1)[:, 0])
    positions = _read(folder / "positions", 4)[order, :3]
    found = Particles.of(
        positions,
        _read(folder / "U", 3)[order],
        0.0,
        _read(folder / "d", 1)[order, 0],
        _read(folder / "rho", 1)[order, 0],
    )
    found.spin = _read(folder / "angularMomentum", 3)[order] / found.inertia[:, None]
    return found


def read_gas(case: Path, time: str, name: str = "U.air") -> Array:
    """Values of an ASCII cell field at a time, shape (n, 1 or 3); one row where it is uniform."""
    value = np.asarray(FoamFile(case / time / name)["internalField"], dtype=float)
    width = 3 if value.shape[-1:] == (3,) else 1
    return value.reshape(-1, width)


def _read(path: Path, width: int) -> Array:
    """An ASCII list of n entries of `width` numbers, also when written n{value}."""
    body = path.read_text().partition("}")[2]
    count, *values = _NUMBER.findall(body)
    table = np.array([float(value) for value in values]).reshape(-1, width)
    return np.broadcast_to(table, (int(count), width)) if len(table) == 1 else table


def set_turbulence(case: Path, k: ArrayLike, epsilon: ArrayLike) -> None:
    """Turbulence by the k-epsilon model's fields, one value per cell or one for all."""
    per_time = {"k": -2, "epsilon": -3, "nut": -1}
    for name, values in {"k": k, "epsilon": epsilon, "nut": 0.0}.items():
        path = case / f"0/{name}.air"
        path.write_text(_HEADER.format("volScalarField", "0", f"{name}.air"))
        with FoamFile(path) as field:
            field["dimensions"] = FoamFile.DimensionSet(length=2, time=per_time[name])
            field["internalField"] = values if np.ndim(values) == 0 else np.asarray(values)
            kind = {"type": "calculated", "value": 0} if name == "nut" else {"type": "zeroGradient"}
            field["boundaryField"] = {
                **{group: kind for group in ("wall", "inflow", "outflow")},
                "cyclic": {"type": "cyclic"},
            }
    change(
        case,
        {
            "constant/turbulenceProperties.air:simulationType": "RAS",
            "constant/turbulenceProperties.air:RAS": {
                "RASModel": "kEpsilon", "turbulence": True, "printCoeffs": False,
            },
        },
    )  # fmt: skip
