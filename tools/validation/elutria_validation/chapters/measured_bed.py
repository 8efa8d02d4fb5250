"""Rise times of light spheres through a small fluidised bed of glass beads, as measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from elutria.physics.drag import drag_coefficient
from elutria_validation.book.figures import COLOURS, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase, Contacts, Material, Pair
from elutria_validation.harness.cases import (
    CONTROL,
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

FRAME, PIECE, LIMIT = 0.1, 0.5, 9.0
"""s: between states that are looked at, of a run at a time, after which it is given up; the last is
above every measured interval of what is computed, so that what has not risen fails."""
SETTLING = 0.5  # s
STILL = 1.2
"""m/s: gas that does not lift the settled bed."""
ALLOWED_STILL = 0.05
UPPER = 1.053
"""Of the gas velocity: the upper end of what is known of it, over its value."""
FASTER = f"gas {100 * (UPPER - 1):.1f} % faster"
LOW, HIGH = 0.02, 0.06
"""m: heights between which an intruder's speed is taken."""
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
    friction: float | None = None  # of all pairs; None: as measured
    uneven: float = 0.0  # share by which gas through neighbouring faces of the bottom differs
    more: Mapping[str, Any] = field(default_factory=dict)

    def contacts(self) -> Contacts:
        """Stepped contacts with a modulus that a step can follow."""
        pairs = {**LIGHT_PAIRS, **{f"light-{wall}": LIGHT_PAIRS["glass-light"] for wall in WALLS}}
        entries = {
            name: {"restitution": pair.restitution, "friction": self._friction(pair)}
            for name, pair in pairs.items()
        }
        glass, wall = (
            replace(one, friction=self._friction(one)) for one in (GLASS_PAIR, WALL_PAIR)
        )
        return Contacts(glass, wall, treatment="soft", particle=Material(self.young),
                        step_fraction=0.2, more={"pairs": entries})  # fmt: skip

    def _friction(self, pair: Pair) -> float:
        return pair.friction if self.friction is None else self.friction

    def inflow(self, velocity: float) -> dict[str, Any]:
        """Entry of the bottom's gas velocity (m/s, superficial) where it is uneven."""
        if self.uneven == 0:
            return {}
        x, y = np.indices(self.cells[:2]).reshape(2, -1)
        upward = velocity * (1 + self.uneven * (2 * ((x + y) % 2) - 1))
        faces = np.column_stack([0 * upward, 0 * upward, upward])
        return {"0.orig/U.air:boundaryField/inflow/inletVelocity": faces}


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


FLOWS = {Flow(1.99, "large", 2): 2}
SLOWER_AND_FASTER = {Flow(1.83, "large", 1): 1, Flow(2.14, "large", 2): 2}
"""What is computed, and in how many runs; once more each with the upper end of the velocity."""


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
              **patch_mean("bottom", "p"), **models.inflow(velocity), **models.more},
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
    (times, intruders), the beads' mean height (m) and the root mean square of their vertical speeds
    (m/s); the bed's mean pressure drop (Pa)."""

    time: Array
    height: Array
    share: Array
    mean: Array
    stir: Array
    drop: float

    def times(self, share: float = SEEN) -> Array:
        """When each was first seen by that share, s, in their order; LIMIT where it was not."""
        at = np.where(self.share >= share, self.time[:, None], LIMIT)
        return np.sort(at.min(axis=0))

    @property
    def late(self) -> Array:
        """Which times are of the second half."""
        return np.asarray(self.time > self.time[-1] / 2)

    @property
    def stirred(self) -> float:
        """The beads' vertical speed in the second half, m/s: a bed at rest has next to none."""
        return float(self.stir[self.late].mean())

    def speeds(self) -> Array:
        """Of each intruder between two heights, m/s; of those that got there."""
        there = self.height.max(axis=0) > HIGH
        low, high = (self.time[(self.height[:, there] > z).argmax(axis=0)] for z in (LOW, HIGH))
        return np.asarray((HIGH - LOW) / (high - low))

    def depth(self, radius: float) -> float:
        """Of the uppermost intruder's top below the bed's surface in the second half, m; the
        surface is taken at twice the beads' mean height."""
        covered = 2 * self.mean[:, None] - self.height - radius
        return float(covered[self.late].mean(axis=0).min())


