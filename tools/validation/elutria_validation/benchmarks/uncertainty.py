"""How far the cut moves with what nobody knows exactly: models, material, walls, inlet, loading.

One scene, the column at 4 m/s, one entry changed at a time. Beside it stand what the numerics do
(mesh, step) and what chance does to the run that all are compared with.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import hypot, isfinite, nan
from pathlib import Path
from statistics import fmean, median
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import FuncFormatter, NullLocator
from numpy.typing import NDArray

from elutria.errors import ElutriaError
from elutria.output.style import COLUMN_WIDTH
from elutria_validation.benchmarks.accuracy_error import Cut, cut_of_events, mean_noise
from elutria_validation.benchmarks.accuracy_runs import (
    POINTS,
    SLOW,
    Changes,
    Point,
    drag,
    replicates,
)
from elutria_validation.harness.cases import CONTACTS, MODELS, PARAMETERS
from elutria_validation.harness.programs import slug

SCENE = SLOW
COLUMNS = (
    "group", "what", "d50_m", "d50_change", "d50_noise", "sharpness", "sharpness_change",
    "sharpness_noise", "seconds", "note",
)  # fmt: skip
BASE = "parcels x 3"
SPHERICITY = "constant/feed:materials/quartz/sphericity"
INLET = "0.orig/U.air:boundaryField/bottom/value"
ACROSS = 10
"""Cells of the inlet, each way."""

Row = dict[str, Any]
Array = NDArray[np.float64]


def _law(name: str, sphericity: float) -> Changes:
    return {**drag(name), SPHERICITY: sphericity}


def _contacts(what: str, value: float) -> Changes:
    """Restitution or friction of all contacts."""
    pairs = ("particleParticle", "particleWall")
    return {f"{CONTACTS}/{pair}/{what}": value for pair in pairs}


def _walls(restitution: float, friction: float) -> Changes:
    wall = f"{CONTACTS}/particleWall"
    return {f"{wall}/restitution": restitution, f"{wall}/friction": friction}


def inlet(profile: Callable[[Array], Array], velocity: float) -> Changes:
    """An inlet whose profile is a product of `profile`(y) both ways, y from 0 at a wall to 1 in
    the middle, with the mean `velocity` (m/s)."""
    middle = (np.arange(ACROSS) + 0.5) / ACROSS
    one = profile(1 - np.abs(2 * middle - 1))
    speed = np.outer(one, one).ravel()
    speed *= velocity / speed.mean()
    return {INLET: np.column_stack([np.zeros((speed.size, 2)), speed])}


def _parabola(y: Array) -> Array:
    return np.asarray(y * (2 - y))


def _power(y: Array) -> Array:
    return np.asarray(y ** (1 / 7))


STOCHASTIC = {f"{MODELS}/dispersionModel": "stochasticDispersionRAS"}
VARIED: Mapping[str, Mapping[str, Changes]] = {
    "drag law": {
        "Clift": drag("CliftDrag"),
        "Haider-Levenspiel, sphere": _law("HaiderLevenspielDrag", 1),
    },
    "shape": {
        "Haider-Levenspiel, sphericity 0.8": _law("HaiderLevenspielDrag", 0.8),
        "Haider-Levenspiel, sphericity 0.6": _law("HaiderLevenspielDrag", 0.6),
        "Ganser, sphericity 0.8": _law("GanserDrag", 0.8),
        "Ganser, sphericity 0.6": _law("GanserDrag", 0.6),
    },
    "dispersion": {
        "none": {f"{MODELS}/dispersionModel": "none"},
        "stock's random walk": STOCHASTIC,
    },
    "restitution": {
        "0.3": _contacts("restitution", 0.3),
        "0.95": _contacts("restitution", 0.95),
    },
    "friction": {"0": _contacts("friction", 0), "0.8": _contacts("friction", 0.8)},
    "walls": {
        "dull and rough (0.3, 0.8)": _walls(0.3, 0.8),
        "lively and smooth (0.95, 0)": _walls(0.95, 0),
    },
    "inlet profile": {
        "power 1/7": inlet(_power, SCENE.velocity),
        "parabola": inlet(_parabola, SCENE.velocity),
    },
    "loading": {
        "0.02": {f"{PARAMETERS}:loading": 0.02},
        "1": {f"{PARAMETERS}:loading": 1},
    },
}
NUMERICS = ("mesh x 0.6", "mesh x 1.5", "step / 4", "step x 2", "soft contacts", "gas by points")
QUICK, QUICK_MESH = ("drag law", "restitution"), 0.6
QUICK_BASE = "mesh x 0.6"


def measure(
    runs: Path, parcels: int, seeds: Sequence[int], quick: bool, say: Callable[[str], None]
) -> list[Row]:
    """A row per varied thing, numerics and chance included, each from the same seeds; those that
    fail say why."""

    def run(point: Point) -> tuple[list[Cut], float]:
        folder = runs / slug(SCENE.name, point.name)
        done = replicates(folder, SCENE, point, parcels, seeds[:1] if point.once else seeds)
        cuts = [cut_of_events(one.run.events) for one in done]
        return cuts, median(one.seconds for one in done)

    known = {point.name: point for point in POINTS}
    base, seconds = run(known[QUICK_BASE if quick else BASE])
    mesh = QUICK_MESH if quick else 1.0
    rows = [_chance(QUICK_BASE if quick else BASE, base, seconds)]
    points = [
        (group, what, Point(f"{group} {what}", changes, mesh=mesh))
        for group, entries in VARIED.items()
        if not quick or group in QUICK
        for what, changes in entries.items()
    ]
    points += [("numerics", name, known[name]) for name in NUMERICS if not quick]
    for group, what, point in points:
        try:
            cut, seconds = run(point)
        except ElutriaError as error:
            rows.append({**dict.fromkeys(COLUMNS, nan), "group": group, "what": what,
                         "note": str(error)})  # fmt: skip
        else:
            rows.append(change_of(group, what, cut, base, seconds))
        say(f"{group}, {what}: d50 {100 * rows[-1]['d50_change']:+.1f} % {rows[-1]['note']}")
    return rows


def change_of(
    group: str, what: str, cuts: Sequence[Cut], base: Sequence[Cut], seconds: float
) -> Row:
    """What changed against the runs that all are compared with; noise is one deviation of both."""
    changed, compared = _mean(cuts), _mean(base)
    return {
        "group": group,
        "what": what,
        "d50_m": changed["d50"],
        "d50_change": changed["d50"] / compared["d50"] - 1,
        "d50_noise": hypot(changed["d50_noise"], compared["d50_noise"]) / compared["d50"],
        "sharpness": changed["sharpness"],
        "sharpness_change": changed["sharpness"] - compared["sharpness"],
        "sharpness_noise": hypot(changed["sharpness_noise"], compared["sharpness_noise"]),
        "seconds": seconds,
        "note": "",
    }


def _mean(cuts: Sequence[Cut]) -> dict[str, float]:
    """d50 (m) and sharpness, with the standard deviation of their means."""
    d50, sharpness = [cut.d50 for cut in cuts], [cut.sharpness for cut in cuts]
    return {
        "d50": fmean(d50),
        "d50_noise": mean_noise(d50, [cut.d50_sd for cut in cuts], 0),
        "sharpness": fmean(sharpness),
        "sharpness_noise": mean_noise(sharpness, [cut.sharpness_sd for cut in cuts], 0),
    }


def _chance(name: str, base: Sequence[Cut], seconds: float) -> Row:
    """The noise of the compared runs themselves: one deviation."""
    own = _mean(base)
    return {
        **change_of("chance", f"{name}, one deviation", base, base, seconds),
        "d50_change": own["d50_noise"] / own["d50"],
        "d50_noise": 0.0,
        "sharpness_change": own["sharpness_noise"],
        "sharpness_noise": 0.0,
    }


LINEAR = 2
"""Changes of d50 (%) up to which the figure's axis is linear."""
COLOURS = {"model or material": "#0072B2", "numerics": "#009E73", "chance": "0.6"}


