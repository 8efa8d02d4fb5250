"""Hold-up of grains in a pseudo-2D riser, at gas velocities near their settling velocity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import t as student

from elutria.physics.drag import drag_coefficient
from elutria_validation.book.figures import BLUE, COLOURS, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase, Contacts, Pair
from elutria_validation.harness.cases import (
    CONTROL,
    PARAMETERS,
    SOLUTION,
    add_feed,
    add_zone,
    change,
    material,
    read_gas,
    set_turbulence,
    solve,
    times,
)
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.harness.programs import slug
from elutria_validation.references.drag import AIR, STANDARD_GRAVITY, read_table

Array = NDArray[np.float64]

HEIGHT, WIDTH, FED_BELOW = 1.57, 0.07, 0.03
"""m: of the riser, and of the zone at its bottom into which grains are fed."""
DIAMETER, DENSITY = 0.85e-3, 2500.0
"""Of the glass, m, kg/m3."""
VOLUME = pi / 6 * DIAMETER**3
"""Of a grain, m3."""
NU = 1.5e-5  # m2/s, of the gas
LOW, HIGH = 0.1, 1.4
"""m: heights between which the mean hold-up is taken."""
ENTRANCE = 0.5
"""m: a measured height below which grains still gather speed."""
HEIGHTS = np.arange(LOW, HIGH + 0.01, 0.05)
PLACE = 0.8
"""m: heights of the drawn profile, and of the one across the width."""
WINDOW = 0.03
"""m: half of the height over which a profile is averaged, as the measured one."""
LAYER = 0.05
"""m: the same where places across the width are told apart."""
CORE, WALL = (0.3, 0.7), 0.095
"""Of the width: the core, and what counts as beside a wall."""
FRAME = 0.1  # s, between states that are averaged
BLOCKS = 4
"""Parts of the averaged time, from whose scatter chance is taken."""
STEADY = "mass that rises, kg/m2/s, beside what is fed: is the riser steady?"
ALLOWED, SAME = 0.15, 0.01
"""Of the measured; of what grains and gas should both hold."""
FAST, SLOW = 6.74, 5.95  # m/s
START = {FAST: 0.015, SLOW: 0.03}
"""Solid fraction of the whole riser at the start, at each."""
PEERS = {FAST: "authors' LES-DEM -34 %; an Euler-Lagrange code +13 %",
         SLOW: "authors' LES-DEM -6 %; an Euler-Lagrange code -15 %"}  # fmt: skip


@dataclass(frozen=True)
class Models:
    """One set of settings for both velocities: what is fed (kg/m2/s) and within which share of the
    width, depth and height (m), friction of all pairs, drag law, grains in a parcel, cells along x,
    y and z, step (s), how long until the flow counts as steady, how long it is averaged (s)."""

    flux: float = 28.5
    fed_within: float = 1.0
    depth: float = 7e-3
    height: float = HEIGHT
    restitution: float = 0.97
    friction: float = 0.1
    drag: str = "GidaspowDrag"
    grains: int = 1
    cells: tuple[int, int, int] = (10, 1, 105)
    step: float = 4e-3
    settles: float = 2.0
    averaged: float = 1.5


STANDARD = Models()
UNKNOWN = {
    "flux 25 kg/m2/s": Models(flux=25.0),
    "flux 32 kg/m2/s": Models(flux=32.0),
    "depth 6 mm": Models(depth=6e-3),
    "depth 8 mm": Models(depth=8e-3),
}
"""What the sources at hand give as a range: both ends of each, the other in its middle."""
ENTRY = Models(height=0.6, cells=(10, 1, 40), settles=0.7, averaged=0.6)
"""The riser's lowest part alone."""
CHANGED = {
    "standard": ENTRY,
    "fed at one side": replace(ENTRY, fed_within=0.2),
    "flux 32 kg/m2/s": replace(ENTRY, flux=32.0),
    "Beetstra's drag": replace(ENTRY, drag="BeetstraDrag"),
    "friction 0.3": replace(ENTRY, friction=0.3),
}
"""Changed one at a time, at the first velocity."""
QUICK = Models(cells=(5, 1, 52), settles=0.032, averaged=0.064)


