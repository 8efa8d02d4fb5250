"""Rise times of light spheres through a small fluidised bed of glass beads, as measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import t as student

from elutria.physics.drag import drag_coefficient
from elutria_validation.book.figures import COLOURS, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase, Contacts, Material, Pair
from elutria_validation.harness.cases import (
    CONTROL,
    MODELS,
    PARAMETERS,
    add_feed,
    change,
    material,
    patch_mean,
    read_gas,
    solve,
    times,
)
from elutria_validation.harness.particles import HEADER, Particles, read_particles
from elutria_validation.references.drag import STANDARD_GRAVITY, Gas, read_table
from elutria_validation.references.flows import ergun, minimum_fluidisation

Array = NDArray[np.float64]

WIDTH, DEPTH, HEIGHT = 38.09e-3, 38.11e-3, 228.6e-3  # m
MASS = 0.17746  # kg of glass
GLASS, SCATTER, GLASS_DENSITY = 3.101e-3, 0.187e-3, 2522.0  # m, m, kg/m3
INTRUDERS, LIGHT_DENSITY = {"large": 9.430e-3, "small": 3.155e-3}, 941.0  # m, kg/m3
ROOM = Gas(83770 / (287.05 * 293.15), 1.813e-5)
"""Air at 83.77 kPa and 293.15 K."""
GLASS_PAIR, WALL_PAIR = Pair(0.9696, 0.2736), Pair(0.9549, 0.2514)
LIGHT_PAIRS = {"glass-light": Pair(0.8230, 0.3041), "light-light": Pair(0.8217, 0.3768)}
"""Of the intruders; with walls, which was not measured, they are taken as with glass."""
WALLS = ("west", "east", "south", "north", "bottom")

FRAME, PIECE, LIMIT = 0.1, 0.5, 12.0
"""s: between states that are looked at, of a run at a time, after which it is given up."""
SETTLING = 0.5  # s
STILL = 1.2
"""m/s: gas that does not lift the settled bed."""
ALLOWED_STILL = 0.05
SEEN, SOONER, LATER = 0.5, 0.1, 0.8
"""Share of an intruder that is seen from above once it has risen; what else that could mean."""


@dataclass(frozen=True)
class Models:
    """One set of settings for all flows."""

    drag: str = "BeetstraDrag"
    young: float = 1e6  # Pa
    cells: tuple[int, int, int] = (6, 6, 36)
    kernel: float = 1.5 * GLASS  # m
    step: float = 2e-3  # s
    more: Mapping[str, Any] = field(default_factory=dict)

    def contacts(self) -> Contacts:
        """Stepped contacts with a modulus that a step can follow."""
        pairs = {**LIGHT_PAIRS, **{f"light-{wall}": LIGHT_PAIRS["glass-light"] for wall in WALLS}}
        entries = {
            name: {"restitution": pair.restitution, "friction": pair.friction}
            for name, pair in pairs.items()
        }
        return Contacts(GLASS_PAIR, WALL_PAIR, treatment="soft", particle=Material(self.young),
                        step_fraction=0.2, more={"pairs": entries})  # fmt: skip


STANDARD = Models()


@dataclass(frozen=True)
class Flow:
    """Superficial velocity (m/s), kind and number of the intruders."""

    velocity: float
    kind: str
    number: int

    @property
    def name(self) -> str:
        return f"{self.velocity:g} m/s, {self.number} {self.kind}"

    @property
    def sizes(self) -> list[float]:
        """Of the intruders, m."""
        return [INTRUDERS[self.kind]] * self.number

    def measured(self) -> tuple[Array, Array]:
        """Mean rise times of the intruders in their order, and half their 95 % intervals, s."""
        rows = [
            (float(row["time_s"]), float(row["interval_s"])) for row in read_table("lamarche2022")
            if (float(row["velocity_m_s"]), row["intruder"], int(row["number"]))
            == (self.velocity, self.kind, self.number)
        ]  # fmt: skip
        mean, interval = np.array(rows).T
        return mean, interval


FLOWS = {Flow(1.99, "large", 2): 1}
SLOWER_AND_FASTER = {Flow(1.83, "large", 1): 1, Flow(2.14, "large", 2): 1}
"""What is computed, and in how many runs."""


def poured(sizes: list[float], seed: int) -> Particles:
    """Intruders of `sizes` (m) at random places of the bottom; beads on a shaken lattice above."""
    random = np.random.default_rng(seed)
    number = round(MASS / (GLASS_DENSITY * pi / 6 * GLASS**3 * (1 + 3 * (SCATTER / GLASS) ** 2)))
    beads = random.normal(GLASS, SCATTER, number)
    low: list[Array] = []
    while len(low) < len(sizes):
        radius = sizes[len(low)] / 2
        across = random.uniform([radius] * 2, [WIDTH - radius, DEPTH - radius])
        if all(np.hypot(*(across - other[:2])) > 2.02 * radius for other in low):
            low.append(np.array([*across, radius]))
    pitch = 1.22 * GLASS
    rows = int(WIDTH / pitch)
    layers = -(-number // rows**2)
    grid = np.indices((layers, rows, rows)).reshape(3, -1).T[:number, ::-1] + 0.5
    place = grid * [WIDTH / rows, DEPTH / rows, pitch] + [0, 0, max(sizes, default=0.0)]
    place += random.uniform(-0.05, 0.05, place.shape) * GLASS
    velocity = np.vstack([random.uniform(-0.2, 0.2, place.shape), np.zeros((len(low), 3))])
    density = [GLASS_DENSITY] * number + [LIGHT_DENSITY] * len(low)
    return Particles.of(np.vstack([place, *low]), velocity,
                        diameter=np.r_[beads, sizes], density=density)  # fmt: skip


def _made(folder: Path, box: BoxCase, start: Particles) -> Path:
    """A box whose particles are beads and intruders, the two materials of a feed that begins after
    the end."""
    case = box.make(folder, start)
    light = (start.density < GLASS_DENSITY).astype(int)
    where = "0/lagrangian/kinematicCloud"
    (case / where / "typeId").write_text(
        HEADER.format("labelField", where, "typeId")
        + f"{light.size}\n(\n" + "\n".join(map(str, light)) + "\n)\n"
    )  # fmt: skip
    sizes = {"type": "fixedValue", "value": GLASS}
    kinds = {name: {**material(density, **sizes)["solid"], "massFraction": 0.5}
             for name, density in (("glass", GLASS_DENSITY), ("light", LIGHT_DENSITY))}  # fmt: skip
    add_feed(case, {"materials": kinds, "massFlowRate": 1e-3, "particles": 1, "start": 1e3,
                    "outlets": {"out": ["top"]}})  # fmt: skip
    return case


def settled(folder: Path, start: Particles, models: Models) -> Particles:
    """The bed at rest, without gas."""
    top = float(start.position[:, 2].max()) + GLASS
    box = BoxCase(width=WIDTH, depth=DEPTH, height=max(HEIGHT, top), step=5e-4, end=SETTLING,
                  forces={"gravity": {}}, contacts=models.contacts(),
                  more={f"{PARAMETERS}:bottomType": "wall"})  # fmt: skip
    case = _made(folder, box, start)
    solve(case)
    found = read_particles(case, times(case)[-1])
    return Particles.of(found.position, 0, 0, found.diameter, found.density)


def fluidised(folder: Path, bed: Particles, velocity: float, models: Models, end: float) -> Path:
    """A case of a settled bed with gas through its bottom from the first moment on, not yet run."""
    box = BoxCase(
        width=WIDTH, depth=DEPTH, height=HEIGHT, cells=models.cells, gas_velocity=velocity,
        side_velocity="noSlip", gas_density=ROOM.density,
        gas_viscosity=ROOM.viscosity / ROOM.density, solve_gas=True, coupled=True,
        most_solids=0.9, kernel=models.kernel, contacts=models.contacts(),
        forces={models.drag: {"alphac": "alpha.air"}, "gravity": {}}, tolerance=(1e-7, 1e-2),
        step=models.step, end=end, interval=FRAME,
        more={f"{PARAMETERS}:bottomType": "wall", f"{CONTROL}:writePrecision": 10,
              **patch_mean("bottom", "p"), **models.more},
    )  # fmt: skip
    return _made(folder, box, bed)


def seen(state: Particles, k: int, rays: int = 200) -> float:
    """Share of sphere k's disc that no sphere above its centre covers, looked at from above."""
    centre, radius = state.position[k], state.diameter[k] / 2
    n = np.arange(rays) + 0.5
    out, angle = radius * np.sqrt(n / rays), n * pi * (1 + 5**0.5)
    spots = centre[:2] + np.column_stack([out * np.cos(angle), out * np.sin(angle)])
    above = state.position[:, 2] > centre[2]
    apart = np.linalg.norm(spots[:, None] - state.position[None, above, :2], axis=-1)
    return float(np.mean((apart > state.diameter[above] / 2).all(axis=1)))


