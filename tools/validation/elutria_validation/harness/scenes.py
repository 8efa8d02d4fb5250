"""Scenes that maps, benchmarks and tests share, each run and held to what every state keeps to."""

from __future__ import annotations

import json
import math
import re
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from elutria.openfoam.started import started_in
from elutria_validation.harness.box import (
    CLOSED,
    NO_DRAG,
    WEIGHTLESS,
    BoxCase,
    Contacts,
    GasPlan,
    Material,
    Pair,
    cube,
)
from elutria_validation.harness.cases import (
    CONTROL,
    PARAMETERS,
    PLAN,
    Settings,
    change,
    read_gas,
    times,
)
from elutria_validation.harness.particles import Particles, lattice, read_particles
from elutria_validation.harness.programs import project_root, run_program

PATIENCE = 180
"""s: a scene that takes longer has failed."""


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


def attempt(case: Path) -> str:
    """The solver's output. Raises EndedEarly with why it refused or failed, or with what of its
    end state breaks what every state keeps to."""
    try:
        with started_in(case, ["elutriaFoam"]) as command:
            done = subprocess.run(
                command, cwd=case, capture_output=True, text=True, check=False, timeout=PATIENCE
            )
    except subprocess.TimeoutExpired:
        raise EndedEarly(Verdict("failed", note=f"took more than {PATIENCE} s")) from None
    (case / "log.elutriaFoam").write_text(done.stdout + done.stderr)
    if done.returncode == 0 and "elutria: finished" in done.stdout:
        broken = _broken(case)
        if broken:
            raise EndedEarly(Verdict("failed", warned="Warning:" in done.stdout, note=broken))
        return done.stdout
    said = re.findall(r"elutria: failed: (.*)", done.stdout)
    reason = said[-1] if said else f"exit code {done.returncode}"
    reason = reason.replace(f"{case.resolve()}/", "")
    # with a reason, and its last sound state kept, a run is marked for what it is
    told = bool(said) and (done.returncode == 2 or "last sound state written" in done.stdout)
    raise EndedEarly(Verdict("refused" if told else "failed", note=reason[:200]))


def _broken(case: Path) -> str:
    """What the end state breaks of what every state keeps to; "" for nothing."""
    last = times(case)[-1]
    particles = read_particles(case, last)
    if not all(np.isfinite(a).all() for a in (particles.position, particles.velocity)):
        return "a particle's state is not finite"
    gas, void = read_gas(case, last), read_gas(case, last, "alpha.air")
    if not (np.isfinite(gas).all() and np.isfinite(void).all()):
        return "the gas is not finite"
    if void.min() < 0.3 - 1e-9 or void.max() > 1 + 1e-9:
        return f"void fraction from {void.min():.3g} to {void.max():.3g}, allowed 0.3 to 1"
    ledger = case / "postProcessing/ledger.json"
    if ledger.is_file():
        account = json.loads(ledger.read_text())["total"]
        out = sum(o["number"] for o in account["outlets"].values()) + account["inside"]["number"]
        fed = account["injected"]["number"]
        if account["lost"]["parcels"] or abs(out - fed) > 1e-9 * fed:
            return f"{account['lost']['parcels']} parcels lost, {out:.12g} of {fed:.12g} found"
        if account["mass_closure_error"] > 1e-9:
            return f"mass is not closed by {account['mass_closure_error']:.2g}"
    return ""


def contacts(
    restitution: float = 0.8, friction: float = 0.3, young: float = 1e7, **more: Any
) -> Contacts:
    """The same contacts for particles and walls; `more` are fields of Contacts."""
    return Contacts(Pair(restitution, friction), particle=Material(young), **more)


