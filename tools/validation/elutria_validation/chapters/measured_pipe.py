"""Gas and grains in an upward pipe: profiles of both, in a periodic piece of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria_validation.book.figures import BLUE, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase, Contacts, Pair
from elutria_validation.harness.cases import (
    cell_centres,
    change,
    read_gas,
    set_turbulence,
    solve,
    times,
)
from elutria_validation.harness.particles import HEADER, Particles, read_particles
from elutria_validation.harness.programs import slug
from elutria_validation.references.drag import AIR, read_table

Array = NDArray[np.float64]

RADIUS, DENSITY = 0.01525, 1020.0
"""Of the pipe, m; of polystyrene, kg/m3."""
CELLS = (6, 4)
"""Across the pipe's core, and from it to the wall."""
CELL = 7.6e-3  # m, along
FRAMES = 12
"""Written states that are averaged."""
WINDOW = 0.07
"""Half width of what is averaged about a measured place, over the radius."""
GRAINS, GAS = 0.05, 0.06
"""Allowed root mean square of the differences, over the gas' mean velocity."""
PEERS = {"grains": "1.5 to 6.9 %", "gas": "3.1 to 5.9 %"}


@dataclass(frozen=True)
class Flow:
    """A measured flow: grains (m), loading (kg/kg), mean gas velocity (m/s), and the piece of pipe
    that is computed (m) until it is steady and for its mean (s)."""

    diameter: float
    loading: float
    velocity: float
    length: float
    settles: float
    averaged: float
    step: float

    @property
    def name(self) -> str:
        return f"{1e6 * self.diameter:g} um, loading {self.loading:g}"

    def measured(self, phase: str) -> tuple[Array, Array]:
        """Radii over the pipe's, and velocities (m/s)."""
        wanted = (round(1e6 * self.diameter), self.loading, phase)
        rows = [
            (float(row["radius"]), float(row["velocity_m_s"])) for row in read_table("tsuji1984")
            if (int(row["diameter_um"]), float(row["loading"]), row["phase"]) == wanted
        ]  # fmt: skip
        radius, velocity = np.array(rows).T
        return radius, velocity

    @property
    def number(self) -> int:
        """Grains in the piece: so many as bring the loading at their measured velocities."""
        radius, velocity = self.measured("grains")
        mean = float(np.average(velocity, weights=np.maximum(radius, 0.03)))
        rate = self.loading * AIR.density * self.velocity * pi * RADIUS**2  # kg/s
        return round(rate * self.length / mean / (DENSITY * pi / 6 * self.diameter**3))

    def start(self) -> Particles:
        """Grains at places drawn from a lattice, as fast as the measured ones on the axis."""
        random = np.random.default_rng(3)
        within = RADIUS - 0.6 * self.diameter
        pitch = 1.3 * self.diameter
        across = np.arange(-within, within, pitch)
        along = np.arange(pitch / 2, self.length - pitch / 2, pitch)
        grid = np.stack(np.meshgrid(across, across, along), axis=-1).reshape(-1, 3)
        grid = grid[np.hypot(*grid[:, :2].T) < within]
        place = grid[random.permutation(len(grid))[: self.number]]
        velocity = random.normal(0, 0.05, place.shape) * self.velocity
        velocity[:, 2] += self.measured("grains")[1][0]
        return Particles.of(place, velocity, diameter=self.diameter, density=DENSITY)


FLOWS = (Flow(501e-6, 1.1, 7.96, 4 * RADIUS, 2.0, 0.6, 1e-3),
         Flow(501e-6, 3.6, 7.89, 2 * RADIUS, 2.0, 0.6, 1e-3),
         Flow(243e-6, 1.0, 15.6, 2 * RADIUS, 1.0, 0.3, 5e-4))  # fmt: skip


