"""Classification: cut size in plug flow, and the limit of a vanishing feed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from elutria.classification.classify import fit_events
from elutria.classification.events import Events, read_run
from elutria_validation.book.figures import BLUE, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase, Contacts, GasPlan
from elutria_validation.harness.cases import add_feed, solve, uniform
from elutria_validation.references.drag import cut_size

NAME = "classification"
TITLE = "Classification"
HELP = "Cut size in plug flow, and the limit of a vanishing feed."

Array = NDArray[np.float64]

GRAVITY = 9.81
# cut sizes (um) by density (kg/m3) and gas velocity (m/s), from terminal velocities by
# Schiller-Naumann
PLUG_FLOW = {
    2650: {0.5: 90.7, 1: 146.3, 2: 260.2, 3: 385.2, 5: 667.6, 8: 1155},
    7200: {0.5: 52.9, 1: 82.5, 2: 139.4, 3: 199.3, 5: 332.0, 8: 559},
}


def plug_flow_cut(folder: Path, density: float, velocity: float, collide: bool = False) -> float:
    """Cut size (m) of 300 particles within 10 % of the theoretical one, loading 1e-4."""
    cut = cut_size(velocity, density, GRAVITY)
    case = BoxCase(
        gas_velocity=velocity, gravity=-GRAVITY, width=0.2, depth=0.2, height=0.04,
        cells=(8, 8, 2), coupled=True, contacts=Contacts() if collide else None,
        solve_gas="auto", converge_gas="auto", step=0.01 * velocity, end=1000,
    ).make(folder)  # fmt: skip
    add_feed(case, {"materials": uniform(density, 0.9 * cut, 1.1 * cut), "loading": 1e-4,
                    "particles": 300, "drainTime": 15 / velocity})  # fmt: skip
    solve(case)
    return float(fit_events(read_run(case).events).d50)


def plug_flow(folder: Path, quick: bool) -> Section:
    section = Section(
        "Plug flow: cut size",
        "Slip walls, laminar, no dispersion, loading 1e-4: from feed to cut size through "
        "solver and tools. Reference: the size whose terminal velocity (Schiller-Naumann) is "
        "the gas velocity. With contacts the cut must be the same.",
    )
    figure, (axes,) = new_figure(60)
    for (density, cuts), colour in zip(PLUG_FLOW.items(), (BLUE, RED), strict=True):
        velocities = list(cuts)[1:4:2] if quick else list(cuts)
        found = [
            plug_flow_cut(folder / f"{density}{velocity}", density, velocity)
            for velocity in velocities
        ]
        section.rows += [
            Row.relative(f"{density} kg/m3, {velocity:g} m/s", "d50, m", 1e-6 * cuts[velocity],
                         d50, 3e-3)
            for velocity, d50 in zip(velocities, found, strict=True)
        ]  # fmt: skip
        axes.loglog(list(cuts), list(cuts.values()), "-", color=colour, linewidth=0.8,
                    label=f"{density} kg/m³")  # fmt: skip
        axes.loglog(velocities, np.array(found) * 1e6, "o", color=colour, markersize=4)
    for velocity in (8,) if quick else (0.5, 8):
        d50 = plug_flow_cut(folder / f"collide{velocity}", 2650, velocity, collide=True)
        section.rows.append(
            Row.relative(f"2650 kg/m3, {velocity:g} m/s, contacts", "d50, m",
                         1e-6 * PLUG_FLOW[2650][velocity], d50, 3e-3)
        )  # fmt: skip
    axes.set_xticks(velocities, [f"{velocity:g}" for velocity in velocities])
    axes.xaxis.set_minor_locator(NullLocator())
    label(axes, "gas velocity, m/s", "cut size, µm", "theory")
    section.figures["plug"] = (figure, "Plug flow: cut size against gas velocity.")
    return section


# whether the grains act on the gas, and whether they collide
COUPLINGS = {
    "one-way": (False, False),
    "two-way": (True, False),
    "collisions alone": (False, True),
    "four-way": (True, True),
}
GRAINS, VELOCITY, DENSITY = 2400, 8.0, 2650.0


def loaded(folder: Path, loading: float, coupling: str, gas: GasPlan = True) -> Events:
    """GRAINS grains through a small column, fed from one of its walls, within 20 % of the cut.

    `gas` as in system/scenePlan, where the coupling needs it.
    """
    two_way, contacts = COUPLINGS[coupling]
    cut = cut_size(VELOCITY, DENSITY, GRAVITY)
    case = BoxCase(
        gas_velocity=VELOCITY, gravity=-GRAVITY, width=0.03, depth=0.03, height=0.12,
        cells=(3, 3, 12), coupled=two_way, contacts=Contacts() if contacts else None,
        solve_gas=gas if two_way else False, tolerance=(1e-8, 1e-3), step=2e-3, end=1000,
    ).make(folder)  # fmt: skip
    add_feed(case, {"materials": uniform(DENSITY, 0.8 * cut, 1.2 * cut), "loading": loading,
                    "particles": GRAINS, "drainTime": 1.5})  # fmt: skip
    solve(case)
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


def vanishing_feed(folder: Path, quick: bool) -> Section:
    section = Section(
        "Vanishing feed: action on the gas, and collisions",
        f"The same {GRAINS} grains (same seed, sizes within 20 % of the cut, fed from one wall) at "
        "falling loading; where they act on the gas it is solved on every step. Difference of a "
        "partition curve from the one-way curve: mean over the sizes of the share to coarse. What "
        "grains do to the gas must vanish with the loading, and so must their collisions: a "
        "straight line through the differences meets zero loading within one grain in a hundred, "
        "and the least loading has less than half the difference of the largest. Both together "
        "(four-way) are for information.",
    )
    ladders: dict[str, tuple[float, ...]] = {
        "two-way": (0.08, 0.04, 0.02),
        "collisions alone": (0.02, 0.005, 0.00125),
    }
    if quick:
        ladders["two-way"] = ladders["two-way"][::2]
        ladders["collisions alone"] = ladders["collisions alone"][::2]
    cut = cut_size(VELOCITY, DENSITY, GRAVITY)
    edges = np.linspace(0.79, 1.21, 22) * cut
    sizes = 0.5e6 * (edges[1:] + edges[:-1])
    figure, panels = new_figure(120, rows=2)
    alone = _shares(loaded(folder / "alone", 0.02, "one-way"), edges)
    panels[0].plot(sizes, alone, "k-", label="one-way")
    for (coupling, loadings), colour in zip(ladders.items(), (BLUE, RED), strict=True):
        differences = []
        for loading, style in zip(loadings, ("-", "--", ":"), strict=False):
            share = _shares(loaded(folder / f"{coupling}{loading}", loading, coupling), edges)
            section.rows.append(_difference(f"{coupling}, loading {loading:g}", alone, share))
            differences.append(section.rows[-1].error)
            panels[0].plot(sizes, share, style, color=colour, lw=0.8,
                           label=f"{coupling}, {loading:g}")  # fmt: skip
        slope, intercept = np.polyfit(loadings, differences, 1)
        left = differences[-1] / max(differences[0], 1e-9)
        section.rows += [
            Row.size(coupling, "difference extrapolated to zero loading; error absolute",
                     float(intercept), 0.01),
            Row(coupling, "difference at the least over that at the largest loading; first order "
                "would be their ratio", loadings[-1] / loadings[0], left, left, 0.5),
        ]  # fmt: skip
        panels[1].plot(loadings, differences, "o", color=colour, label=coupling)
        panels[1].plot([0, loadings[0]], [intercept, intercept + slope * loadings[0]], ":",
                       color=colour, lw=0.8)  # fmt: skip
    both = ladders["two-way"][-1]
    share = _shares(loaded(folder / "both", both, "four-way"), edges)
    section.rows.append(_difference(f"four-way, loading {both:g}", alone, share))
    label(panels[0], "diameter, µm", "partition to coarse", fontsize=6)
    panels[1].set_xlim(0, None)
    label(panels[1], "loading, kg/kg", "mean difference from one-way")
    section.figures["vanishing"] = (figure, "Partition curves at falling loading.")
    return section


SECTIONS = (plug_flow, vanishing_feed)
