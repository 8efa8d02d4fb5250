"""Turbulent dispersion: a uniform cloud stays uniform; drift with axial dispersion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from elutria.classification.events import Events, read_run
from elutria_validation.book.figures import BLUE, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import (
    add_feed,
    add_zone,
    cell_centres,
    set_turbulence,
    solve,
    uniform,
)
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.references.drag import Gas, cut_size, terminal_velocity
from elutria_validation.references.flows import drift_fines_share

NAME = "dispersion"
TITLE = "Turbulent dispersion"
HELP = "Turbulent dispersion: well-mixed cloud, and drift with axial dispersion."

Array = NDArray[np.float64]

# so that drag is linear and grains follow the eddies at once: their drift is exactly U - v_t
NU, HEAVY = 0.15, 981.0  # m2/s, m/s2
OIL = Gas(1.2, 1.2 * NU)
CONTINUOUS, STOCK = "continuousDispersionRAS", "stochasticDispersionRAS"
MILNE = 1.4604  # -zeta(1/2): Marshall and Watson 1985, doi 10.1088/0305-4470/18/18/016
C0 = 2.1  # of the Langevin model: T_L = (k/epsilon)/(1/2 + 3/4 C0)


def wall_turbulence(height: Array) -> tuple[Array, Array]:
    """k and epsilon of a channel's log layer, `height` over the half width; u* 0.3 m/s."""
    friction, half = 0.3, 0.05
    k = friction**2 / 0.3 * (1 - 0.76 * height)
    return k, friction**3 / (0.41 * half * height)


def decaying_turbulence(height: Array) -> tuple[Array, Array]:
    """Root-mean-square fluctuation from 0.1 m/s at the wall to 0.5, T_L 0.02 s throughout."""
    k = 1.5 * (0.1 + 0.4 * height) ** 2
    return k, k / (0.02 * (0.5 + 0.75 * C0))


def spread(
    folder: Path, model: str, turbulence: Callable[[Array], tuple[Array, Array]], number: int
) -> Array:
    """Places across (0 to 1) of tracers after 2 s; they start evenly spread, gas at rest."""
    width = 0.1
    across = np.random.default_rng(11).permutation((np.arange(number) + 0.5) / number)
    places = np.stack([across, np.full(number, 0.5), np.full(number, 0.5)], axis=1) * width
    case = BoxCase(
        cells=(20, 1, 1), ends="cyclic", gravity=0, dispersion=model, step=0.002, end=2
    ).make(folder, Particles.of(places, diameter=5e-6, density=1000.0))
    centres, _ = cell_centres(case)
    height = 1 - np.abs(2 * centres[:, 0] / width - 1)
    set_turbulence(case, *turbulence(height))
    solve(case)
    return read_particles(case, "2").position[:, 0] / width


def well_mixed(folder: Path, quick: bool) -> Section:
    bins, number = 20, 1000 if quick else 4000
    section = Section(
        "Well-mixed cloud in turbulence near walls",
        f"{number} tracers start evenly spread between two walls, in gas at rest whose turbulence "
        "varies across; after 2 s they must still be so: chi-squared of 20 equal slices below "
        "its 95 % limit. OpenFOAM's stochasticDispersionRAS is shown for comparison.",
    )
    figure, panels = new_figure(110, rows=2)
    limit = float(chi2.ppf(0.95, bins - 1))
    scenes = {"log layer of a channel": wall_turbulence,
              "turbulence that decays to the walls": decaying_turbulence}  # fmt: skip
    worst: dict[str, float] = {}
    for axes, (title, turbulence) in zip(panels, scenes.items(), strict=True):
        for model, colour in ((CONTINUOUS, BLUE), (STOCK, RED)):
            name = f"{model}{title[:4].strip()}"
            counts, edges = np.histogram(
                spread(folder / name, model, turbulence, number), bins, (0, 1)
            )
            expected = number / bins
            statistic = float(((counts - expected) ** 2 / expected).sum())
            deviation = float(np.abs(counts / expected - 1).max())
            worst[model] = max(worst.get(model, 0), deviation)
            section.rows += [
                Row(f"{title}, {model}", "chi-squared (reference: its 95 % limit; error: ratio)",
                    limit, statistic, statistic / limit, 1 if model == CONTINUOUS else None),
                Row.size(f"{title}, {model}", "largest deviation of a slice from the mean",
                         deviation, None),
            ]  # fmt: skip
            axes.stairs(counts / expected, edges, color=colour, label=model)
        band = 1.96 * np.sqrt((bins - 1) / number)
        axes.axhspan(1 - band, 1 + band, color="0.85", label="uniform, 95 %", zorder=0)
        axes.set_ylabel("concentration over the mean")
        axes.set_title(title, fontsize=8)
        axes.set_ylim(0, 2.2)
    panels[0].legend()
    panels[1].set_xlabel("place across the channel")
    section.found = (
        f"The largest deviation of a slice is {worst[CONTINUOUS]:.2f} of the mean with our model, "
        f"{worst[STOCK]:.2f} with OpenFOAM's."
    )
    section.figures["mixed"] = (figure, "Concentration across the channel after 2 s.")
    return section


