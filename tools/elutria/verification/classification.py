"""Classification against exact partition curves: plug flow, a laminar channel, a vanishing feed."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from foamlib import FoamFile
from matplotlib import rc_context
from numpy.typing import NDArray
from scipy.stats import chi2

from elutria.bench.common import Options
from elutria.classify import fit_events
from elutria.drag import Gas, plug_flow_cut_size, terminal_velocity
from elutria.events import Events, read_run
from elutria.plots import STYLE, new_figure
from elutria.theory import channel_fines_share
from elutria.verification.book import Chapter, Row, write_chapter
from elutria.verification.scene import (
    BOX,
    CLOUD,
    CONTROL,
    add_feed,
    make_scene,
    run_scene,
)

NAME = "classification"
HELP = "Exact partition curves: plug flow, a laminar channel, a vanishing feed."

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
def run(options: Options) -> None:
    """Plug flow at two densities, a laminar channel, and the limit of a vanishing feed."""
    chapter = Chapter(
        NAME,
        "Classification",
        "From feed to partition curve through solver and tools. Plug flow (slip walls, laminar, no "
        "dispersion): a step where the terminal velocity is the gas velocity. Laminar plane "
        "channel without lateral motion: fines share sqrt(1 - v_t/(1.5 U)). With less and less "
        "feed, the coupled cut must become the uncoupled one.",
    )
    with TemporaryDirectory() as work:
        folder = Path(work)
        for density, cuts in PLUG_FLOW.items():
            for velocity, cut in cuts.items():
                _plug_flow(chapter, folder, density, velocity, cut * 1e-6)
        _vanishing_feed(chapter, folder)
        _channel(chapter, folder, 2000 if options.quick else 10000)
    write_chapter(options, chapter)


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


def _plug_flow(chapter: Chapter, folder: Path, density: float, velocity: float, cut: float) -> None:
    found = plug_flow(folder / f"plug{density}{velocity}", density, velocity, 1e-4, True)
    chapter.rows.append(
        Row.relative(
            f"Plug flow, {density} kg/m3, {velocity:g} m/s, loading 1e-4", "d50, m", cut, found,
            3e-3,
        )
    )  # fmt: skip


def _vanishing_feed(chapter: Chapter, folder: Path) -> None:
    alone = plug_flow(folder / "alone", 2650, 2, 1e-2, False)
    loadings = (0.1, 0.01, 1e-3)
    for loading in loadings:
        found = plug_flow(folder / f"load{loading}", 2650, 2, loading, True)
        # what the feed takes from the gas is at most of the order of the loading
        chapter.rows.append(
            Row.relative(
                f"Vanishing feed, 2 m/s, loading {loading:g}", "d50 coupled over uncoupled, m",
                alone, found, max(1.5 * loading, 2e-3),
            )
        )  # fmt: skip


def _channel(chapter: Chapter, folder: Path, number: int) -> None:
    # the exact profile, taken from 200 cells across; every place on the south wall is as likely
    velocity, width, cells = 1.0, 0.02, 200
    case = make_scene(
        folder / "channel",
        settings={
            f"{BOX}:width": width,
            f"{BOX}:depth": width,
            f"{BOX}:height": width,
            f"{BOX}:cellsAcross": cells,
            f"{BOX}:gravity": -GRAVITY,
            f"{CONTROL}:deltaT": 4e-3,
            f"{CONTROL}:endTime": 16,
            f"{CONTROL}:writeInterval": 16,
        },
    )
    across = (np.arange(cells) + 0.5) / cells
    profile = np.zeros((cells**2, 3))
    profile[:, 2] = np.tile(6 * velocity * across * (1 - across), cells)
    with FoamFile(case / "0/U.air") as field:
        field["internalField"] = profile.tolist()
    largest = 1.05 * plug_flow_cut_size(1.5 * velocity, 2650, GAS, gravity=GRAVITY)
    _feed(case, 2650, 0.1 * largest, largest, patch="south", massFlowRate=1.0, particles=number)
    run_scene(case)
    _channel_rows(chapter, read_run(case).events, velocity)


def _channel_rows(chapter: Chapter, events: Events, velocity: float) -> None:
    left = events.select(events.has_left)
    terminal = np.array([terminal_velocity(d, 2650, GAS, gravity=GRAVITY) for d in left.diameter])
    coarse = 1 - channel_fines_share(terminal, velocity)
    limits = np.linspace(left.diameter.min(), left.diameter.max(), 13)
    sizes, found, expected, low, high = [], [], [], [], []
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
        low.append(p - 1.96 * variance**0.5 / n)
        high.append(p + 1.96 * variance**0.5 / n)
    case = f"Laminar channel, 1 m/s, {len(events)} particles"
    inside = int(np.sum((np.array(found) >= low) & (np.array(found) <= high)))
    critical = float(chi2.ppf(0.95, len(sizes)))
    chapter.rows += [
        Row(case, f"classes of {len(sizes)} inside their 95 % band (error: those outside)",
            len(sizes), inside, len(sizes) - inside, 2),
        Row(case, "chi-squared of all classes (reference: critical at 95 %; error: their ratio)",
            critical, statistic, statistic / critical, 1),
        Row(case, "share of parcels still inside; error: itself", 0,
            1 - len(left) / len(events), 1 - len(left) / len(events), 0.02),
    ]  # fmt: skip
    figure, (axes,) = new_figure(60)
    axes.fill_between(sizes, low, high, color="#56B4E9", alpha=0.4, label="exact, 95 % band")
    axes.plot(sizes, expected, "k:", label="exact")
    axes.plot(sizes, found, "o", color="#D55E00", label="elutriaFoam")
    axes.set_xlabel("diameter, µm")
    axes.set_ylabel("partition to coarse")
    axes.legend()
    chapter.figures["channel"] = (figure, "Laminar plane channel: partition curve.")
