"""Turbulent dispersion: a uniform cloud stays uniform; drift with axial dispersion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray
from scipy.stats import chi2

from elutria.classification.events import Events, read_run
from elutria.estimates.theory import drift_dispersion_fines_share
from elutria.output.plots import STYLE, new_figure
from elutria.physics.drag import Gas, plug_flow_cut_size, terminal_velocity
from elutria_validation.book.book import Chapter, Row, write_chapter
from elutria_validation.harness.common import Options
from elutria_validation.harness.scene import (
    BOX,
    CONTROL,
    MODELS,
    Particles,
    add_feed,
    add_zone,
    cell_centres,
    make_scene,
    read_particles,
    run_scene,
    set_turbulence,
)

NAME = "dispersion"
HELP = "Turbulent dispersion: well-mixed cloud, and drift with axial dispersion."

Array = NDArray[np.float64]

# so that drag is linear and grains follow the eddies at once: their drift is exactly U - v_t
NU, HEAVY = 0.15, 981.0  # m2/s, m/s2
GAS = Gas(1.2, 1.2 * NU)
CONTINUOUS, STOCK = "continuousDispersionRAS", "stochasticDispersionRAS"
MILNE = 1.4604  # -zeta(1/2): Marshall and Watson 1985, doi 10.1088/0305-4470/18/18/016
C0 = 2.1  # of the Langevin model: T_L = (k/epsilon)/(1/2 + 3/4 C0)


@rc_context(STYLE)
def run(options: Options) -> Chapter:
    """Two turbulence profiles with both models; two drifts."""
    chapter = Chapter(NAME, "Turbulent dispersion")
    with TemporaryDirectory() as work:
        _well_mixed(chapter, Path(work), 1000 if options.quick else 4000)
        _drift(chapter, Path(work), 1000 if options.quick else 40000)
    return write_chapter(options, chapter)


def _wall_turbulence(height: Array) -> tuple[Array, Array]:
    """k and epsilon of a channel's log layer, `height` over the half width; u* 0.3 m/s."""
    friction, half = 0.3, 0.05
    k = friction**2 / 0.3 * (1 - 0.76 * height)
    return k, friction**3 / (0.41 * half * height)


def _decaying_turbulence(height: Array) -> tuple[Array, Array]:
    """Root-mean-square fluctuation from 0.1 m/s at the wall to 0.5, T_L 0.02 s throughout."""
    k = 1.5 * (0.1 + 0.4 * height) ** 2
    return k, k / (0.02 * (0.5 + 0.75 * C0))


def spread(folder: Path, model: str, turbulence: Any, number: int) -> Array:
    """Places across (0 to 1) of tracers after 2 s; they start evenly spread, gas at rest."""
    width, cells = 0.1, 20
    across = np.random.default_rng(11).permutation((np.arange(number) + 0.5) / number)
    places = np.stack([across, np.full(number, 0.5), np.full(number, 0.5)], axis=1) * width
    case = make_scene(
        folder,
        Particles.of(places, diameter=5e-6, density=1000.0),
        {
            f"{BOX}:cellsX": cells,
            f"{BOX}:ends": "cyclic",
            f"{BOX}:bottomGroup": "closed",
            f"{BOX}:topGroup": "closed",
            f"{BOX}:gravity": 0,
            f"{MODELS}/dispersionModel": model,
            f"{CONTROL}:deltaT": 0.002,
            f"{CONTROL}:endTime": 2,
            f"{CONTROL}:writeInterval": 2,
        },
    )
    centres, _ = cell_centres(case)
    height = 1 - np.abs(2 * centres[:, 0] / width - 1)
    set_turbulence(case, *turbulence(height))
    run_scene(case)
    return read_particles(case, "2").position[:, 0] / width