@dataclass(frozen=True)
class Models:
    """One set of settings for all flows; each is changed alone to show what it matters."""

    restitution: float = 0.9
    friction: float = 0.3
    dispersion: str = "continuousDispersionRAS"
    forces: Mapping[str, Any] = field(default_factory=dict)  # beside drag and weight
    contacts: bool = True
    coupled: bool = True


STANDARD = Models()
CHANGED = {
    "friction 0": Models(friction=0.0),
    "restitution 0.8": Models(restitution=0.8),
    "no dispersion": Models(dispersion="none"),
    "Saffman's lift": Models(forces={"SaffmanMeiLiftForce": {"U": "U.air"}}),
    "no contacts": Models(contacts=False),
    "grains do not act on the gas": Models(coupled=False),
}
FINE = replace(FLOWS[2], settles=0.5, averaged=0.15)
"""The third flow, shorter."""
MIXING = {
    "standard": STANDARD,
    "no dispersion": Models(dispersion="none"),
    "no contacts": Models(contacts=False),
    "friction 0": Models(friction=0.0),
}
"""Of the third flow: what mixes grains across the pipe."""


@dataclass(frozen=True)
class Profiles:
    """Means over time, and over places about the measured ones, of grains and gas (m/s), with the
    grains' standard error; the loading that was found, and the gas' profile (radius, velocity)."""

    grains: Array
    error: Array
    gas: Array
    loading: float
    across: Array


def rise(folder: Path, flow: Flow, models: Models = STANDARD, short: bool = False) -> Profiles:
    """The flow in a periodic piece of pipe, driven so that the gas keeps its mean velocity."""
    along = max(round(flow.length / CELL), 2)
    settles, averaged = (0.02, 0.01) if short else (flow.settles, flow.averaged)
    interval = averaged / FRAMES
    wall = Pair(models.restitution, models.friction)
    more: dict[str, Any] = {
        f"system/fvSchemes:divSchemes/div(alphaPhi.air,{name}.air)": ("Gauss", "upwind")
        for name in ("k", "epsilon")
    }
    case = BoxCase(
        mesh="pipeMeshDict", radius=RADIUS, pipe_length=flow.length / RADIUS, ends="cyclic",
        cells=(*CELLS, along), gas_velocity=flow.velocity, side_velocity="noSlip",
        coupled=models.coupled, solve_gas=True, tolerance=(1e-7, 1e-2),
        forces={"SchillerNaumannDrag": {}, "gravity": {}, **models.forces},
        dispersion=models.dispersion, contacts=Contacts(wall) if models.contacts else None,
        step=min(flow.step, interval), end=settles + averaged, interval=interval,
        more=more,
    ).make(folder, flow.start())  # fmt: skip
    friction = 0.05 * flow.velocity
    set_turbulence(case, 3.3 * friction**2, friction**3 / (0.1 * RADIUS), wall_functions=True)
    _drive(case, flow.velocity)
    centres, _ = cell_centres(case)
    solve(case)
    return _profiles(case, flow, centres)


def _drive(case: Path, velocity: float) -> None:
    """A pressure gradient that keeps the gas' mean velocity; solvers for the turbulence too."""
    source = {"type": "meanVelocityForce", "active": True, "meanVelocityForceCoeffs": {
        "selectionMode": "all", "fields": ["U.air"], "Ubar": [0, 0, velocity]}}  # fmt: skip
    (case / "constant/fvOptions").write_text(HEADER.format("dictionary", "constant", "fvOptions"))
    solver = {"solver": "smoothSolver", "smoother": "symGaussSeidel", "tolerance": 1e-8,
              "relTol": 0.01}  # fmt: skip
    change(case, {"constant/fvOptions:drive": source,
                  'system/fvSolution:solvers/"(k|epsilon).air(Final)?"': solver})  # fmt: skip


