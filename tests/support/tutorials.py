"""Tutorials of the OpenFOAM installation that DPMFoam solves, or would with a collision model."""

from __future__ import annotations

import gzip
import os
import re
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from elutria_validation.harness.cases import CLOUD, CONTROL, MODELS, change, read_gas, solve, times
from elutria_validation.harness.programs import run_program

ROOTS = (
    Path(os.environ.get("FOAM_TUTORIALS", "/nowhere")),
    Path("/usr/share/doc/openfoam-examples/examples"),
)
STEPS = 50


def tutorials() -> Path | None:
    """The folder of the installation's tutorials, if there is one."""
    return next((root for root in ROOTS if (root / "lagrangian/DPMFoam").is_dir()), None)


@dataclass(frozen=True)
class Tutorial:
    """What of a tutorial is not taken as it stands: `cells` replace its numbers of cells."""

    name: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    cells: Mapping[str, str] = field(default_factory=dict)
    surface: str = ""
    """Its surface among the tutorials' geometries."""
    steps: int = STEPS


def springs(size: float, modulus: float) -> dict[str, Any]:
    """Stock's spring, slider and dashpot instead of MPPICFoam's models."""
    law = {"useEquivalentSize": False, "alpha": 0.02, "b": 1.5, "mu": 0.1,
           "cohesionEnergyDensity": 0, "collisionResolutionSteps": 12}  # fmt: skip
    wall = {**law, "youngsModulus": modulus, "poissonsRatio": 0.3}
    pairs = {"maxInteractionDistance": size, "writeReferredParticleCloud": False, "U": "U.air",
             "pairModel": "pairSpringSliderDashpot", "pairSpringSliderDashpotCoeffs": law,
             "wallModel": "wallSpringSliderDashpot",
             "wallSpringSliderDashpotCoeffs": wall}  # fmt: skip
    off = dict.fromkeys(("packingModel", "dampingModel", "isotropyModel"), "none")
    return {
        **{f"{MODELS}/{name}": value for name, value in off.items()},
        f"{MODELS}/collisionModel": "pairCollision",
        f"{MODELS}/pairCollisionCoeffs": pairs,
        f"{CLOUD}:constantProperties/youngsModulus": modulus,
        f"{CLOUD}:constantProperties/poissonsRatio": 0.3,
    }


def made(tutorial: Tutorial, root: Path, folder: Path) -> Path:
    """The tutorial, meshed, that ends after its steps; its compressed cloud is unpacked."""
    shutil.copytree(root / "lagrangian" / tutorial.name, folder)
    packed = folder / f"{CLOUD}.gz"
    if packed.is_file():
        (folder / CLOUD).write_bytes(gzip.decompress(packed.read_bytes()))
        packed.unlink()
    plan = folder / "system/blockMeshDict"
    for old, new in tutorial.cells.items():
        text = plan.read_text()
        assert text.count(old) == 1
        plan.write_text(text.replace(old, new))
    if tutorial.surface:
        surface = root / "resources/geometry" / tutorial.surface
        (folder / "constant/triSurface").mkdir(exist_ok=True)
        shutil.copy(surface, folder / "constant/triSurface")
    run_program(["blockMesh"], folder)
    if tutorial.surface:
        run_program(["snappyHexMesh", "-overwrite"], folder)
    step = float(re.findall(r"^deltaT\s+(\S+);", (folder / CONTROL).read_text(), re.M)[0])
    change(folder, {f"{CONTROL}:endTime": tutorial.steps * step,
                    f"{CONTROL}:writeInterval": tutorial.steps * step,
                    f"{CONTROL}:writeFormat": "ascii", f"{CONTROL}:writePrecision": 12,
                    **tutorial.settings})  # fmt: skip
    return folder


@dataclass(frozen=True)
class Outcome:
    """Of a run: parcels and mass (kg) inside, parcels and mass that came in, parcels that left,
    mean pressure over density (m2/s2) and its fall from the first to the last cells, mean share of
    solids in the cells."""

    parcels: int
    mass: float
    fed: int
    fed_mass: float
    escaped: int
    pressure: float
    fall: float
    solids: float


def _last(text: str, name: str) -> float:
    return float(re.findall(rf"{name} += ([-+.\de]+)", text)[-1])


def outcome(case: Path, solver: str) -> Outcome:
    """Run `case` with `solver`."""
    log = solve(case, solver=solver)
    last = times(case)[-1]
    p, alpha = (read_gas(case, last, name)[:, 0] for name in ("p", "alpha.air"))
    layer = max(len(p) // 40, 1)
    return Outcome(
        parcels=int(_last(log, "Current number of parcels")),
        mass=_last(log, "Current mass in system"),
        fed=sum(map(int, _of_last_step(log, r"- parcels added += (\d+)"))),
        fed_mass=sum(map(float, _of_last_step(log, r"- mass introduced += (\S+)"))),
        escaped=sum(map(int, _of_last_step(log, r"- escape +[^\n]*= (\d+),"))),
        pressure=float(np.mean(p)),
        fall=float(np.mean(p[:layer]) - np.mean(p[-layer:])),
        solids=float(np.mean(1 - alpha)),
    )


def _of_last_step(log: str, pattern: str) -> list[str]:
    return re.findall(pattern, log.rpartition("Cloud:")[2])
