"""Steps that are not sound: taken again smaller, or the run ends with its last sound state."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import (
    CLOUD,
    CONTROL,
    PLAN,
    add_feed,
    change,
    material,
    read_gas,
    times,
)
from elutria_validation.harness.particles import Particles
from elutria_validation.harness.scenes import EndedEarly, attempt, colliding, contacts


def test_a_contact_step_far_too_large_is_lowered(tmp_path: Path) -> None:
    law = contacts(restitution=1, friction=0, treatment="soft", step=1e-4)
    start, after, output = colliding(tmp_path / "case", law, number=125, end=0.02, step=2e-4)
    assert "the contact step asked for is too long: 0.0001 s, allowed: " in output
    assert after.kinetic_energy == pytest.approx(start.kinetic_energy, rel=0.1)


def gas_scene(folder: Path, velocity: float, **plan: object) -> Path:
    """Gas through a box with a feed of 200, its inflow `velocity` from 0.05 s on."""
    case = BoxCase(
        gas_velocity=2, cells=(4, 4, 4), coupled=True, contacts=Contacts(), solve_gas=True,
        end=0.1, more={f"{PLAN}:{name}": value for name, value in plan.items()},
    ).make(folder)  # fmt: skip
    quartz = material(2650, type="fixedValue", value=5e-4)
    add_feed(case, {"massFlowRate": 2e-3, "particles": 200, "drainTime": 1, "materials": quartz})
    inflow(case, velocity)
    return case


def inflow(case: Path, velocity: float) -> None:
    """The inflow from 0.05 s on, in the case and in what it wrote."""
    for time in times(case):
        path = case / time / "U.air"
        text = path.read_text()
        name = "inflow" if "inflow" in text else "bottom"
        begin = text.index(name, text.index("boundaryField"))
        end = text.index("}", begin)
        table = f"((0 (0 0 2)) (0.05 (0 0 2)) (0.0501 (0 0 {velocity})) (9 (0 0 {velocity})))"
        entries = f"{name} {{ type uniformFixedValue; uniformValue table {table}; "
        path.write_text(text[:begin] + entries + "value uniform (0 0 2); " + text[end:])


def test_a_gas_that_cannot_be_solved_ends_with_the_last_sound_state(tmp_path: Path) -> None:
    case = gas_scene(tmp_path / "case", 1e5, retakes=2)
    with pytest.raises(EndedEarly) as caught:
        attempt(case)
    said = caught.value.verdict.note
    assert said.startswith("the gas diverged at time 0.05")
    assert "in cell" in said
    assert "also after 2 retakes" in said
    log = (case / "log.elutriaFoam").read_text()
    assert log.count("Warning: a step of the gas was taken again") == 2
    last = times(case)[-1]
    assert f"last sound state written, time {last}" in log
    assert np.abs(read_gas(case, last)).max() < 10

    # it can be started again from there, when what was wrong is put right
    inflow(case, 2)
    attempt(case)
    tables = list((case / "postProcessing/outlets").rglob("particles.csv"))
    rows = [line.split(",")[3] for table in tables for line in table.read_text().splitlines()[1:]]
    assert len(rows) == len(set(rows))
    total = json.loads((case / "postProcessing/ledger.json").read_text())["total"]
    assert total["lost"]["parcels"] == 0
    assert total["injected"]["number"] == len(rows) + total["inside"]["number"]


def test_a_failing_run_is_one_line_and_code_1(tmp_path: Path) -> None:
    case = gas_scene(tmp_path / "case", 1e5, retakes=0)
    done = subprocess.run(["elutriaFoam"], cwd=case, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    (line,) = [x for x in done.stdout.splitlines() if x.startswith("elutria: failed:")]
    for word in ("time 0.05", "cell", "likely causes"):
        assert word in line


def test_a_long_gas_step_is_taken_in_parts(tmp_path: Path) -> None:
    """The gas keeps below its Courant number whatever the step of the run."""
    limits = {"parts": 0.05, "fine": 100}
    cases = [gas_scene(tmp_path / name, 4, gasCourant=limit) for name, limit in limits.items()]
    change(cases[1], {f"{CONTROL}:deltaT": 4e-4})
    gas = []
    for case in cases:
        change(case, {f"{CLOUD}:solution/coupled": False})
        attempt(case)
        gas.append(read_gas(case, times(case)[-1]))
    log = (cases[0] / "log.elutriaFoam").read_text()
    assert log.count("continuity errors") > 2 * log.count("\nTime = ")
    assert np.abs(gas[0] - gas[1]).max() < 0.01 * np.abs(gas[1]).max()


def test_a_first_step_that_cannot_be_taken_leaves_the_start_as_it_was(tmp_path: Path) -> None:
    """Spheres that meet their own images: the reason is said, and what the user wrote is kept."""
    places = [[0.004 * (i + 1), 0.00075, 0.01] for i in range(3)]
    case = BoxCase(
        width=0.02, depth=1.5e-3, height=0.02, sides="cyclic", contacts=Contacts(), end=0.01
    ).make(tmp_path / "case", Particles.of(places, diameter=2e-3))
    before = {path: path.read_bytes() for path in (case / "0").rglob("*") if path.is_file()}
    done = subprocess.run(["elutriaFoam"], cwd=case, capture_output=True, text=True, check=False)
    (line,) = [x for x in done.stdout.splitlines() if x.startswith("elutria: failed:")]
    assert done.returncode == 1
    assert "periodic box is 0.0015 m wide in y" in line
    assert {path: path.read_bytes() for path in before} == before
    assert not list(case.glob("elutriaUnfinished.*"))
