"""Small scenes for the stability maps, each run through elutriaFoam and judged by its own balance.

A scene gives a `Verdict`: how far it is off what is known (a balance, a closed form, or the same
scene in fine steps), and whether the solver said so. SI units.
"""

from __future__ import annotations

import json
import math
import re
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria.openfoam.started import started_in
from elutria_validation.harness.common import project_root, run_program
from elutria_validation.harness.scene import (
    BOX,
    CLOUD,
    CONTACTS,
    CONTROL,
    MODELS,
    WEIGHTLESS,
    Particles,
    change,
    make_scene,
    read_gas,
    read_particles,
    times,
)

Array = NDArray[np.float64]
PATIENCE = 180
"""s: a point that takes longer has failed."""
DENSITY, GAS_DENSITY, GRAVITY = 2650.0, 1.2, 9.80665
CLOSED = {
    f"{BOX}:ends": "wall",
    f"{BOX}:bottomGroup": "closed",
    f"{BOX}:topGroup": "closed",
}


@dataclass(frozen=True)
class Verdict:
    """`kind` is right, off, refused or failed; `off` the relative error; `note` says of what."""

    kind: str
    off: float = math.nan
    warned: bool = False
    note: str = ""


class EndedEarly(Exception):
    """Carries the verdict on a scene whose run did not reach its end."""

    def __init__(self, verdict: Verdict):
        super().__init__(verdict.note)
        self.verdict = verdict


def solve(case: Path) -> str:
    """The solver's output. Raises EndedEarly with why it refused or failed."""
    try:
        with started_in(case, ["elutriaFoam"]) as command:
            done = subprocess.run(
                command, cwd=case, capture_output=True, text=True, check=False, timeout=PATIENCE
            )
    except subprocess.TimeoutExpired:
        raise EndedEarly(Verdict("failed", note=f"took more than {PATIENCE} s")) from None
    (case / "log.elutriaFoam").write_text(done.stdout + done.stderr)
    if done.returncode == 0 and "elutria: finished" in done.stdout:
        return done.stdout
    said = re.findall(r"elutria: failed: (.*)", done.stdout)
    reason = said[-1] if said else f"exit code {done.returncode}"
    reason = reason.replace(f"{case.resolve()}/", "")
    # with a reason, and its last sound state kept, a run is marked for what it is
    told = bool(said) and (done.returncode == 2 or "last sound state written" in done.stdout)
    raise EndedEarly(Verdict("refused" if told else "failed", note=reason[:200]))


def judged(off: float, allowed: float, output: str, what: str) -> Verdict:
    """Right or off, by a relative error and what is allowed of it."""
    warned = "Warning:" in output
    if not math.isfinite(off):
        return Verdict("failed", off, warned, f"{what} is not finite")
    return Verdict("right" if off <= allowed else "off", off, warned, what)


def nothing_wrong(case: Path, output: str) -> None:
    """Raises EndedEarly where the end state breaks what every state keeps to."""

    def fail(note: str) -> EndedEarly:
        return EndedEarly(Verdict("failed", warned="Warning:" in output, note=note))

    last = times(case)[-1]
    if (case / last / "lagrangian/kinematicCloud/origId").is_file():
        particles = read_particles(case, last)
        if not all(np.isfinite(a).all() for a in (particles.position, particles.velocity)):
            raise fail("a particle's state is not finite")
    gas, void = read_gas(case, last), read_gas(case, last, "alpha.air")
    if not (np.isfinite(gas).all() and np.isfinite(void).all()):
        raise fail("the gas is not finite")
    if void.min() < 0.3 - 1e-9 or void.max() > 1 + 1e-9:
        raise fail(f"void fraction from {void.min():.3g} to {void.max():.3g}, allowed 0.3 to 1")
    ledger = case / "postProcessing/ledger.json"
    if ledger.is_file():
        account = json.loads(ledger.read_text())["total"]
        out = sum(o["number"] for o in account["outlets"].values()) + account["inside"]["number"]
        fed = account["injected"]["number"]
        if account["lost"]["parcels"] or abs(out - fed) > 1e-9 * fed:
            raise fail(f"{account['lost']['parcels']} parcels lost, {out:.12g} of {fed:.12g} found")
        if account["mass_closure_error"] > 1e-9:
            raise fail(f"mass is not closed by {account['mass_closure_error']:.2g}")


def kinetic_energy(p: Particles) -> float:
    """J, with spin."""
    linear = p.mass @ np.sum(p.velocity**2, axis=1)
    return float(0.5 * (linear + p.inertia @ np.sum(p.spin**2, axis=1)))


def lattice(number: int, side: float) -> Array:
    """Places (n, 3) in a cube, as far apart as can be."""
    n = math.ceil(number ** (1 / 3))
    grid = np.stack(np.meshgrid(*[np.arange(n)] * 3), axis=-1).reshape(-1, 3)
    return np.asarray((grid[:number] + 0.5) / n * side)


def contacts(**entries: Any) -> dict[str, Any]:
    """Settings of contacts; restitution, friction and stiffness for particles and walls."""
    pair = {"restitution": 0.8, "friction": 0.3, "normalStiffness": 1000}
    pair |= {name: entries.pop(name) for name in tuple(entries) if name in pair}
    young = entries.pop("young", 1e7)
    material = {"youngsModulus": young, "poissonsRatio": 0.25}
    settings = {f"{CONTACTS}/{name}": value for name, value in entries.items()}
    return {
        f"{MODELS}/collisionModel": "cellList",
        f"{CONTACTS}/particle": material,
        f"{CONTACTS}/wall": material,
        f"{CONTACTS}/particleParticle": pair,
        f"{CONTACTS}/particleWall": pair,
        **settings,
    }