def _well_mixed(chapter: Chapter, folder: Path, number: int) -> None:
    bins = 20
    section = chapter.section(
        "Well-mixed cloud in turbulence near walls",
        f"{number} tracers start evenly spread between two walls, in gas at rest whose turbulence "
        "varies across; after 2 s they must still be so: chi-squared of 20 equal slices below "
        "its 95 % limit. OpenFOAM's stochasticDispersionRAS is "
        "shown for comparison.",
        "Four faults were mended on the way: the time scale followed the slip at hand, with which "
        "upward and downward eddies last differently long and the cloud drifts; eddies went on "
        "into a wall that had thrown the grain back; sigma's gradient was halved in the cells at "
        "walls, and sigma was one value per cell; and in a step that is not short against T the "
        "change of T and sigma along the way went unseen. OpenFOAM's model empties or fills the "
        "walls threefold.",
    )
    figure, panels = new_figure(110, rows=2)
    limit = float(chi2.ppf(0.95, bins - 1))
    for axes, (title, turbulence) in zip(
        panels,
        (("log layer of a channel", _wall_turbulence), ("turbulence that decays to the walls",
                                                        _decaying_turbulence)),
        strict=True,
    ):  # fmt: skip
        for model, colour in ((CONTINUOUS, "#0072B2"), (STOCK, "#D55E00")):
            places = spread(folder / f"{model}{title[:4].strip()}", model, turbulence, number)
            counts, edges = np.histogram(places, bins, (0, 1))
            expected = number / bins
            statistic = float(((counts - expected) ** 2 / expected).sum())
            worst = float(np.abs(counts / expected - 1).max())
            ours = model == CONTINUOUS
            section.rows += [
                Row(f"{title}, {model}", "chi-squared (reference: its 95 % limit; error: ratio)",
                    limit, statistic, statistic / limit, 1 if ours else None),
                Row(f"{title}, {model}", "largest deviation of a slice from the mean", 0, worst,
                    worst, None),
            ]  # fmt: skip
            axes.stairs(counts / expected, edges, color=colour, label=model)
        band = 1.96 * np.sqrt((bins - 1) / number)
        axes.axhspan(1 - band, 1 + band, color="0.85", label="uniform, 95 %", zorder=0)
        axes.set_ylabel("concentration over the mean")
        axes.set_title(title, fontsize=8)
        axes.set_ylim(0, 2.2)
    panels[0].legend()
    panels[1].set_xlabel("place across the channel")
    section.figures["mixed"] = (figure, "Concentration across the channel after 2 s.")


@dataclass(frozen=True)
class Column:
    """Uniform upflow (m/s) with uniform turbulence: sigma (m/s) and T_L (s)."""

    velocity: float
    fluctuation: float
    time: float
    seed: int
    length: float = 0.12  # m

    def dispersion(self, terminal: Array) -> Array:
        """D (m2/s) of grains that slip with `terminal` through the eddies."""
        shorter = np.sqrt(1 + (terminal / self.fluctuation) ** 2)
        return np.asarray(self.fluctuation**2 * self.time / shorter)

    def fines_share(self, sizes: Array, beyond: float = 0) -> Array:
        """Formula for a feed at mid-height; ends absorb `beyond` lengths sigma T outside."""
        terminal = np.array([terminal_velocity(d, 1000.0, GAS, gravity=HEAVY) for d in sizes])
        dispersion = self.dispersion(terminal)
        lengths = self.length + 2 * beyond * dispersion / self.fluctuation
        return np.array([
            drift_dispersion_fines_share(v, self.velocity, length / 2, length, d)
            for v, length, d in zip(terminal, lengths, dispersion, strict=True)
        ])  # fmt: skip

    def sizes(self, number: int) -> Array:
        """Limits (m) of `number` classes over which the share goes from 0.05 to 0.95."""
        dispersion = self.dispersion(np.array(self.velocity))
        drift = 6 * dispersion / self.length
        low, high = (
            plug_flow_cut_size(self.velocity + w, 1000.0, GAS, gravity=HEAVY)
            for w in (-drift, drift)
        )
        return np.linspace(low, high, number + 1)


def classify_drift(folder: Path, column: Column, number: int) -> Events:
    """What became of grains fed at mid-height, in the size range of the column's cut."""
    limits = column.sizes(10)
    across, layers = 0.02, 21
    step = 0.25 * column.time
    case = make_scene(
        folder,
        settings={
            f"{BOX}:width": across,
            f"{BOX}:depth": across,
            f"{BOX}:height": column.length,
            f"{BOX}:cellsAlong": layers,
            f"{BOX}:gasVelocity": column.velocity,
            f"{BOX}:gravity": -HEAVY,
            f"{BOX}:gasNu": NU,
            f"{MODELS}/dispersionModel": CONTINUOUS,
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:endTime": 40,
            f"{CONTROL}:writeInterval": 40,
        },
    )
    k = 1.5 * column.fluctuation**2
    set_turbulence(case, k, k / (column.time * (0.5 + 0.75 * C0)))
    layer = column.length / layers
    add_zone(case, "middle", (0, 0, 10 * layer), (across, across, 11 * layer))
    sizes = {"type": "uniform", "min": limits[0], "max": limits[-1], "weighting": "number"}
    solid = {"density": 1000.0, "massFraction": 1, "sizeDistribution": sizes}
    feed = {"zone": "middle", "massFlowRate": 1.0, "particles": number, "seed": column.seed}
    add_feed(case, {"materials": {"solid": solid}, **feed})
    run_scene(case)
    return read_run(case).events


