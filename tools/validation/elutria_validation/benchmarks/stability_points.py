"""The stability maps: which quantities are varied, and what is run and judged at each point."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from elutria_validation.harness.box import CLOSED, PERIODIC, WEIGHTLESS, BoxCase, cube
from elutria_validation.harness.cases import read_gas, times
from elutria_validation.harness.particles import Particles, lattice, read_particles
from elutria_validation.harness.scenes import (
    CoarseColumn,
    Verdict,
    attempt,
    colliding,
    contacts,
    settling_bed,
)
from elutria_validation.references.drag import AIR, STANDARD_GRAVITY, fall

Point = Callable[[Path, Any, Any], Verdict]


@dataclass(frozen=True)
class Map:
    """Two quantities that are varied, and the scene that is run at each pair of values."""

    name: str
    title: str
    x_name: str
    x: Sequence[Any]
    y_name: str
    y: Sequence[Any]
    point: Point


def judged(off: float, allowed: float, output: str, what: str) -> Verdict:
    """Right or off, by a relative error and what is allowed of it."""
    warned = "Warning:" in output
    if not math.isfinite(off):
        return Verdict("failed", off, warned, f"{what} is not finite")
    return Verdict("right" if off <= allowed else "off", off, warned, what)


def drag_step(folder: Path, relaxations: float, ratio: float) -> Verdict:
    """One particle falls in gas at rest: its speed against the equation of motion.

    Relaxation time over step, and density over the gas'.
    """
    diameter, density = 1e-4, ratio * AIR.density
    relaxation = density * diameter**2 / (18 * AIR.viscosity)
    step = relaxation / relaxations
    end = min(max(20 * step, 3 * relaxation), 200 * step)
    start = Particles.of([0.05, 0.05, 0.05], diameter=diameter, density=density)
    case = BoxCase(**PERIODIC, step=step, end=end).make(folder, start)
    output = attempt(case)
    speed = -float(read_particles(case, times(case)[-1]).velocity[0, 2])
    exact = -float(fall(diameter, density, 0.0, [end], "LSODA")[0])
    off = abs(speed - exact) / max(abs(exact), 1e-9)
    return judged(off, 0.02, output, f"speed {speed:.4g} m/s, exact {exact:.4g}")


def _streaming(folder: Path, start: Particles, box: BoxCase) -> tuple[float, Particles, Any, str]:
    """Particles that stream through gas at rest in a periodic box: momentum (kg m/s) that both
    together have lost or won, particles and gas velocity at the end, what the solver said."""
    case = box.make(folder, start)
    output = attempt(case)
    last = times(case)[-1]
    after = read_particles(case, last)
    gas = read_gas(case, last) * read_gas(case, last, "alpha.air")
    whole = np.broadcast_to(gas, (box.cells[0] ** 3, 3)).mean(axis=0)
    of_gas = box.gas_density * box.width**3 * whole
    drift = float(np.linalg.norm(after.momentum + of_gas - start.momentum))
    return drift, after, gas, output


def coupling(folder: Path, relaxations: float, loading: float) -> Verdict:
    """Particles stream through gas at rest, periodic: momentum of both, and both at one speed.

    Relaxation time over step, and kg of solids per kg of gas.
    """
    side, diameter, number, step = 0.01, 2e-4, 200, 1e-3
    density = loading * AIR.density * side**3 / (number * np.pi / 6 * diameter**3)
    viscosity = density * diameter**2 / (18 * relaxations * step)
    places = np.random.default_rng(1).uniform(0.02, 0.98, (number, 3)) * side
    start = Particles.of(places, [0.0, 0.0, 1.0], diameter=diameter, density=density)
    box = BoxCase(**WEIGHTLESS, **cube(side, 4), gas_viscosity=viscosity / AIR.density,
                  coupled=True, solve_gas=True, step=step, end=0.02)  # fmt: skip
    drift, after, _, output = _streaming(folder, start, box)
    drift /= float(np.linalg.norm(start.momentum))
    energy = after.kinetic_energy / start.kinetic_energy
    off = max(drift, energy - 1)
    return judged(off, 0.01, output, f"momentum drifts by {drift:.2g}, energy {energy:.3g}")


def _energy(start: Particles, after: Particles, output: str, allowed: float) -> Verdict:
    """Elastic spheres: off by what was gained, or by what is gone beyond what contacts can hold.

    Soft contacts hold some of the energy while they last: up to a tenth is not counted.
    """
    change = after.kinetic_energy / start.kinetic_energy - 1
    off = change if change > 0 else max(0.0, -change - 0.1)
    return judged(off, allowed, output, f"kinetic energy changed by {change:.2g}")


def contact_step(folder: Path, share: float, young: float) -> Verdict:
    """Elastic spheres in a box: energy kept. Sub-step over contact time, and stiffness (Pa)."""
    law = contacts(restitution=1, friction=0, young=young, treatment="soft",
                        step_fraction=share)  # fmt: skip
    end = 0.02 if share > 0.02 and young < 1e9 else 0.004
    start, after, output = colliding(folder, law, end=end, step=2e-4)
    return _energy(start, after, output, 0.1)


def dissipation(folder: Path, restitution: float, friction: float) -> Verdict:
    """Spheres collide: energy falls, momentum stays. Restitution, and friction."""
    law = contacts(restitution=restitution, friction=friction)
    start, after, output = colliding(folder, law)
    gained = after.kinetic_energy / start.kinetic_energy - 1
    drift = np.linalg.norm(after.momentum - start.momentum) / (start.mass.sum() * 0.3)
    off = max(gained, float(drift), 0.0)
    return judged(off, 1e-3, output, f"energy {1 + gained:.6g}, momentum drifts by {drift:.2g}")


def sizes(folder: Path, ratio: float, young: float) -> Verdict:
    """Spheres of unequal sizes collide elastically: energy. Size ratio, and stiffness (Pa)."""
    law = contacts(restitution=1, friction=0, young=young)
    start, after, output = colliding(folder, law, ratio=ratio, end=0.01)
    return _energy(start, after, output, 0.02)


def rest(folder: Path, step: float, friction: float) -> Verdict:
    """A bed settles: it comes to rest where it fits. Gas step (s), and friction."""
    law = contacts(friction=friction)
    start, after, output = settling_bed(folder, law, number=32, step=step, end=0.2)
    return _settled(start, after, output)


def _settled(start: Particles, after: Particles, output: str) -> Verdict:
    """Off by the energy left, over what the fall gave; above it the bed made energy."""
    given = STANDARD_GRAVITY * float(start.mass @ start.position[:, 2])
    left = after.kinetic_energy / given
    low = float(np.max(0.5 * after.diameter - after.position[:, 2]) / 1e-3)
    off = max(left, low - 0.05)
    return judged(off, 0.05, output, f"energy left {left:.2g} of the fall's, sunk {low:.2g} d")


def stiffness(folder: Path, young: float, restitution: float) -> Verdict:
    """A bed settles. Stiffness (Pa), and restitution."""
    law = contacts(young=young, restitution=restitution)
    start, after, output = settling_bed(folder, law, number=24, end=0.2, step=1e-3)
    return _settled(start, after, output)


def cells(folder: Path, ratio: float, number: float) -> Verdict:
    """Particles give momentum to gas in cells of some of their diameters: momentum of both.

    Cell over particle size, and number of particles.
    """
    count = min(max(1, round(0.012 / (ratio * 1e-3))), 40)
    side = count * ratio * 1e-3
    if side < 0.004:  # room for them
        count *= math.ceil(0.004 / side)
        side = count * ratio * 1e-3
    number = int(min(number, (side / 1.05e-3 // 1) ** 3))
    start = Particles.of(lattice(number, side), [0.0, 0.0, 1.0], diameter=1e-3)
    box = BoxCase(**WEIGHTLESS, **cube(side, count), coupled=True, solve_gas=True, end=0.02)
    drift, after, gas, output = _streaming(folder, start, box)
    drift /= float(np.linalg.norm(after.momentum - start.momentum))
    fast = float(np.abs(gas).max())
    return judged(max(drift, fast - 1), 0.01, output,
                  f"exchange closes to {drift:.2g}, fastest gas {fast:.2g} m/s")  # fmt: skip


def courant(folder: Path, number: float, loading: float) -> Verdict:
    """The column in gas steps of some cells, against a quarter of a cell a step.

    Courant, and loading. What the gas of fine steps differs by under another seed is chance.
    """
    size, velocity = 0.0125, 7.0
    fine = [folder.parent / f"fine{loading:g}-{seed}" for seed in (1, 2)]
    if not fine[0].exists():
        for seed, place in enumerate(fine, 1):
            CoarseColumn(velocity, loading, 0.25 * size / velocity, seed=seed, gas=True).run(place)
    output = CoarseColumn(velocity, loading, number * size / velocity, gas=True).run(folder)
    gas, exact, other = (read_gas(c, times(c)[-1]) for c in (folder, *fine))

    def differs(one: Any) -> float:
        return float(np.sqrt(np.mean((one - exact) ** 2) / np.mean(exact**2)))

    off, chance = differs(gas), differs(other)
    what = f"gas differs by {off:.2g} from that in fine steps, by {chance:.2g} by chance"
    return judged(max(0.0, off - chance), 0.1, output, what)


def _flow(case: Path) -> float:
    """Superficial gas velocity (m/s) at the end, mean of the cells."""
    last = times(case)[-1]
    return float(np.mean(read_gas(case, last)[:, 2] * read_gas(case, last, "alpha.air")[:, 0]))


def default_steps(folder: Path, velocity: float, loading: float) -> Verdict:
    """The column as it comes, its own steps. Gas velocity (m/s), and loading up to choking."""
    output = CoarseColumn(velocity, loading).run(folder)
    through = _flow(folder) / velocity
    return judged(abs(through - 1), 0.1, output, f"gas through the column {through:.3g} of the fed")


def jump(folder: Path, factor: float, seconds: float) -> Verdict:
    """The gas velocity jumps or reverses in so many s. Last over first velocity, and time (s)."""
    velocity = 4.0
    last = f"(0 0 {factor * velocity})"
    table = f"(0 (0 0 {velocity})) (0.1 (0 0 {velocity})) ({0.1 + seconds} {last}) (9 {last})"
    output = CoarseColumn(velocity, 0.2, inlet=table, end=0.4).run(folder)
    through = _flow(folder) / velocity
    off = abs(through - factor) / max(abs(factor), 1)
    return judged(off, 0.1, output, f"gas through the column {through:.3g} of the first")


def against_outlet(folder: Path, opening: str, friction: float) -> Verdict:
    """A bed packed on an outlet, a grating or a gas inlet: none leaves faster than it can fall."""
    ends = {
        "outlet": {},
        "outlet, gas up": {"gas_velocity": 3},
        "outlet, gas down": {"gas_velocity": -3},
        "closed": CLOSED,
    }[opening]
    end = 0.01  # s; later most have fallen out
    start, after, output = settling_bed(
        folder, contacts(friction=friction), step=1e-3, end=end, ends=ends, packed=True
    )
    given = STANDARD_GRAVITY * float(start.mass.sum()) * 0.03
    wind = 3.0 if "gas" in opening else 0.0
    most = math.sqrt(2 * STANDARD_GRAVITY * 0.03) + wind
    fastest = float(np.max(np.linalg.norm(after.velocity, axis=1), initial=0.0))
    return judged(max(0.0, fastest / most - 1), 0.05, output,
                  f"fastest {fastest:.3g} m/s, can be {most:.3g}; given {given:.2g} J")  # fmt: skip


YOUNG = (1e5, 1e6, 1e7, 1e8, 1e9, 1e10)
MAPS = (
    Map("drag", "one particle falls", "relaxation time / step", (1e-4, 1e-2, 1, 1e2, 1e4),
        "density / gas density", (1.01, 100, 1e4), drag_step),
    Map("coupling", "particles stream through gas", "relaxation time / step",
        (1e-4, 1e-2, 1, 1e2, 1e4), "loading", (1e-5, 0.1, 10, 100), coupling),
    Map("contactStep", "elastic spheres, soft contacts", "contact step / contact time",
        (0.01, 0.05, 0.2, 0.5, 2), "Young's modulus, Pa", (1e5, 1e7, 1e9), contact_step),
    Map("dissipation", "colliding spheres", "restitution", (0.05, 0.3, 0.8, 1),
        "friction", (0, 0.1, 0.5, 2), dissipation),
    Map("sizes", "elastic spheres of two sizes", "largest / smallest", (1, 3, 10, 50),
        "Young's modulus, Pa", (1e5, 1e7, 1e9), sizes),
    Map("rest", "a bed settles", "gas step, s", (1e-4, 1e-3, 1e-2, 0.1), "friction",
        (0, 0.3, 2), rest),
    Map("stiffness", "a bed settles", "Young's modulus, Pa", YOUNG, "restitution",
        (0.05, 0.95), stiffness),
    Map("cells", "gas in cells, particles of 1 mm", "cell / particle", (0.3, 0.6, 1, 3, 10, 30),
        "particles", (1, 200), cells),
    Map("courant", "column, given steps", "Courant number", (0.05, 0.5, 5, 20), "loading",
        (1e-5, 0.1, 10), courant),
    Map("column", "column, its own steps", "gas velocity, m/s", (1, 5, 16), "loading",
        (1e-5, 0.1, 10, 100, 1000), default_steps),
    Map("jump", "the gas jumps", "last / first velocity", (-5, -1, 0, 0.1, 3, 10), "in s",
        (1e-6, 0.05), jump),
    Map("outlet", "packed on an opening", "opening",
        ("outlet", "outlet, gas up", "outlet, gas down", "closed"), "friction", (0, 2),
        against_outlet),
)  # fmt: skip
