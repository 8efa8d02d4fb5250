"""A box of gas with given particles: what a scene may vary, with units and defaults.

The files of `harness/box` are an ordinary case; a BoxCase is a copy of it with other entries and
with the particles' files in its start time. SI units throughout.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from elutria_validation.harness.cases import (
    CLOUD,
    CONTACTS,
    CONTROL,
    MODELS,
    PARAMETERS,
    PLAN,
    SOLUTION,
    Settings,
    change,
)
from elutria_validation.harness.particles import Particles, write_particles
from elutria_validation.harness.programs import run_program

ContactLaw = Literal["hertzMindlin", "linearSpringDashpot", "springSliderDashpot"]
GasPlan = bool | Literal["auto"]
"""Whether the gas is solved on every step, left as it is, or as the scene plan decides."""
Treatment = Literal["auto", "soft", "impact"]
TEMPLATE = Path(__file__).with_name("box")


def _entry(default: Any, *places: str) -> Any:
    """A field that stands at these places of the case's files, where `default` is written."""
    return field(default=default, metadata={"places": places})


def _parameter(default: Any, *names: str) -> Any:
    return _entry(default, *(f"{PARAMETERS}:{name}" for name in names))


@dataclass(frozen=True)
class Material:
    """Elasticity: Young's modulus (Pa) and Poisson's ratio."""

    young: float = 1e7
    poisson: float = 0.25

    def entries(self) -> dict[str, float]:
        return {"youngsModulus": self.young, "poissonsRatio": self.poisson}


@dataclass(frozen=True)
class Pair:
    """Two materials in contact: restitution, friction, stiffness (N/m) of the linear law."""

    restitution: float = 0.8
    friction: float = 0.0
    stiffness: float = 1000.0

    def entries(self) -> dict[str, float]:
        return {
            "restitution": self.restitution,
            "friction": self.friction,
            "normalStiffness": self.stiffness,
        }


@dataclass(frozen=True)
class Contacts:
    """Contacts of particles with each other and with walls."""

    pair: Pair = field(default_factory=Pair)
    wall_pair: Pair | None = None  # None: as `pair`
    law: ContactLaw = "hertzMindlin"
    treatment: Treatment = "auto"
    particle: Material = field(default_factory=Material)
    wall: Material | None = None  # None: as `particle`
    step: float | None = None  # s, of a contact; None: the solver's choice
    step_fraction: float | None = None  # contact step over a contact's duration
    more: Mapping[str, Any] = field(default_factory=dict)  # other entries of cellListCoeffs

    def settings(self) -> dict[str, Any]:
        """FILE:ENTRY and value of all of it."""
        entries = {
            "contactLaw": self.law,
            "treatment": self.treatment,
            "particle": self.particle.entries(),
            "wall": (self.wall or self.particle).entries(),
            "particleParticle": self.pair.entries(),
            "particleWall": (self.wall_pair or self.pair).entries(),
            **({} if self.step is None else {"step": self.step}),
            **({} if self.step_fraction is None else {"stepFraction": self.step_fraction}),
            **self.more,
        }
        return {
            f"{MODELS}/collisionModel": "cellList",
            **{f"{CONTACTS}/{name}": value for name, value in entries.items()},
        }


