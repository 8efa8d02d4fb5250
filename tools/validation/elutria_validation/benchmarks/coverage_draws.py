"""Synthetic partition curves and events: how often are the limits of their fits where they say?

Needs numpy and scipy alone, so that it runs on any machine with this source tree:

    export OPENBLAS_NUM_THREADS=1 PYTHONPATH=tools:tools/validation
    python3 -m elutria_validation.benchmarks.coverage_draws --jobs 16 --to FOLDER
        [--shapes steep,three-step] [--events 100,300] [--first 0] [--draws 1000]

Each draw has a curve of its own, sizes log-uniform over half to twice a typical d50, and weights
that are equal, a function of size, or scattered. A draw's random numbers depend on its shape,
events and number alone. Rows are written as they come, SHAPE-EVENTS.csv; draws already there are
not repeated.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import exp, inf, log, nan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import expit

from elutria.classification.curves import MODELS, Model
from elutria.classification.fit import LEVELS, PartitionFit, fit_partition

Array = NDArray[np.float64]
Row = dict[str, Any]

SHAPES = ("smooth", "steep", "bypassed", "two-step", "fish-hook")
OTHERS = ("three-step", "uneven", "shoulder", "hump")
"""Shapes beside those, drawn where asked for."""
EVENTS = (100, 300, 1_000, 3_000, 10_000, 30_000)
PLACES = (0.02, 0.05, 0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9, 0.95, 0.98)
"""Shares T at whose sizes a band is asked for; beyond the outer ones lie the ends."""
TYPICAL = log(700e-6)
"""ln d50/m about which all is drawn."""
WIDE = 0.8
"""A band so wide somewhere tells nothing there."""
COLUMNS = (
    "seed", *(f"at_{place:g}" for place in PLACES), "ends", "d25", "d50", "d75", "sharpness",
    "width", "ideal", "widest", "ends_widest", "d50_width", "d50_off", "sharpness_off", "seconds",
)  # fmt: skip
"""Of a draw: 1 or 0 for what is covered or not, empty where the curve has no such size; mean widths
of the band at PLACES, and of that of a fit of the curve's own formula (Fisher information); how far
d50 is above the true one, in halves of its interval's width; how far ln(d75/d25) is below it,
relative to it. What the last two are on average is bias, not chance."""


@dataclass(frozen=True)
class Curve:
    """T over ln d - TYPICAL, by a formula of `parameters`."""

    formula: Callable[[Array, Array], Array]
    parameters: Array

    def share(self, y: Array) -> Array:
        """T at ln d - TYPICAL."""
        return self.formula(y, self.parameters)

    def place(self, share: float) -> float:
        """The largest ln d - TYPICAL below which T is less than `share`; nan without any."""
        y = np.linspace(-log(2), log(2), 2001)
        rising = np.flatnonzero(np.diff((self.share(y) >= share).astype(int)) > 0)
        if not rising.size:
            return nan
        k = rising[-1]
        return float(brentq(lambda x: self.share(np.array([x]))[0] - share, y[k], y[k + 1]))

    def ideal_width(self, events: Array, effective: float, at: Array) -> Array:
        """Width of the 95 % band at `at` of a fit of this very formula to events at `events`, each
        of which counts for `effective`."""

        def slopes(y: Array) -> Array:
            steps = 1e-5 * np.eye(self.parameters.size)
            return (
                np.array(
                    [
                        self.formula(y, self.parameters + s) - self.formula(y, self.parameters - s)
                        for s in steps
                    ]
                )
                / 2e-5
            )

        share, here = self.share(events), slopes(events)
        information = (effective * here / np.maximum(share * (1 - share), 1e-9)) @ here.T
        there = slopes(at)
        variance = np.einsum("kn,kl,ln->n", there, np.linalg.pinv(information), there)
        half = 1.96 * np.sqrt(np.maximum(variance, 0))
        middle = self.share(at)
        return np.asarray(np.minimum(middle + half, 1) - np.maximum(middle - half, 0))


def curve_of(shape: str, random: np.random.Generator) -> Curve:
    """A curve of a shape; its steepness is that of any of the literature's formulas.

    ln(d75/d25) without what the shape adds: smooth 0.2 to 0.7, steep and two-step 0.02 to 0.12,
    else 0.04 to 0.3. Bypass 3 to 20 %; half to half of the mass, give or take a tenth, that cuts 8
    to 16 % higher and lower; a hook of 10 to 30 % that ends 20 to 50 % below the cut.
    """
    steep = ("steep", "two-step", "three-step", "uneven")
    low, high = (0.2, 0.7) if shape == "smooth" else (0.02, 0.12) if shape in steep else (0.04, 0.3)
    width = exp(random.uniform(log(low), log(high)))
    model, log_shape = _with_width(random, width)
    center = random.uniform(-0.1, 0.1)

    def cut(y: Array, center: float, log_shape: float) -> Array:
        return np.asarray(expit(model.logit(y - center, log_shape)[0]))

    if shape == "bypassed":
        return Curve(
            lambda y, p: p[2] + (1 - p[2]) * cut(y, p[0], p[1]),
            np.array([center, log_shape, random.uniform(0.03, 0.2)]),
        )
    if shape == "two-step":
        return Curve(
            lambda y, p: p[3] * cut(y, p[0] + p[2], p[1]) + (1 - p[3]) * cut(y, p[0] - p[2], p[1]),
            np.array([center, log_shape, random.uniform(0.08, 0.16), random.uniform(0.4, 0.6)]),
        )
    if shape == "fish-hook":
        return Curve(
            lambda y, p: 1 - (1 - cut(y, p[0], p[1])) * (1 - p[2] * expit((p[3] - y) / 0.12)),
            np.array([center, log_shape, random.uniform(0.1, 0.3), random.uniform(-0.5, -0.2)]),
        )
    if shape in OTHERS:
        return _other(shape, random, cut, [center, log_shape])
    return Curve(lambda y, p: cut(y, p[0], p[1]), np.array([center, log_shape]))


def _other(
    shape: str,
    random: np.random.Generator,
    cut: Callable[[Array, float, float], Array],
    own: list[float],
) -> Curve:
    """A curve of OTHERS, from a `cut` of `own` parameters: thirds that cut 10 to 20 % apart; 30 or
    70 % that cut 16 to 32 % higher than the rest; 8 to 20 % that cut 25 to 40 % higher, less
    sharply; 10 to 30 % fewer to coarse about a size 25 to 40 % above the cut."""
    if shape == "three-step":
        apart = random.uniform(0.1, 0.2)
        return Curve(
            lambda y, p: np.mean([cut(y, p[0] + k * p[2], p[1]) for k in (-1, 0, 1)], axis=0),
            np.array([*own, apart]),
        )
    if shape == "uneven":
        apart, share = random.uniform(0.08, 0.16), random.choice([0.3, 0.7])
        return Curve(
            lambda y, p: p[3] * cut(y, p[0] + p[2], p[1]) + (1 - p[3]) * cut(y, p[0] - p[2], p[1]),
            np.array([*own, apart, share]),
        )
    if shape == "shoulder":
        apart, share = random.uniform(0.25, 0.4), random.uniform(0.08, 0.2)
        return Curve(
            lambda y, p: (1 - p[3]) * cut(y, p[0], p[1]) + p[3] * expit((y - p[0] - p[2]) / 0.05),
            np.array([*own, apart, share]),
        )
    share, apart = random.uniform(0.1, 0.3), random.uniform(0.25, 0.4)
    return Curve(
        lambda y, p: cut(y, p[0], p[1]) * (1 - p[2] * np.exp(-(((y - p[0] - p[3]) / 0.1) ** 2))),
        np.array([*own, share, apart]),
    )


def _with_width(random: np.random.Generator, width: float) -> tuple[Model, float]:
    """A model of the literature and its ln s for which ln(d75/d25) is `width`."""

    def off(log_shape: float, model: Model) -> float:
        return model.log_x_at(0.75, log_shape) - model.log_x_at(0.25, log_shape) - width

    while True:
        model = MODELS[random.integers(len(MODELS))]
        low, high = model.bounds
        if off(low, model) > 0 > off(high, model):
            return model, float(brentq(off, low, high, args=(model,)))


@dataclass(frozen=True)
class Draw:
    """A curve and its events: ln d - TYPICAL, whether coarse, weight; `effective` is the number of
    events that one counts for (Kish)."""

    curve: Curve
    y: Array
    coarse: NDArray[np.bool_]
    weight: Array
    effective: float

    def fit(self) -> PartitionFit:
        """As `classify` does."""
        time = np.arange(self.y.size, dtype=float)
        return fit_partition(np.exp(TYPICAL + self.y), self.coarse, self.weight, time)


def draw(shape: str, events: int, seed: int) -> Draw:
    """The draw of a number."""
    random = np.random.default_rng([(*SHAPES, *OTHERS).index(shape), events, seed])
    curve = curve_of(shape, random)
    y = random.uniform(-log(2), log(2), events)
    coarse = random.random(events) < curve.share(y)
    kind = random.integers(3)
    if kind == 0:
        return Draw(curve, y, coarse, np.ones(events), 1.0)
    if kind == 1:  # a function of size: half of the parcels near the cut
        return Draw(curve, y, coarse, np.where(np.abs(y) < 0.3, 0.3, 1.0) * np.exp(-3 * y), 1.0)
    spread = 0.5
    return Draw(curve, y, coarse, np.exp(random.normal(0, spread, events)), exp(-(spread**2)))


def measure(shape: str, events: int, seed: int) -> Row:
    """The row of one draw."""
    drawn = draw(shape, events, seed)
    curve, y = drawn.curve, drawn.y
    start = time.process_time()
    fit = drawn.fit()
    row: Row = {"seed": seed, "seconds": time.process_time() - start}
    if fit.curve is None:
        return row
    places = np.array([curve.place(share) for share in PLACES])
    inside = (places >= y.min()) & (places <= y.max())
    ends = np.linspace(y.min(), y.max(), 41)
    ends = ends[np.abs(curve.share(ends) - 0.5) > 0.48]
    held, width = _band(fit, curve, places[inside])
    ends_held, ends_width = _band(fit, curve, ends)
    ideal = curve.ideal_width(y, drawn.effective, places[inside])
    known = [f"at_{share:g}" for share, is_in in zip(PLACES, inside, strict=True) if is_in]
    row |= dict(zip(known, held.astype(int).tolist(), strict=True))
    if ends.size:
        row |= {"ends": ends_held.mean(), "ends_widest": ends_width.max()}
    if width.size:
        row |= {"width": width.mean(), "ideal": ideal.mean()}
    row["widest"] = max([*width, *ends_width])
    return row | _sizes(fit, curve, y)


def _band(fit: PartitionFit, curve: Curve, y: Array) -> tuple[NDArray[np.bool_], Array]:
    if not y.size:
        return np.zeros(0, dtype=bool), np.zeros(0)
    _, low, high = fit.band(np.exp(TYPICAL + y))
    truth = curve.share(y)
    return (low <= truth) & (truth <= high), high - low


def _sizes(fit: PartitionFit, curve: Curve, y: Array) -> Row:
    """Whether the intervals hold the true sizes and sharpness, where the fit gives any."""
    row: Row = {}
    true = {level: curve.place(level) for level in LEVELS}
    for level, at in true.items():
        value, low, high = fit.sizes[level]
        if y.min() <= at <= y.max() and value == value:
            row[f"d{100 * level:.0f}"] = int(low <= exp(TYPICAL + at) <= high)
            if level == 0.5 and low > 0 and high < inf:
                row["d50_width"] = log(high / low)
                row["d50_off"] = (log(value) - TYPICAL - at) / (log(high / low) / 2)
    value, low, high = fit.sharpness_interval
    if low == low and true[0.25] == true[0.25] and true[0.75] == true[0.75]:
        row["sharpness"] = int(low <= exp(true[0.25] - true[0.75]) <= high)
        row["sharpness_off"] = 1 - log(value) / (true[0.25] - true[0.75])
    return row


def run(
    folder: Path,
    shapes: Sequence[str],
    events: Sequence[int],
    seeds: range,
    jobs: int,
    say: Callable[[str], None] = print,
) -> None:
    """Rows of all draws that FOLDER/SHAPE-EVENTS.csv do not have yet, by `jobs` processes."""
    folder.mkdir(parents=True, exist_ok=True)
    tasks = []
    for number in events:  # all shapes of few events first
        for shape in shapes:
            done = {int(row["seed"]) for row in read(folder, shape, number)}
            tasks += [(shape, number, seed) for seed in seeds if seed not in done]
    start, last = time.monotonic(), 0.0
    with multiprocessing.Pool(jobs) as pool:
        for k, (task, row) in enumerate(pool.imap_unordered(_task, tasks, chunksize=4), start=1):
            _append(_file(folder, *task[:2]), row)
            spent = time.monotonic() - start
            if spent > last + 20 or k == len(tasks):
                say(f"{k} of {len(tasks)} draws, {spent:.0f} s, now {task[0]} {task[1]}")
                last = spent


def _task(task: tuple[str, int, int]) -> tuple[tuple[str, int, int], Row]:
    return task, measure(*task)


def _file(folder: Path, shape: str, events: int) -> Path:
    return folder / f"{shape}-{events}.csv"


def _append(path: Path, row: Row) -> None:
    new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if new:
            writer.writeheader()
        short = {name: f"{v:.5g}" if isinstance(v, float) else v for name, v in row.items()}
        writer.writerow(short)


def read(folder: Path, shape: str, events: int) -> list[Row]:
    """Rows of a kind by seed, numbers or nan."""
    path = _file(folder, shape, events)
    if not path.is_file():
        return []
    with path.open(newline="") as file:
        rows = [
            {name: float(value) if value else nan for name, value in row.items()}
            for row in csv.DictReader(file)
            if None not in row.values()  # a row that was cut off
        ]
    return sorted(rows, key=lambda row: row["seed"])


def main() -> None:
    parser = argparse.ArgumentParser(description="Draws of `elutria bench coverage`.")
    parser.add_argument("--to", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--shapes", default=",".join(SHAPES))
    parser.add_argument("--events", default=",".join(map(str, EVENTS)))
    parser.add_argument("--first", type=int, default=0, help="first draw")
    parser.add_argument("--draws", type=int, default=1000)
    options = parser.parse_args()
    run(
        options.to,
        options.shapes.split(","),
        _numbers(options.events.split(",")),
        range(options.first, options.first + options.draws),
        options.jobs,
        lambda line: print(line, flush=True),
    )


def _numbers(words: Iterable[str]) -> list[int]:
    return [int(word) for word in words]


if __name__ == "__main__":
    main()
