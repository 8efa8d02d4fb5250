"""Laminar channel and pipe: the gas profile, and the exact partition curves it makes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
from foamlib import FoamFile
from matplotlib.axes import Axes
from numpy.typing import NDArray
from scipy.stats import chi2

from elutria.classification.events import Events, read_run
from elutria_validation.book.figures import BLUE, RED, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import (
    SOLUTION,
    add_feed,
    cell_centres,
    read_gas,
    solve,
    times,
    uniform,
)
from elutria_validation.references.drag import cut_size, terminal_velocity
from elutria_validation.references.flows import channel_fines_share, pipe_fines_share

NAME = "profiles"
TITLE = "Laminar profiles"
HELP = "Laminar channel and pipe: gas profile and exact partition curves."

Array = NDArray[np.float64]

GRAVITY = 9.81


@dataclass(frozen=True)
class Duct:
    """A shape: its mesh, its exact profile (velocity over the mean) and its partition to fines."""

    name: str
    mesh: Literal["blockMeshDict", "pipeMeshDict"]
    mesh_text: str
    formula: str
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
    "channel", "blockMeshDict", "", "sqrt(1 - v_t/(1.5 U))", {"patch": "south"},
    _channel_profile, 1.5, channel_fines_share,
)  # fmt: skip
PIPE = Duct(
    "pipe", "pipeMeshDict", " on a mesh of five blocks (O-grid)", "1 - v_t/(2 U)",
    {"zone": "pipe"}, _pipe_profile, 2.0, pipe_fines_share,
)  # fmt: skip


@dataclass(frozen=True)
class Stream:
    """Gas velocity (m/s) through a duct of `width` (m), and the grains' density (kg/m3)."""

    velocity: float
    width: float
    density: float
    colour: str

    @property
    def name(self) -> str:
        return f"{self.velocity:g} m/s, {self.width * 1e3:g} mm, {self.density:g} kg/m3"


STREAMS = (Stream(1.0, 0.02, 2650.0, RED), Stream(0.4, 0.012, 7200.0, BLUE))


def channel(folder: Path, quick: bool) -> Section:
    return _section(folder, CHANNEL, quick)


def pipe(folder: Path, quick: bool) -> Section:
    return _section(folder, PIPE, quick)


def _section(folder: Path, duct: Duct, quick: bool) -> Section:
    number = 2000 if quick else 10000
    section = Section(
        f"Laminar {duct.name}: gas profile and partition curve",
        f"The gas enters with the exact profile{duct.mesh_text} and is solved until it is "
        f"steady; then {number} grains, fed uniformly over the section, move without "
        f"changing it and without lateral motion: the share to fines is {duct.formula}. "
        "The points must lie in the exact curve's 95 % band (binomial): of 12 classes at "
        "most 2 outside, which chance exceeds in 2 % of runs, and chi-squared of all below "
        "its 95 % limit.",
    )
    figure, panels = new_figure(125, rows=2)
    for stream in STREAMS[: 1 if quick else None]:
        _classify(section, panels, folder / f"{stream.velocity}", duct, stream, number)
    panels[0].set_xlabel("distance from the middle over half the width")
    panels[0].set_ylabel("gas velocity over the mean")
    panels[1].set_xlabel("diameter, µm")
    panels[1].set_ylabel("partition to coarse")
    for axes in panels:
        axes.legend()
    section.figures[duct.name] = (figure, f"Laminar {duct.name}: profile and partition.")
    return section