def measured(velocity: float, place: str, source: str = "measured") -> tuple[Array, Array]:
    """Heights (m) and solid fractions there at a gas velocity (m/s)."""
    rows = [
        (float(row["height_m"]), float(row["solid_fraction"]))
        for row in read_table("carlosvaras2017")
        if (float(row["velocity_m_s"]), row["place"], row["source"]) == (velocity, place, source)
    ]  # fmt: skip
    height, fraction = np.array(rows).T
    return height, fraction


def measured_mean(velocity: float, low: float = LOW, high: float = HIGH) -> float:
    """Hold-up between two of the measured heights (m)."""
    height, fraction = measured(velocity, "section")
    inside = (low <= height) & (height <= high)
    return float(np.trapezoid(fraction[inside], height[inside]) / (high - low))


def even_suspension(velocity: float, models: Models) -> float:
    """Hold-up of grains that rise steadily, spread evenly in gas that is even too and has no walls:
    by the drag law alone."""

    def slip(fraction: float) -> float:
        return float(brentq(lambda s: _drag(models.drag, s, fraction) - weight, 0.1, 20))

    weight = (DENSITY - AIR.density) * STANDARD_GRAVITY  # N/m3
    carried = models.flux / DENSITY  # m/s
    return float(brentq(lambda f: f * (velocity / (1 - f) - slip(f)) - carried, 1e-4, 0.2))


def _drag(law: str, slip: float, fraction: float) -> float:
    """By volume of grains, N/m3."""
    reynolds = slip * DIAMETER / NU
    coefficient = float(drag_coefficient(law, reynolds, 1 - fraction))
    return 0.75 * coefficient * AIR.density * slip**2 / DIAMETER


@dataclass(frozen=True)
class Grains:
    """Places of parcels (m) and how fast they rise (m/s) at each of several times, shapes (n, 3)
    and (n,); the volume of the grains of one (m3), the depth that is computed (m); the solid
    fraction of the whole riser by the gas' cells."""

    places: list[Array]
    upward: list[Array]
    volume: float
    depth: float
    cells: float = np.nan

    def within(self, low: float, high: float, across: tuple[float, float] = (0.0, 1.0)) -> Array:
        """Solid fraction between two heights (m) and two places over the width, at each time."""
        room = (high - low) * (across[1] - across[0]) * WIDTH * self.depth
        return np.array([
            np.sum((low <= p[:, 2]) & (p[:, 2] < high) & (across[0] * WIDTH <= p[:, 0])
                   & (p[:, 0] < across[1] * WIDTH)) for p in self.places
        ]) * self.volume / room  # fmt: skip

    def along(self, heights: Array, half: float = WINDOW) -> Array:
        """Mean solid fraction of the section about each height (m)."""
        return np.array([self.within(z - half, z + half).mean() for z in heights])

    def beside(self, height: float, places: str) -> float:
        """Mean solid fraction of the core or beside both walls, about a height (m)."""
        parts = [CORE] if places == "core" else [(0.0, WALL), (1 - WALL, 1.0)]
        return float(np.mean([self.within(height - LAYER, height + LAYER, one) for one in parts]))

    @property
    def mean(self) -> float:
        """Hold-up between LOW and HIGH."""
        return float(self.within(LOW, HIGH).mean())

    @property
    def flux(self) -> float:
        """Mass of grains that rises between LOW and HIGH, kg/m2/s; steady, it is what is fed."""
        rates = [
            np.sum(up[(p[:, 2] >= LOW) & (p[:, 2] < HIGH)])
            for p, up in zip(self.places, self.upward, strict=True)
        ]  # fmt: skip
        return float(np.mean(rates)) * DENSITY * self.volume / ((HIGH - LOW) * WIDTH * self.depth)

    @property
    def chance(self) -> float:
        """Half the 95 % interval of it, from the scatter of BLOCKS parts of the time."""
        parts = [part.mean() for part in np.array_split(self.within(LOW, HIGH), BLOCKS)]
        return float(student.ppf(0.975, BLOCKS - 1) * np.std(parts, ddof=1) / BLOCKS**0.5)