@dataclass(frozen=True)
class Column:
    """Uniform upflow (m/s) with uniform turbulence: sigma (m/s) and T_L (s)."""

    velocity: float
    fluctuation: float
    time: float
    seed: int
    colour: str
    length: float = 0.12  # m

    def dispersion(self, terminal: Array) -> Array:
        """D (m2/s) of grains that slip with `terminal` through the eddies."""
        shorter = np.sqrt(1 + (terminal / self.fluctuation) ** 2)
        return np.asarray(self.fluctuation**2 * self.time / shorter)

    def fines_share(self, sizes: Array, beyond: float = 0) -> Array:
        """Formula for a feed at mid-height; ends absorb `beyond` lengths sigma T outside."""
        terminal = np.array([terminal_velocity(d, 1000.0, OIL, HEAVY) for d in sizes])
        dispersion = self.dispersion(terminal)
        lengths = self.length + 2 * beyond * dispersion / self.fluctuation
        return drift_fines_share(self.velocity - terminal, dispersion, lengths)

    def limits(self, number: int) -> Array:
        """Limits (m) of `number` size classes over which the share goes from 0.05 to 0.95."""
        drift = 6 * float(self.dispersion(np.array(self.velocity))) / self.length
        low, high = (cut_size(self.velocity + w, 1000.0, HEAVY, OIL) for w in (-drift, drift))
        return np.linspace(low, high, number + 1)


COLUMNS = (Column(0.5, 0.25, 0.01, 1, BLUE), Column(0.3, 0.15, 0.02, 2, RED))


def classify_drift(folder: Path, column: Column, number: int) -> Events:
    """What became of grains fed at mid-height, in the size range of the column's cut."""
    limits = column.limits(10)
    across, layers = 0.02, 21
    case = BoxCase(
        width=across, depth=across, height=column.length, cells=(1, 1, layers),
        gas_velocity=column.velocity, gravity=-HEAVY, gas_viscosity=NU, dispersion=CONTINUOUS,
        step=0.25 * column.time, end=40,
    ).make(folder)  # fmt: skip
    k = 1.5 * column.fluctuation**2
    set_turbulence(case, k, k / (column.time * (0.5 + 0.75 * C0)))
    layer = column.length / layers
    add_zone(case, "middle", (0, 0, 10 * layer), (across, across, 11 * layer))
    grains = uniform(1000.0, limits[0], limits[-1])
    add_feed(case, {"materials": grains, "zone": "middle", "massFlowRate": 1.0,
                    "particles": number, "seed": column.seed})  # fmt: skip
    solve(case)
    return read_run(case).events


def drift(folder: Path, quick: bool) -> Section:
    number = 1000 if quick else 40000
    eddies = max(
        float(c.dispersion(np.array(c.velocity))) / c.fluctuation / c.length for c in COLUMNS
    )
    section = Section(
        "Drift with axial dispersion",
        "Grains enter at mid-height of a column of uniform turbulence and leave at either end: "
        "share to fines (1 - exp(-w x0/D))/(1 - exp(-w L/D)), w = U - v_t, with D = sigma^2 T of "
        "the dispersion model, T shortened by the slip. Gravity is a hundredfold and the gas as "
        "thick as oil, so that drag is linear, grains follow the eddies at once and their drift "
        "is exactly w. The theory is the limit of eddies that are small against the column; here "
        f"sigma T/L is {eddies:.2f}. Allowed: of 10 size classes at most 2 outside the 95 % band, "
        "which chance exceeds in 1 % of runs. Rows for information: a grain whose eddies last a "
        "while leaves as if the ends lay 1.46 sigma T further out (the Milne problem of a "
        "Langevin process).",
    )
    figure, (axes,) = new_figure(65)
    for column in COLUMNS:
        case = f"{column.velocity:g} m/s, sigma {column.fluctuation:g} m/s, T_L {column.time:g} s"
        events = classify_drift(folder / f"drift{column.velocity}", column, number)
        left = events.select(events.has_left)
        limits = column.limits(10)
        exact = column.fines_share(left.diameter)
        where = np.clip(np.digitize(left.diameter, limits) - 1, 0, 9)
        count = np.bincount(where, minlength=10)
        theory = np.bincount(where, exact, 10) / count
        share = np.bincount(where, ~left.is_coarse, 10) / count
        band = 1.96 * np.sqrt(np.bincount(where, exact * (1 - exact), 10)) / count
        longer = np.bincount(where, column.fines_share(left.diameter, MILNE), 10) / count
        inside, inside_longer = (
            int(np.sum(np.abs(share - one) <= band)) for one in (theory, longer)
        )
        to_fines = float((~left.is_coarse).mean())
        section.rows += [
            Row(case, "classes of 10 inside the 95 % band (error: those outside)", 10, inside,
                10 - inside, 2),
            Row(case, "the same beside the theory with ends 1.46 sigma T further out", 10,
                inside_longer, 10 - inside_longer, None),
            Row(case, "share to fines, mean of all; error absolute", float(exact.mean()),
                to_fines, abs(to_fines - float(exact.mean())),
                0.01 if not quick else 2 * (0.25 / number) ** 0.5),
            Row.size(case, "share of grains still inside at the end; error: itself",
                     1 - len(left) / len(events), 0.01),
        ]  # fmt: skip
        sizes = 0.5e6 * (limits[1:] + limits[:-1])
        axes.fill_between(sizes, theory - band, theory + band, color=column.colour, alpha=0.25,
                          lw=0)  # fmt: skip
        axes.plot(sizes, theory, "k:", linewidth=0.8)
        axes.plot(sizes, share, "o", color=column.colour, markersize=3, label=case)
    label(axes, "diameter, µm", "share to fines", "theory")
    section.figures["drift"] = (figure, "Drift with axial dispersion.")
    return section


SECTIONS = (well_mixed, drift)