def _classify(
    section: Section, panels: list[Axes], folder: Path, duct: Duct, stream: Stream, number: int
) -> None:
    width = stream.width
    case = _duct_case(folder, duct, stream)
    centres, _ = cell_centres(case)
    largest = 1.05 * cut_size(duct.peak * stream.velocity, stream.density, GRAVITY)
    grains = uniform(stream.density, 0.1 * largest, largest)
    add_feed(case, {"materials": grains, **duct.entrance, "massFlowRate": 1.0,
                    "particles": number})  # fmt: skip
    solve(case)
    middle = np.abs(centres[:, 2] - 0.5 * width) < 0.15 * width
    gas = read_gas(case, times(case)[-1])[middle, 2] / stream.velocity
    exact = duct.profile(centres[middle], width)
    k = int(np.abs(gas - exact).argmax())
    section.rows.append(
        Row(stream.name, "gas velocity over the mean at mid-height, worst cell; error absolute",
            exact[k], gas[k], float(np.abs(gas - exact)[k]), 0.01)
    )  # fmt: skip
    off = centres[middle, 0] - (0.5 * width if duct is CHANNEL else 0)
    radius = np.abs(off) if duct is CHANNEL else np.hypot(*centres[middle, :2].T)
    panels[0].plot(2 * radius / width, gas, ".", color=stream.colour, ms=3, label=stream.name)
    line = np.linspace(0, 1, 60)
    panels[0].plot(line, duct.peak * (1 - line**2), "k:", linewidth=0.8)
    _partition_rows(section, panels[1], duct, stream, read_run(case).events)


def _duct_case(folder: Path, duct: Duct, stream: Stream) -> Path:
    round_pipe = duct is PIPE
    velocity, width = stream.velocity, stream.width
    case = BoxCase(
        mesh=duct.mesh, radius=width / 2, width=width, depth=width / 4, height=width,
        cells=(24, 20, 10) if round_pipe else (60, 2, 10), gas_velocity=velocity,
        side_velocity="noSlip", south_north="frictionless", gravity=-GRAVITY, gas_by="cellPoint",
        solve_gas="auto", converge_gas="auto", gas_tolerance=1e-4, gas_courant=2,
        tolerance=(1e-10, 1e-3), step=0.2 * width / velocity,
        end=0.8 * width / 0.02 / velocity * 20,
        more={
            # exact where the gas does not change along its way, and stable at any step
            "system/fvSchemes:divSchemes/div(alphaPhi.air,U.air)": ("Gauss", "upwind"),
            f"{SOLUTION}:PIMPLE/nCorrectors": 3,
            f"{SOLUTION}:PIMPLE/nNonOrthogonalCorrectors": 1 if round_pipe else 0,
        },
    ).make(folder)  # fmt: skip
    inside, patches = cell_centres(case)

    def along(places: Array) -> Array:
        profile = np.zeros((len(places), 3))
        profile[:, 2] = velocity * duct.profile(places, width)
        return profile

    with FoamFile(case / "0/U.air") as field:
        field["internalField"] = along(inside)
        field["boundaryField", "bottom"] = {"type": "fixedValue", "value": along(patches["bottom"])}
    return case


def _partition_rows(
    section: Section, axes: Axes, duct: Duct, stream: Stream, events: Events
) -> None:
    left = events.select(events.has_left)
    terminal = np.array(
        [terminal_velocity(d, stream.density, gravity=GRAVITY) for d in left.diameter]
    )
    coarse = 1 - duct.fines_share(terminal, stream.velocity)
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
    section.rows += [
        Row(stream.name, f"classes of {len(sizes)} inside the 95 % band (error: those outside)",
            len(sizes), inside, len(sizes) - inside, 2),
        Row(stream.name, "chi-squared (reference: its 95 % limit; error: ratio)", critical,
            statistic, statistic / critical, 1),
        Row.size(stream.name, "share of grains that hover inside at the end; error: itself",
                 1 - len(left) / len(events), 0.02),
    ]  # fmt: skip
    colour = stream.colour
    axes.fill_between(sizes, exact - band, exact + band, color=colour, alpha=0.25, linewidth=0)
    axes.plot(sizes, exact, "k:", linewidth=0.8)
    axes.plot(sizes, share, "o", color=colour, markersize=3, label=stream.name)


SECTIONS = (channel, pipe)