@dataclass(frozen=True)
class BoxCase:
    """A box of gas. A field that keeps its default is left as the files have it."""

    # the box: sizes, cells along x, y, z, blockMesh's grading of them
    width: float = _parameter(0.1, "width")  # m, x
    depth: float = _parameter(0.1, "depth")  # m, y
    height: float = _parameter(0.1, "height")  # m, z
    cells: tuple[int, int, int] = (1, 1, 1)
    grading: Any = field(default=(1, 1, 1), metadata={"places": (f"{PARAMETERS}:grading",)})
    mesh: Literal["blockMeshDict", "pipeMeshDict"] = "blockMeshDict"
    radius: float = _parameter(0.01, "radius")  # m, of the pipe of pipeMeshDict
    pipe_length: float = _parameter(2.0, "pipeLength")  # of it, in radii

    # its faces; `ends` are bottom and top: a patch lets gas in and out
    sides: Literal["wall", "cyclic", "symmetry"] = _parameter("wall", "sides")
    ends: Literal["patch", "wall", "cyclic"] = _parameter("patch", "ends")
    side_velocity: Literal["slip", "noSlip"] = _parameter("slip", "sideVelocity")
    south_north: Literal["plain", "frictionless"] = _parameter("plain", "southNorthGroup")

    # gas and gravity, both along z
    gas_velocity: float = _parameter(0.0, "gasVelocity")  # m/s, superficial, upward
    gas_density: float = _parameter(1.2, "gasDensity")  # kg/m3
    gas_viscosity: float = _parameter(1.5e-5, "gasNu")  # m2/s, kinematic
    gravity: float = _parameter(-9.80665, "gravity")  # m/s2
    gas_by: Literal["cell", "cellPoint"] = _entry(
        "cell", f"{CLOUD}:solution/interpolationSchemes/U.air"
    )

    # what particles do to the gas, and the gas to them
    coupled: bool = _entry(False, f"{CLOUD}:solution/coupled")
    solve_gas: bool | Literal["auto"] = _entry(False, f"{PLAN}:gas")
    converge_gas: bool | Literal["auto"] = _entry(False, f"{PLAN}:convergeGas")
    gas_tolerance: float | None = _entry(None, f"{PLAN}:gasTolerance")
    gas_courant: float | None = _entry(None, f"{PLAN}:gasCourant")
    kernel: float | Literal["auto"] | None = None  # m, width of what spreads a deposit
    undisturbed: bool | None = None  # whether a particle's own wake is corrected for
    most_solids: float = _entry(0.7, f"{CLOUD}:constantProperties/alphaMax")
    forces: Mapping[str, Any] | None = _entry(None, f"{MODELS}/particleForces")
    dispersion: str = _entry("none", f"{MODELS}/dispersionModel")
    contacts: Contacts | None = None

    # steps, end and interval of writing (None: the end), s
    step: float = _entry(1e-3, f"{CONTROL}:deltaT")
    end: float = 1.0
    interval: float | None = None

    # linear solvers: tolerances (None: to round-off) of p and U, relative tolerance of p
    tolerance: tuple[float, float] | None = None
    outer_correctors: int = _entry(1, f"{SOLUTION}:PIMPLE/nOuterCorrectors")

    more: Settings = field(default_factory=dict)  # FILE:ENTRY of what one scene alone needs

    def settings(self) -> dict[str, Any]:
        """FILE:ENTRY and value of what differs from the files."""
        changed: dict[str, Any] = {}
        for one in fields(self):
            value = getattr(self, one.name)
            if value != one.default:
                changed |= dict.fromkeys(one.metadata.get("places", ()), value)
        for name, number in zip(("cellsX", "cellsY", "cellsAlong"), self.cells, strict=True):
            if number != 1:
                changed[f"{PARAMETERS}:{name}"] = number
        if self.ends != "patch":
            changed |= {f"{PARAMETERS}:{end}Group": "closed" for end in ("bottom", "top")}
        if self.kernel is not None:
            changed[f"{CLOUD}:spreading"] = {"width": self.kernel}
        if self.undisturbed is not None:
            changed[f"{CLOUD}:ownWake"] = {"undisturbed": self.undisturbed}
        if self.contacts is not None:
            changed |= self.contacts.settings()
        if self.tolerance is not None:
            changed |= loose_solvers(*self.tolerance)
        changed[f"{CONTROL}:endTime"] = self.end
        changed[f"{CONTROL}:writeInterval"] = self.interval or self.end
        return {**changed, **self.more}

    def make(self, folder: Path, particles: Particles | None = None) -> Path:
        """Write the case to `folder`, which must not exist, and mesh it; gives the folder."""
        shutil.copytree(TEMPLATE, folder)
        change(folder, self.settings())
        shutil.copytree(folder / "0.orig", folder / "0")
        if particles is not None:
            write_particles(folder, particles)
        run_program(["blockMesh", "-dict", f"system/{self.mesh}"], folder)
        return folder


def cube(side: float, cells: int = 1) -> dict[str, Any]:
    """Fields of a cubic box (m)."""
    return {"width": side, "depth": side, "height": side, "cells": (cells, cells, cells)}


PERIODIC: dict[str, Any] = {"sides": "cyclic", "ends": "cyclic"}
"""Fields of a box without walls and without flow through it."""
WEIGHTLESS: dict[str, Any] = {**PERIODIC, "gravity": 0}
CLOSED: dict[str, Any] = {"ends": "wall"}
NO_DRAG: dict[str, Any] = {"gravity": {}}
"""Forces of particles that gas does not move."""


def loose_solvers(tolerance: float, relative: float) -> dict[str, float]:
    """Settings of linear solvers for flows that need no round-off balance."""
    pressure, velocity = (f'{SOLUTION}:solvers/"{name}(Final)?"' for name in ("p", "U.air"))
    return {
        f"{pressure}/tolerance": tolerance,
        f"{pressure}/relTol": relative,
        f"{velocity}/tolerance": tolerance,
    }
