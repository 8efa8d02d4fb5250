"""Contacts of the linear spring-dashpot: bounces, a stacked pair, slip to roll."""

from __future__ import annotations

from math import cos, exp, log, log2, pi, sin, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from elutria.output.plots import STYLE, new_figure
from elutria_validation.book.book import Chapter, Row, Section, write_chapter
from elutria_validation.harness.common import Options
from elutria_validation.harness.scene import (
    BOX,
    CLOUD,
    CONTACTS,
    CONTROL,
    MODELS,
    Particles,
    make_scene,
    read_particles,
    run_scene,
    times,
)

NAME = "contacts"
HELP = "Contacts of the linear spring-dashpot: bounces, a stacked pair, slip to roll."

Array = NDArray[np.float64]


@rc_context(STYLE)
def run(options: Options) -> Chapter:
    """Free fall and bounce, repeated bounces, a stacked pair, slip to roll."""
    chapter = Chapter(NAME, "Contacts")
    with TemporaryDirectory() as work:
        folder = Path(work)
        bounce = chapter.section(
            "Free fall and bounce (MFiX DEM01)",
            "A sphere of 0.2 m falls 0.4 m on a linear spring-dashpot. Reference: free fall, the "
            "damped oscillator with gravity, free flight, in closed form (Garg et al. 2012). "
            "Error: the largest of 60 times, in metres, and the order of convergence in the "
            "contact's step, in the rebound.",
        )
        _bounce(bounce, folder)
        repeated = chapter.section(
            "Repeated bounces (MFiX DEM02)",
            "The same sphere, ten bounces: heights of the soft sphere with gravity in its "
            "contacts, by the soft law and by the default treatment auto, which chooses between "
            "impacts and the soft law. The hard sphere's height is for information.",
        )
        _repeated_bounces(repeated, folder)
        _stacked_pair(chapter, folder)
        rolling = chapter.section(
            "Slip to roll (MFiX DEM04)",
            "A sliding sphere of 1 mm begins to roll when friction g t/u0 = 2/7, and then keeps "
            "5/7 of its speed.",
        )
        _slip_to_roll(rolling, folder)
    return write_chapter(options, chapter)


def collide(
    folder: Path,
    particles: Particles,
    pair: dict[str, float],
    *,
    step: float,
    duration: float,
    writes: int = 1,
    gravity: float = 0.0,
    size: float = 1.0,
    height: float | None = None,
    contacts: dict[str, Any] | None = None,
) -> dict[float, Particles]:
    """The particles at `writes` equidistant times in a box of walls, by time.

    The box is a cube of `size` (m), unless it has a `height`.
    """
    case = make_scene(
        folder,
        particles,
        {
            **{f"{BOX}:{name}": size for name in ("width", "depth")},
            f"{BOX}:height": height or size,
            f"{BOX}:ends": "wall",
            f"{BOX}:bottomGroup": "closed",
            f"{BOX}:topGroup": "closed",
            f"{BOX}:gravity": -gravity,
            f"{BOX}:gasDensity": 1e-9,
            f"{MODELS}/collisionModel": "cellList",
            f"{MODELS}/particleForces": {"gravity": {}},
            # parcels may be as heavy as spheres of steel
            f"{CLOUD}:constantProperties/alphaMax": 0.99,
            f"{CONTACTS}/particleParticle": pair,
            f"{CONTACTS}/particleWall": pair,
            **{f"{CONTACTS}/{name}": value for name, value in (contacts or {}).items()},
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:endTime": duration,
            f"{CONTROL}:writeInterval": duration / writes,
        },
    )
    run_scene(case)
    return {float(time): read_particles(case, time) for time in times(case)[1:]}


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


def _ball() -> Particles:
    return Particles.of((0.5, 0.5, Bounce.height), diameter=0.2, density=Bounce.density)


def linear(stiffness: float, restitution: float, friction: float = 0.0) -> dict[str, float]:
    return {"restitution": restitution, "friction": friction, "normalStiffness": stiffness}


LINEAR = {"contactLaw": "linearSpringDashpot", "treatment": "soft"}
# half the default step
FINE = {**LINEAR, "stepFraction": 0.01}


