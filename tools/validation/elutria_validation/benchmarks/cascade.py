"""Whether the cascade's partition curves collapse over the Froude number, as Barsky found.

A grain of diameter d in gas of velocity U has Fr = g d (rho_s/rho - 1)/U^2: its weight less
buoyancy over the gas's drag, but for the drag coefficient. Where that is constant (Newton's law,
grain Reynolds numbers above 1000) nothing else tells one gas velocity from another, and the curves
of one cascade over Fr are the same. In air the grains near the cut are below: their drag
coefficient falls with the Reynolds number, and the curves lie apart. The closed form beside them:
all cut the grain whose terminal velocity is the same multiple of U, that of the reference.

The cascade is the delivered one with fewer shelves and coarser cells. All runs are alike but for
what a row says: feed, drain and sizes are the same in units of the shaft's passages and of the
terminal velocity over U.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from math import log
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from elutria.case.case import Case
from elutria.output.style import COLUMN_WIDTH, LINES, MATERIAL_COLOURS, STYLE, log_if_wide
from elutria.physics.drag import GRAVITY, Gas, plug_flow_cut_size, terminal_velocity
from elutria_validation.benchmarks.accuracy_error import Array, Cut, cut_of_events
from elutria_validation.benchmarks.accuracy_runs import Changes, fed, measured
from elutria_validation.harness.cases import PARAMETERS, change
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.programs import project_root, slug
from elutria_validation.harness.provenance import write_result

NAME = "cascade"
HELP = "partition curves of the cascade over the Froude number, at several velocities"
COLUMNS = (
    "point", "gas_velocity_m_s", "density_kg_m3", "viscosity_m2_s", "parcels", "inside", "d50_m",
    "d50_low_m", "d50_high_m", "sharpness", "sharpness_sd", "reynolds", "fr50", "fr50_sd",
    "fr50_change", "fr50_change_closed_form", "settling50", "settling50_change", "curve_froude",
    "curve_settling", "seconds",
)  # fmt: skip
QUARTZ = "constant/feed:materials/quartz"
GAS_DENSITY, AIR, THIN = 1.2, 1.5e-5, 1.5e-7
"""kg/m3; m2/s of air, and of a gas in which Newton's law holds for grains near the cut."""
CELL = 8e-3
"""m, also the shelves' thickness."""
FEED, DRAIN = 1.0, 8.0
"""m, of the gas' way: the time times its velocity."""
SMALLEST, MIDDLE, LARGEST = 1.2, 2.0, 3.2
"""Terminal velocities of the feed's sizes over the gas velocity."""
AROUND = np.exp(np.linspace(log(0.7), log(1.4), 71))
"""Where curves are compared, over the reference's Fr50."""
Row = dict[str, Any]


@dataclass(frozen=True)
class Point:
    """Gas velocity (m/s), density of the grains (kg/m3), kinematic viscosity of the gas (m2/s)."""

    velocity: float
    density: float = 2650
    viscosity: float = AIR

    @property
    def name(self) -> str:
        """As in the table."""
        gas = "air" if self.viscosity == AIR else "thin gas"
        return f"{self.velocity:g} m/s, {self.density:g} kg/m3, {gas}"

    @property
    def gas(self) -> Gas:
        """The gas, by its dynamic viscosity."""
        return Gas(GAS_DENSITY, GAS_DENSITY * self.viscosity)

    def size(self, settling: float) -> float:
        """Diameter (m) of the grain whose terminal velocity is that multiple of U."""
        return plug_flow_cut_size(settling * self.velocity, self.density, self.gas)

    def settling(self, diameter: float) -> float:
        """Terminal velocity over U."""
        return terminal_velocity(diameter, self.density, self.gas) / self.velocity

    def per_metre(self) -> float:
        """Froude number over diameter, 1/m."""
        return GRAVITY * (self.density / GAS_DENSITY - 1) / self.velocity**2

    def changes(self, parcels: int, seed: int) -> Changes:
        """Entries of the case."""
        sizes = f"{QUARTZ}/sizeDistribution"
        return {
            **fed(parcels, FEED / self.velocity, DRAIN / self.velocity),
            f"{PARAMETERS}:gasVelocity": self.velocity,
            f"{PARAMETERS}:seed": seed,
            "constant/transportProperties:nu": self.viscosity,
            f"{QUARTZ}/density": self.density,
            f"{sizes}/min": self.size(SMALLEST),
            f"{sizes}/d63": self.size(MIDDLE),
            f"{sizes}/max": self.size(LARGEST),
            "constant/feed:focus": self.size(MIDDLE),
        }


REFERENCE = Point(3, viscosity=THIN)
POINTS = (
    REFERENCE, Point(3), Point(1.2), Point(4.5, viscosity=THIN), Point(2, 5200), Point(4.5),
    Point(2),
)  # fmt: skip
"""The first is what all are compared with."""
QUICK = POINTS[:2]