def _drift(chapter: Chapter, folder: Path, number: int) -> None:
    section = chapter.section(
        "Drift with axial dispersion",
        "Grains enter at mid-height of a column of uniform turbulence and leave at either end: "
        "share to fines (1 - exp(-w x0/D))/(1 - exp(-w L/D)), w = U - v_t, with D = sigma^2 T of "
        "the dispersion model, T shortened by the slip. Gravity is a hundredfold and the gas as "
        "thick as oil, so that drag is linear, grains follow the eddies at once and their drift "
        "is exactly w. The theory is the limit of eddies that are small against the column; here "
        "sigma T/L is 0.01. Allowed: of 10 size classes at most 2 outside the 95 % band, which "
        "chance exceeds in 1 % of runs.",
        "A grain whose eddies last a while leaves the column as if the ends lay 1.46 sigma T "
        "further out (the Milne problem of a Langevin process, -zeta(1/2)). In a column of half "
        "the length that was 5 % of it, and five times 10 000 grains had 12 of 50 classes outside "
        "the band of the theory of small eddies, 5 with the ends moved; their mean share differed "
        "from the theory by 0.0002, one alone by up to 0.011, which is chance. The rows for "
        "information have the ends moved.",
    )
    figure, (axes,) = new_figure(65)
    for column, colour in (
        (Column(0.5, 0.25, 0.01, 1), "#0072B2"), (Column(0.3, 0.15, 0.02, 2), "#D55E00")
    ):  # fmt: skip
        case = f"{column.velocity:g} m/s, sigma {column.fluctuation:g} m/s, T_L {column.time:g} s"
        events = classify_drift(folder / f"drift{column.velocity}", column, number)
        left = events.select(events.has_left)
        limits = column.sizes(10)
        exact = column.fines_share(left.diameter)
        where = np.clip(np.digitize(left.diameter, limits) - 1, 0, 9)
        count = np.bincount(where, minlength=10)
        theory = np.bincount(where, exact, 10) / count
        share = np.bincount(where, ~left.is_coarse, 10) / count
        band = 1.96 * np.sqrt(np.bincount(where, exact * (1 - exact), 10)) / count
        inside = int(np.sum(np.abs(share - theory) <= band))
        longer = np.bincount(where, column.fines_share(left.diameter, MILNE), 10) / count
        inside_longer = int(np.sum(np.abs(share - longer) <= band))
        section.rows += [
            Row(case, "classes of 10 inside the 95 % band (error: those outside)", 10, inside,
                10 - inside, 2),
            Row(case, "the same beside the theory with ends 1.46 sigma T further out", 10,
                inside_longer, 10 - inside_longer, None),
            Row(case, "share to fines, mean of all; error absolute", float(exact.mean()),
                float((~left.is_coarse).mean()),
                abs(float((~left.is_coarse).mean() - exact.mean())), 0.01),
            Row(case, "share of grains still inside at the end; error: itself", 0,
                1 - len(left) / len(events), 1 - len(left) / len(events), 0.01),
        ]  # fmt: skip
        sizes = 0.5e6 * (limits[1:] + limits[:-1])
        axes.fill_between(sizes, theory - band, theory + band, color=colour, alpha=0.25, lw=0)
        axes.plot(sizes, theory, "k:", linewidth=0.8)
        axes.plot(sizes, share, "o", color=colour, markersize=3, label=case)
    axes.set_xlabel("diameter, µm")
    axes.set_ylabel("share to fines")
    axes.legend(title="lines: theory; dots: elutriaFoam", title_fontsize=7)
    section.figures["drift"] = (figure, "Drift with axial dispersion.")