def _bounce(section: Section, folder: Path) -> None:
    peers = {(1e4, 0.9): "1.4e-4 m (Adams-Bashforth), 2.1e-3 m (Euler)"}
    for stiffness in (1e4, 5e4, 1e5):
        # at 1e4 N/m without damping the centre would go through the wall
        for restitution in (0.6, 0.9) if stiffness == 1e4 else (0.6, 0.9, 1.0):
            exact = Bounce(stiffness, restitution, 9.81)
            found = collide(
                folder / f"bounce{stiffness}{restitution}", _ball(),
                linear(stiffness, restitution), step=5e-3, duration=0.6, writes=60,
                gravity=9.81, contacts=FINE,
            )  # fmt: skip
            errors = [abs(p.position[0, 2] - exact.at(t)) for t, p in found.items()]
            k = int(np.argmax(errors))
            time = list(found)[k]
            section.rows.append(
                Row(
                    f"Bounce (DEM01) k {stiffness:g} N/m, e {restitution:g}",
                    f"height, worst of 60 times ({time:g} s), m; error in m",
                    exact.at(time),
                    found[time].position[0, 2],
                    errors[k],
                    1.4e-4,
                    peers.get((stiffness, restitution), ""),
                )
            )
    exact = Bounce(1e4, 0.9, 9.81)
    steps = [8e-3, 4e-3, 2e-3, 1e-3]
    errors = []
    for h in steps:
        end = collide(
            folder / f"order{h}", _ball(), linear(1e4, 0.9), step=h, duration=0.4,
            gravity=9.81, contacts={**LINEAR, "step": h},
        )  # fmt: skip
        ((time, ball),) = end.items()
        errors.append(abs(ball.position[0, 2] - exact.at(time)))
    # end points: less swayed than neighbours by where in a step the contact begins
    order = log2(errors[0] / errors[-1]) / 3
    section.rows.append(
        Row("Bounce (DEM01) k 1e4 N/m, e 0.9", "order in the contact step (error: shortfall from "
            "2)", 2, order, max(2 - order, 0), 0.2)
    )  # fmt: skip
    figure, (axes,) = new_figure(60)
    axes.loglog(steps, errors, "o-", color="#0072B2", label="elutriaFoam, in the contact")
    axes.loglog(steps, [errors[0] * (h / steps[0]) ** 2 for h in steps], "k:", label="order 2")
    axes.set_xlabel("contact step, s")
    axes.set_ylabel("error of height at 0.4 s, m")
    axes.legend()
    section.figures["order"] = (figure, "Bounce: error in the rebound against the contact step.")


def _repeated_bounces(section: Section, folder: Path) -> None:
    gravity = 9.80665
    references = {5e4: (0.419072, 0.226328, 0.136477), 5e6: (0.423524, 0.238194, 0.147433)}
    peers = {5e4: "0.08 %", 5e6: "0.3 %"}
    for stiffness, heights in references.items():
        case = f"Repeated bounces (DEM02) k {stiffness:g} N/m, e 0.9"
        apexes = {}
        for treatment in ("soft", "auto"):
            found = collide(
                folder / f"repeated{stiffness}{treatment}",
                _ball(),
                linear(stiffness, 0.9),
                step=1e-2,
                duration=4.6,
                writes=115,
                gravity=gravity,
                contacts={**FINE, "treatment": treatment},
            )
            apexes[treatment] = _apexes(found, gravity)
        for bounce, reference in zip((1, 5, 10), heights, strict=True):
            section.rows.append(
                Row.relative(
                    f"{case}, soft",
                    f"height after bounce {bounce}, m",
                    reference,
                    apexes["soft"][bounce],
                    5e-4,
                    peers[stiffness],
                )
            )
        hard = Bounce.radius + (Bounce.height - Bounce.radius) * 0.9**20
        for what, reference in (("soft sphere", heights[2]), ("hard sphere", hard)):
            section.rows.append(
                Row.relative(
                    f"{case}, auto",
                    f"height after bounce 10 against the {what}, m",
                    reference,
                    apexes["auto"][10],
                    5e-4 if what == "soft sphere" else None,
                    peers[stiffness] if what == "soft sphere" else "",
                )
            )


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


