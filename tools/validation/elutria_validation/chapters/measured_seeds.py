"""Wheat from straw, and the terminal velocities of seeds, as measured in several laboratories."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from elutria_validation.book.figures import COLOURS, GREEN, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import add_feed, add_zone, solve
from elutria_validation.references.drag import read_table

LAW = "HaiderLevenspielDrag"
OTHER_LAWS = ("GanserDrag", "HoelzerSommerfeldDrag")
LOW, HIGH = 4.85, 7.04
"""m/s: between them wheat and straw are parted, as measured."""
WHEAT, STRAW = (7.04, 7.74), (2.53, 4.85)
"""m/s: measured terminal velocities of kernels of 20 to 50 mg, of straw of 1 to 10 cm."""
LABORATORIES = 0.2
"""By which laboratories differ on wheat."""


@dataclass(frozen=True)
class Body:
    """A particle by its volume-equivalent size (m), density (kg/m3) and sphericity."""

    diameter: float
    density: float
    sphericity: float

    def material(self, share: float) -> dict[str, Any]:
        """Of a feed."""
        return {"density": self.density, "sphericity": round(self.sphericity, 4),
                "massFraction": share,
                "sizeDistribution": {"type": "fixedValue", "value": self.diameter}}  # fmt: skip


def kernel(milligrams: float, density: float, sphericity: float) -> Body:
    """A kernel of wheat."""
    return Body((6e-6 * milligrams / (pi * density)) ** (1 / 3), density, sphericity)


def straw(length: float, across: float, density: float) -> Body:
    """A straw (m, m) as a cylinder of the density (kg/m3) that its outer volume has."""
    diameter = (1.5 * across**2 * length) ** (1 / 3)
    surface = pi * across * length + pi / 2 * across**2
    return Body(diameter, density, pi * diameter**2 / surface)


# what the source does not give, over what is plausible; the first of each is the one taken
MASSES = (35.0, 20.0, 50.0)  # mg, given
DENSITIES, SPHERICITIES = (1300.0, 1200.0, 1400.0), (0.88, 0.84, 0.92)
LENGTHS = (0.03, 0.01, 0.10)  # m, given
ACROSS, HOLLOW = (3e-3, 2e-3, 4.5e-3), (200.0, 100.0, 400.0)  # m; kg/m3


def bodies() -> dict[str, Body]:
    """By name: every kernel and straw over the ranges of what is given and what is not, seeds."""
    found = {f"wheat{k}": kernel(*values)
             for k, values in enumerate(product(MASSES, DENSITIES, SPHERICITIES))}  # fmt: skip
    found |= {f"straw{k}": straw(*values)
              for k, values in enumerate(product(LENGTHS, ACROSS, HOLLOW))}  # fmt: skip
    return found | {
        f"seed{k}": Body(1e-3 * float(row["diameter_mm"]), float(row["density_kg_m3"]),
                         float(row["sphericity"]))
        for k, row in enumerate(read_table("seeds"))
    }  # fmt: skip


def column(folder: Path, which: dict[str, Body], law: str, upflow: float, height: float,
           fed_at: float) -> Path:  # fmt: skip
    """A finished run: the bodies let go at `fed_at` of the `height` (m) of a column of rising gas;
    what rises leaves at the top."""
    case = BoxCase(height=height, cells=(1, 1, 20), gas_velocity=upflow,
                   forces={law: {}, "gravity": {}}, step=5e-3, end=60).make(folder)  # fmt: skip
    layer = height / 20
    low = layer * int(20 * fed_at)
    add_zone(case, "start", (0, 0, low), (0.1, 0.1, low + layer))
    feed = {name: body.material(1 / len(which)) for name, body in which.items()}
    add_feed(case, {"materials": feed, "zone": "start", "massFlowRate": 1.0, "duration": 0.01,
                    "parcels": "evenMass", "particles": 4 * len(which),
                    "drainTime": 30})  # fmt: skip
    solve(case)
    return case


def left(case: Path) -> pd.DataFrame:
    """The parcels that left a run."""
    files = case.glob("postProcessing/outlets/*/particles.csv")
    return pd.concat([pd.read_csv(file) for file in files])


def terminal_velocities(folder: Path, which: dict[str, Body], law: str) -> dict[str, float]:
    """m/s, by name: how fast each leaves a column of air at rest at its bottom, 20 m below."""
    rows = left(column(folder, which, law, 0.0, 22.0, 0.95))
    return {str(name): -float(own["uz_m_s"].mean()) for name, own in rows.groupby("material")}


def seeds(folder: Path, quick: bool) -> Section:
    section = Section(
        "Wheat from straw, and seeds, measured (Khoshtaghaza and Mehdizadeh; others)",
        "Kernels of wheat (20 to 50 mg) were measured to fall at 7.04 to 7.74 m/s, straws of 1 to "
        "10 cm at 2.53 to 4.85 m/s: between 4.85 and 7.04 m/s gas parts them. Haider and "
        "Levenspiel's drag. The source gives neither the kernels' density and shape nor the "
        "straws' mass and diameter: what is taken (kernels 1300 kg/m3, sphericity 0.88; straws 3 "
        "mm, 200 kg/m3 of outer volume) is drawn with a band over 1200 to 1400 kg/m3, 0.84 to "
        "0.92, 2 to 4.5 mm and 100 to 400 kg/m3. Judged is the window alone: at velocities within "
        "it the share of what was taken that leaves on the wrong side must be nil, since it is "
        "stated; velocities and seeds are for information, as laboratories differ by 20 % on "
        "wheat.",
    )
    known = bodies()
    taken = {name: body for name, body in known.items() if name in _nominal()}
    inside, outside = (4.9, 5.95, 7.0), (4.0, 8.0)
    for upflow in (5.95,) if quick else (*outside[:1], *inside, *outside[1:]):
        rows = left(column(folder / f"u{upflow}", taken, LAW, upflow, 2.0, 0.5))
        wheat = rows["material"].str.startswith("wheat")
        wrong = {"wheat": (rows["outlet"] == "fines")[wheat].mean(),
                 "straw": (rows["outlet"] == "coarse")[~wheat].mean()}  # fmt: skip
        judged = 0.0 if upflow in inside else None
        section.rows += [
            Row.size(f"gas at {upflow:g} m/s", f"share of {name} that leaves on the wrong side",
                     float(share), judged)
            for name, share in wrong.items()
        ]  # fmt: skip
    laws = (LAW,) if quick else (LAW, *OTHER_LAWS)
    found = {law: terminal_velocities(folder / law, known, law) for law in laws}
    section.rows += _velocity_rows(found[LAW])
    table = read_table("seeds")
    measured = np.array([float(row["velocity_m_s"]) for row in table])
    for law, ours in found.items():
        section.rows += [
            Row.relative(f"{row['seed']}, {law}", "terminal velocity, m/s", value,
                         ours[f"seed{k}"], None, "laboratories: 20 %")
            for k, (row, value) in enumerate(zip(table, measured, strict=True))
        ]  # fmt: skip
    _draw(section, found, measured)
    return section


def _nominal() -> set[str]:
    """Names of the kernels and straws of what is taken: all masses and lengths, which are given."""
    step = len(DENSITIES) * len(SPHERICITIES)
    return {f"{kind}{step * k}" for kind in ("wheat", "straw") for k in range(3)}


def _velocity_rows(ours: dict[str, float]) -> list[Row]:
    rows = []
    for kind, measured in (("wheat", WHEAT), ("straw", STRAW)):
        taken = [ours[name] for name in _nominal() if name.startswith(kind)]
        every = [value for name, value in ours.items() if name.startswith(kind)]
        for end, reference, pick in (("slowest", measured[0], min), ("fastest", measured[1], max)):
            rows.append(
                Row.relative(kind, f"terminal velocity of the {end}, m/s (band "
                             f"{min(every):.2f} to {max(every):.2f})", reference, pick(taken),
                             None, "laboratories: 20 %")
            )  # fmt: skip
    return rows


def _draw(section: Section, found: dict[str, dict[str, float]], measured: np.ndarray[Any, Any]
          ) -> None:  # fmt: skip
    figure, (window, scatter) = new_figure(140, rows=2, height_ratios=(1, 1.7))
    ours = found[LAW]
    for place, (kind, ends, colour) in enumerate((("straw", STRAW, GREEN), ("wheat", WHEAT, RED))):
        every = [value for name, value in ours.items() if name.startswith(kind)]
        taken = [ours[name] for name in _nominal() if name.startswith(kind)]
        window.plot(ends, [place + 0.15] * 2, "|-", color="k", lw=1.5)
        window.plot([min(every), max(every)], [place - 0.1] * 2, color=colour, lw=6, alpha=0.3,
                    solid_capstyle="butt")  # fmt: skip
        window.plot([min(taken), max(taken)], [place - 0.1] * 2, "|-", color=colour, lw=1.5)
    window.axvspan(LOW, HIGH, color="0.92", zorder=0)
    window.set_yticks([0, 1], ["straw", "wheat"])
    window.set_ylim(-0.5, 1.5)
    window.set_xlabel("terminal velocity, m/s")
    line = np.array([5.0, 10.5])
    scatter.plot(line, line, "k-", lw=0.7)
    scatter.fill_between(line, line * (1 - LABORATORIES), line * (1 + LABORATORIES), color="0.9",
                         label="between laboratories, 20 %", zorder=0)  # fmt: skip
    for (law, values), mark, colour in zip(found.items(), "os^", COLOURS, strict=False):
        scatter.plot(measured, [values[f"seed{k}"] for k in range(measured.size)], mark, ms=4,
                     mfc="none", color=colour, label=law.removesuffix("Drag"))  # fmt: skip
    label(scatter, "measured terminal velocity, m/s", "computed, m/s")
    section.figures["seeds"] = (
        figure,
        "Above: the stated window (grey), measured velocities (black), ours of "
        "what is taken (colour) and over what is not known (faint). Below: six seeds.",
    )