def riser_case(folder: Path, velocity: float, models: Models) -> Path:
    """A riser with gas (m/s, superficial) through its bottom, which grains do not pass, and grains
    that are let go at rest just above it at a constant rate; at first others are spread evenly in
    it. Its front half alone, up to the plane of symmetry. Not yet run."""
    end = models.settles + models.averaged
    divergences = "system/fvSchemes:divSchemes/div(alphaPhi.air"
    case = BoxCase(
        width=WIDTH, depth=models.depth / 2, height=models.height, cells=models.cells,
        gas_velocity=velocity, gas_viscosity=NU, side_velocity="noSlip",
        solve_gas=True, gas_courant=1.0, coupled=True,
        contacts=Contacts(Pair(models.restitution, models.friction), step_fraction=0.2),
        dispersion="continuousDispersionRAS", tolerance=(1e-6, 1e-2),
        forces={models.drag: {"alphac": "alpha.air"}, "gravity": {}},
        step=models.step, end=end, interval=min(FRAME, models.averaged / BLOCKS),
        more={f"{PARAMETERS}:bottomType": "wall", f"{PARAMETERS}:northType": "symmetry",
              f"{CONTROL}:writePrecision": 7,
              f"{divergences},U.air)": ("Gauss", "limitedLinearV", 1),
              f"{divergences},k.air)": ("Gauss", "upwind"),
              f"{divergences},epsilon.air)": ("Gauss", "upwind")},
    ).make(folder, _spread(START[velocity], models))  # fmt: skip
    _stir(case, velocity)
    add_zone(case, "fed", (0, 0, 0), (models.fed_within * WIDTH, models.depth / 2, FED_BELOW))
    rate = models.flux * WIDTH * models.depth / 2
    feed = {"outlets": {"out": ["top"]}, "zone": "fed", "massFlowRate": rate, "duration": end,
            "materials": material(DENSITY, type="fixedValue", value=DIAMETER)}  # fmt: skip
    if models.grains > 1:
        weight = case / "0/lagrangian/kinematicCloud/nParticle"
        weight.write_text(weight.read_text().replace("{1}", f"{{{models.grains}}}"))
        feed["parcels"] = "evenMass"
        feed["particles"] = round(rate * end / (DENSITY * VOLUME * models.grains))
    add_feed(case, feed)
    return case


def _spread(fraction: float, models: Models) -> Particles:
    """Grains at places drawn from a lattice in the whole riser, at a solid fraction."""
    random = np.random.default_rng(1)
    room = (WIDTH, models.depth / 2, models.height)
    number = round(fraction * float(np.prod(room)) / (VOLUME * models.grains))
    axes = [np.arange(0.7, side / DIAMETER - 0.7, 1.3) * DIAMETER for side in room]
    grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    place = grid[random.permutation(len(grid))[:number]]
    velocity = random.normal([0, 0, 0.5], 0.1, place.shape)  # m/s
    return Particles.of(place, velocity, diameter=DIAMETER, density=DENSITY)


def _stir(case: Path, velocity: float) -> None:
    """Turbulence of a channel, at the start and where the gas enters; solvers for it."""
    friction = 0.05 * velocity
    k, epsilon = 3.3 * friction**2, friction**3 / (0.1 * WIDTH / 2)
    set_turbulence(case, k, epsilon, wall_functions=True)
    solver = {"solver": "smoothSolver", "smoother": "symGaussSeidel", "tolerance": 1e-7,
              "relTol": 0.01}  # fmt: skip
    change(case, {
        f'{SOLUTION}:solvers/"(k|epsilon).air(Final)?"': solver,
        "0/k.air:boundaryField/inflow": {"type": "fixedValue", "value": k},
        "0/epsilon.air:boundaryField/inflow": {"type": "fixedValue", "value": epsilon},
    })  # fmt: skip


