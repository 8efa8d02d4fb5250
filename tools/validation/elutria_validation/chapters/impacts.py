"""Oblique and Hertzian impacts against closed forms and a measurement."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, cos, degrees, radians, sin, tan
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elutria_validation.book.figures import BLUE, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.box import ContactLaw, Contacts, Material, Pair, Treatment
from elutria_validation.harness.collisions import BOX, collide
from elutria_validation.harness.particles import Particles
from elutria_validation.references.drag import read_table

NAME = "impacts"
TITLE = "Impacts"
HELP = "Oblique and Hertzian impacts against closed forms and Kharaz' measurement."

Array = NDArray[np.float64]

GLASS = Material(70e9, 0.25)
"""Stiff enough that a contact is short and flat, as the closed forms have it."""


def oblique(
    folder: Path, angles: list[float], speed: float, radius: float, density: float,
    contacts: Contacts,
) -> Particles:  # fmt: skip
    """State after spheres hit the floor at angles (degrees) from its normal, towards +x."""
    n = len(angles)
    size = 0.1 * max(1.0, radius / 1e-3)
    tilt = np.radians(angles)
    velocity = speed * np.stack([np.sin(tilt), np.zeros(n), -np.cos(tilt)], axis=1)
    gap = 0.01 * size
    position = np.stack(
        [np.full(n, 0.3 * size), np.linspace(0.1, 0.9, n) * size, np.full(n, radius + gap)], axis=1
    )
    start = Particles.of(position, velocity, diameter=2 * radius, density=density)
    duration = min(2.5 * gap / (speed * cos(max(tilt))), 0.5 * size / speed)
    box = replace(BOX, width=size, depth=size, height=size, gravity=0.0, step=duration / 10,
                  end=duration)  # fmt: skip
    return list(collide(folder, start, contacts, box).values())[-1]


def gross_sliding(folder: Path, quick: bool) -> Section:
    section = Section(
        "Oblique impact, gross sliding",
        "A sphere hits a wall at tan(angle) >= 3.5 mu (1 + e) and slides throughout: "
        "tangential restitution 1 - mu (1 + e)/tan(angle), spin 2.5 mu (1 + e) V "
        "cos(angle)/R and the rebound angle, at four angles each.",
    )
    choices: tuple[tuple[ContactLaw, Treatment], ...] = (
        ("hertzMindlin", "soft"), ("hertzMindlin", "auto"), ("linearSpringDashpot", "soft")
    )  # fmt: skip
    for law, treatment in choices:
        for friction, restitution in ((0.1, 0.9),) if quick else ((0.1, 0.9), (0.3, 0.6)):
            grip = friction * (1 + restitution)
            angles = list(np.linspace(degrees(atan2(3.6 * grip, 1)), 75, 4))
            speed, radius = 0.2, 1e-3
            contacts = Contacts(Pair(restitution, friction, 1e8), law=law, treatment=treatment,
                                particle=GLASS)  # fmt: skip
            name = f"slide{law}{treatment}{friction}"
            after = oblique(folder / name, angles, speed, radius, 2650, contacts)
            ratios, names = [], []
            for (vx, _, vz), spin, angle in zip(after.velocity, after.spin[:, 1], angles,
                                                strict=True):  # fmt: skip
                tilt = radians(angle)
                ratios += [
                    vx / (speed * sin(tilt)) / (1 - grip / tan(tilt)),
                    spin * radius / (2.5 * grip * speed * cos(tilt)),
                    vx / vz / ((tan(tilt) - grip) / restitution),
                ]
                names += [
                    f"{what} at {angle:.0f} deg"
                    for what in ("tangential restitution", "spin", "rebound angle")
                ]
            section.rows.append(
                Row.worst(
                    f"Gross sliding, {law}, {treatment}, friction {friction:g}, e {restitution:g}",
                    "over the closed form", names, np.ones(len(ratios)), ratios, 1e-3, "0.0-0.3 %",
                )
            )  # fmt: skip
    return section


# Chung and Ooi 2011: Young's modulus (Pa), Poisson's ratio, density (kg/m3); radius (m) and speed
HERTZ = {
    "T1 glass": (48e9, 0.20, 2800, 0.01, 10.0, (274.11e-6, 10.697e3)),
    "T1 limestone": (20e9, 0.25, 2500, 0.01, 10.0, (368.30e-6, 7.108e3)),
    "T2 aluminium alloy": (70e9, 0.30, 2699, 0.1, 0.2, (49.717e-6, 11.370e3)),
    "T2 magnesium alloy": (40e9, 0.35, 1800, 0.1, 0.2, (52.123e-6, 7.233e3)),
}


def hertz(folder: Path, quick: bool) -> Section:
    section = Section(
        "Hertz impact (Chung and Ooi 2011)",
        "Two equal spheres, and a sphere on a rigid wall: largest overlap, largest force, "
        "duration of the elastic impact.",
    )
    for name, (young, poisson, density, radius, speed, (overlap, force)) in list(
        HERTZ.items()
    )[:: 3 if quick else 1]:  # fmt: skip
        two = name.startswith("T1")
        duration = 2.943 * overlap / (2 * speed if two else speed)
        apart = (1 + 1e-4) * radius
        places = [(0.5 - apart, 0.5, 0.5), (0.5 + apart, 0.5, 0.5)] if two else (0.5, 0.5, apart)
        speeds = [(speed, 0, 0), (-speed, 0, 0)] if two else (0, 0, -speed)
        start = Particles.of(places, speeds, diameter=2 * radius, density=density)
        solid = Material(young, poisson)
        contacts = Contacts(Pair(1, 0, 1), treatment="soft", particle=solid,
                            wall=solid if two else Material(1e20, 0.3))  # fmt: skip
        box = replace(BOX, gravity=0.0, step=duration / 100, end=1.5 * duration)
        found = collide(folder / name.replace(" ", ""), start, contacts, box, writes=150)
        moments = np.array([0.0, *found])
        states = [start, *found.values()]
        if two:
            gaps = np.array([2 * radius - np.ptp(p.position[:, 0]) for p in states])
            after = np.array([p.velocity[1, 0] for p in states])
        else:
            gaps = np.array([radius - p.position[0, 2] for p in states])
            after = np.array([p.velocity[0, 2] for p in states])
        pushes = np.diff(after) / np.diff(moments) * start.mass[0]
        half = int(gaps.argmax())
        begins = np.interp(0, gaps[:half], moments[:half])
        ends = np.interp(0, -gaps[half:], moments[half:])
        section.rows += [
            Row.relative(f"Hertz impact {name}", checked, reference, ours, 1e-3, "0.1-0.5 %")
            for checked, reference, ours in (
                ("largest overlap, m", overlap, _peak(gaps)),
                ("largest force, N", force, _peak(pushes)),
                ("duration, s", duration, float(ends - begins)),
            )
        ]
    return section


def _peak(values: Array) -> float:
    """Top of the parabola through the largest value and its neighbours."""
    k = int(values.argmax())
    a, b, c = values[k - 1 : k + 2]
    return float(b + (c - a) ** 2 / (8 * (2 * b - a - c)))


# what was measured: its name, what is allowed (rms, absolute), from which angle (degrees) on
KHARAZ = {
    "tangential_restitution": ("tangential restitution", 0.1, 10.0),
    "spin_after_rad_per_s": ("spin after, rad/s", 60.0, 10.0),
    "rebound_angle_centre_deg": ("rebound angle, degrees", 2.0, 0.0),
}


def kharaz(folder: Path, quick: bool) -> Section:
    section = Section(
        "Oblique impact, measured (Kharaz, Gorham and Salman 2001)",
        "Alumina spheres of 5 mm on glass at 3.9 m/s, friction 0.092, e 0.98, Hertz-Mindlin. "
        "Allowed is a scatter like the digitised measurement's.",
    )
    measured: dict[str, list[tuple[float, float]]] = {}
    for row in read_table("kharaz2001"):
        point = (float(row["impact_angle_deg"]), float(row["value"]))
        measured.setdefault(row["quantity"], []).append(point)
    contacts = Contacts(Pair(0.98, 0.092, 1), treatment="soft", particle=Material(380e9, 0.23),
                        wall=GLASS)  # fmt: skip
    speed, radius = 3.9, 2.5e-3

    def after(angles: list[float], name: str) -> dict[str, Array]:
        end = oblique(folder / name, angles, speed, radius, 4000, contacts)
        return {
            "tangential_restitution": end.velocity[:, 0] / (speed * np.sin(np.radians(angles))),
            "spin_after_rad_per_s": end.spin[:, 1],
            "rebound_angle_centre_deg": np.degrees(
                np.arctan2(end.velocity[:, 0], end.velocity[:, 2])
            ),
        }

    curve_angles = list(np.linspace(2, 62, 5 if quick else 21))
    curve = after(curve_angles, "curve")
    figure, panels = new_figure(130, rows=3)
    for axes, (name, points) in zip(panels, measured.items(), strict=True):
        what, allowed, least = KHARAZ[name]
        angles, values = np.array(points).T
        ours = after(list(angles), name)[name]
        used = angles >= least
        errors = np.where(used, np.abs(ours - values), 0)
        k = int(errors.argmax())
        where = f", from {least:g} degrees" if least else ""
        section.rows.append(
            Row(
                "Kharaz 2001, 5 mm alumina on glass",
                f"{what}{where}: worst at {angles[k]:.0f} deg; error: rms, absolute",
                values[k], ours[k], float(np.sqrt((errors[used] ** 2).mean())), allowed,
                "Hertz-Mindlin codes overpredict e_t below about 10 degrees",
            )
        )  # fmt: skip
        axes.plot(angles, values, "o", color=RED, label="measured")
        axes.plot(curve_angles, curve[name], "-", color=BLUE, label="elutriaFoam")
        axes.set_ylabel(what)
    label(panels[-1], "impact angle from the normal, degrees", panels[-1].get_ylabel())
    section.figures["kharaz"] = (figure, "Oblique impact of alumina on glass at 3.9 m/s.")
    return section


SECTIONS = (gross_sliding, hertz, kharaz)