def _profiles(case: Path, flow: Flow, centres: Array) -> Profiles:
    written = [name for name in times(case) if float(name) > 0][-FRAMES:]
    states = [read_particles(case, name) for name in written]
    radius = np.concatenate([np.hypot(*state.position[:, :2].T) for state in states]) / RADIUS
    upward = np.concatenate([state.velocity[:, 2] for state in states])
    at = flow.measured("grains")[0]
    means, errors = np.empty_like(at), np.empty_like(at)
    for k, place in enumerate(at):
        own = upward[np.abs(radius - place) < WINDOW]
        means[k], errors[k] = own.mean(), own.std() / np.sqrt(len(own) / FRAMES)
    gas = np.mean([read_gas(case, name)[:, 2] for name in written], axis=0)
    where = np.hypot(*centres[:, :2].T) / RADIUS
    edges = np.linspace(0, 1, 11)
    index = np.digitize(where, edges) - 1
    held = np.unique(index)
    line = np.array([[where[index == k].mean(), gas[index == k].mean()] for k in held]).T
    mass = DENSITY * pi / 6 * flow.diameter**3
    rate = float(np.mean([state.velocity[:, 2].sum() for state in states])) * mass / flow.length
    return Profiles(means, errors, np.interp(flow.measured("gas")[0], *line),
                    rate / (AIR.density * flow.velocity * pi * RADIUS**2), line)  # fmt: skip


def _rms(flow: Flow, phase: str, ours: Array) -> float:
    return float(np.sqrt(np.mean((ours - flow.measured(phase)[1]) ** 2)) / flow.velocity)


def pipe(folder: Path, quick: bool) -> Section:
    section = Section(
        "Gas and grains in an upward pipe, measured (Tsuji, Morikawa and Shiomi 1984)",
        "Polystyrene spheres of 501 um (loadings 1.1 and 3.6) and 243 um (1.0) rise with air "
        "through a pipe of 30.5 mm. The fourth flow that was measured, 243 um at 4.2, is not "
        "here: in a piece of pipe two cells long the gas diverged after 0.77 s. Computed is a "
        "periodic piece of the pipe: a pressure gradient holds the gas' mean "
        "velocity (meanVelocityForce of constant/fvOptions), the number of grains "
        "is that of the loading at their measured velocities and stays, k-epsilon "
        "with wall functions on cells of 2 mm, drag by Schiller and Naumann, dispersion, contacts "
        "with grains and wall. Restitution (0.9) and friction (0.3) were not at hand and are "
        "assumed; one set of settings for all flows. Allowed: root mean square of the differences "
        "5 % of the mean gas velocity for grains, 6 % for gas. The walls are smooth: there is no "
        "model of their roughness yet. The flow is steady, where the measurement is said to be "
        "5.1 m from the feed.",
    )
    flows = FLOWS[:1] if quick else FLOWS
    found = {flow: rise(folder / f"flow{k}", flow, short=quick) for k, flow in enumerate(flows)}
    for flow, ours in found.items():
        for phase, line, allowed in (("grains", ours.grains, GRAINS), ("gas", ours.gas, GAS)):
            section.rows.append(
                Row.size(flow.name, f"velocity of the {phase}, rms over the gas' mean; error: "
                         "itself", _rms(flow, phase, line), None if quick else allowed,
                         PEERS[phase])
            )  # fmt: skip
        section.rows.append(
            Row.relative(flow.name, "loading, kg/kg", flow.loading, ours.loading, None)
        )
    if not quick:
        section.rows += _features(found)
    else:
        flow, ours = next(iter(found.items()))
        mean = float(np.average(ours.across[1], weights=ours.across[0]))
        section.rows.append(
            Row.relative(flow.name, "mean gas velocity, which the gradient holds, m/s",
                         flow.velocity, mean, 0.05)
        )  # fmt: skip
    _draw(section, found)
    return section