def rise(folder: Path, bed: Particles, velocity: float, models: Models = STANDARD,
         limit: float = LIMIT) -> Rise:  # fmt: skip
    """Gas (m/s) through a settled bed with intruders on its bottom, until all have risen."""
    case = fluidised(folder, bed, velocity, models, 0)
    light = np.flatnonzero(bed.density < GLASS_DENSITY).tolist()
    time: list[float] = []
    height: list[Array] = []
    share: list[list[float]] = []
    beads: list[tuple[float, float]] = []
    while not time or (time[-1] < limit - 1e-6 and np.max(share, axis=0).min() < LATER):
        change(case, {f"{CONTROL}:endTime": min(limit, round(sum(time[-1:]) + PIECE, 6))})
        solve(case)
        for name in times(case):
            if float(name) > sum(time[-1:]) + 1e-6:
                state = read_particles(case, name)
                time.append(float(name))
                height.append(state.position[light, 2])
                share.append([seen(state, k) for k in light])
                own = state.density >= GLASS_DENSITY
                beads.append((float(state.position[own, 2].mean()),
                              float(np.sqrt(np.mean(state.velocity[own, 2] ** 2)))))  # fmt: skip
    mean, stir = np.array(beads).T
    return Rise(np.array(time), np.array(height), np.array(share), mean, stir, _drop(case))


def _drop(case: Path) -> float:
    """Mean pressure drop of the second half of a run, Pa, without the gas' own weight."""
    found = case.glob("postProcessing/bottom/*/surfaceFieldValue.dat")
    series = np.concatenate([np.loadtxt(file, ndmin=2) for file in found])
    late = series[:, 0] > series[:, 0].max() / 2
    return float(series[late, 1].mean()) * ROOM.density - ROOM.density * STANDARD_GRAVITY * HEIGHT


def gradient(drag: str, velocity: float, void: float, diameter: float) -> float:
    """Pressure gradient of a bed at rest by a drag law, at a superficial velocity (m/s), Pa/m."""
    slip = velocity / void
    reynolds = slip * diameter * ROOM.density / ROOM.viscosity
    coefficient = float(drag_coefficient(drag, reynolds, void))
    return 0.75 * (1 - void) * coefficient * ROOM.density * slip**2 / diameter


def weight(void: float) -> float:
    """Of the beads in the gas, per volume of the bed, N/m3."""
    return (1 - void) * (GLASS_DENSITY - ROOM.density) * STANDARD_GRAVITY


def carried(drag: str, velocity: float) -> float:
    """Void fraction at which the gas carries beads that lie still."""
    spread = (SCATTER / GLASS) ** 2
    sauter = GLASS * (1 + 3 * spread) / (1 + spread)
    return float(
        brentq(lambda void: gradient(drag, velocity, void, sauter) - weight(void), 0.3, 0.8)
    )


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
        return gradient(models.drag, velocity, void, mean)

    lift = float(brentq(lambda u: law(u) * ours / law(STILL) - weight(void), 0.1, 10))
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
        "known to 5.3 %: each flow is run once more at the upper end of that, for information. A "
        f"run ends after {LIMIT:g} s. First, gas that does not lift the settled bed: the pressure "
        "gradient in its middle beside closed forms at the void fraction there.",
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
    upper: dict[Flow, Rise] = {}
    for flow, number in flows.items():
        for seed in range(1, 1 + number):
            place = folder / f"flow{len(found)}-{seed}"
            bed = settled(place / "settled", poured(flow.sizes, seed), STANDARD)
            if not section.rows:
                section.rows += still(place / "still", bed)
            limit = 0.2 if quick else LIMIT
            one = rise(place / "gas", bed, flow.velocity, STANDARD, limit)
            if quick:
                section.rows.append(
                    Row.size(f"{flow.name}, 0.2 s", "share of an intruder seen", one.share.max(), 0)
                )
                return section
            found.setdefault(flow, []).append(one)
            if seed == 1:
                upper[flow] = rise(place / "upper", bed, UPPER * flow.velocity, STANDARD, limit)
        section.rows += _rows(flow, found[flow], upper[flow])
    section.found = _found(found)
    _draw(section, found, upper)
    return section