@dataclass(frozen=True)
class Rise:
    """Times (s), and at each the heights of the intruders (m) and how much of each is seen, shape
    (times, intruders); the bed's mean pressure drop (Pa)."""

    time: Array
    height: Array
    share: Array
    drop: float

    def times(self, share: float = SEEN) -> Array:
        """When each was first seen by that share, s, in their order; LIMIT where it was not."""
        at = np.where(self.share >= share, self.time[:, None], LIMIT)
        return np.sort(at.min(axis=0))


def rise(folder: Path, bed: Particles, velocity: float, models: Models = STANDARD,
         limit: float = LIMIT) -> Rise:  # fmt: skip
    """Gas (m/s) through a settled bed with intruders on its bottom, until all have risen."""
    case = fluidised(folder, bed, velocity, models, 0)
    light = np.flatnonzero(bed.density < GLASS_DENSITY).tolist()
    time: list[float] = []
    height: list[Array] = []
    share: list[list[float]] = []
    while not time or (time[-1] < limit - 1e-6 and np.max(share, axis=0).min() < LATER):
        change(case, {f"{CONTROL}:endTime": min(limit, round(sum(time[-1:]) + PIECE, 6))})
        solve(case)
        for name in times(case):
            if float(name) > sum(time[-1:]) + 1e-6:
                state = read_particles(case, name)
                time.append(float(name))
                height.append(state.position[light, 2])
                share.append([seen(state, k) for k in light])
    return Rise(np.array(time), np.array(height), np.array(share), _drop(case))