def _features(found: Mapping[Flow, Profiles]) -> list[Row]:
    """What the measurement shows beside numbers: the gas' maximum, the slip on the axis."""
    rows = []
    dense = found[FLOWS[1]]
    top = float(dense.across[0][int(dense.across[1].argmax())])
    radius, velocity = FLOWS[1].measured("gas")
    rows.append(
        Row(FLOWS[1].name, "place of the gas' maximum, over the radius (error: 1 on the axis)",
            float(radius[int(velocity.argmax())]), top, float(top < 0.25), 0)
    )  # fmt: skip
    thin, thick = FLOWS[:2]
    slips = [found[flow].gas[0] - found[flow].grains[0] for flow in (thin, thick)]
    theirs = [flow.measured("gas")[1][0] - flow.measured("grains")[1][0] for flow in (thin, thick)]
    rows.append(
        Row("501 um", "slip on the axis, m/s: how much it falls with the loading (error: 1 where "
            "it rises)", theirs[0] - theirs[1], slips[0] - slips[1],
            float(slips[1] >= slips[0]), 0)
    )  # fmt: skip
    return rows


def settings(folder: Path, quick: bool) -> Section:
    section = Section(
        "The upward pipe: what each setting matters",
        "One setting changed at a time; for information. Above the first flow (501 um, loading "
        "1.1): friction and restitution cover what is plausible of what was not at hand. Below "
        "the third (243 um, loading 1, for a shorter time): what mixes grains across the pipe. "
        "Wall roughness is not among them: there is no model of it yet.",
    )
    coarse = {"standard": STANDARD, **({} if quick else CHANGED)}
    tried = [(FLOWS[0], coarse)] if quick else [(FLOWS[0], coarse), (FINE, MIXING)]
    figure, panels = new_figure(15 + 75 * len(tried), rows=len(tried), sharex=True)
    for axes, (flow, changes) in zip(panels, tried, strict=True):
        for name, models in changes.items():
            ours = rise(folder / slug(flow.name, name), flow, models, short=quick)
            section.rows += [
                Row.size(f"{flow.name}, {name}", f"velocity of the {phase}, rms over the gas' mean",
                         _rms(flow, phase, line), None)
                for phase, line in (("grains", ours.grains), ("gas", ours.gas))
            ]  # fmt: skip
            (drawn,) = axes.plot(*ours.across, lw=0.9, label=name)
            radius = flow.measured("grains")[0]
            axes.plot(radius, ours.grains, "--", lw=0.9, color=drawn.get_color())
        for phase, mark in (("gas", "s"), ("grains", "o")):
            axes.plot(*flow.measured(phase), mark, ms=4, mfc="none", color="k",
                      label=f"{phase}, measured")  # fmt: skip
        axes.set_ylim(0, None)
        label(axes, "distance from the axis over the radius", "velocity, m/s", fontsize=6)
    section.figures["settings"] = (figure, "One setting at a time: gas (lines), grains (dashed).")
    return section


def _draw(section: Section, found: Mapping[Flow, Profiles]) -> None:
    figure, panels = new_figure(20 + 48 * len(found), rows=len(found), sharex=True)
    for axes, (flow, ours) in zip(panels, found.items(), strict=True):
        radius, velocity = flow.measured("gas")
        axes.plot(radius, velocity, "s", ms=4, mfc="none", color=BLUE, label="gas, measured")
        axes.plot(*ours.across, color=BLUE, label="gas")
        radius, velocity = flow.measured("grains")
        axes.plot(radius, velocity, "o", ms=4, mfc="none", color=RED, label="grains, measured")
        axes.errorbar(radius, ours.grains, 1.96 * ours.error, color=RED, lw=1.1, label="grains")
        axes.set_title(f"{flow.name}, gas {flow.velocity:g} m/s", fontsize=8)
        axes.set_ylim(0, 1.25 * flow.velocity)
        axes.set_ylabel("velocity, m/s")
    label(panels[0], "", "velocity, m/s", ncols=2)
    panels[-1].set_xlabel("distance from the axis over the radius")
    section.figures["pipe"] = (
        figure, "Upward pipe: gas and grains; bars: the 95 % interval of chance."
    )  # fmt: skip