@dataclass(frozen=True)
class Options:
    """Its own."""

    parcels: int = option(1500, quick=150, least=10)
    cell: float = option(CELL, quick=0.012, unit="m")
    shelves: int = option(5, quick=3, least=1)
    seed: int = option(1)


def run(job: Job, options: Options) -> None:
    """Run what is not finished; writes cascade.csv, .png and .json."""
    points = QUICK if job.quick else POINTS
    rows, cuts = [], []
    for point in points:
        folder = job.folder / "runs" / slug(point.name)
        done = measured(make_case(folder / "case", point, options), folder / "run")
        cuts.append(cut_of_events(done.run.events))
        rows.append(row(point, cuts[-1], points[0], cuts[0]))
        events = done.run.events
        rows[-1] |= {"parcels": len(events), "inside": int(events.is_inside.sum()),
                     "seconds": done.seconds}  # fmt: skip
        job.say(f"{point.name}: Fr50 {rows[-1]['fr50']:.3f}, {done.seconds:.0f} s")
    with mpl.rc_context(STYLE):
        write_result(job, NAME, COLUMNS, rows, figure(points, cuts))


def make_case(case: Path, point: Point, options: Options) -> Path:
    """The cascade with the settings of a point."""
    shutil.rmtree(case, ignore_errors=True)
    Case(project_root() / "cases/cascade").copy_to(case, [])
    geometry = {
        f"{PARAMETERS}:cellSize": options.cell,
        f"{PARAMETERS}:shelfThickness": options.cell,
        f"{PARAMETERS}:shelves": options.shelves,
        f"{PARAMETERS}:feedShelf": (options.shelves + 1) // 2,
    }
    change(case, {**geometry, **point.changes(options.parcels, options.seed)})
    return case


def row(point: Point, cut: Cut, reference: Point, compared: Cut) -> Row:
    """What a curve's middle is in both scales, and how far it is from the reference's: relative,
    and by the closed form; the curves' root-mean-square differences around the cut."""
    fr50, settling = point.per_metre() * cut.d50, point.settling(cut.d50)
    of_reference = reference.settling(compared.d50)
    fr_reference = reference.per_metre() * compared.d50
    return {
        "point": point.name,
        "gas_velocity_m_s": point.velocity,
        "density_kg_m3": point.density,
        "viscosity_m2_s": point.viscosity,
        **cut.columns(),
        "reynolds": cut.d50 * point.velocity * settling / point.viscosity,
        "fr50": fr50,
        "fr50_sd": point.per_metre() * cut.d50_sd,
        "fr50_change": fr50 / fr_reference - 1,
        "fr50_change_closed_form": point.per_metre() * point.size(of_reference) / fr_reference - 1,
        "settling50": settling,
        "settling50_change": settling / of_reference - 1,
        "curve_froude": curve_difference(
            cut, AROUND * fr_reference / point.per_metre(), compared, AROUND * compared.d50
        ),
        "curve_settling": curve_difference(
            cut, np.array([point.size(reference.settling(d)) for d in AROUND * compared.d50]),
            compared, AROUND * compared.d50,
        ),
    }  # fmt: skip


def curve_difference(one: Cut, sizes: Array, other: Cut, its_sizes: Array) -> float:
    """Root-mean-square difference of two curves' shares, each at its own sizes (m)."""
    return float(np.sqrt(np.mean((one.at(sizes) - other.at(its_sizes)) ** 2)))


def figure(points: Sequence[Point], cuts: Sequence[Cut]) -> Figure:
    """The curves over the Froude number, and over the terminal velocity: a colour for each gas and
    density, a line for each velocity."""
    drawing = Figure(figsize=(2 * COLUMN_WIDTH, 1.15 * COLUMN_WIDTH))
    left, right = drawing.subplots(1, 2, sharey=True)
    kinds: dict[tuple[float, float], list[float]] = {}
    for point in points:
        kinds.setdefault((point.density, point.viscosity), []).append(point.velocity)
    for point, cut in zip(points, cuts, strict=True):
        kind = (point.density, point.viscosity)
        style = {
            "color": MATERIAL_COLOURS[list(kinds).index(kind)],
            "linestyle": LINES[sorted(kinds[kind]).index(point.velocity)],
        }
        left.plot(point.per_metre() * cut.diameter, cut.share, label=point.name, **style)
        right.plot([point.settling(d) for d in cut.diameter], cut.share, **style)
    left.set_ylabel("share to coarse")
    left.set_xlabel(r"Froude number  $g d (\rho_s/\rho - 1)/U^2$")
    right.set_xlabel("terminal velocity over gas velocity")
    for axes in (left, right):
        low, high = axes.dataLim.intervalx
        log_if_wide(axes, low, high, "x")
        axes.set_ylim(0, 1)
    drawing.legend(loc="outside lower center", ncols=3, fontsize=6)
    return drawing