def _drop(case: Path) -> float:
    """Mean pressure drop of the second half of a run, Pa, without the gas' own weight."""
    found = case.glob("postProcessing/bottom/*/surfaceFieldValue.dat")
    series = np.concatenate([np.loadtxt(file, ndmin=2) for file in found])
    late = series[:, 0] > series[:, 0].max() / 2
    return float(series[late, 1].mean()) * ROOM.density - ROOM.density * STANDARD_GRAVITY * HEIGHT


def still(folder: Path, bed: Particles, models: Models = STANDARD) -> list[Row]:
    """Pressure gradient above the intruders and below the surface of a settled bed, beside closed
    forms at the void fraction there; and the velocity that would lift it."""
    case = fluidised(folder, bed, STILL, models, FRAME)
    solve(case)
    state = read_particles(case, times(case)[-1])
    layer = HEIGHT / models.cells[2]
    pressure = read_gas(case, times(case)[-1], "p")[:, 0].reshape(models.cells[2], -1).mean(1)
    low, high = 3, int(np.quantile(state.position[:, 2], 0.98) / layer) - 3
    ends = layer * (np.array([low, high]) + 0.5)
    ours = ROOM.density * (float(pressure[low] - pressure[high]) / (ends[1] - ends[0])
                           - STANDARD_GRAVITY)  # fmt: skip
    solid = _below(state, ends[1]) - _below(state, ends[0])
    void = 1 - solid / (WIDTH * DEPTH * (ends[1] - ends[0]))
    mean = float(np.sum(state.diameter**3) / np.sum(state.diameter**2))

    def law(velocity: float) -> float:
        slip = velocity / void
        reynolds = slip * mean * ROOM.density / ROOM.viscosity
        drag = float(drag_coefficient(models.drag, reynolds, void))
        return float(0.75 * (1 - void) * drag * ROOM.density * slip**2 / mean)

    weight = (1 - void) * (GLASS_DENSITY - ROOM.density) * STANDARD_GRAVITY
    lift = float(brentq(lambda u: law(u) * ours / law(STILL) - weight, 0.1, 10))
    name = f"settled bed, void fraction {void:.3f}"
    return [
        Row.relative(name, f"pressure gradient at {STILL:g} m/s, by the drag law itself, Pa/m",
                     law(STILL), ours, ALLOWED_STILL),
        Row.relative(name, "the same by Ergun, Pa/m", ergun(STILL, mean, void, ROOM), ours, None),
        Row.relative(name, "minimum fluidisation by Ergun, m/s",
                     minimum_fluidisation(mean, GLASS_DENSITY, void, ROOM), lift, None),
    ]  # fmt: skip