def timing(step: float, end: float) -> dict[str, Any]:
    """Steps of `step` s until `end` s, written at the end."""
    return {f"{CONTROL}:deltaT": step, f"{CONTROL}:endTime": end, f"{CONTROL}:writeInterval": end}


def cube(side: float, cells: int = 1) -> dict[str, Any]:
    """A cubic box."""
    return {
        **{f"{BOX}:{name}": side for name in ("width", "depth", "height")},
        f"{BOX}:cellsAcross": cells,
        f"{BOX}:cellsAlong": cells,
    }


def colliding(
    folder: Path, settings: Mapping[str, Any], ratio: float = 1.0, number: int = 125,
    end: float = 0.05, step: float = 1e-3, solids: float = 0.1,
) -> tuple[Particles, Particles, str]:  # fmt: skip
    """Spheres of 1 mm at most, sizes over `ratio`, thrown about in a periodic box without gas."""
    random = np.random.default_rng(2)
    diameter = 1e-3 * ratio ** -random.uniform(0, 1, number)
    diameter[:2] = 1e-3, 1e-3 / ratio
    side = max(float(np.pi / 6 * np.sum(diameter**3) / solids) ** (1 / 3),
               1.01e-3 * math.ceil(number ** (1 / 3)))  # fmt: skip
    velocity = random.normal(0, 0.3, (number, 3))
    start = Particles.of(lattice(number, side), velocity, diameter=diameter)
    case = make_scene(
        folder,
        start,
        {**WEIGHTLESS, **cube(side), f"{MODELS}/particleForces": {"gravity": {}},
         **timing(step, end), **settings},
    )  # fmt: skip
    output = solve(case)
    nothing_wrong(case, output)
    return start, read_particles(case, times(case)[-1]), output


def bed(
    folder: Path, settings: Mapping[str, Any], number: int = 64, end: float = 0.3,
    step: float = 2e-3, ends: Mapping[str, Any] | None = None, packed: bool = False, seed: int = 4,
) -> tuple[Particles, Particles, str]:  # fmt: skip
    """Spheres of 1 mm that fall upon each other between walls and come to rest, coupled gas."""
    side, diameter = 0.006, 1e-3
    random = np.random.default_rng(seed)
    layers = math.ceil(number / 16)
    pitch = diameter * (1.0 if packed else 1.3)
    places = np.array([
        [(k % 4 + 0.5) * side / 4, (k // 4 % 4 + 0.5) * side / 4, (k // 16 + 0.51) * pitch]
        for k in range(16 * layers)
    ])[:number]  # fmt: skip
    places[:, :2] += random.uniform(-1e-4, 1e-4, (number, 2))
    start = Particles.of(places, diameter=diameter)
    case = make_scene(
        folder,
        start,
        {
            **(CLOSED if ends is None else ends),
            **{f"{BOX}:width": side, f"{BOX}:depth": side, f"{BOX}:height": 4 * side},
            f"{BOX}:cellsAcross": 2,
            f"{BOX}:cellsAlong": 8,
            f"{MODELS}/particleForces": {"SchillerNaumannDrag": {}, "gravity": {}},
            f"{CLOUD}:solution/coupled": True,
            "system/scenePlan:gas": "auto",
            **timing(step, end),
            **settings,
        },
    )
    output = solve(case)
    nothing_wrong(case, output)
    return start, what_is_inside(case), output


def what_is_inside(case: Path) -> Particles:
    """The particles of the last time; OpenFOAM writes no file where there are none."""
    last = times(case)[-1]
    if not (case / last / "lagrangian/kinematicCloud/origId").is_file():
        return Particles.of(np.empty((0, 3)))
    return read_particles(case, last)


def column(
    folder: Path, velocity: float, loading: float, step: float | None = None,
    inlet: str | None = None, end: float = 0.3, particles: int = 1000, seed: int = 1,
    gas: str | bool = "auto",
) -> tuple[Path, str]:  # fmt: skip
    """The default column in 336 coarse cells, 0.6 to 2 mm particles; `inlet` is a table of U."""
    shutil.copytree(project_root() / "cases/column", folder,
                    ignore=shutil.ignore_patterns("polyMesh", "processor*", "[1-9]*"))  # fmt: skip
    for name, replacements in {
        "system/blockMeshDict": {"(10 10 49)": "(4 4 10)", "(10 10 2)": "(4 4 1)"},
        "constant/feed": {"900e-6": "1.2e-3", "300e-6": "6e-4"},
        "system/controlDict": {"binary": "ascii"},
    }.items():
        text = (folder / name).read_text()
        for old, new in replacements.items():
            text = text.replace(old, new)
        (folder / name).write_text(text)
    change(
        folder,
        {
            f"{BOX}:gasVelocity": velocity,
            f"{BOX}:loading": loading,
            f"{BOX}:particles": particles,
            f"{BOX}:seed": seed,
            "system/scenePlan:gas": gas,
            f"{CONTROL}:endTime": end,
            f"{CONTROL}:writeInterval": end,
            **({f"{CONTROL}:deltaT": step, f"{CONTROL}:adjustTimeStep": False} if step else {}),
        },
    )
    if inlet:
        path = folder / "0.orig/U.air"
        text = path.read_text()
        text = re.sub(
            r"(bottom\s*\{)[^}]*\}",
            rf"\1 type uniformFixedValue; uniformValue table ({inlet}); value $internalField; }}",
            text,
        )
        top = "type pressureInletOutletVelocity; phi phi.air; value $internalField;"
        path.write_text(re.sub(r"(top\s*\{)[^}]*\}", rf"\1 {top} }}", text))
    shutil.copytree(folder / "0.orig", folder / "0")
    run_program(["blockMesh"], folder)
    output = solve(folder)
    nothing_wrong(folder, output)
    return folder, output
