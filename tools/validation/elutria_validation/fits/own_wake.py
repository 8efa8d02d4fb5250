"""The constants of the correction for a particle's own wake: a lattice, and grains of its own.

Viscous: Stokes' equations on a lattice with the solver's way of putting a cell's force on faces and
back give how fast a cell moves in which a force acts; the Gaussian that would move it as fast has
the width that the constants 0.337, 0.28 and 0.57 describe. No run is needed.

Inertial: grains that hover or fall through the solver without the correction (own_wake.csv, made by
`python -m elutria_validation.fits --measure`) give 0.277, 0.75, 1.3 and 12. All are judged by the
chapter `wake`, whose grains are none of these.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from math import pi, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from elutria.files import read_csv, write_csv
from elutria_validation.chapters.wake import LIGHT, NU, QUARTZ, Hovering, Settling
from elutria_validation.fits.constants import Constant, Fit
from elutria_validation.harness.programs import project_root
from elutria_validation.references.drag import AIR, STANDARD_GRAVITY

Array = NDArray[np.float64]

SOURCE = "SelfInducedVelocity.hpp"
VISCOUS = {"cell alone": "0.337", "kernel": "0.28", "kernel over cell": "0.57"}
INERTIAL = {"cell alone": "0.277", "kernel over cell": "0.75", "motion along the slip": "1.3",
            "s h/nu where both count alike": "12"}  # fmt: skip
LIMITS = "0.4 (largest motion along the slip) and 1.2 (own solids) are limits that were chosen."

KERNELS = (0.3, 0.4, 0.5, 0.6, 0.75, 1.0, 1.25, 1.5, 2.0)
"""Of the kernel, in cells, at which the lattice is solved."""
GRAINS: tuple[Hovering | Settling, ...] = (
    Hovering(5e-4, 5e-3, 0.0), Hovering(1e-3, 4e-3, 0.0), Hovering(1e-3, 8e-3, 0.0),
    Hovering(1e-3, 6e-3, -0.2), Hovering(1e-3, 6e-3, 0.2), Hovering(2e-3, 5e-3, 0.0),
    Settling(3e-4, 3), Settling(1e-3, 3), Settling(1e-3, 6),
)  # fmt: skip
"""None of them is in the chapter."""
COLUMNS = ("grain", "velocity_over_slip")
TABLE = project_root() / "docs/verification/fits/own_wake.csv"
OF_GAUSSIAN = sqrt(2 / pi) / (6 * pi)
"""Velocity in the middle of a Gaussian force, in F/(mu w)."""


def lattice_width(kernel: float) -> float:
    """Width, in cells, of the Gaussian that moves its middle as a force moves its cell.

    The kernel (in cells) is as many explicit steps of diffusion as the solver takes. Cells at
    infinity: the sum over modes is extrapolated from two numbers of them.
    """
    few, many = (_cell_velocity(kernel, modes) for modes in (60, 120))
    return OF_GAUSSIAN / (2 * many - few)


def _cell_velocity(kernel: float, modes: int) -> float:
    """In F/(mu h), of the cell in which the force acts."""
    k = ((np.arange(modes) + 0.5) / modes * 2 - 1) * pi
    half = np.sin(k / 2) ** 2
    across, along = half[:, None, None], half[None, None, :]
    other = half[None, :, None]
    laplacian = 4 * (across + other + along)
    steps = max(2, int(np.ceil(3 * kernel**2 - 1e-9)))
    spread = (1 - 0.5 * kernel**2 / steps * laplacian) ** steps

    def pressed(part: Array) -> Array:
        """Of a direction: interpolated to faces and back, and what the faces' own flux adds."""
        return np.asarray((1 - part) / laplacian + part / 6)

    whole = across * pressed(across) + other * pressed(other) + along * pressed(along)
    free = 1 - along * pressed(along) / whole  # of the pressure's gradient
    return float(((1 - along) * free / laplacian * spread).mean())


def viscous_width(kernel: Array, cell: float, constant: float, linear: float) -> Array:
    """The formula's, in cells."""
    return np.sqrt(cell**2 + kernel**2 * np.minimum(1, constant + linear * kernel))


def fit_viscous() -> Fit:
    """The constants of the lattice."""
    cell = lattice_width(0)
    kernels = np.array(KERNELS)
    widths = np.array([lattice_width(kernel) for kernel in KERNELS])
    best = least_squares(lambda p: viscous_width(kernels, cell, *p) / widths - 1, [0.28, 0.57])
    used = [float(text) for text in VISCOUS.values()]
    return Fit(
        "Own wake where viscosity rules",
        SOURCE,
        _constants(VISCOUS, (cell, *best.x)),
        "largest error of the width on the lattice; of settling grains (chapter wake), over the "
        "allowed one",
        float(np.abs(viscous_width(kernels, *used) / widths - 1).max()),
        worst_of_book("A particle's own wake"),
        1.0,
    )  # fmt: skip


