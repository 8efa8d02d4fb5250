"""Classification: cut size in plug flow, and the limit of a vanishing feed."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from elutria.classification.classify import fit_events
from elutria.classification.events import Events, read_run
from elutria.output.plots import STYLE, new_figure
from elutria.physics.drag import Gas, plug_flow_cut_size
from elutria_validation.book.book import Chapter, Row, Section, write_chapter
from elutria_validation.chapters.wake import loose_solvers
from elutria_validation.harness.common import Options
from elutria_validation.harness.scene import (
    BOX,
    CLOUD,
    CONTROL,
    MODELS,
    add_feed,
    make_scene,
    run_scene,
)

NAME = "classification"
HELP = "Cut size in plug flow, and the limit of a vanishing feed."

Array = NDArray[np.float64]

GAS = Gas()
GRAVITY = 9.81
# cut sizes (um) by density (kg/m3) and gas velocity (m/s), from terminal velocities by
# Schiller-Naumann
PLUG_FLOW = {
    2650: {0.5: 90.7, 1: 146.3, 2: 260.2, 3: 385.2, 5: 667.6, 8: 1155},
    7200: {0.5: 52.9, 1: 82.5, 2: 139.4, 3: 199.3, 5: 332.0, 8: 559},
}


@rc_context(STYLE)
def run(options: Options) -> Chapter:
    """Plug flow at two densities and six velocities, and the limit of a vanishing feed."""
    chapter = Chapter(NAME, "Classification")
    with TemporaryDirectory() as work:
        folder = Path(work)
        plug = chapter.section(
            "Plug flow: cut size",
            "Slip walls, laminar, no dispersion, loading 1e-4: from feed to cut size through "
            "solver and tools. Reference: the size whose terminal velocity (Schiller-Naumann) is "
            "the gas velocity.",
        )
        figure, (axes,) = new_figure(60)
        for (density, cuts), colour in zip(PLUG_FLOW.items(), ("#0072B2", "#D55E00"), strict=True):
            velocities = list(cuts)[1:4:2] if options.quick else list(cuts)
            found = [
                _plug_flow(plug, folder, density, velocity, cuts[velocity] * 1e-6)
                for velocity in velocities
            ]
            axes.loglog(list(cuts), list(cuts.values()), "-", color=colour, linewidth=0.8,
                        label=f"{density} kg/m³")  # fmt: skip
            axes.loglog(velocities, np.array(found) * 1e6, "o", color=colour, markersize=4)
        axes.set_xticks(velocities, [f"{velocity:g}" for velocity in velocities])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xlabel("gas velocity, m/s")
        axes.set_ylabel("cut size, µm")
        axes.legend(title="lines: theory; dots: elutriaFoam", title_fontsize=7)
        plug.figures["plug"] = (figure, "Plug flow: cut size against gas velocity.")
        _vanishing_feed(chapter, folder, options.quick)
    return write_chapter(options, chapter)


def plug_flow(
    folder: Path, density: float, velocity: float, loading: float, coupled: bool
) -> float:
    """Cut size (m) of 300 particles within 10 % of the theoretical one."""
    cut = plug_flow_cut_size(velocity, density, GAS, gravity=GRAVITY)
    case = make_scene(
        folder,
        settings={
            f"{BOX}:gasVelocity": velocity,
            f"{BOX}:gravity": -GRAVITY,
            f"{BOX}:width": 0.2,
            f"{BOX}:depth": 0.2,
            f"{BOX}:height": 0.04,
            f"{BOX}:cellsAcross": 8,
            f"{BOX}:cellsAlong": 2,
            f"{CLOUD}:solution/coupled": coupled,
            f"{CONTROL}:deltaT": 0.01 * velocity,
            f"{CONTROL}:endTime": 1000,
            f"{CONTROL}:writeInterval": 1000,
            "system/scenePlan:gas": "auto",
            "system/scenePlan:convergeGas": "auto",
        },
    )
    _feed(case, density, 0.9 * cut, 1.1 * cut, loading=loading, particles=300,
          drainTime=15 / velocity)  # fmt: skip
    run_scene(case)
    return fit_events(read_run(case).events).d50


def _feed(case: Path, density: float, smallest: float, largest: float, **more: Any) -> None:
    sizes = {"type": "uniform", "min": smallest, "max": largest, "weighting": "number"}
    solid = {"density": density, "massFraction": 1, "sizeDistribution": sizes}
    add_feed(case, {"materials": {"solid": solid}, **more})


def _plug_flow(
    section: Section, folder: Path, density: float, velocity: float, cut: float
) -> float:
    found = plug_flow(folder / f"plug{density}{velocity}", density, velocity, 1e-4, True)
    section.rows.append(
        Row.relative(f"{density} kg/m3, {velocity:g} m/s", "d50, m", cut, found, 3e-3)
    )
    return found


# whether the grains act on the gas, and whether they collide
COUPLINGS = {
    "one-way": (False, False),
    "two-way": (True, False),
    "collisions alone": (False, True),
    "four-way": (True, True),
}


GRAINS = 2400


def loaded(folder: Path, loading: float, coupling: str, gas: str | bool = True) -> Events:
    """GRAINS grains through a small column at 8 m/s, fed from one of its walls.

    `gas` as in system/scenePlan, where the coupling needs it.
    """
    two_way, contacts = COUPLINGS[coupling]
    velocity, density = 8.0, 2650.0
    cut = plug_flow_cut_size(velocity, density, GAS, gravity=GRAVITY)
    case = make_scene(
        folder,
        settings={
            f"{BOX}:gasVelocity": velocity,
            f"{BOX}:gravity": -GRAVITY,
            f"{BOX}:width": 0.03,
            f"{BOX}:depth": 0.03,
            f"{BOX}:height": 0.12,
            f"{BOX}:cellsAcross": 3,
            f"{BOX}:cellsAlong": 12,
            f"{CLOUD}:solution/coupled": two_way,
            f"{MODELS}/collisionModel": "cellList" if contacts else "none",
            "system/scenePlan:gas": gas if two_way else False,
            **loose_solvers(1e-8, 1e-3),
            f"{CONTROL}:deltaT": 2e-3,
            f"{CONTROL}:endTime": 1000,
            f"{CONTROL}:writeInterval": 1000,
        },
    )
    _feed(case, density, 0.8 * cut, 1.2 * cut, loading=loading, particles=GRAINS, drainTime=1.5)
    run_scene(case)
    return read_run(case).events


def _shares(events: Events, edges: Array) -> Array:
    """Partition to coarse of the size classes, over what has left."""
    left = events.select(events.has_left)
    where = np.digitize(left.diameter, edges) - 1
    classes = len(edges) - 1
    return np.bincount(where, left.is_coarse, classes) / np.bincount(where, minlength=classes)


def _difference(case: str, alone: Array, share: Array) -> Row:
    """How far a partition curve is from the one-way curve, for information."""
    return Row(
        case, "mean share to coarse; error: mean absolute difference over the sizes",
        float(alone.mean()), float(share.mean()), float(np.abs(share - alone).mean()), None,
    )  # fmt: skip


def _vanishing_feed(chapter: Chapter, folder: Path, quick: bool) -> None:
    section = chapter.section(
        "Vanishing feed: action on the gas, and collisions",
        f"The same {GRAINS} grains (same seed, sizes within 20 % of the cut, fed from one wall) at "
        "falling loading; where they act on the gas it is solved on every step. Difference of a "
        "partition curve from the one-way curve: mean over the sizes of the share to coarse. What "
        "grains do to the gas must vanish with the loading, and so must their collisions: a "
        "straight line through the differences meets zero loading within one grain in a hundred, "
        "and the least loading has less than half the difference of the largest.",
        "Collisions vanish more slowly than the loading: a grain within 1 % of the cut hovers for "
        "seconds, and one collision carries it out of a column that is shorter than its way of "
        "relaxation. A straight line from 0.02 to 0.08 kg/kg met zero loading at 0.015 (with 600 "
        "grains and higher loadings at 0.036), which is why theirs starts lower. Both together "
        "(four-way) are for information.",
    )
    ladders = {"two-way": (0.08, 0.04, 0.02), "collisions alone": (0.02, 0.005, 0.00125)}
    if quick:
        ladders = {coupling: (0.2, 0.1) for coupling in ladders}
    cut = plug_flow_cut_size(8.0, 2650.0, GAS, gravity=GRAVITY)
    edges = np.linspace(0.79, 1.21, 22) * cut
    sizes = 0.5e6 * (edges[1:] + edges[:-1])
    figure, panels = new_figure(120, rows=2)
    alone = _shares(loaded(folder / "alone", 0.02, "one-way"), edges)
    panels[0].plot(sizes, alone, "k-", label="one-way")
    for (coupling, loadings), colour in zip(ladders.items(), ("#0072B2", "#D55E00"), strict=True):
        differences = []
        for loading, style in zip(loadings, ("-", "--", ":"), strict=False):
            share = _shares(loaded(folder / f"{coupling}{loading}", loading, coupling), edges)
            section.rows.append(_difference(f"{coupling}, loading {loading:g}", alone, share))
            differences.append(section.rows[-1].error)
            panels[0].plot(sizes, share, style, color=colour, lw=0.8,
                           label=f"{coupling}, {loading:g}")  # fmt: skip
        slope, intercept = np.polyfit(loadings, differences, 1)
        section.rows += [
            Row(coupling, "difference extrapolated to zero loading; error absolute", 0,
                float(intercept), abs(float(intercept)), 0.01),
            Row(coupling, "difference at the least over that at the largest loading; first order "
                "would be their ratio", loadings[-1] / loadings[0],
                differences[-1] / max(differences[0], 1e-9),
                differences[-1] / max(differences[0], 1e-9), 0.5),
        ]  # fmt: skip
        panels[1].plot(loadings, differences, "o", color=colour, label=coupling)
        panels[1].plot([0, loadings[0]], [intercept, intercept + slope * loadings[0]], ":",
                       color=colour, lw=0.8)  # fmt: skip
    both = ladders["two-way"][-1]
    share = _shares(loaded(folder / "both", both, "four-way"), edges)
    section.rows.append(_difference(f"four-way, loading {both:g}", alone, share))
    panels[0].set_xlabel("diameter, µm")
    panels[0].set_ylabel("partition to coarse")
    panels[0].legend(fontsize=6)
    panels[1].set_xlabel("loading, kg/kg")
    panels[1].set_ylabel("mean difference from one-way")
    panels[1].set_xlim(0, None)
    panels[1].legend()
    section.figures["vanishing"] = (figure, "Partition curves at falling loading.")
