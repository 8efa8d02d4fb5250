"""OpenFOAM's own fluidised bed, Goldschmidt's: its files for any solver, and what it weighs."""

from __future__ import annotations

import gzip
import os
import shutil
from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elutria.errors import InputError
from elutria_validation.harness.cases import (
    CONTROL,
    MODELS,
    change,
    patch_mean,
    read_patch_mean,
    times,
)
from elutria_validation.harness.particles import read_particles

Array = NDArray[np.float64]


def tutorials() -> Path:
    """OpenFOAM's tutorials: those of the sourced environment, else Debian's examples."""
    return Path(os.environ.get("FOAM_TUTORIALS") or "/usr/share/doc/openfoam-examples/examples")


TUTORIAL = tutorials() / "lagrangian/DPMFoam/Goldschmidt"
STEP = 2e-5  # s, the tutorial's
GAS_DENSITY = 1.2  # kg/m3
SECTION = 0.015 * 0.150  # m2
SPHERES, DIAMETER, DENSITY, GRAVITY = 24750, 2.5e-3, 2526.0, 9.81
WEIGHT = SPHERES * pi / 6 * DIAMETER**3 * (DENSITY - GAS_DENSITY) * GRAVITY / SECTION  # Pa


def copy_tutorial(case: Path) -> Path:
    """The tutorial's files, unpacked, in a folder that is made anew. Raises InputError where it is
    not installed."""
    if not TUTORIAL.is_dir():
        raise InputError(f"{TUTORIAL}: not found; apt-get install openfoam-examples")
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(TUTORIAL, case)
    for packed in case.rglob("*.gz"):
        packed.with_suffix("").write_bytes(gzip.decompress(packed.read_bytes()))
        packed.unlink()
    return case


def make_bed(case: Path, solver: str, step: float, ours: bool = True) -> Path:
    """A copy of the tutorial for a solver and a time step (s), with our contacts or stock's."""
    case = copy_tutorial(case)
    change(
        case,
        {
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:writeControl": "runTime",
            f"{CONTROL}:writeFormat": "ascii",
            f"{CONTROL}:writeCompression": False,
            **patch_mean("bottom", "p"),
            **({f"{MODELS}/collisionModel": "cellList"} if ours else {}),
        },
    )
    if ours and solver == "DPMFoam":
        change(case, {f"{CONTROL}:libs": ['"libelutriaCollision.so"']})
    return case


@dataclass(frozen=True)
class History:
    """A bed's states at the written times (s): momentum upwards (kg m/s), mean height (m); and
    rows of time (s) and pressure drop (Pa) at every step."""

    time: Array
    momentum: Array
    height: Array
    pressure_drop: Array


def read_history(case: Path) -> History:
    """What a run of make_bed()'s case has written."""
    written = [name for name in times(case) if float(name) > 0]
    states = [read_particles(case, name) for name in written]
    return History(
        np.array([float(name) for name in written]),
        np.array([state.momentum[2] for state in states]),
        np.array([state.position[:, 2].mean() for state in states]),
        read_patch_mean(case, "bottom") * (1, GAS_DENSITY),
    )