def _stacked_pair(chapter: Chapter, folder: Path) -> None:
    radius, gravity, densities, gap = 5e-4, 9.80665, (2e4, 1e4), 1.8e-3
    section = chapter.section(
        "Stacked pair (MFiX DEM03)",
        "Two spheres of 1 mm, the lower one twice as heavy, squeezed between floor and ceiling "
        "3.6 radii apart. Reference: an ODE solution (scipy, DOP853, 1e-11) of the two linear "
        "spring-dashpots to the walls and the one between. Error: worst of 40 times, over the "
        "radius.",
    )
    figure, (axes,) = new_figure(60)
    duration = 4e-3
    for stiffness, restitution, colour in (
        (1e3, 0.9, "#0072B2"), (1e3, 0.6, "#D55E00"), (1e4, 0.9, "#009E73")
    ):  # fmt: skip
        start = Particles.of(
            [(0.5, 0.5, 0.5 * gap / 1.8), (0.5, 0.5, 1.5 * gap / 1.8)], diameter=2 * radius,
            density=densities,
        )  # fmt: skip
        found = collide(
            folder / f"stack{stiffness}{restitution}", start, linear(stiffness, restitution),
            step=duration / 40, duration=duration, writes=40, gravity=gravity, height=gap,
            contacts=FINE,
        )  # fmt: skip
        moments = np.array(list(found))
        ours = np.array([p.position[:, 2] for p in found.values()]).T
        exact = _pair_by_ode(stiffness, restitution, radius, densities, gap, gravity, moments)
        errors = np.abs(ours - exact)
        which, when = np.unravel_index(int(errors.argmax()), errors.shape)
        section.rows.append(
            Row(
                f"k {stiffness:g} N/m, e {restitution:g}",
                f"height of the {('lower', 'upper')[which]} at {moments[when]:.3g} s, m; error "
                "over the radius",
                exact[which, when], ours[which, when], errors.max() / radius, 5e-4,
                "no figure given",
            )
        )  # fmt: skip
        label = f"k {stiffness:g} N/m, e {restitution:g}"
        for sphere in (0, 1):
            axes.plot(moments * 1e3, exact[sphere] * 1e3, "-", color=colour, linewidth=0.8)
            axes.plot(moments * 1e3, ours[sphere] * 1e3, ".", color=colour, markersize=3,
                      label=label if sphere else None)  # fmt: skip
    axes.set_xlabel("time, ms")
    axes.set_ylabel("height, mm")
    axes.legend(title="lines: ODE; dots: elutriaFoam", title_fontsize=7)
    section.figures["stack"] = (figure, "Stacked pair: heights of both spheres.")


def _slip_to_roll(section: Section, folder: Path) -> None:
    radius, density, stiffness, start = 5e-4, 1e4, 1e4, 0.1
    gravity = 9.81
    sag = density * 4 / 3 * pi * radius**3 * gravity / stiffness
    ball = Particles.of((0.02, 0.05, radius - sag), (start, 0, 0), diameter=2 * radius,
                        density=density)  # fmt: skip
    for friction in (0.2, 0.6, 1.0):
        slip = 2 * start / (7 * friction * gravity)
        found = collide(
            folder / f"roll{friction}", ball, linear(stiffness, 0.9, friction), step=slip / 50,
            duration=2 * slip, writes=100, gravity=gravity, size=0.1, contacts=LINEAR,
        )  # fmt: skip
        moments = np.array(list(found))
        speed = np.array([p.velocity[0, 0] for p in found.values()])
        rolled = speed[-1] / start
        # sliding slows it evenly: where that line meets the final speed it begins to roll
        sliding = moments < 0.8 * slip
        slope, intercept = np.polyfit(moments[sliding], speed[sliding], 1)
        begins = (speed[-1] - intercept) / slope
        case = f"Slip to roll (DEM04), friction {friction:g}"
        spin = found[moments[-1]].spin[0, 1] * radius / start
        for checked, reference, ours in (
            ("friction g t/u0 when it begins to roll", 2 / 7, friction * gravity * begins / start),
            ("final u/u0", 5 / 7, rolled),
            ("final omega r/u0", 5 / 7, spin),
        ):
            section.rows.append(Row.relative(case, checked, reference, ours, 1e-3, "0.04-0.57 %"))