def _below(state: Particles, height: float) -> float:
    """Volume of the spheres below a height (m), from their caps, m3."""
    radius = state.diameter / 2
    t = np.clip((height - state.position[:, 2]) / radius, -1, 1)
    return float(np.sum(pi * radius**3 * (2 / 3 + t - t**3 / 3)))


def bed(folder: Path, quick: bool) -> Section:
    section = Section(
        "Light spheres in a fluidised bed, measured (LaMarche et al. 2022)",
        "Spheres of polyethylene (9.43 mm, 941 kg/m3) lie under 177.46 g of glass beads (3.1 mm, "
        "2522 kg/m3) in a square bed 38 mm wide; gas lifts them through it, and the time until "
        "each is seen on the surface was measured (7 or more runs each; mean and its 95 % "
        "interval). Computed is each sphere. Assumed, as the source says no more: the intruders "
        "start at random places of the bottom, under a bed that fell on them and came to rest; "
        "the clock starts as the gas does, at its full velocity; one has risen when half of it "
        "is seen from above for the first time. Restitution and friction are those measured, "
        "and the intruders' with walls as with glass. The drag law is Beetstra's, which knows of "
        "sizes: by Gidaspow's, as by any law of one size, a large sphere has too little of the "
        "pressure gradient around it. Cells of 6.35 mm, a kernel of 1.5 bead diameters, Young's "
        "modulus 1 MPa, walls without slip. Allowed: the measured interval. The gas velocity is "
        "known to 5.3 %. First, gas that does not lift the settled bed: the pressure gradient in "
        "its middle beside closed forms at the void fraction there.",
    )
    return _filled(section, folder, FLOWS, quick)


def bed_velocities(folder: Path, quick: bool) -> Section:
    section = Section(
        "Light spheres in a fluidised bed: slower and faster gas, measured (LaMarche et al. 2022)",
        "As above, with one intruder at 1.83 m/s and two at 2.14 m/s.",
    )
    return _filled(section, folder, SLOWER_AND_FASTER, quick)


def _filled(section: Section, folder: Path, flows: Mapping[Flow, int], quick: bool) -> Section:
    """With rows and figure of these flows, each so many times; or of a moment of the first."""
    found: dict[Flow, list[Rise]] = {}
    for flow, number in flows.items():
        for seed in range(1, 1 + number):
            place = folder / f"flow{len(found)}-{seed}"
            bed = settled(place / "settled", poured(flow.sizes, seed), STANDARD)
            if not section.rows:
                section.rows += still(place / "still", bed)
            limit = 0.2 if quick else LIMIT
            found.setdefault(flow, []).append(
                rise(place / "gas", bed, flow.velocity, STANDARD, limit)
            )
        if quick:
            (short,) = found[flow]
            section.rows.append(
                Row.size(f"{flow.name}, 0.2 s", "share of an intruder seen", short.share.max(), 0)
            )
            return section
        section.rows += _rows(flow, found[flow])
    section.found = _found(found)
    _draw(section, found)
    return section


