"""Laminar channel and pipe: the gas profile, and the exact partition curves it makes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from foamlib import FoamFile
from matplotlib import rc_context
from matplotlib.axes import Axes
from numpy.typing import NDArray
from scipy.stats import chi2

from elutria.classification.events import Events, read_run
from elutria.estimates.theory import channel_fines_share, pipe_fines_share
from elutria.output.plots import STYLE, new_figure
from elutria.physics.drag import Gas, plug_flow_cut_size, terminal_velocity
from elutria_validation.book.book import Chapter, Row, Section, write_chapter
from elutria_validation.chapters.wake import loose_solvers
from elutria_validation.harness.common import Options
from elutria_validation.harness.scene import (
    BOX,
    CLOUD,
    CONTROL,
    add_feed,
    cell_centres,
    make_scene,
    read_gas,
    run_scene,
    times,
)

NAME = "profiles"
HELP = "Laminar channel and pipe: gas profile and exact partition curves."

Array = NDArray[np.float64]

GAS, GRAVITY = Gas(), 9.81


@dataclass(frozen=True)
class Duct:
    """A shape: its mesh, its exact profile (velocity over the mean) and its partition to fines."""

    name: str
    mesh: str
    mesh_text: str
    entrance: dict[str, Any]
    profile: Callable[[Array, float], Array]  # of places (n, 3) and width (m)
    peak: float  # largest velocity over the mean
    fines_share: Callable[[Array, float], Array]


def _channel_profile(places: Array, width: float) -> Array:
    across = places[:, 0] / width
    return np.asarray(6 * across * (1 - across))


def _pipe_profile(places: Array, width: float) -> Array:
    return np.asarray(2 * (1 - (places[:, :2] ** 2).sum(axis=1) / (width / 2) ** 2))


CHANNEL = Duct(
    "channel", "blockMeshDict", "", {"patch": "south"}, _channel_profile, 1.5, channel_fines_share
)
PIPE = Duct(
    "pipe", "pipeMeshDict", " on a mesh of five blocks (O-grid)", {"zone": "pipe"},
    _pipe_profile, 2.0, pipe_fines_share,
)  # fmt: skip


@rc_context(STYLE)
def run(options: Options) -> Chapter:
    """Both shapes at two velocities, widths and densities."""
    chapter = Chapter(NAME, "Laminar profiles")
    number = 2000 if options.quick else 10000
    with TemporaryDirectory() as work:
        for duct, formula in ((CHANNEL, "sqrt(1 - v_t/(1.5 U))"), (PIPE, "1 - v_t/(2 U)")):
            section = chapter.section(
                f"Laminar {duct.name}: gas profile and partition curve",
                f"The gas enters with the exact profile{duct.mesh_text} and is solved until it is "
                f"steady; then {number} grains, fed uniformly over the section, move without "
                f"changing it and without lateral motion: the share to fines is {formula}. "
                "The points must lie in the exact curve's 95 % band (binomial): of 12 classes at "
                "most 2 outside, which chance exceeds in 2 % of runs, and chi-squared of all below "
                "its 95 % limit.",
            )
            figure, panels = new_figure(125, rows=2)
            for velocity, width, density, colour in (
                (1.0, 0.02, 2650.0, "#D55E00"), (0.4, 0.012, 7200.0, "#0072B2")
            ):  # fmt: skip
                folder = Path(work) / f"{duct.name}{velocity}"
                _classify(section, panels, folder, duct, velocity, width, density, number, colour)
            panels[0].legend()
            panels[1].legend()
            section.figures[duct.name] = (figure, f"Laminar {duct.name}: profile and partition.")
    return write_chapter(options, chapter)


def _classify(
    section: Section, panels: list[Axes], folder: Path, duct: Duct, velocity: float, width: float,
    density: float, number: int, colour: str,
) -> None:  # fmt: skip
    case = _duct_case(folder, duct, velocity, width)
    centres, _ = cell_centres(case)
    largest = 1.05 * plug_flow_cut_size(duct.peak * velocity, density, GAS, gravity=GRAVITY)
    sizes = {"type": "uniform", "min": 0.1 * largest, "max": largest, "weighting": "number"}
    solid = {"density": density, "massFraction": 1, "sizeDistribution": sizes}
    add_feed(
        case,
        {"materials": {"solid": solid}, **duct.entrance, "massFlowRate": 1.0, "particles": number},
    )
    run_scene(case)
    name = f"{velocity:g} m/s, {width * 1e3:g} mm, {density:g} kg/m3"
    middle = np.abs(centres[:, 2] - 0.5 * width) < 0.15 * width
    gas = read_gas(case, times(case)[-1])[middle, 2] / velocity
    exact = duct.profile(centres[middle], width)
    k = int(np.abs(gas - exact).argmax())
    section.rows.append(
        Row(name, "gas velocity over the mean at mid-height, worst cell; error absolute", exact[k],
            gas[k], float(np.abs(gas - exact)[k]), 0.01)
    )  # fmt: skip
    off = centres[middle, 0] - (0.5 * width if duct is CHANNEL else 0)
    radius = np.abs(off) if duct is CHANNEL else np.hypot(*centres[middle, :2].T)
    panels[0].plot(2 * radius / width, gas, ".", color=colour, markersize=3, label=name)
    line = np.linspace(0, 1, 60)
    panels[0].plot(line, duct.peak * (1 - line**2), "k:", linewidth=0.8)
    panels[0].set_xlabel("distance from the middle over half the width")
    panels[0].set_ylabel("gas velocity over the mean")
    _partition_rows(section, panels[1], duct, name, read_run(case).events, velocity, density,
                    colour)  # fmt: skip


def _duct_case(folder: Path, duct: Duct, velocity: float, width: float) -> Path:
    pipe = duct is PIPE
    duration = 0.8 * width / 0.02 / velocity * 20
    case = make_scene(
        folder,
        settings={
            f"{BOX}:gasVelocity": velocity,
            f"{BOX}:radius": width / 2,
            f"{BOX}:width": width,
            f"{BOX}:depth": width / 4,
            f"{BOX}:height": width,
            f"{BOX}:cellsX": 24 if pipe else 60,
            f"{BOX}:cellsY": 20 if pipe else 2,
            f"{BOX}:cellsAlong": 10,
            f"{BOX}:sideVelocity": "noSlip",
            f"{BOX}:southNorthGroup": "frictionless",
            f"{BOX}:gravity": -GRAVITY,
            f"{CLOUD}:solution/interpolationSchemes/U.air": "cellPoint",
            "system/scenePlan:gas": "auto",
            "system/scenePlan:convergeGas": "auto",
            "system/scenePlan:gasTolerance": 1e-4,
            # exact where the gas does not change along its way, and stable at any step
            "system/fvSchemes:divSchemes/div(alphaPhi.air,U.air)": ("Gauss", "upwind"),
            "system/scenePlan:gasCourant": 2,
            "system/fvSolution:PIMPLE/nCorrectors": 3,
            "system/fvSolution:PIMPLE/nNonOrthogonalCorrectors": 1 if pipe else 0,
            **loose_solvers(1e-10, 1e-3),
            f"{CONTROL}:deltaT": 0.2 * width / velocity,
            f"{CONTROL}:endTime": duration,
            f"{CONTROL}:writeInterval": duration,
        },
        mesh=duct.mesh,
    )
    inside, patches = cell_centres(case)

    def along(places: Array) -> Array:
        profile = np.zeros((len(places), 3))
        profile[:, 2] = velocity * duct.profile(places, width)
        return profile

    with FoamFile(case / "0/U.air") as field:
        field["internalField"] = along(inside)
        field["boundaryField", "bottom"] = {
            "type": "fixedValue", "value": along(patches["bottom"])
        }  # fmt: skip
    return case


def _partition_rows(
    section: Section, axes: Axes, duct: Duct, case: str, events: Events, velocity: float,
    density: float, colour: str,
) -> None:  # fmt: skip
    left = events.select(events.has_left)
    terminal = np.array(
        [terminal_velocity(d, density, GAS, gravity=GRAVITY) for d in left.diameter]
    )
    coarse = 1 - duct.fines_share(terminal, velocity)
    limits = np.linspace(left.diameter.min(), left.diameter.max(), 13)
    sizes, found, expected, half = [], [], [], []
    statistic = 0.0
    for lower, upper in pairwise(limits):
        here = (left.diameter >= lower) & (left.diameter <= upper)
        n, p = int(here.sum()), float(coarse[here].mean())
        variance = float((coarse[here] * (1 - coarse[here])).sum())
        seen = int(left.is_coarse[here].sum())
        statistic += (seen - n * p) ** 2 / max(variance, 1.0)
        sizes.append(0.5e6 * (lower + upper))
        found.append(seen / n)
        expected.append(p)
        half.append(1.96 * variance**0.5 / n)
    share, exact, band = np.array(found), np.array(expected), np.array(half)
    inside = int(np.sum(np.abs(share - exact) <= band))
    critical = float(chi2.ppf(0.95, len(sizes)))
    lost = 1 - len(left) / len(events)
    section.rows += [
        Row(case, f"classes of {len(sizes)} inside the 95 % band (error: those outside)",
            len(sizes), inside, len(sizes) - inside, 2),
        Row(case, "chi-squared (reference: its 95 % limit; error: ratio)", critical, statistic,
            statistic / critical, 1),
        Row(case, "share of grains that hover inside at the end; error: itself", 0, lost, lost,
            0.02),
    ]  # fmt: skip
    axes.fill_between(sizes, exact - band, exact + band, color=colour, alpha=0.25, linewidth=0)
    axes.plot(sizes, exact, "k:", linewidth=0.8)
    axes.plot(sizes, share, "o", color=colour, markersize=3, label=case)
    axes.set_xlabel("diameter, µm")
    axes.set_ylabel("partition to coarse")