def figure(rows: Sequence[Row]) -> Figure:
    """Bars of the change of d50 and of the sharpness, the widest at the top."""
    shown = sorted((row for row in rows if isfinite(row["d50_change"])), key=width)
    names = [f"{row['group']}: {row['what']}" for row in shown]
    colours = [COLOURS.get(row["group"], COLOURS["model or material"]) for row in shown]
    size = (2 * COLUMN_WIDTH, 0.15 * len(shown) + 0.8)
    result, panels = plt.subplots(1, 2, figsize=size, sharey=True)
    for axes, quantity, factor in zip(panels, ("d50", "sharpness"), (100, 1), strict=True):
        axes.barh(
            names,
            [factor * row[f"{quantity}_change"] for row in shown],
            xerr=[factor * row[f"{quantity}_noise"] for row in shown],
            color=colours,
            error_kw={"linewidth": 0.6, "ecolor": "0.3"},
            height=0.7,
        )
        axes.axvline(0, color="0.3", linewidth=0.6)
        axes.tick_params(axis="y", length=0, labelsize=6.5)
        axes.margins(y=0.01)
    panels[0].set_xscale("symlog", linthresh=LINEAR, linscale=0.8)
    panels[0].set_xticks([-20, -5, -2, 0, 2, 5, 20, 50, 150])
    panels[0].xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    panels[0].xaxis.set_minor_locator(NullLocator())
    panels[0].set_xlabel(f"change of d50, % (logarithmic beyond {LINEAR} %)")
    panels[1].set_xlabel("change of sharpness d25/d75")
    handles = [Rectangle((0, 0), 1, 1, color=colour) for colour in COLOURS.values()]
    result.legend(handles, COLOURS, loc="outside upper center", ncols=len(handles))
    return result


def width(row: Row) -> float:
    """Size of the change of d50; those that failed come last."""
    return abs(row["d50_change"]) if isfinite(row["d50_change"]) else -1.0