def rise(folder: Path, velocity: float, models: Models = STANDARD) -> Grains:
    """The riser's grains once the flow is steady."""
    case = riser_case(folder, velocity, models)
    solve(case)
    return read_grains(case, models)


def read_grains(case: Path, models: Models) -> Grains:
    """Of a run, the states after it has settled."""
    written = [name for name in times(case) if float(name) > models.settles + 1e-6]
    states = [read_particles(case, name) for name in written]
    cells = np.mean([1 - read_gas(case, name, "alpha.air").mean() for name in written])
    return Grains([state.position for state in states], [state.velocity[:, 2] for state in states],
                  models.grains * VOLUME, models.depth / 2, float(cells))  # fmt: skip


def riser(folder: Path, quick: bool) -> Section:
    section = Section(
        "Hold-up in a riser near the settling velocity, measured (Carlos Varas et al. 2017)",
        "Glass grains of 0.85 mm (settling velocity 5.95 m/s) in a pseudo-2D riser of 1.57 m x 70 "
        f"mm, at {FAST:g} m/s of gas: hold-up against height, and in the core and beside the "
        "walls. Every grain of the front half is computed, with its contacts; the middle of the "
        "depth is a plane of symmetry. Gas enters evenly through the bottom; grains are let go at "
        f"rest in the lowest {1e3 * FED_BELOW:g} mm and leave at the top. The riser starts with "
        f"an even solid fraction of {START[FAST]:g}; means are over {STANDARD.averaged:g} s after "
        f"{STANDARD.settles:g} s. Drag by Gidaspow (the default law with a void fraction), "
        "restitution 0.97, friction 0.1, k-epsilon with wall functions, dispersion, cells of 7 x "
        f"3.5 x 15 mm, steps of {1e3 * STANDARD.step:g} ms. What is at hand of the source gives "
        "the depth as 6 to 8 mm and the flux as 25 to 32 kg/m2/s: taken are the middles, 7 mm and "
        "28.5 kg/m2/s. How grains enter and leave in the laboratory is not known here either. "
        f"Allowed: 15 % of the mean hold-up from {LOW:g} to {HIGH:g} m; beside the walls there "
        "must be more than in the core. Chance is from the scatter of four parts of the time: what "
        "swings more slowly is not in it.",
    )
    found = {FAST: rise(folder / "fast", FAST, QUICK if quick else STANDARD)}
    section.rows += _rows(FAST, found[FAST], quick)
    _draw(section, "riser", found)
    return section


def riser_slower(folder: Path, quick: bool) -> Section:
    section = Section(
        "The riser: slower gas, measured (Carlos Varas et al. 2017)",
        f"As above, at {SLOW:g} m/s, from an even solid fraction of {START[SLOW]:g}; and how the "
        f"hold-up changes with the velocity, for which {FAST:g} m/s is computed once more. "
        "Allowed: 15 % of that too.",
    )
    models, speeds = (QUICK, (SLOW,)) if quick else (STANDARD, (SLOW, FAST))
    found = {speed: rise(folder / slug(f"{speed:g}"), speed, models) for speed in speeds}
    section.rows += _rows(SLOW, found[SLOW], quick)
    if not quick:
        section.rows.append(
            Row.relative(f"gas at {SLOW:g} over {FAST:g} m/s", "mean hold-up, ratio",
                         measured_mean(SLOW) / measured_mean(FAST),
                         found[SLOW].mean / found[FAST].mean, ALLOWED,
                         "authors' LES-DEM +43 %; an Euler-Lagrange code -25 %")
        )  # fmt: skip
    _draw(section, "riser_slower", found)
    return section


