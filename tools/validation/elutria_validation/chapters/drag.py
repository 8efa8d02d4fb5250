"""Drag laws against other codes' implementations, the standard curve, and measurements.

No reference here is worked out by the formula that is checked: references/tables says whose the
numbers are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import fluids.drag
import numpy as np
from numpy.typing import ArrayLike, NDArray

from elutria_validation.book.figures import COLOURS, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import PERIODIC, WEIGHTLESS, BoxCase, cube
from elutria_validation.harness.cases import solve, times
from elutria_validation.harness.particles import Particles, lattice, read_particles
from elutria_validation.references.drag import (
    AIR,
    Gas,
    newton_drag,
    read_table,
    stokes_factor,
)

NAME = "drag"
TITLE = "Drag laws"
HELP = "Drag laws against other codes, the standard curve, and measurements."

Array = NDArray[np.float64]

REYNOLDS = np.geomspace(2e-2, 1e4, 27)
DIAMETER, DENSITY = 1e-3, 2650.0
DILUTE = 1e-8  # of solids
SUSPENSION = ("ErgunWenYuDrag", "GidaspowDrag", "WenYuVoidDrag", "BeetstraDrag", "DiFeliceDrag")
SAME_LAW, AS_TABULATED = 1e-6, 5e-4  # allowed: another code's law at hand, its tabulated values
VOIDS = (0.95, 0.85, 0.75, 0.6, 0.5)


def drag_coefficients(
    folder: Path, drag: Mapping[str, Any], solids: float = DILUTE, reynolds: ArrayLike = REYNOLDS
) -> tuple[Array, str]:
    """Cd at `reynolds` and what the solver said: spheres of a lattice fly through gas at rest.

    Each is slowed for a moment so short that its drag hardly changes. The gas' void fraction is
    1 less `solids`.
    """
    wanted = np.atleast_1d(np.asarray(reynolds, dtype=float))
    number = wanted.size
    side = (number * np.pi / 6 * DIAMETER**3 / solids) ** (1 / 3)
    speed = wanted * AIR.viscosity / (AIR.density * DIAMETER)
    velocity = np.stack([np.zeros(number), np.zeros(number), speed], axis=1)
    start = Particles.of(lattice(number, side), velocity, diameter=DIAMETER, density=DENSITY)
    # a rate of 1/s at most: Cd Re of 1e4 is about 1e4
    step = 1e-7
    box = BoxCase(**cube(side), **WEIGHTLESS, most_solids=0.9, forces=dict(drag), step=step,
                  end=step)  # fmt: skip
    case = box.make(folder, start)
    said = solve(case)
    after = read_particles(case, times(case)[-1]).velocity[:, 2]
    # at the mean speed of the step
    slowed = -np.log(after / speed) / step * np.sqrt(after / speed) * speed
    area_over_mass = 1.5 / (DENSITY * DIAMETER)
    return slowed / (0.5 * AIR.density * speed * after * area_over_mass), said


def force(name: str, sphericity: float = 1.0) -> dict[str, Any]:
    """A drag force as a case has it."""
    if name in SUSPENSION:
        return {name: {"alphac": "alpha.air"}}
    if name == "nonSphereDrag":  # OpenFOAM's word for the sphericity
        return {name: {"phi": sphericity}}
    return {name: {} if name == "sphereDrag" else {"sphericity": sphericity}}


def _worst(
    case: str, checked: str, reynolds: Sequence[float] | Array, reference: ArrayLike,
    ours: ArrayLike, allowed: float | None,
) -> Row:  # fmt: skip
    return Row.worst(case, checked, [f"Re {re:.3g}" for re in reynolds], reference, ours, allowed)


def _table_rows(
    section: Section, folder: Path, name: str, quick: bool, few: tuple[float, ...]
) -> None:
    """Rows of a law beside tables/drag_laws.csv, one for each sphericity and void fraction."""
    groups: dict[tuple[float, float, str], list[tuple[float, float]]] = {}
    for row in read_table("drag_laws"):
        if row["law"] == name:
            key = (float(row["sphericity"]), float(row["void"]), row["code"])
            groups.setdefault(key, []).append(
                (float(row["reynolds"]), float(row["drag_coefficient"]))
            )
    for (sphericity, void, code), points in groups.items():
        if quick and not {sphericity, void} & set(few):
            continue
        reynolds, reference = np.array(points).T
        place = folder / f"{name}{sphericity}{void}table"
        solids = 1 - void or DILUTE
        ours, _ = drag_coefficients(place, force(name, sphericity), solids, reynolds)
        what = f"sphericity {sphericity:g}" if void == 1 else f"void fraction {void:g}"
        section.rows.append(
            _worst(f"{name}, {what}", f"Cd, by {code}", reynolds, reference, ours, AS_TABULATED)
        )


def single(folder: Path, quick: bool) -> Section:
    section = Section(
        "Drag laws of single particles",
        "Spheres fly through gas at rest for 1e-7 s: the drag coefficient from their change of "
        "velocity. References: the same law by others. OpenFOAM's own nonSphereDrag (Haider and "
        "Levenspiel) and ErgunWenYuDrag in dilute gas (Schiller and Naumann) run beside ours; "
        "Clift's piecewise curve is that of the library fluids; Ganser's and Haider and "
        "Levenspiel's values were tabulated with Kratos.",
    )
    figure, (axes,) = new_figure(65)
    clift = np.array([fluids.drag.Clift(re) for re in REYNOLDS])
    pairs: list[tuple[str, float, str]] = [
        ("SchillerNaumannDrag", 1.0, "ErgunWenYuDrag"), ("CliftDrag", 1.0, "fluids"),
        ("HaiderLevenspielDrag", 1.0, "nonSphereDrag"),
        ("HaiderLevenspielDrag", 0.7, "nonSphereDrag"),
    ]  # fmt: skip
    for (name, sphericity, other), colour in zip(pairs, COLOURS, strict=False):
        ours, _ = drag_coefficients(folder / f"{name}{sphericity}", force(name, sphericity))
        reference = clift
        if other != "fluids":
            place = folder / f"{other}{sphericity}"
            reference, _ = drag_coefficients(place, force(other, sphericity))
        section.rows.append(
            _worst(f"{name}, sphericity {sphericity:g}", f"Cd, by {other}", REYNOLDS, reference,
                   ours, SAME_LAW)
        )  # fmt: skip
        title = f"{name.removesuffix('Drag')}, sphericity {sphericity:g}"
        axes.semilogx(REYNOLDS, reference / clift, "-", color=colour, label=title)
        axes.semilogx(REYNOLDS, ours / clift, ".", color=colour, markersize=4)
    for name, few in (("GanserDrag", (0.7,)), ("HaiderLevenspielDrag", (0.7,))):
        _table_rows(section, folder, name, quick, few)
    axes.set_ylim(0.6, 3)
    label(axes, "Reynolds number", "Cd over Clift's standard curve", "others' law")
    section.figures["single"] = (figure, "Drag laws over the standard curve for spheres.")
    return section


# the largest Re that a law is judged at beside spheres, and its error beside measured ones
SPHERES = {"CliftDrag": 1e4, "SchillerNaumannDrag": 800, "sphereDrag": 800,
           "HaiderLevenspielDrag": 1e4, "GanserDrag": 0, "DiFeliceDrag": 0}  # fmt: skip


def spheres(folder: Path, _quick: bool) -> Section:
    section = Section(
        "Drag of spheres: standard curve and measurements",
        "The solver's drag coefficients beside Clift's published standard curve and beside "
        "experiments. Allowed beside the curve: 0.05 % for Clift's own law, 5 % for Schiller and "
        "Naumann's and Putnam's up to Re 800, where they were made; beside experiments 10 %, which "
        "is what the points scatter with their reading. Laws that do not stand for spheres in "
        "dilute gas are for information.",
    )
    curve, measured = (
        np.array([[float(v) for v in row.values()] for row in read_table(name)]).T
        for name in ("standard_curve", "spheres")
    )
    reynolds = np.concatenate([curve[0], measured[0]])
    for name, most in SPHERES.items():
        ours, _ = drag_coefficients(folder / name, force(name), DILUTE, reynolds)
        standard, experiment = np.split(ours, [curve[0].size])
        for what, (re, cd), found in (
            ("Cd of the standard curve", curve, standard),
            ("Cd of experiments", measured, experiment),
        ):
            near = re <= (most or np.inf)
            allowed: float | None = 0.1
            if what.endswith("curve"):
                allowed = 5e-4 if name == "CliftDrag" else 0.05
                if name == "HaiderLevenspielDrag":
                    allowed = 0.1
            section.rows.append(
                _worst(name, what, re[near], cd[near], found[near], allowed if most else None)
            )
    return section


def drops(folder: Path, _quick: bool) -> Section:
    section = Section(
        "Terminal velocity of drops (Gunn and Kinzer 1949)",
        "Water drops of 0.2 to 1 mm fall in still air, as measured. Allowed: 5 %. The measurement "
        "is good to about 1 %; the rest is the laws', and drops of 1 mm begin to flatten.",
    )
    table = read_table("drops")
    sizes = np.array([1e-3 * float(row["diameter_mm"]) for row in table])
    measured = np.array([float(row["velocity_m_s"]) for row in table])
    gas = Gas(1.204, 1.818e-5)
    for name in ("SchillerNaumannDrag", "CliftDrag", "sphereDrag"):
        box = BoxCase(**PERIODIC, gas_density=gas.density,
                      gas_viscosity=gas.viscosity / gas.density,
                      forces={name: {}, "gravity": {}}, step=0.05, end=10)  # fmt: skip
        start = Particles.of(np.full((sizes.size, 3), 0.05), diameter=sizes, density=998.0)
        case = box.make(folder / name, start)
        solve(case)
        ours = -read_particles(case, "10").velocity[:, 2]
        at = [f"{1e3 * d:g} mm" for d in sizes]
        section.rows.append(Row.worst(name, "terminal velocity, m/s", at, measured, ours, 0.05))
    return section


def isometric(folder: Path, _quick: bool) -> Section:
    section = Section(
        "Drag of isometric particles (Pettyjohn and Christiansen 1948)",
        "Tetrahedra, cubes, octahedra and cuboctahedra (sphericity 0.67, 0.806, 0.846, 0.906): "
        "their measured shape factor where viscosity rules (Re 0.05) and drag coefficient where "
        "inertia does (Re 10 000). Allowed: 10 %, less than the mean error of either law over the "
        "non-spherical particles of Chhabra et al. 1999 (16 and 22 %).",
    )
    shapes = (0.67, 0.806, 0.846, 0.906)
    for name in ("HaiderLevenspielDrag", "GanserDrag"):
        found = np.array([
            drag_coefficients(folder / f"{name}{s}", force(name, s), DILUTE, (0.05, 1e4))[0]
            for s in shapes
        ])  # fmt: skip
        at = [f"sphericity {s:g}" for s in shapes]
        viscous = [24 / 0.05 / stokes_factor(s) for s in shapes]
        inertial = [newton_drag(s) for s in shapes]
        section.rows += [
            Row.worst(name, "Cd at Re 0.05", at, viscous, found[:, 0], 0.1),
            Row.worst(name, "Cd at Re 10 000", at, inertial, found[:, 1], 0.1),
        ]
    return section


def suspensions(folder: Path, quick: bool) -> Section:
    section = Section(
        "Drag laws of suspensions",
        "The same on a lattice of spheres at five void fractions. Gidaspow's law, and above a void "
        "fraction of 0.8 Wen and Yu's, beside OpenFOAM's own ErgunWenYuDrag; Beetstra's beside "
        "values tabulated with OpenFOAM-dev, Di Felice's with Kratos. The figure shows the laws at "
        "void fraction 0.6 and Wen and Yu's: they differ by more than any numerical error.",
    )
    figure, (axes,) = new_figure(65)
    alone, _ = drag_coefficients(folder / "alone", {"SchillerNaumannDrag": {}})
    for void in (0.85, 0.6) if quick else VOIDS:
        stock, _ = drag_coefficients(folder / f"stock{void}", force("ErgunWenYuDrag"), 1 - void)
        for name in ("GidaspowDrag", "WenYuVoidDrag"):
            if name == "GidaspowDrag" or void > 0.8:
                ours, _ = drag_coefficients(folder / f"{name}{void}", force(name), 1 - void)
                section.rows.append(
                    _worst(f"{name}, void fraction {void:g}", "Cd, by ErgunWenYuDrag", REYNOLDS,
                           stock, ours, SAME_LAW)
                )  # fmt: skip
    for name in ("BeetstraDrag", "DiFeliceDrag"):
        _table_rows(section, folder, name, quick, (0.85, 0.6))
    names = ("WenYuVoidDrag", "GidaspowDrag", "BeetstraDrag", "DiFeliceDrag")
    for name, colour in zip(names, COLOURS, strict=False):
        ours, _ = drag_coefficients(folder / f"{name}figure", force(name), 0.4)
        axes.loglog(REYNOLDS, ours / alone, "-", color=colour, label=name)
    label(axes, "Reynolds number (interstitial slip)", "drag over that of a single sphere")
    section.figures["suspensions"] = (figure, "Drag laws at void fraction 0.6.")
    return section


def out_of_range(folder: Path, _quick: bool) -> Section:
    section = Section(
        "Use of a drag law out of its range",
        "The solver reports the first use of a law beyond the Reynolds numbers and void fractions "
        "it was made for. Reference 1: must report; 0: must not.",
    )
    for name, solids, expected in (
        ("BeetstraDrag", 0.1, 1), ("SchillerNaumannDrag", DILUTE, 0),
        ("SchillerNaumannDrag", 0.3, 1), ("WenYuVoidDrag", 0.3, 0), ("WenYuVoidDrag", 0.6, 1),
    ):  # fmt: skip
        entries = {name: {"alphac": "alpha.air"}}
        _, said = drag_coefficients(folder / f"{name}{solids}", entries, solids)
        reported = int(f"Warning: {name} is used outside its range" in said)
        section.rows.append(
            Row(f"{name}, Re up to 1e4, void fraction {1 - solids:g}", "reported", expected,
                reported, abs(expected - reported), 0)
        )  # fmt: skip
    return section


SECTIONS = (single, spheres, drops, isometric, suspensions, out_of_range)
