"""Budgets: momentum of gas and particles together, and the ledger of the default column."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from elutria.bench.common import project_root, run_program
from elutria.bench.stability_scenes import PERIODIC
from elutria.verification.scene import (
    BOX,
    CLOUD,
    CONTROL,
    Particles,
    change,
    make_scene,
    read_gas,
    read_particles,
    run_scene,
)


@pytest.mark.parametrize(
    ("outer", "allowed"),
    # one outer corrector leaves what the void fraction's change in the step does to the flux
    [(1, 1e-4), (4, 1e-8)],
)
def test_gas_and_particle_momentum_stay_in_a_periodic_box(
    tmp_path: Path, measured, outer: int, allowed: float
) -> None:
    side, cells, steps, step = 0.02, 6, 40, 5e-4
    random = np.random.default_rng(3)
    number = 400
    start = Particles.of(
        random.uniform(0, side, (number, 3)),
        random.normal((1.0, 0.5, -0.3), 0.5, (number, 3)),
        diameter=random.uniform(1e-4, 8e-4, number),
    )
    case = make_scene(
        tmp_path / "case",
        start,
        {
            **PERIODIC,
            **{f"{BOX}:{name}": side for name in ("width", "depth", "height")},
            f"{BOX}:cellsAcross": cells,
            f"{BOX}:cellsAlong": cells,
            f"{CLOUD}:solution/coupled": True,
            "system/scenePlan:gas": True,
            "system/fvSolution:PIMPLE/nOuterCorrectors": outer,
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:endTime": steps * step,
            f"{CONTROL}:writeInterval": steps * step,
        },
    )
    run_scene(case)
    time = f"{steps * step:g}"
    gas = read_gas(case, time)
    void = read_gas(case, time, "alpha.air")
    gas_momentum = 1.2 * (void * gas).sum(axis=0) * side**3 / cells**3
    taken = read_particles(case, time).momentum - start.momentum
    assert np.linalg.norm(taken) > 0.01 * np.linalg.norm(start.momentum), "drag has acted"
    drift = np.linalg.norm(gas_momentum + taken) / np.linalg.norm(taken)
    measured("drift of the total momentum over the momentum exchanged", drift, allowed)


@pytest.fixture(scope="module")
def short_column(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The default column, the first 200 particles at 10 m/s, run twice."""
    runs = []
    for name in ("first", "second"):
        case = tmp_path_factory.mktemp("column") / name
        column = project_root() / "cases/column"
        for folder in ("0.orig", "constant", "system"):
            shutil.copytree(
                column / folder, case / folder, ignore=shutil.ignore_patterns("polyMesh")
            )
        change(
            case,
            {
                "system/simulationParameters:particles": 200,
                "system/simulationParameters:feedTime": 0.05,
                "system/simulationParameters:gasVelocity": 10,
                "system/simulationParameters:drainTime": 0.4,
                f"{CONTROL}:writeInterval": 0.05,
            },
        )
        shutil.copytree(case / "0.orig", case / "0")
        run_program(["blockMesh"], case)
        run_scene(case)
        runs.append(case)
    return runs


def test_ledger_of_the_default_column_closes(short_column: list[Path], measured) -> None:
    ledger = json.loads((short_column[0] / "postProcessing/ledger.json").read_text())
    accounts = {"all": ledger["total"], **ledger["materials"]}
    for name, account in accounts.items():
        for kind, allowed in (("number", 1e-12), ("mass_kg", 1e-9)):
            fed = account["injected"][kind]
            out = sum(outlet[kind] for outlet in account["outlets"].values())
            error = abs(fed - out - account["inside"][kind]) / fed
            measured(f"{name}: {kind} that is missing over the feed", error, allowed)
        assert account["lost"] == {"parcels": 0, "number": 0, "mass_kg": 0}
    assert ledger["total"]["injected"]["parcels"] == 200
    assert ledger["total"]["outlets"]["fines"]["parcels"] > 50


def test_the_same_seed_gives_the_same_files(short_column: list[Path]) -> None:
    tables = [list((run / "postProcessing/outlets").rglob("particles.csv")) for run in short_column]
    (first,), (second,) = tables
    assert first.read_bytes().count(b"\n") > 50
    assert first.read_bytes() == second.read_bytes()
    for name in ("inside.csv", "ledger.json"):
        one, other = (run / "postProcessing" / name for run in short_column)
        assert one.read_bytes() == other.read_bytes()
