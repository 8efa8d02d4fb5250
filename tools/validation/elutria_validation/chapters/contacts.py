"""Contacts of the linear spring-dashpot: bounces, a stacked pair, slip to roll."""

from __future__ import annotations

from dataclasses import replace
from math import cos, exp, log, log2, pi, sin, sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from elutria_validation.book.figures import BLUE, GREEN, RED, label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.harness.collisions import BOX, LINEAR, collide, linear
from elutria_validation.harness.particles import Particles

NAME = "contacts"
TITLE = "Contacts"
HELP = "Contacts of the linear spring-dashpot: bounces, a stacked pair, slip to roll."

Array = NDArray[np.float64]


class Bounce:
    """A sphere falls on a linear spring-dashpot; closed form with gravity in the contact."""

    radius, density, height = 0.1, 2600.0, 0.5

    def __init__(self, stiffness: float, restitution: float, gravity: float):
        mass = self.density * 4 / 3 * pi * self.radius**3
        self.gravity = gravity
        self.omega = sqrt(stiffness / mass)
        ratio = -log(restitution) / sqrt(pi**2 + log(restitution) ** 2)
        self.beta = ratio * self.omega
        self.omega_d = self.omega * sqrt(1 - ratio**2)
        self.sag = gravity / self.omega**2

    def contact(self, time: float, impact: float) -> tuple[float, float]:
        """Height over the touching height (m) and velocity, `time` after touching at -impact."""
        b, w = self.beta, self.omega_d
        sine = (-impact + b * self.sag) / w
        decay, c, s = exp(-b * time), cos(w * time), sin(w * time)
        position = decay * (self.sag * c + sine * s) - self.sag
        velocity = decay * ((sine * w - b * self.sag) * c - (self.sag * w + b * sine) * s)
        return position, velocity

    def rebound(self, impact: float) -> tuple[float, float]:
        """Duration of the contact (s) and the speed after it."""
        half = pi / self.omega_d
        end = brentq(lambda t: self.contact(t, impact)[0], 0.6 * half, 1.4 * half, xtol=1e-15)
        return end, self.contact(end, impact)[1]

    def at(self, time: float) -> float:
        """Height of the centre, m."""
        g = self.gravity
        fall = sqrt(2 * (self.height - self.radius) / g)
        if time < fall:
            return self.height - 0.5 * g * time**2
        end, speed = self.rebound(g * fall)
        if time < fall + end:
            return self.radius + self.contact(time - fall, g * fall)[0]
        free = time - fall - end
        return self.radius + speed * free - 0.5 * g * free**2


BALL = Particles.of((0.5, 0.5, Bounce.height), diameter=0.2, density=Bounce.density)


def bounce(folder: Path, quick: bool) -> Section:
    section = Section(
        "Free fall and bounce (MFiX DEM01)",
        "A sphere of 0.2 m falls 0.4 m on a linear spring-dashpot. Reference: free fall, the "
        "damped oscillator with gravity, free flight, in closed form (Garg et al. 2012). "
        "Error: the largest of 60 times, in metres, and the order of convergence in the "
        "contact's step, in the rebound.",
    )
    peers = {(1e4, 0.9): "1.4e-4 m (Adams-Bashforth), 2.1e-3 m (Euler)"}
    box = replace(BOX, gravity=-9.81, step=5e-3, end=0.6)
    # at 1e4 N/m without damping the centre would go through the wall
    scenes = [(k, e) for k in (1e4, 5e4, 1e5) for e in (0.6, 0.9, 1.0) if k > 1e4 or e < 1]
    for stiffness, restitution in [(5e4, 0.9)] if quick else scenes:
        exact = Bounce(stiffness, restitution, 9.81)
        name = f"bounce{stiffness}{restitution}"
        found = collide(folder / name, BALL, linear(stiffness, restitution), box, writes=60)
        errors = [abs(p.position[0, 2] - exact.at(t)) for t, p in found.items()]
        k = int(np.argmax(errors))
        time = list(found)[k]
        section.rows.append(
            Row(
                f"Bounce (DEM01) k {stiffness:g} N/m, e {restitution:g}",
                f"height, worst of 60 times ({time:g} s), m; error in m",
                exact.at(time), found[time].position[0, 2], errors[k], 1.4e-4,
                peers.get((stiffness, restitution), ""),
            )
        )  # fmt: skip
    _order(section, folder)
    return section