def _constants(named: dict[str, str], today: Iterable[float]) -> tuple[Constant, ...]:
    return tuple(
        Constant(name, text, float(value))
        for (name, text), value in zip(named.items(), today, strict=True)
    )


def measure() -> None:
    """Run the grains without correction and write their table."""
    rows = []
    with TemporaryDirectory() as work:
        for number, grain in enumerate(GRAINS):
            place = Path(work) / str(number)
            found = grain.lost if isinstance(grain, Hovering) else grain.error
            rows.append(dict(zip(COLUMNS, (repr(grain), found(place, False)), strict=True)))
            print(*rows[-1].values(), flush=True)
    write_csv(TABLE, COLUMNS, rows)


@dataclass(frozen=True)
class Deposit:
    """What a grain does to its cell: force (N), slip (m/s) and motion along it over the slip, cell
    and kernel (m)."""

    force: float
    slip: float
    passing: float
    cell: float
    kernel: float

    @classmethod
    def of(cls, grain: Hovering | Settling, measured: float) -> Deposit:
        """With the slip that it had."""
        density = QUARTZ if isinstance(grain, Hovering) else LIGHT
        weight = (density - AIR.density) * STANDARD_GRAVITY * pi / 6 * grain.diameter**3
        if isinstance(grain, Hovering):
            slip, passing, cell = grain.terminal, grain.rising, grain.cell
        else:
            slip = grain.terminal * (1 + measured)
            passing, cell = -grain.falling, grain.cell
        kernel = 1.5 * grain.diameter
        return cls(weight, slip, passing, cell, kernel if kernel > 0.25 * cell else 0.0)

    def velocity(self, cell: float, linear: float, motion: float, between: float) -> float:
        """Of its cell (m/s), by the formula with the inertial constants."""
        reynolds = self.slip * self.cell / NU
        inertia = reynolds / (between + reynolds)
        ratio = self.kernel / self.cell
        used = [float(text) for text in VISCOUS.values()]
        viscous = float(viscous_width(np.array(ratio), *used)) ** 2
        square = (1 - inertia) * viscous + inertia * (cell**2 + ratio**2 * min(1, linear * ratio))
        width = self.cell * sqrt(square)
        ahead = max(min(self.passing, 0.4), -0.4)
        share = inertia * cell**2 / square
        stirred = (1 + motion * ahead * share) / (1 + 0.5 * self.slip * width / NU)
        return self.force * OF_GAUSSIAN / (AIR.viscosity * width) * stirred


@cache
def grains() -> tuple[tuple[Deposit, float], ...]:
    """The measured grains, and the velocity (m/s) that each gave its cell."""
    known = {str(row["grain"]): float(row["velocity_over_slip"])
             for row in read_csv(TABLE, COLUMNS, COLUMNS[:1])}  # fmt: skip
    return tuple(
        (Deposit.of(grain, known[repr(grain)]), known[repr(grain)] * grain.terminal)
        for grain in GRAINS
    )


def errors(constants: Iterable[float]) -> Array:
    """Of the cells' velocities over the grains' slips, by these inertial constants."""
    chosen = tuple(constants)
    return np.array([(one.velocity(*chosen) - seen) / one.slip for one, seen in grains()])


def fit_inertial() -> Fit:
    """The constants of the measured grains."""
    used = np.array([float(text) for text in INERTIAL.values()])
    sizes = np.array([seen / one.slip for one, seen in grains()])
    best = least_squares(lambda p: errors(p * used) / sizes, np.ones(used.size), bounds=(0.1, 10))
    return Fit(
        "Own wake where inertia rules",
        SOURCE,
        _constants(INERTIAL, best.x * used),
        "largest error of a cell's velocity over the slip; of grains near the cut (chapter wake), "
        "over the allowed one",
        float(np.abs(errors(used)).max()),
        worst_of_book("The wake of a grain near the cut"),
        1.0,
        f"Today's fit leaves {np.abs(errors(best.x * used)).max():.2g}. "
        + LIMITS,
    )  # fmt: skip


def worst_of_book(section: str) -> float:
    """Largest error over what is allowed in a section of the kept book."""
    rows = read_csv(
        project_root() / "docs/verification/wake/rows.csv",
        ("section", "error", "allowed"), ("section", "allowed"),
    )  # fmt: skip
    judged = [row for row in rows if row["section"] == section and row["allowed"] != "None"]
    return max(float(row["error"]) / float(str(row["allowed"])) for row in judged)