def _rows(velocity: float, ours: Grains, quick: bool) -> list[Row]:
    case = f"gas at {velocity:g} m/s"
    rows = [
        _mean(case, velocity, ours, None if quick else ALLOWED),
        Row.relative(case, "the same by the drag law alone, grains and gas spread evenly",
                     measured_mean(velocity), even_suspension(velocity, STANDARD), None),
    ]  # fmt: skip
    rows += [
        Row.relative(case, f"mean hold-up from {low:g} to {high:g} m",
                     measured_mean(velocity, low, high), float(ours.within(low, high).mean()), None)
        for low, high in pairwise((LOW, ENTRANCE, HIGH))
    ]  # fmt: skip
    height, fraction = measured(velocity, "section")
    rows += [
        Row.relative(case, f"hold-up at {z:g} m", value, float(own), None)
        for z, value, own in zip(height, fraction, ours.along(height), strict=True)
    ]  # fmt: skip
    rows += _places(case, velocity, ours, quick)
    rows.append(
        Row.relative(case, "solid fraction of the whole riser, by the grains and by the gas' cells",
                     float(ours.within(0, HEIGHT).mean()), ours.cells, SAME)
    )  # fmt: skip
    rows.append(
        Row.relative(case, STEADY, STANDARD.flux, ours.flux, None if quick else ALLOWED)
    )  # fmt: skip
    return rows


def _mean(case: str, velocity: float, ours: Grains, allowed: float | None = None) -> Row:
    return Row.relative(
        case, f"mean hold-up from {LOW:g} to {HIGH:g} m (chance: +-{ours.chance:.4f})",
        measured_mean(velocity), ours.mean, allowed, PEERS[velocity] if allowed else "",
    )  # fmt: skip


def _places(case: str, velocity: float, ours: Grains, quick: bool) -> list[Row]:
    """Core and walls, of which the measured ones differ from each other."""
    rows = []
    height, core = measured(velocity, "core")
    walls = np.mean([measured(velocity, wall)[1] for wall in ("wall", "other wall")], axis=0)
    for z, inner, outer in zip(height, core, walls, strict=True):
        in_core, at_wall = ours.beside(z, "core"), ours.beside(z, "walls")
        rows += [
            Row.relative(f"{case}, {z:g} m", "solid fraction of the core", inner, in_core, None),
            Row.relative(f"{case}, {z:g} m", "solid fraction beside the walls, mean of both",
                         outer, at_wall, None),
            Row(f"{case}, {z:g} m", "walls over core (error: 1 where the core has more)",
                outer / inner, at_wall / max(in_core, 1e-9), float(at_wall <= in_core),
                None if quick else 0),
        ]  # fmt: skip
    return rows


def riser_inputs(folder: Path, quick: bool) -> Section:
    section = Section(
        "The riser: what is not known of it",
        "As above, with both ends of what is at hand of the flux (25 to 32 kg/m2/s) and the depth "
        "(6 to 8 mm), one at a time, the other in its middle; for information.",
    )
    found: dict[float, list[Grains]] = {}
    for speed in (FAST,) if quick else (FAST, SLOW):
        tried = {"quick": QUICK} if quick else UNKNOWN
        for name, models in tried.items():
            ours = rise(folder / slug(f"{speed:g}", name), speed, models)
            found.setdefault(speed, []).append(ours)
            section.rows.append(_mean(f"gas at {speed:g} m/s, {name}", speed, ours))
    figure, (axes,) = new_figure(95)
    for (speed, runs), colour in zip(found.items(), (BLUE, RED), strict=False):
        lines = 100 * np.array([one.along(HEIGHTS) for one in runs])
        axes.fill_betweenx(HEIGHTS, lines.min(axis=0), lines.max(axis=0), color=colour, alpha=0.3,
                           lw=0, label=f"{speed:g} m/s")  # fmt: skip
        _draw_measured(axes, speed, colour)
    _finish(axes)
    section.figures["riser_inputs"] = (
        figure, "Hold-up against height; band: flux 25 to 32 kg/m2/s, depth 6 to 8 mm."
    )  # fmt: skip
    return section