def _rows(flow: Flow, runs: list[Rise]) -> list[Row]:
    ours = np.array([one.times() for one in runs])
    weight = (MASS + LIGHT_DENSITY * pi / 6 * sum(d**3 for d in flow.sizes)) * STANDARD_GRAVITY
    rows = [
        Row.relative(
            flow.name, f"rise time of number {k + 1}, s (mean of {len(runs)}: "
            f"{ours[:, k].min():.1f} to {ours[:, k].max():.1f})", mean, float(ours[:, k].mean()),
            float(interval / mean),
        ) for k, (mean, interval) in enumerate(zip(*flow.measured(), strict=True))
    ]  # fmt: skip
    drop = float(np.mean([one.drop for one in runs]))
    return [*rows, Row.relative(flow.name, "pressure drop beside the bed's weight, Pa",
                                weight / (WIDTH * DEPTH), drop, None)]  # fmt: skip


def _found(found: Mapping[Flow, list[Rise]]) -> str:
    """What other meanings of "risen" would give, and what never rose."""
    parts = []
    for flow, runs in found.items():
        sooner, later = (
            np.mean([one.times(share) for one in runs], axis=0) for share in (SOONER, LATER)
        )
        parts.append(f"{flow.name}: " + ", ".join(
            f"{a:.1f} to {b:.1f} s" for a, b in zip(sooner, later, strict=True)))  # fmt: skip
    never = sum(int((one.times() >= LIMIT).sum()) for runs in found.values() for one in runs)
    return (
        f"Rise times were {SOONER:g} or {LATER:g} of an intruder to be seen: {'; '.join(parts)}. "
        f"Had not risen after {LIMIT:g} s, and count as that: {never}."
    )


def _draw(section: Section, found: Mapping[Flow, list[Rise]]) -> None:
    figure, (above, below) = new_figure(125, rows=2, height_ratios=(1, 1.2))
    for number, (flow, runs) in enumerate(found.items()):
        mean, interval = flow.measured()
        place = number + np.linspace(-0.2, 0.2, 2 * flow.number + 2)[1:-1].reshape(-1, 2)
        above.errorbar(place[:, 0], mean, interval, fmt="s", ms=4, mfc="none", color="k", capsize=2,
                       label="measured, mean and 95 %" if number == 0 else None)  # fmt: skip
        ours = np.array([one.times() for one in runs])
        above.plot(np.broadcast_to(place[:, 1], ours.shape).ravel(), ours.ravel(), ".", ms=4,
                   color=RED, label="each run" if number == 0 else None)  # fmt: skip
        if len(runs) > 1:
            wide = ours.std(axis=0, ddof=1) * student.ppf(0.975, len(runs) - 1) / len(runs) ** 0.5
            above.errorbar(place[:, 1], ours.mean(axis=0), wide, fmt="o", ms=4, color=RED,
                           capsize=2, label="mean and 95 %" if number == 0 else None)  # fmt: skip
        colour = COLOURS[number]
        for one in runs:
            below.plot(one.time, 1e3 * one.height, color=colour, lw=0.7)
        below.plot([], [], color=colour, label=flow.name)
    above.set_xticks(range(len(found)), [flow.name for flow in found])
    above.set_ylim(0, None)
    above.set_ylabel("rise time, s")
    above.legend()
    label(below, "time, s", "height of the intruders' centres, mm")
    section.figures["bed" if FLOWS.keys() == found.keys() else "bed_velocities"] = (
        figure, "Above: rise times, one behind the other where several rise. Below: their heights."
    )  # fmt: skip
