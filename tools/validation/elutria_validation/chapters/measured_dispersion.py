"""Dispersion of grains in decaying grid turbulence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from elutria_validation.book.figures import BLUE, COLOURS, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import MODELS, cell_centres, set_turbulence, solve, times
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.references.drag import read_table, terminal_velocity

Array = NDArray[np.float64]

MESH, SPEED = 25.4e-3, 6.55
"""Of the grid, m; of the gas, m/s."""
FED, FROM = 20.0, 68.4
"""Distances from the grid, in MESH: where the grains enter, where their displacement counts from"""
WRITTEN, BEFORE, AFTER = 0.0125, 15, 33
"""Interval of writing, s; so many until grains are at FROM, and after."""
ALLOWED = 0.15
C0 = 2.1
"""The model's own."""
MEASURED = 0.03
"""Digitising error of the displacements."""


@dataclass(frozen=True)
class Kind:
    """Grains by size (m) and density (kg/m3)."""

    name: str
    diameter: float
    density: float

    @property
    def terminal(self) -> float:
        """Settling velocity, m/s."""
        return terminal_velocity(self.diameter, self.density)


KINDS = (Kind("hollow glass", 46.5e-6, 260.0), Kind("corn pollen", 87e-6, 1000.0),
         Kind("glass", 87e-6, 2500.0), Kind("copper", 46.5e-6, 8900.0))  # fmt: skip


def turbulence(distance: Array) -> tuple[Array, Array]:
    """k (m2/s2) and epsilon (m2/s3) at distances from the grid, in MESH: U2/u'2 = 42.4 (x - 16)
    along the stream, 39.4 (x - 12) across it, and epsilon = -U dk/dx."""
    along, across = 42.4 * (distance - 16), 39.4 * (distance - 12)
    k = SPEED**2 * (0.5 / along + 1 / across)
    slope = 0.5 * 42.4 / along**2 + 39.4 / across**2
    return k, SPEED**3 / MESH * slope


def of_the_model(at: Array, c0: float = C0) -> Array:
    """Mean square displacement (m2) at times (s) since FROM of a tracer in this turbulence by the
    Langevin model that ours is: 2 int int sigma sigma' exp(-int ds/T), T = (k/epsilon)/(1/2 + 3/4
    C0) (Pope 2000, eq. 12.27), worked out apart from the solver."""
    moment = np.linspace(0, at[-1], 2001)
    k, epsilon = turbulence(FROM + moment * SPEED / MESH)
    sigma, rate = np.sqrt(2 * k / 3), (0.5 + 0.75 * c0) * epsilon / k
    elapsed = cumulative_trapezoid(rate, moment, initial=0)
    inner = cumulative_trapezoid(sigma * np.exp(elapsed), moment, initial=0)
    square = 2 * cumulative_trapezoid(sigma * np.exp(-elapsed) * inner, moment, initial=0)
    return np.asarray(np.interp(at, moment, square))


def displacements(
    folder: Path, number: int, coefficients: Mapping[str, float] | None = None
) -> tuple[Array, dict[str, Array]]:
    """Times (s) since FROM, and mean square displacements (m2) across by kind of grain;
    `coefficients` of the dispersion model that are not its own."""
    length, width, margin = 165 * MESH, 0.6, 2 * MESH
    moment = BEFORE * WRITTEN
    starts, diameters, densities = [], [], []
    for kind in KINDS:
        on_the_way = moment * (SPEED - kind.terminal)
        starts.append((FROM - FED) * MESH - on_the_way + margin)
        diameters.append(kind.diameter)
        densities.append(kind.density)
    place = np.full((len(KINDS) * number, 3), width / 2)
    place[:, 2] = np.repeat(starts, number)
    velocity = np.zeros_like(place)
    velocity[:, 2] = SPEED - np.repeat([kind.terminal for kind in KINDS], number)
    case = BoxCase(
        width=width, depth=width, height=length, cells=(1, 1, 330), sides="cyclic",
        gas_velocity=SPEED, dispersion="continuousDispersionRAS", step=WRITTEN / 10,
        end=(BEFORE + AFTER) * WRITTEN, interval=WRITTEN,
        more={f"{MODELS}/continuousDispersionRASCoeffs": dict(coefficients)}
        if coefficients else {},
    ).make(folder, Particles.of(place, velocity, diameter=np.repeat(diameters, number),
                                density=np.repeat(densities, number)))  # fmt: skip
    centres, _ = cell_centres(case)
    set_turbulence(case, *turbulence(FED + (centres[:, 2] - margin) / MESH))
    solve(case)
    written = [name for name in times(case) if float(name) >= moment - 1e-9]
    states = np.array([read_particles(case, name).position[:, :2] for name in written])
    squares = ((states - states[0]) ** 2).mean(axis=2).reshape(len(written), len(KINDS), number)
    since = np.array([float(name) for name in written]) - float(written[0])
    means = squares.mean(axis=2)
    return since, {kind.name: means[:, k] for k, kind in enumerate(KINDS)}