def _rows(flow: Flow, runs: list[Rise], upper: Rise) -> list[Row]:
    ours = np.array([one.times() for one in runs])
    whole = (MASS + LIGHT_DENSITY * pi / 6 * sum(d**3 for d in flow.sizes)) * STANDARD_GRAVITY
    mean, interval = flow.measured()
    rows = [
        Row.relative(
            flow.name, f"rise time of number {k + 1}, s (mean of {len(runs)}: "
            f"{ours[:, k].min():.1f} to {ours[:, k].max():.1f}, {LIMIT:g}: not risen)",
            mean[k], float(ours[:, k].mean()), float(interval[k] / mean[k]),
        ) for k in range(flow.number)
    ]  # fmt: skip
    drop = float(np.mean([one.drop for one in runs]))
    rows.append(Row.relative(flow.name, "pressure drop beside the bed's weight, Pa",
                             whole / (WIDTH * DEPTH), drop, None))  # fmt: skip
    for name, those in ((flow.name, runs), (f"{flow.name}, {FASTER}", [upper])):
        rows += motion(name, flow, those)
    return rows


def motion(name: str, flow: Flow, runs: list[Rise]) -> list[Row]:
    """For information: whether the beads move, how fast the intruders rise, where they stay."""
    stirred = float(np.mean([one.stirred for one in runs]))
    rows = [Row.size(name, "vertical speed of the beads, rms in the second half, m/s; error: "
                     "itself", stirred, None)]  # fmt: skip
    solid = MASS / GLASS_DENSITY + sum(pi / 6 * d**3 for d in flow.sizes)
    height = 2 * np.mean([one.mean[one.late].mean() for one in runs])
    rows.append(Row.size(name, "void fraction of the whole bed, second half; error: itself",
                         float(1 - solid / (WIDTH * DEPTH * height)), None))  # fmt: skip
    speeds = np.concatenate([one.speeds() for one in runs])
    if len(speeds):
        radius = flow.sizes[0] / 2
        way = 2 * float(np.mean([one.mean.mean() for one in runs])) - 2 * radius
        rows.append(
            Row.relative(name, f"speed of the {len(speeds)} intruders of {flow.number * len(runs)} "
                         f"that get from {1e3 * LOW:g} to {1e3 * HIGH:g} mm, m/s, beside the bed's "
                         "height over the measured time", way / float(flow.measured()[0].mean()),
                         float(speeds.mean()), None)
        )  # fmt: skip
    deep = float(np.mean([one.depth(flow.sizes[0] / 2) for one in runs]))
    rows.append(Row.size(name, "depth of the uppermost intruder's top below the surface, second "
                         "half, m; error: itself", deep, None))  # fmt: skip
    return rows


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


def _draw(section: Section, found: Mapping[Flow, list[Rise]], upper: Mapping[Flow, Rise]) -> None:
    figure, (above, below) = new_figure(125, rows=2, height_ratios=(1, 1.2))
    for number, (flow, runs) in enumerate(found.items()):
        mean, interval = flow.measured()
        place = number + np.linspace(-0.2, 0.2, 2 * flow.number + 2)[1:-1].reshape(-1, 2)
        above.errorbar(place[:, 0], mean, interval, fmt="s", ms=4, mfc="none", color="k", capsize=2,
                       label="measured, mean and 95 %" if number == 0 else None)  # fmt: skip
        ours = np.array([one.times() for one in runs])
        above.plot(np.broadcast_to(place[:, 1], ours.shape).ravel(), ours.ravel(), ".", ms=4,
                   color=RED, label="each run" if number == 0 else None)  # fmt: skip
        colour = COLOURS[number]
        for k, one in enumerate(runs):
            below.plot(one.time, 1e3 * one.height, color=colour, lw=0.8)
            if k == 0:
                below.plot(one.time, 2e3 * one.mean, ":", color=colour, lw=0.7)
        below.plot(upper[flow].time, 1e3 * upper[flow].height, "--", color=colour, lw=0.8)
        below.plot([], [], color=colour, label=flow.name)
    below.plot([], [], "--", color="k", lw=0.8, label=FASTER)
    below.plot([], [], ":", color="k", lw=0.7, label="the bed's surface")
    above.axhline(LIMIT, color="0.6", lw=0.6)
    above.set_xticks(range(len(found)), [flow.name for flow in found])
    above.set_xlim(-0.5, len(found) - 0.5)
    above.set_ylim(0, 1.1 * LIMIT)
    above.set_ylabel("rise time, s")
    above.legend(loc="lower right")
    below.set_ylim(0, 145)
    label(below, "time, s", "height of the intruders' centres, mm", fontsize=6, loc="upper left",
          ncols=2)  # fmt: skip
    section.figures["bed" if FLOWS.keys() == found.keys() else "bed_velocities"] = (
        figure, "Above: rise times, one behind the other where several rise; on the grey line: not "
        "risen. Below: heights of their centres, and of the bed's surface (twice the mean of the "
        "beads'; first run)."
    )  # fmt: skip