def _order(section: Section, folder: Path) -> None:
    exact = Bounce(1e4, 0.9, 9.81)
    steps = [8e-3, 4e-3, 2e-3, 1e-3]
    errors = []
    for h in steps:
        contacts = replace(linear(1e4, 0.9), step_fraction=None, step=h)
        box = replace(BOX, gravity=-9.81, step=h, end=0.4)
        ((time, ball),) = collide(folder / f"order{h}", BALL, contacts, box).items()
        errors.append(abs(ball.position[0, 2] - exact.at(time)))
    # end points: less swayed than neighbours by where in a step the contact begins
    order = log2(errors[0] / errors[-1]) / 3
    section.rows.append(
        Row("Bounce (DEM01) k 1e4 N/m, e 0.9", "order in the contact step (error: shortfall from "
            "2)", 2, order, max(2 - order, 0), 0.2)
    )  # fmt: skip
    figure, (axes,) = new_figure(60)
    axes.loglog(steps, errors, "o-", color=BLUE, label="elutriaFoam, in the contact")
    axes.loglog(steps, [errors[0] * (h / steps[0]) ** 2 for h in steps], "k:", label="order 2")
    label(axes, "contact step, s", "error of height at 0.4 s, m")
    section.figures["order"] = (figure, "Bounce: error in the rebound against the contact step.")


def repeated_bounces(folder: Path, quick: bool) -> Section:
    section = Section(
        "Repeated bounces (MFiX DEM02)",
        "The same sphere, ten bounces: heights of the soft sphere with gravity in its "
        "contacts, by the soft law and by the default treatment auto, which chooses between "
        "impacts and the soft law. The hard sphere's height is for information.",
    )
    gravity = 9.80665
    references = {5e4: (0.419072, 0.226328, 0.136477), 5e6: (0.423524, 0.238194, 0.147433)}
    peers = {5e4: "0.08 %", 5e6: "0.3 %"}
    box = replace(BOX, gravity=-gravity, step=1e-2, end=4.6)
    for stiffness, heights in list(references.items())[: 1 if quick else None]:
        case = f"Repeated bounces (DEM02) k {stiffness:g} N/m, e 0.9"
        law = linear(stiffness, 0.9)
        soft, auto = (
            _apexes(
                collide(folder / f"{stiffness}{treatment}", BALL,
                        replace(law, treatment=treatment), box, writes=115),
                gravity,
            )
            for treatment in ("soft", "auto")
        )  # fmt: skip
        section.rows += [
            Row.relative(f"{case}, soft", f"height after bounce {n}, m", height, soft[n], 5e-4,
                         peers[stiffness])
            for n, height in zip((1, 5, 10), heights, strict=True)
        ]  # fmt: skip
        hard = Bounce.radius + (Bounce.height - Bounce.radius) * 0.9**20
        what = "height after bounce 10 against the {} sphere, m"
        section.rows += [
            Row.relative(f"{case}, auto", what.format("soft"), heights[2], auto[10], 5e-4,
                         peers[stiffness]),
            Row.relative(f"{case}, auto", what.format("hard"), hard, auto[10], None),
        ]  # fmt: skip
    return section


def _apexes(found: dict[float, Particles], gravity: float) -> list[float]:
    """Apex heights (m), from the energy in each flight; the first is the start's."""
    apexes: list[float] = []
    for ball in found.values():
        height, velocity = ball.position[0, 2], ball.velocity[0, 2]
        if height <= Bounce.radius * (1 + 1e-9):
            continue
        apex = height + velocity**2 / (2 * gravity)
        if not apexes or abs(apex - apexes[-1]) > 1e-3 * apex:
            apexes.append(apex)
    return apexes


def _pair_by_ode(
    stiffness: float, restitution: float, radius: float, densities: tuple[float, float],
    gap: float, gravity: float, moments: Array,
) -> Array:  # fmt: skip
    """Heights (m) of two spheres between floor and ceiling, shape (2, times)."""
    mass = np.array(densities) * 4 / 3 * pi * radius**3
    ratio = -log(restitution) / sqrt(pi**2 + log(restitution) ** 2)

    def push(overlap: float, closing: float, effective: float) -> float:
        damping = 2 * ratio * sqrt(stiffness * effective)
        return stiffness * overlap + damping * closing if overlap > 0 else 0.0

    def slope(_time: float, state: Array) -> Array:
        low, high, below, above = state
        floor = push(radius - low, -below, mass[0])
        between = push(2 * radius - (high - low), below - above, mass[0] * mass[1] / mass.sum())
        ceiling = push(radius + high - gap, above, mass[1])
        pull = np.array([floor - between, between - ceiling]) / mass - gravity
        return np.array([below, above, *pull])

    start = [0.5 * gap / 1.8, 1.5 * gap / 1.8, 0.0, 0.0]
    end = float(moments[-1])
    solution = solve_ivp(
        slope, (0, end), start, "DOP853", moments, rtol=1e-11, atol=1e-13, max_step=end / 1000
    )
    return np.asarray(solution.y[:2])


