"""Contacts against closed forms and a measurement: bounce, sliding, rolling, Hertz, Kharaz."""

from __future__ import annotations

import csv
from math import atan2, cos, degrees, exp, log, log2, pi, radians, sin, sqrt, tan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray
from scipy.optimize import brentq

from elutria.bench.common import Options
from elutria.plots import STYLE, new_figure
from elutria.verification.book import Chapter, Row, write_chapter
from elutria.verification.scene import (
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
HELP = "Contacts against closed forms and a measurement: bounce, sliding, rolling, Hertz, Kharaz."

Array = NDArray[np.float64]


@rc_context(STYLE)
def run(options: Options) -> None:
    """Free fall and bounce, oblique impacts, slip to roll, Hertz' peaks, Kharaz' measurement."""
    chapter = Chapter(
        NAME,
        "Contacts",
        "Spheres and walls without gas forces, moved by elutriaFoam. References: free fall and "
        "bounce of a linear spring-dashpot with gravity (MFiX DEM01); its repeated bounces "
        "(DEM02); slip to roll (DEM04); gross sliding; Hertz' peaks (Chung and Ooi 2011); oblique "
        "impacts of alumina on glass as Kharaz, Gorham and Salman measured them (2001).",
    )
    with TemporaryDirectory() as work:
        folder = Path(work)
        _bounce(chapter, folder)
        _repeated_bounces(chapter, folder)
        _slip_to_roll(chapter, folder)
        _gross_sliding(chapter, folder)
        _hertz(chapter, folder)
        _kharaz(chapter, folder)
    write_chapter(options, chapter)


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
    contacts: dict[str, Any] | None = None,
) -> dict[float, Particles]:
    """The particles at `writes` equidistant times in a box of walls of `size` (m), by time."""
    case = make_scene(
        folder,
        particles,
        {
            **{f"{BOX}:{name}": size for name in ("width", "depth", "height")},
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


def _linear(stiffness: float, restitution: float, friction: float = 0.0) -> dict[str, float]:
    return {"restitution": restitution, "friction": friction, "normalStiffness": stiffness}


# stiff enough that a contact is short and flat, as the closed forms have it
GLASS = {"youngsModulus": 70e9, "poissonsRatio": 0.25}
LINEAR = {"contactLaw": "linearSpringDashpot", "treatment": "soft"}
# half the default step
FINE = {**LINEAR, "stepFraction": 0.01}


def _bounce(chapter: Chapter, folder: Path) -> None:
    peers = {(1e4, 0.9): "1.4e-4 m (Adams-Bashforth), 2.1e-3 m (Euler)"}
    for stiffness in (1e4, 5e4, 1e5):
        # at 1e4 N/m without damping the centre would go through the wall
        for restitution in (0.6, 0.9) if stiffness == 1e4 else (0.6, 0.9, 1.0):
            exact = Bounce(stiffness, restitution, 9.81)
            found = collide(
                folder / f"bounce{stiffness}{restitution}", _ball(),
                _linear(stiffness, restitution), step=5e-3, duration=0.6, writes=60,
                gravity=9.81, contacts=FINE,
            )  # fmt: skip
            errors = [abs(p.position[0, 2] - exact.at(t)) for t, p in found.items()]
            k = int(np.argmax(errors))
            time = list(found)[k]
            chapter.rows.append(
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
            folder / f"order{h}", _ball(), _linear(1e4, 0.9), step=h, duration=0.4,
            gravity=9.81, contacts={**LINEAR, "step": h},
        )  # fmt: skip
        ((time, ball),) = end.items()
        errors.append(abs(ball.position[0, 2] - exact.at(time)))
    # end points: less swayed than neighbours by where in a step the contact begins
    order = log2(errors[0] / errors[-1]) / 3
    chapter.rows.append(
        Row("Bounce (DEM01) k 1e4 N/m, e 0.9", "order in the contact step (error: shortfall from "
            "2)", 2, order, max(2 - order, 0), 0.2)
    )  # fmt: skip
    figure, (axes,) = new_figure(60)
    axes.loglog(steps, errors, "o-", color="#0072B2", label="elutriaFoam, in the contact")
    axes.loglog(steps, [errors[0] * (h / steps[0]) ** 2 for h in steps], "k:", label="order 2")
    axes.set_xlabel("contact step, s")
    axes.set_ylabel("error of height at 0.4 s, m")
    axes.legend()
    chapter.figures["order"] = (figure, "Bounce: error in the rebound against the contact step.")


def _repeated_bounces(chapter: Chapter, folder: Path) -> None:
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
                _linear(stiffness, 0.9),
                step=1e-2,
                duration=4.6,
                writes=115,
                gravity=gravity,
                contacts={**FINE, "treatment": treatment},
            )
            apexes[treatment] = _apexes(found, gravity)
        for bounce, reference in zip((1, 5, 10), heights, strict=True):
            chapter.rows.append(
                Row.relative(
                    f"{case}, soft",
                    f"height after bounce {bounce}, m",
                    reference,
                    apexes["soft"][bounce],
                    5e-4,
                    peers[stiffness],
                )
            )
        # an impact takes no time, so that gravity does nothing in it
        hard = Bounce.radius + (Bounce.height - Bounce.radius) * 0.9**20
        for what, reference in (("soft sphere", heights[2]), ("hard sphere", hard)):
            chapter.rows.append(
                Row.relative(
                    f"{case}, auto",
                    f"height after bounce 10 against the {what}, m",
                    reference,
                    apexes["auto"][10],
                    5e-4,
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


def _slip_to_roll(chapter: Chapter, folder: Path) -> None:
    radius, density, stiffness, start = 5e-4, 1e4, 1e4, 0.1
    gravity = 9.81
    sag = density * 4 / 3 * pi * radius**3 * gravity / stiffness
    ball = Particles.of((0.02, 0.05, radius - sag), (start, 0, 0), diameter=2 * radius,
                        density=density)  # fmt: skip
    for friction in (0.2, 0.6, 1.0):
        slip = 2 * start / (7 * friction * gravity)
        found = collide(
            folder / f"roll{friction}", ball, _linear(stiffness, 0.9, friction), step=slip / 50,
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
            chapter.rows.append(Row.relative(case, checked, reference, ours, 1e-3, "0.04-0.57 %"))


def oblique(
    folder: Path, angles: list[float], speed: float, radius: float, density: float,
    pair: dict[str, float], contacts: dict[str, Any],
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
    duration = 2.5 * gap / (speed * cos(max(tilt)))
    duration = min(duration, 0.5 * size / speed)
    found = collide(
        folder, start, pair, step=duration / 10, duration=duration, size=size, contacts=contacts
    )
    return list(found.values())[-1]


def _gross_sliding(chapter: Chapter, folder: Path) -> None:
    for law, treatment in (
        ("hertzMindlin", "soft"), ("hertzMindlin", "auto"), ("linearSpringDashpot", "soft")
    ):  # fmt: skip
        for friction, restitution in ((0.1, 0.9), (0.3, 0.6)):
            least = degrees(atan2(3.6 * friction * (1 + restitution), 1))
            angles = list(np.linspace(least, 75, 4))
            speed, radius = 0.2, 1e-3
            after = oblique(
                folder / f"slide{law}{treatment}{friction}", angles, speed, radius, 2650,
                _linear(1e8, restitution, friction),
                {"contactLaw": law, "treatment": treatment, "particle": GLASS, "wall": GLASS},
            )  # fmt: skip
            errors = []
            for i, angle in enumerate(angles):
                tilt = radians(angle)
                grip = friction * (1 + restitution)
                errors += [
                    after.velocity[i, 0] / (speed * sin(tilt)) / (1 - grip / tan(tilt)) - 1,
                    after.spin[i, 1] * radius / (2.5 * grip * speed * cos(tilt)) - 1,
                    after.velocity[i, 0] / after.velocity[i, 2]
                    / ((tan(tilt) - grip) / restitution) - 1,
                ]  # fmt: skip
            k = int(np.argmax(np.abs(errors)))
            tilt = radians(angles[k // 3])
            what = ("tangential restitution", "spin", "rebound angle")[k % 3]
            chapter.rows.append(
                Row(
                    f"Gross sliding, {law}, {treatment}, friction {friction:g}, e {restitution:g}",
                    f"e_t, spin and angle at 4 angles, worst: {what} at {angles[k // 3]:.0f} deg, "
                    "over the closed form",
                    1,
                    1 + errors[k],
                    abs(errors[k]),
                    1e-3,
                    "0.0-0.3 %",
                )
            )


# Chung and Ooi 2011: Young's modulus (Pa), Poisson's ratio, density (kg/m3); radius (m) and speed
HERTZ = {
    "T1 glass": (48e9, 0.20, 2800, 0.01, 10.0, (274.11e-6, 10.697e3)),
    "T1 limestone": (20e9, 0.25, 2500, 0.01, 10.0, (368.30e-6, 7.108e3)),
    "T2 aluminium alloy": (70e9, 0.30, 2699, 0.1, 0.2, (49.717e-6, 11.370e3)),
    "T2 magnesium alloy": (40e9, 0.35, 1800, 0.1, 0.2, (52.123e-6, 7.233e3)),
}


def _hertz(chapter: Chapter, folder: Path) -> None:
    for name, (young, poisson, density, radius, speed, (overlap, force)) in HERTZ.items():
        two = name.startswith("T1")
        duration = 2.943 * overlap / (2 * speed if two else speed)
        apart = (1 + 1e-4) * radius
        if two:
            start = Particles.of(
                [(0.5 - apart, 0.5, 0.5), (0.5 + apart, 0.5, 0.5)],
                [(speed, 0, 0), (-speed, 0, 0)], diameter=2 * radius, density=density,
            )  # fmt: skip
        else:
            start = Particles.of((0.5, 0.5, apart), (0, 0, -speed), diameter=2 * radius,
                                 density=density)  # fmt: skip
        material = {"youngsModulus": young, "poissonsRatio": poisson}
        rigid = {"youngsModulus": 1e20, "poissonsRatio": 0.3}
        found = collide(
            folder / name.replace(" ", ""), start, _linear(1, 1), step=duration / 100,
            duration=1.5 * duration, writes=150,
            contacts={"treatment": "soft", "particle": material,
                      "wall": material if two else rigid},
        )  # fmt: skip
        moments = np.array([0.0, *found])
        states = [start, *found.values()]
        if two:
            gaps = np.array([2 * radius - np.ptp(p.position[:, 0]) for p in states])
            speeds = np.array([p.velocity[1, 0] for p in states])
        else:
            gaps = np.array([radius - p.position[0, 2] for p in states])
            speeds = np.array([p.velocity[0, 2] for p in states])
        pushes = np.diff(speeds) / np.diff(moments) * start.mass[0]
        half = int(gaps.argmax())
        begins = np.interp(0, gaps[:half], moments[:half])
        ends = np.interp(0, -gaps[half:], moments[half:])
        for checked, reference, ours in (
            ("largest overlap, m", overlap, _peak(gaps)),
            ("largest force, N", force, _peak(pushes)),
            ("duration, s", duration, float(ends - begins)),
        ):
            chapter.rows.append(
                Row.relative(f"Hertz impact {name}", checked, reference, ours, 1e-3, "0.1-0.5 %")
            )


def _peak(values: Array) -> float:
    """Top of the parabola through the largest value and its neighbours."""
    k = int(values.argmax())
    a, b, c = values[k - 1 : k + 2]
    return float(b + (c - a) ** 2 / (8 * (2 * b - a - c)))


def _kharaz(chapter: Chapter, folder: Path) -> None:
    measured: dict[str, list[tuple[float, float]]] = {}
    with (Path(__file__).parent / "kharaz2001.csv").open() as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            point = (float(row["impact_angle_deg"]), float(row["value"]))
            measured.setdefault(row["quantity"], []).append(point)
    alumina = {"youngsModulus": 380e9, "poissonsRatio": 0.23}
    glass = {"youngsModulus": 70e9, "poissonsRatio": 0.25}
    speed, radius = 3.9, 2.5e-3

    def after(angles: list[float], name: str) -> dict[str, Array]:
        end = oblique(
            folder / name, angles, speed, radius, 4000, _linear(1, 0.98, 0.092),
            {"treatment": "soft", "particle": alumina, "wall": glass},
        )  # fmt: skip
        tilt = np.radians(angles)
        return {
            "tangential_restitution": end.velocity[:, 0] / (speed * np.sin(tilt)),
            "spin_after_rad_per_s": end.spin[:, 1],
            "rebound_angle_centre_deg": np.degrees(
                np.arctan2(end.velocity[:, 0], end.velocity[:, 2])
            ),
        }

    curve_angles = list(np.linspace(2, 62, 21))
    curve = after(curve_angles, "kharazCurve")
    labels = {
        "tangential_restitution": ("tangential restitution", 0.1, 10.0),
        "spin_after_rad_per_s": ("spin after, rad/s", 60.0, 10.0),
        "rebound_angle_centre_deg": ("rebound angle, degrees", 2.0, 0.0),
    }
    figure, panels = new_figure(130, rows=3)
    for axes, (name, points) in zip(panels, measured.items(), strict=True):
        label, allowed, least = labels[name]
        angles, values = np.array(points).T
        ours = after(list(angles), name)[name]
        used = angles >= least
        errors = np.where(used, np.abs(ours - values), 0)
        rms = float(np.sqrt((errors[used] ** 2).mean()))
        k = int(errors.argmax())
        where = f", from {least:g} degrees" if least else ""
        chapter.rows.append(
            Row(
                "Kharaz 2001, 5 mm alumina on glass",
                f"{label}{where}: worst at {angles[k]:.0f} deg; error: rms, absolute",
                values[k],
                ours[k],
                rms,
                allowed,
                "Hertz-Mindlin codes overpredict e_t below about 10 degrees",
            )
        )
        axes.plot(angles, values, "o", color="#D55E00", label="measured")
        axes.plot(curve_angles, curve[name], "-", color="#0072B2", label="elutriaFoam")
        axes.set_ylabel(label)
    panels[-1].legend()
    panels[-1].set_xlabel("impact angle from the normal, degrees")
    chapter.figures["kharaz"] = (figure, "Oblique impact of alumina on glass at 3.9 m/s.")
