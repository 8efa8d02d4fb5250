"""Cases in general: entries changed, feeds and fields written, the solver run, results read."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from foamlib import FoamFile
from numpy.typing import ArrayLike, NDArray

from elutria.errors import ElutriaError
from elutria.openfoam.started import started_in
from elutria_validation.harness.particles import HEADER
from elutria_validation.harness.programs import run_program

Array = NDArray[np.float64]
Settings = Mapping[str, Any]
"""FILE:ENTRY of a case (nested entries as a/b/c), and its value."""

CLOUD = "constant/kinematicCloudProperties"
MODELS = f"{CLOUD}:subModels"
CONTACTS = f"{MODELS}/cellListCoeffs"
PARAMETERS = "system/simulationParameters"
CONTROL = "system/controlDict"
PLAN = "system/scenePlan"
SOLUTION = "system/fvSolution"


def change(case: Path, settings: Settings) -> None:
    """Give entries of a case other values; a mapping makes a dictionary."""
    by_file: dict[str, dict[Any, Any]] = {}
    for name, value in settings.items():
        file, _, entry = name.partition(":")
        by_file.setdefault(file, {})[tuple(entry.split("/"))] = value
    for file, entries in by_file.items():
        with FoamFile(case / file) as dictionary:
            for keys, value in entries.items():
                dictionary[keys] = value


def timing(step: float, end: float) -> dict[str, Any]:
    """Steps of `step` s until `end` s, written at the end."""
    return {f"{CONTROL}:deltaT": step, f"{CONTROL}:endTime": end, f"{CONTROL}:writeInterval": end}


def solve(
    case: Path,
    processors: int = 1,
    solver: str = "elutriaFoam",
    options: Sequence[str] = (),
) -> str:
    """Run the solver with its `options` in `case`; its output, also kept in log.SOLVER. Raises
    ElutriaError with the solver's reason."""
    if processors > 1:
        decompose(case)
    return solve_decomposed(case, processors, solver, options)


def decompose(case: Path) -> None:
    """Cut a case into the pieces of its decomposeParDict, in place of those there are."""
    run_program(["decomposePar", "-force"], case)
    # decomposePar turns positions into coordinates and forgets to say so
    for file in case.glob("processor*/*/uniform/lagrangian/*/cloudProperties"):
        change(file.parent, {f"{file.name}:geometry": "coordinates"})


def solve_decomposed(
    case: Path, processors: int, solver: str = "elutriaFoam", options: Sequence[str] = ()
) -> str:
    """solve() of a case that has been cut into pieces already."""
    command = [solver]
    if processors > 1:
        command = ["mpirun", "-np", str(processors), solver, "-parallel"]
    with started_in(case, [*command, *options]) as placed:
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


def read_gas(case: Path, time: str, name: str = "U.air") -> Array:
    """Values of an ASCII cell field at a time, shape (n, 1 or 3); one row where it is uniform."""
    value = np.asarray(FoamFile(case / time / name)["internalField"], dtype=float)
    width = 3 if value.shape[-1:] == (3,) else 1
    return value.reshape(-1, width)


def cell_centres(case: Path) -> tuple[Array, dict[str, Array]]:
    """Centres of the cells (n, 3), and of the faces of each patch, m."""
    # Debian 13's own cannot start a function object: solver/coupling/foam/sha1Stream.C
    preload = ["env", "LD_PRELOAD=libelutriaCollision.so"]
    run_program([*preload, "postProcess", "-func", "writeCellCentres", "-time", "0"], case)
    with FoamFile(case / "0/C") as centres:
        boundary: Any = centres["boundaryField"]
        patches = {
            name: np.asarray(patch["value"], dtype=float)
            for name, patch in boundary.items()
            if "value" in patch
        }
        inside = np.asarray(centres["internalField"], dtype=float)
    for name in ("C", "Cx", "Cy", "Cz"):
        (case / "0" / name).unlink()
    return inside, patches


def material(density: float, **sizes: Any) -> dict[str, Any]:
    """The `materials` of a feed of one material (kg/m3), called solid; `sizes` as in the file."""
    return {"solid": {"density": density, "massFraction": 1, "sizeDistribution": sizes}}


def uniform(density: float, smallest: float, largest: float) -> dict[str, Any]:
    """A material whose sizes (m) are uniform by number."""
    return material(density, type="uniform", min=smallest, max=largest, weighting="number")


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
    if "zone" not in feed:
        usual["patch"] = "west"
    (case / "constant/feed").write_text(HEADER.format("dictionary", "constant", "feed"))
    change(case, {f"constant/feed:{name}": value for name, value in {**usual, **feed}.items()})
    change(case, {f"{MODELS}/injectionModels": {"feed": {"type": "feed"}}})


def add_zone(case: Path, name: str, low: ArrayLike, high: ArrayLike) -> None:
    """Name the cells whose centres lie in a box (m) a cell zone."""
    corners = " ".join(f"({x:g} {y:g} {z:g})" for x, y, z in (np.asarray(low), np.asarray(high)))
    (case / "system/topoSetDict").write_text(
        HEADER.format("dictionary", "system", "topoSetDict")
        + "actions (\n"
        + f"{{ name set; type cellSet; action new; source boxToCell; box {corners}; }}\n"
        + f"{{ name {name}; type cellZoneSet; action new; source setToCellZone; set set; }}\n);\n"
    )
    run_program(["topoSet"], case)


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


WALL_FUNCTIONS = {"k": "kqRWallFunction", "epsilon": "epsilonWallFunction",
                  "nut": "nutkWallFunction"}  # fmt: skip


def set_turbulence(
    case: Path, k: ArrayLike, epsilon: ArrayLike, wall_functions: bool = False
) -> None:
    """Turbulence by the k-epsilon model's fields (m2/s2, m2/s3), one value per cell or for all;
    where the gas is solved, walls have a boundary layer by `wall_functions`."""
    per_time = {"k": -2, "epsilon": -3, "nut": -1}
    for name, values in {"k": k, "epsilon": epsilon, "nut": 0.0}.items():
        path = case / f"0/{name}.air"
        path.write_text(HEADER.format("volScalarField", "0", f"{name}.air"))
        with FoamFile(path) as field:
            field["dimensions"] = FoamFile.DimensionSet(length=2, time=per_time[name])
            one_or_each: Any = np.asarray(values) if np.ndim(values) else values
            field["internalField"] = one_or_each
            kind: Any = {"type": "calculated", "value": 0}
            if name != "nut":
                kind = {"type": "zeroGradient"}
            field["boundaryField"] = {
                **{group: kind for group in ("wall", "inflow", "outflow")},
                **({"wall": {"type": WALL_FUNCTIONS[name], "value": 0}} if wall_functions else {}),
                "cyclic": {"type": "cyclic"},
                "symmetry": {"type": "symmetry"},
            }
    model = {"RASModel": "kEpsilon", "turbulence": True, "printCoeffs": False}
    turbulence = "constant/turbulenceProperties.air"
    change(case, {f"{turbulence}:simulationType": "RAS", f"{turbulence}:RAS": model})