def stacked_pair(folder: Path, quick: bool) -> Section:
    radius, gravity, densities, gap = 5e-4, 9.80665, (2e4, 1e4), 1.8e-3
    section = Section(
        "Stacked pair (MFiX DEM03)",
        "Two spheres of 1 mm, the lower one twice as heavy, squeezed between floor and ceiling "
        "3.6 radii apart. Reference: an ODE solution (scipy, DOP853, 1e-11) of the two linear "
        "spring-dashpots to the walls and the one between. Error: worst of 40 times, over the "
        "radius.",
    )
    figure, (axes,) = new_figure(60)
    duration = 4e-3
    box = replace(BOX, gravity=-gravity, height=gap, step=duration / 40, end=duration)
    start = Particles.of(
        [(0.5, 0.5, 0.5 * gap / 1.8), (0.5, 0.5, 1.5 * gap / 1.8)], diameter=2 * radius,
        density=densities,
    )  # fmt: skip
    scenes = ((1e3, 0.9, BLUE), (1e3, 0.6, RED), (1e4, 0.9, GREEN))
    for stiffness, restitution, colour in scenes[: 1 if quick else None]:
        name = f"stack{stiffness}{restitution}"
        found = collide(folder / name, start, linear(stiffness, restitution), box, writes=40)
        moments = np.array(list(found))
        ours = np.array([p.position[:, 2] for p in found.values()]).T
        exact = _pair_by_ode(stiffness, restitution, radius, densities, gap, gravity, moments)
        errors = np.abs(ours - exact)
        which, when = np.unravel_index(int(errors.argmax()), errors.shape)
        case = f"k {stiffness:g} N/m, e {restitution:g}"
        section.rows.append(
            Row(
                case,
                f"height of the {('lower', 'upper')[which]} at {moments[when]:.3g} s, m; error "
                "over the radius",
                exact[which, when], ours[which, when], errors.max() / radius, 5e-4,
                "no figure given",
            )
        )  # fmt: skip
        for sphere in (0, 1):
            axes.plot(moments * 1e3, exact[sphere] * 1e3, "-", color=colour, linewidth=0.8)
            axes.plot(moments * 1e3, ours[sphere] * 1e3, ".", color=colour, markersize=3,
                      label=case if sphere else None)  # fmt: skip
    label(axes, "time, ms", "height, mm", "ODE")
    section.figures["stack"] = (figure, "Stacked pair: heights of both spheres.")
    return section


def slip_to_roll(folder: Path, quick: bool) -> Section:
    section = Section(
        "Slip to roll (MFiX DEM04)",
        "A sliding sphere of 1 mm begins to roll when friction g t/u0 = 2/7, and then keeps "
        "5/7 of its speed.",
    )
    radius, density, stiffness, start, gravity = 5e-4, 1e4, 1e4, 0.1, 9.81
    sag = density * 4 / 3 * pi * radius**3 * gravity / stiffness
    ball = Particles.of((0.02, 0.05, radius - sag), (start, 0, 0), diameter=2 * radius,
                        density=density)  # fmt: skip
    for friction in (0.6,) if quick else (0.2, 0.6, 1.0):
        slip = 2 * start / (7 * friction * gravity)
        box = replace(BOX, width=0.1, depth=0.1, height=0.1, gravity=-gravity, step=slip / 50,
                      end=2 * slip)  # fmt: skip
        contacts = replace(LINEAR, pair=linear(stiffness, 0.9, friction).pair)
        found = collide(folder / f"roll{friction}", ball, contacts, box, writes=100)
        moments = np.array(list(found))
        speed = np.array([p.velocity[0, 0] for p in found.values()])
        # sliding slows it evenly: where that line meets the final speed it begins to roll
        sliding = moments < 0.8 * slip
        slope, intercept = np.polyfit(moments[sliding], speed[sliding], 1)
        begins = (speed[-1] - intercept) / slope
        spin = found[moments[-1]].spin[0, 1] * radius / start
        section.rows += [
            Row.relative(f"Slip to roll (DEM04), friction {friction:g}", checked, reference, ours,
                         1e-3, "0.04-0.57 %")
            for checked, reference, ours in (
                ("friction g t/u0 when it begins to roll", 2 / 7,
                 friction * gravity * begins / start),
                ("final u/u0", 5 / 7, speed[-1] / start),
                ("final omega r/u0", 5 / 7, spin),
            )
        ]  # fmt: skip
    return section


SECTIONS = (bounce, repeated_bounces, stacked_pair, slip_to_roll)