def riser_settings(folder: Path, quick: bool) -> Section:
    section = Section(
        "The riser's entrance: what each setting matters",
        f"The lowest {ENTRY.height:g} m of the riser alone, at {FAST:g} m/s, one setting "
        f"changed at a time; mean of {ENTRY.averaged:g} s after {ENTRY.settles:g} s; for "
        "information. Fed at one side: into a fifth of the width.",
    )
    changed = {"10 grains a parcel": replace(QUICK, grains=10)} if quick else CHANGED
    heights = HEIGHTS[HEIGHTS < ENTRANCE + 0.01]
    figure, (axes,) = new_figure(95)
    for (name, models), colour in zip(changed.items(), COLOURS, strict=False):
        ours = rise(folder / slug(name), FAST, models)
        section.rows.append(
            Row.relative(name, f"mean hold-up from {LOW:g} to {ENTRANCE:g} m",
                         measured_mean(FAST, LOW, ENTRANCE),
                         float(ours.within(LOW, ENTRANCE).mean()), None)
        )  # fmt: skip
        axes.plot(100 * ours.along(heights), heights, lw=0.9, color=colour, label=name)
    _draw_measured(axes, FAST, "k", ENTRY.height)
    axes.set_ylim(0, 1.4 * ENTRY.height)
    _finish(axes)
    section.figures["riser_settings"] = (figure, "Hold-up against height, one setting at a time.")
    return section


def _draw(section: Section, name: str, found: Mapping[float, Grains]) -> None:
    figure, (above, below) = new_figure(150, rows=2, height_ratios=(1.4, 1))
    across = np.linspace(0, 1, 11)
    for (velocity, ours), colour in zip(found.items(), (BLUE, RED), strict=False):
        above.plot(100 * ours.along(HEIGHTS), HEIGHTS, color=colour,
                   label=f"{velocity:g} m/s")  # fmt: skip
        _draw_measured(above, velocity, colour)
        parts = [
            100 * ours.within(PLACE - LAYER, PLACE + LAYER, (float(a), float(b))).mean()
            for a, b in pairwise(across)
        ]  # fmt: skip
        below.stairs(parts, across, color=colour, label=f"{velocity:g} m/s")
        for place, where in (("core", 0.5), ("wall", 0.95), ("other wall", 0.05)):
            height, fraction = measured(velocity, place)
            below.plot(where, 100 * fraction[height == PLACE], "s", ms=4, mfc="none", color=colour)
    _finish(above)
    below.set_ylim(0, None)
    label(below, "place over the width", f"solid fraction at {PLACE:g} m, %", fontsize=6)
    section.figures[name] = (
        figure, f"Above: hold-up against height. Below: across the width at {PLACE:g} m; measured "
        "(squares): core and both walls."
    )  # fmt: skip


def _draw_measured(axes: Axes, velocity: float, colour: str, highest: float = HIGH) -> None:
    looks: dict[str, Any] = {
        "measured": {"marker": "s", "ms": 4, "mfc": "none", "ls": ""},
        "simulated": {"ls": ":", "lw": 0.9},
    }
    for source, name in (("measured", "measured"), ("simulated", "authors' LES-DEM")):
        height, fraction = measured(velocity, "section", source)
        shown = height <= highest
        axes.plot(100 * fraction[shown], height[shown], color=colour,
                  label=f"{velocity:g} m/s, {name}", **looks[source])  # fmt: skip


def _finish(axes: Axes) -> None:
    axes.set_xlim(0, None)
    label(axes, "solid fraction, %", "height, m", fontsize=6)