def dispersion(folder: Path, quick: bool) -> Section:
    number = 400 if quick else 2500
    section = Section(
        "Dispersion behind a grid, measured (Snyder and Lumley 1971)",
        "Grains that rise with gas of 6.55 m/s through the decaying turbulence behind a grid of "
        "25.4 mm: their mean square displacement across the stream, from 68.4 meshes behind the "
        "grid on. k and epsilon are given by the measured decay; the flow is not solved. Allowed: "
        f"15 % at each of the nine times; chance is {200 / number**0.5:.1f} %, digitising about 3 "
        "%. Heavier grains fall through the eddies and leave them sooner (crossing "
        "trajectories): corn pollen, glass and copper, for which no numbers were at hand, must "
        "spread less, the more so the faster they settle; without the model's beta they hardly "
        "do. The decay's constants, the mean gas velocity and the grains' sizes and densities are "
        "quoted from memory of the paper; grains' settling velocities and the first point agree "
        "with them.",
    )
    measured = read_table("snyder1971")
    at = np.array([1e-3 * float(row["time_ms"]) for row in measured])
    squares = np.array([1e-4 * float(row["square_cm2"]) for row in measured])
    since, found = displacements(folder / "grid", number)
    _, straight = displacements(folder / "beta0", number // 2, {"beta": 0})
    _, sooner = displacements(folder / "c0", number // 2, {"C0": 2 * C0})
    ours = np.interp(at, since, found["hollow glass"])
    names = [f"{1e3 * t:g} ms" for t in at]
    section.rows.append(
        Row.worst("hollow glass", "mean square displacement, m2", names, squares, ours,
                  None if quick else ALLOWED)
    )  # fmt: skip
    section.rows.append(
        Row.relative("hollow glass", "mean square displacement at the last time, m2", squares[-1],
                     ours[-1], ALLOWED)
    )  # fmt: skip
    section.rows += [
        Row.worst("hollow glass", "the same beside a tracer of the model, worked out apart, m2",
                  names, of_the_model(at), ours, 4 / number**0.5),
        Row.worst("hollow glass, C0 doubled", "mean square displacement, m2", names, squares,
                  np.interp(at, since, sooner["hollow glass"]), None),
    ]  # fmt: skip
    last = {name: float(np.interp(at[-1], since, line)) for name, line in found.items()}
    for kind in KINDS[1:]:
        ratio = last[kind.name] / last["hollow glass"]
        section.rows.append(
            Row(f"{kind.name}, settles at {kind.terminal:.2f} m/s",
                "displacement over hollow glass' (1 without crossing; error: the ratio)", 1, ratio,
                ratio, 0.9)
        )  # fmt: skip
        section.rows.append(
            Row(f"{kind.name}, beta 0", "the same without crossing trajectories", 1,
                without := float(np.interp(at[-1], since, straight[kind.name])
                                 / last["hollow glass"]),
                without, None)
        )  # fmt: skip
    figure, (axes,) = new_figure(75)
    axes.errorbar(1e3 * at, 1e4 * squares, 1e4 * MEASURED * squares, fmt="o", ms=4, color=RED,
                  label="hollow glass, measured")  # fmt: skip
    for kind, colour in zip(KINDS, (BLUE, *COLOURS[2:]), strict=False):
        line, chance = 1e4 * found[kind.name], 2 / number**0.5
        axes.plot(1e3 * since, line, color=colour, label=kind.name)
        axes.fill_between(1e3 * since, line * (1 - chance), line * (1 + chance), color=colour,
                          alpha=0.25, lw=0)  # fmt: skip
    axes.plot(1e3 * since, 1e4 * sooner["hollow glass"], ":", color=BLUE,
              label="hollow glass, C0 doubled")  # fmt: skip
    axes.set_xlim(0, None)
    axes.set_ylim(0, None)
    label(axes, "time, ms", "mean square displacement, cm²")
    section.figures["grid"] = (
        figure, "Displacement across the stream; lines: ours, with the 95 % band of chance."
    )  # fmt: skip
    return section
