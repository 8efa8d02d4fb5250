"""Budgets: momentum of gas and particles together, and the mass of all that was fed."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elutria.case.case import PARAMETERS, Case
from elutria.running.run import run_case
from elutria_validation.book.figures import label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import WEIGHTLESS, BoxCase, cube
from elutria_validation.harness.cases import read_gas, solve, times
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.harness.programs import project_root
from elutria_validation.references.drag import AIR

NAME = "budgets"
TITLE = "Budgets"
HELP = "Budgets: momentum of gas and particles together, mass of what was fed."

Array = NDArray[np.float64]

# One outer corrector leaves what the void fraction's change in the step does to the flux
ALLOWED = {1: 1e-4, 4: 1e-8}
LEDGER_ALLOWED = {"number": 1e-12, "mass_kg": 1e-9}


@dataclass(frozen=True)
class Exchange:
    """Momentum (kg m/s, shape (n, 3)) of gas and of particles at n times (s)."""

    time: Array
    gas: Array
    particles: Array

    @property
    def given(self) -> Array:
        """Momentum (kg m/s) that the particles have given away at the end."""
        return np.asarray(self.particles[0] - self.particles[-1])

    @property
    def exchanged(self) -> float:
        """Size of it over that of what they had."""
        return float(np.linalg.norm(self.given) / np.linalg.norm(self.particles[0]))

    @property
    def drift(self) -> float:
        """Change of the total over the momentum exchanged."""
        total = self.gas + self.particles
        return float(np.linalg.norm(total[-1] - total[0]) / np.linalg.norm(self.given))


def exchange(folder: Path, outer: int, number: int = 400, writes: int = 1) -> Exchange:
    """`number` particles shot through gas at rest in a periodic box, 40 steps."""
    side, cells, steps, step = 0.02, 6, 40, 5e-4
    random = np.random.default_rng(3)
    start = Particles.of(
        random.uniform(0, side, (number, 3)),
        random.normal((1.0, 0.5, -0.3), 0.5, (number, 3)),
        diameter=random.uniform(1e-4, 8e-4, number),
    )
    case = BoxCase(
        **cube(side, cells), **WEIGHTLESS, coupled=True, solve_gas=True, outer_correctors=outer,
        step=step, end=steps * step, interval=steps // writes * step,
    ).make(folder, start)  # fmt: skip
    solve(case)
    written = [time for time in times(case) if float(time) > 0]
    cell = AIR.density * side**3 / cells**3
    gas = [
        cell * (read_gas(case, time, "alpha.air") * read_gas(case, time)).sum(axis=0)
        for time in written
    ]
    particles = [read_particles(case, time).momentum for time in written]
    return Exchange(
        np.array([0, *map(float, written)]),
        np.array([np.zeros(3), *gas]),
        np.array([start.momentum, *particles]),
    )


def ledger_errors(case: Path) -> dict[tuple[str, str], float]:
    """What is missing of what was fed, over it, by account (a material, or all) and kind.

    Raises AssertionError where the ledger itself tells of lost parcels.
    """
    ledger = json.loads((case / "postProcessing/ledger.json").read_text())
    errors = {}
    for name, account in {"all": ledger["total"], **ledger["materials"]}.items():
        assert account["lost"] == {"parcels": 0, "number": 0, "mass_kg": 0}, name
        for kind in LEDGER_ALLOWED:
            fed = account["injected"][kind]
            out = sum(outlet[kind] for outlet in account["outlets"].values())
            errors[name, kind] = abs(fed - out - account["inside"][kind]) / max(fed, 1e-300)
    return errors


def momentum(folder: Path, quick: bool) -> Section:
    section = Section(
        "Momentum of gas and particles",
        "Particles of 0.1 to 0.8 mm are shot through gas at rest in a periodic box without "
        "gravity; they collide, and drag brings the gas along. What the particles lose the gas "
        "must gain. Error: change of the total over the momentum exchanged. With one outer "
        "corrector the flux is that of the void fraction before the step; iterating takes the "
        "rest away. That drag acts at all is judged too: more than 1 % must be exchanged.",
    )
    figure, (axes,) = new_figure(60)
    for number in (400,) if quick else (400, 1600):
        for outer, allowed in ALLOWED.items():
            found = exchange(folder / f"{number}-{outer}", outer, number, writes=10)
            case = f"{number} particles, {outer} outer correctors"
            section.rows += [
                Row.size(case, "drift of the total momentum", found.drift, allowed),
                Row(case, "share of their momentum that particles gave away (error: 1 % over it)",
                    0.01, found.exchanged, 0.01 / found.exchanged, 1),
            ]  # fmt: skip
    along = found.given / np.linalg.norm(found.given) ** 2
    for name, values in (
        ("particles", found.particles), ("gas", found.gas), ("both", found.particles + found.gas)
    ):  # fmt: skip
        change = (values - values[0]) @ along
        axes.plot(1e3 * found.time, change, "o-", markersize=2.5, label=name)
    label(axes, "time (ms)", "change of momentum over\nall that was exchanged")
    section.figures["momentum"] = (figure, f"Momentum along the direction of the exchange, {case}.")
    return section


def mass(folder: Path, quick: bool) -> Section:
    section = Section(
        "Mass of what was fed",
        "The default column with 200 parcels that stand for many grains or few: fed is what left "
        "by each outlet and what is still inside, in number and in mass, for all and for each "
        "material, and nothing is lost. Error: what is missing over what was fed.",
    )
    settings = [
        f"{PARAMETERS}:{text}" for text in ("particles=200", "feedTime=0.05", "drainTime=0.4")
    ]
    column = Case(project_root() / "cases/column")
    for velocity in (10,) if quick else (4, 10):
        case = run_case(column, folder / f"{velocity}", column.settings_for(velocity, settings))
        section.rows += [
            Row.size(f"{velocity} m/s, {account}", f"{kind.removesuffix('_kg')} that is missing",
                     error, LEDGER_ALLOWED[kind])
            for (account, kind), error in ledger_errors(case.path).items()
        ]  # fmt: skip
    return section


SECTIONS = (momentum, mass)