def colliding(
    folder: Path, law: Contacts, ratio: float = 1.0, number: int = 125, end: float = 0.05,
    step: float = 1e-3, solids: float = 0.1,
) -> tuple[Particles, Particles, str]:  # fmt: skip
    """Spheres of 1 mm at most, sizes over `ratio`, thrown about in a periodic box without gas:
    start, end, and what the solver said."""
    random = np.random.default_rng(2)
    diameter = 1e-3 * ratio ** -random.uniform(0, 1, number)
    diameter[:2] = 1e-3, 1e-3 / ratio
    side = max(float(np.pi / 6 * np.sum(diameter**3) / solids) ** (1 / 3),
               1.01e-3 * math.ceil(number ** (1 / 3)))  # fmt: skip
    velocity = random.normal(0, 0.3, (number, 3))
    start = Particles.of(lattice(number, side), velocity, diameter=diameter)
    case = BoxCase(
        **cube(side), **WEIGHTLESS, forces=NO_DRAG, contacts=law, step=step, end=end
    ).make(folder, start)
    output = attempt(case)
    return start, read_particles(case, times(case)[-1]), output


def settling_bed(
    folder: Path, law: Contacts, number: int = 64, end: float = 0.3, step: float = 2e-3,
    ends: Mapping[str, Any] | None = None, packed: bool = False, seed: int = 4,
    more: Settings | None = None,
) -> tuple[Particles, Particles, str]:  # fmt: skip
    """Spheres of 1 mm that fall upon each other between walls and come to rest, coupled gas:
    start, end, and what the solver said. `ends` are fields of the box, `more` other entries."""
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
    case = BoxCase(
        **(CLOSED if ends is None else ends), width=side, depth=side, height=4 * side,
        cells=(2, 2, 8), coupled=True, solve_gas="auto", contacts=law, step=step, end=end,
        more=more or {},
    ).make(folder, start)  # fmt: skip
    output = attempt(case)
    return start, read_particles(case, times(case)[-1]), output


@dataclass(frozen=True)
class CoarseColumn:
    """The default column in 336 coarse cells, with particles of 0.6 to 2 mm."""

    velocity: float  # m/s
    loading: float  # kg/kg
    step: float | None = None  # s; None: the solver's choice
    inlet: str = ""  # a table of U over time
    end: float = 0.3  # s
    particles: int = 1000
    seed: int = 1
    gas: GasPlan = "auto"
    more: Settings = field(default_factory=dict)

    def run(self, folder: Path) -> str:
        """Make the case in `folder` and run it; what the solver said."""
        made = shutil.ignore_patterns("polyMesh", "processor*", "[1-9]*")
        shutil.copytree(project_root() / "cases/column", folder, ignore=made)
        for name, replacements in {
            "system/blockMeshDict": {"(10 10 49)": "(4 4 10)", "(10 10 2)": "(4 4 1)"},
            "constant/feed": {"900e-6": "1.2e-3", "300e-6": "6e-4"},
            CONTROL: {"binary": "ascii"},
        }.items():
            text = (folder / name).read_text()
            for old, new in replacements.items():
                text = text.replace(old, new)
            (folder / name).write_text(text)
        fixed = {f"{CONTROL}:deltaT": self.step, f"{CONTROL}:adjustTimeStep": False}
        change(
            folder,
            {
                f"{PARAMETERS}:gasVelocity": self.velocity,
                f"{PARAMETERS}:loading": self.loading,
                f"{PARAMETERS}:particles": self.particles,
                f"{PARAMETERS}:seed": self.seed,
                f"{PLAN}:gas": self.gas,
                f"{CONTROL}:endTime": self.end,
                f"{CONTROL}:writeInterval": self.end,
                **(fixed if self.step else {}),
                **self.more,
            },
        )
        if self.inlet:
            path = folder / "0.orig/U.air"
            kind = f"type uniformFixedValue; uniformValue table ({self.inlet});"
            text = re.sub(
                r"(bottom\s*\{)[^}]*\}", rf"\1 {kind} value $internalField; }}", path.read_text()
            )
            top = "type pressureInletOutletVelocity; phi phi.air; value $internalField;"
            path.write_text(re.sub(r"(top\s*\{)[^}]*\}", rf"\1 {top} }}", text))
        shutil.copytree(folder / "0.orig", folder / "0")
        run_program(["blockMesh"], folder)
        return attempt(folder)
