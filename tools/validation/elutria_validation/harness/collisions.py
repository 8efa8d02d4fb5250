"""Spheres that collide without gas: the scene of the contact and impact chapters."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from elutria_validation.harness.box import CLOSED, NO_DRAG, BoxCase, Contacts, Pair
from elutria_validation.harness.cases import solve, times
from elutria_validation.harness.particles import Particles, read_particles

LINEAR = Contacts(law="linearSpringDashpot", treatment="soft")
FINE = replace(LINEAR, step_fraction=0.01)
"""Half the default contact step."""

BOX = BoxCase(
    width=1.0, depth=1.0, height=1.0, **CLOSED, gas_density=1e-9, forces=NO_DRAG,
    most_solids=0.99,  # parcels may be as heavy as spheres of steel
)  # fmt: skip


def linear(stiffness: float, restitution: float, friction: float = 0.0) -> Contacts:
    """FINE contacts of a linear spring (N/m)."""
    return replace(FINE, pair=Pair(restitution, friction, stiffness))


def collide(
    folder: Path, particles: Particles, contacts: Contacts, box: BoxCase, writes: int = 1
) -> dict[float, Particles]:
    """The particles at `writes` equidistant times until `box.end`, by time (s)."""
    timed = replace(box, contacts=contacts, interval=box.end / writes)
    case = timed.make(folder, particles)
    solve(case)
    return {float(time): read_particles(case, time) for time in times(case)[1:]}
