"""A run goes on from what it was fed, not from what its files say today.

What may be changed on the way is done as asked; the rest is refused in a line, with nothing on disk
touched.
"""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elutria.case.case import Case
from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import (
    CLOUD,
    CONTROL,
    PARAMETERS,
    add_feed,
    change,
    material,
    solve,
)
from elutria_validation.harness.particles import HEADER
from elutria_validation.harness.programs import run_program
from tests.cases.test_continuation import rows

RATE = 2e-3
FEED = {
    "massFlowRate": RATE, "particles": 200, "duration": 0.2, "velocity": [0.2, 0, 0],
    "parcels": "evenSizes", "drainTime": 0.2,
    "materials": material(2650, type="uniform", min=2e-4, max=6e-4),
}  # fmt: skip
FEED_FILE = "constant/feed"


def begun(folder: Path, until: float = 0.1, **entries: Any) -> Path:
    """A run that has come half way."""
    case = BoxCase(gas_velocity=2, cells=(3, 3, 3), end=until, interval=0.05).make(folder)
    add_feed(case, {**FEED, **entries})
    solve(case)
    change(case, {f"{CONTROL}:endTime": 2})
    return case


def ledger(case: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((case / "postProcessing/ledger.json").read_text())
    return content["total"]


def files(case: Path) -> dict[str, str]:
    """Every file below a case, and what is in it."""
    return {
        str(path.relative_to(case)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(case.rglob("*"))
        if path.is_file()
    }


def refusal(case: Path) -> str:
    """The line in which the solver refuses to go on; it has touched nothing."""
    before = files(case)
    done = subprocess.run(["elutriaFoam"], cwd=case, capture_output=True, text=True, check=False)
    lines = re.findall(r"elutria: failed: (.*)", done.stdout)
    assert done.returncode == 2, done.stdout[-500:]
    assert files(case) == before
    assert len(lines) == 1
    return str(lines[0])


@pytest.fixture(scope="module")
def half_way(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return begun(tmp_path_factory.mktemp("record") / "case")


@pytest.fixture
def case(half_way: Path, tmp_path: Path) -> Path:
    copy = tmp_path / "case"
    subprocess.run(["cp", "-r", str(half_way), str(copy)], check=True)
    return copy


@pytest.mark.parametrize(
    "setting, words",
    [
        ({f"{FEED_FILE}:seed": 7}, ["constant/feed: seed is 7", "was 1"]),
        ({f"{FEED_FILE}:materials/solid/density": 1500}, ["solid/density is 1500", "2650"]),
        ({f"{FEED_FILE}:parcels": "evenMass"}, ["parcels is evenMass", "evenSizes"]),
        ({f"{FEED_FILE}:velocity": [0.3, 0, 0]}, ["velocity", "0.3", "0.2"]),
        ({f"{FEED_FILE}:outlets": {"fines": ["bottom"], "coarse": ["top"]}},
         ["outlets/fines", "bottom", "top"]),
        ({f"{PARAMETERS}:gasVelocity": 3}, ["system/simulationParameters: gasVelocity is 3", "2"]),
        ({f"{PARAMETERS}:gravity": -5}, ["gravity is -5", "-9.8"]),
        ({f"{CLOUD}:subModels/particleForces": {"gravity": {}}}, ["kinematicCloudProperties"]),
        ({f"{FEED_FILE}:particles": 50}, ["particles is 50", "200", "more than 1"]),
        ({f"{FEED_FILE}:duration": 0.05}, ["duration is 0.05", "0.2", "more than 0.1"]),
    ],
)  # fmt: skip
def test_what_would_change_the_past_is_refused(
    case: Path, setting: dict[str, Any], words: list[str]
) -> None:
    change(case, setting)
    said = refusal(case)
    assert all(word in said for word in words), said


def test_a_feed_that_is_gone_is_refused(case: Path) -> None:
    (case / FEED_FILE).unlink()
    assert "constant/feed: file not found" in refusal(case)


SIEVES = "diameter_um,cumulative\n200,0\n400,0.5\n600,1\n"


def test_what_stands_in_a_file_that_the_feed_names_is_of_the_past_too(tmp_path: Path) -> None:
    case = BoxCase(gas_velocity=2, cells=(3, 3, 3), end=0.1, interval=0.05).make(tmp_path / "case")
    sieves = case / "constant/sieves.csv"
    sieves.write_text(SIEVES)
    add_feed(
        case, {**FEED, "materials": material(2650, type="sieve", file='"constant/sieves.csv"')}
    )
    solve(case)
    change(case, {f"{CONTROL}:endTime": 2})
    sieves.write_text(SIEVES.replace("0.5", "0.9"))
    said = refusal(case)
    assert 'solid/sizeDistribution/file is "constant/sieves.csv of SHA-1' in said
    sieves.write_text(SIEVES)
    solve(case)
    assert ledger(case)["mass_closure_error"] < 1e-12


def test_a_source_of_the_gas_that_was_not_there_is_refused(case: Path) -> None:
    (case / "constant/fvOptions").write_text(
        HEADER.format("dictionary", "constant", "fvOptions")
        + "drive { type meanVelocityForce; selectionMode all; fields (U.air); Ubar (0 0 3); }\n"
    )
    said = refusal(case)
    assert "constant/fvOptions: drive is a dictionary" in said
    assert "when it was absent" in said


@pytest.mark.parametrize("entry, value", [("taller", "0.12"), ("finer", "5")])
def test_another_mesh_is_refused(case: Path, entry: str, value: str) -> None:
    """By hand in the plan of the mesh: a fifth taller with as many cells, or in more cells."""
    old = {"taller": "$height", "finer": "$cellsAlong"}[entry]
    plan = case / "system/blockMeshDict"
    assert old in plan.read_text()
    plan.write_text(plan.read_text().replace(old, value))
    run_program(["blockMesh"], case)
    said = refusal(case)
    assert "constant/polyMesh: the mesh is" in said
    assert {"taller": "27 cells, 0.0012 m3", "finer": "45 cells, 0.001 m3"}[entry] in said
    assert "when it was 27 cells, 0.001 m3" in said


def test_a_longer_feed_begins_as_the_shorter_and_lasts_as_long_as_asked(
    case: Path, tmp_path: Path
) -> None:
    short = tmp_path / "short"
    subprocess.run(["cp", "-r", str(case), str(short)], check=True)
    whole = begun(tmp_path / "whole", particles=400, duration=0.4)
    change(case, {f"{FEED_FILE}:particles": 400, f"{FEED_FILE}:duration": 0.4})
    for run in (case, short, whole):
        solve(run)
    account = ledger(case)
    assert account["lost"]["parcels"] == 0
    assert account["injected"]["parcels"] == 400
    assert account["injected"]["mass_kg"] == pytest.approx(RATE * 0.4, rel=0.02)
    # what was planned before is fed as it was planned
    planned, fed = ({int(r[3]): (r[2], r[4], r[6]) for r in rows(run)} for run in (short, case))
    common = set(planned) & set(fed)
    assert len(common) > 100
    assert {i: fed[i] for i in common} == {i: planned[i] for i in common}
    # and the rest enters when that of a run enters which was asked for it from the beginning
    times = [{int(r[3]): float(r[0]) - float(r[10]) for r in rows(run)} for run in (case, whole)]
    common = set(times[0]) & set(times[1])
    assert len(common) > 250
    assert np.abs([times[0][i] - times[1][i] for i in common]).max() < 1e-9


def test_a_longer_duration_alone_keeps_what_a_parcel_stands_for(case: Path) -> None:
    change(case, {f"{FEED_FILE}:duration": 0.4})
    solve(case)
    account = ledger(case)
    assert account["injected"]["parcels"] == 400
    assert account["injected"]["mass_kg"] == pytest.approx(RATE * 0.4, rel=0.02)
    assert account["lost"]["parcels"] == 0


def test_another_rate_is_that_of_what_enters_from_now_on(case: Path) -> None:
    change(case, {f"{FEED_FILE}:massFlowRate": 3 * RATE})
    solve(case)
    account = ledger(case)
    assert account["injected"]["parcels"] == 200
    assert account["injected"]["mass_kg"] == pytest.approx(RATE * 0.1 * (1 + 3), rel=0.04)
    assert account["lost"]["parcels"] == 0


def test_a_run_may_change_more_than_once_and_be_cut_in_any_place(
    case: Path, tmp_path: Path
) -> None:
    """Three stretches, in two starts or in six: the same rows."""
    other = tmp_path / "other"
    subprocess.run(["cp", "-r", str(case), str(other)], check=True)
    for run, ends in ((case, [0.15, 2]), (other, [0.12, 0.15, 0.17, 0.22, 2])):
        change(run, {f"{FEED_FILE}:massFlowRate": 2 * RATE})
        for end in ends:
            if end > 0.15:
                change(run, {f"{FEED_FILE}:massFlowRate": RATE, f"{FEED_FILE}:duration": 0.3})
            change(run, {f"{CONTROL}:endTime": end})
            solve(run)
    assert [row[:5] for row in rows(case)] == [row[:5] for row in rows(other)]
    assert ledger(case)["lost"]["parcels"] == 0
    assert ledger(case)["injected"]["mass_kg"] == pytest.approx(RATE * 0.35, rel=0.04)


def test_a_longer_drain_goes_on_and_a_restart_from_before_forgets_it(tmp_path: Path) -> None:
    case = begun(tmp_path / "case", drainTime=0.01)
    solve(case)
    inside = ledger(case)["inside"]["parcels"]
    assert inside > 0
    change(case, {f"{FEED_FILE}:drainTime": 1})
    solve(case)
    assert ledger(case)["inside"]["parcels"] < inside
    assert ledger(case)["injected"]["parcels"] == 200
    # from the start: everything may be changed
    change(case, {f"{CONTROL}:startFrom": "startTime", f"{CONTROL}:startTime": 0,
                  f"{FEED_FILE}:seed": 5})  # fmt: skip
    solve(case)
    assert ledger(case)["lost"]["parcels"] == 0


def test_an_end_that_is_over_is_refused(tmp_path: Path) -> None:
    """What the run came to since then is no result of a shorter drain, or of an earlier end."""
    case = begun(tmp_path / "case", until=0.35)
    change(case, {f"{FEED_FILE}:drainTime": 0.1})
    said = refusal(case)
    assert said.startswith("constant/feed: drainTime is 0.1, but the run came to time 0.35 when it")
    assert "was 0.2; allowed: at least 0.15, as that much is over" in said
    change(case, {f"{FEED_FILE}:drainTime": 0.2, f"{CONTROL}:endTime": 0.3})
    assert "endTime is 0.3, but the run came to time 0.35; allowed: at least that" in refusal(case)
    change(case, {f"{FEED_FILE}:drainTime": 0.16, f"{CONTROL}:endTime": 2})
    solve(case)
    assert json.loads((case / "postProcessing/ledger.json").read_text())["time_s"] < 0.37


@pytest.mark.slow
def test_two_processors_go_on_as_one_does(case: Path, tmp_path: Path) -> None:
    del case
    one = begun(tmp_path / "one")
    two = BoxCase(gas_velocity=2, cells=(3, 3, 3), end=0.1, interval=0.05).make(tmp_path / "two")
    add_feed(two, FEED)
    solve(two, processors=2)
    for run in (one, two):
        change(run, {f"{CONTROL}:endTime": 2, f"{FEED_FILE}:massFlowRate": 2 * RATE})
    solve(one)
    done = subprocess.run(
        ["mpirun", "--mca", "mpi_yield_when_idle", "1", "-np", "2", "elutriaFoam", "-parallel"],
        cwd=two, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-500:]
    assert [row[1:5] for row in rows(one)] == [row[1:5] for row in rows(two)]
    change(two, {f"{FEED_FILE}:seed": 2})
    done = subprocess.run(
        ["mpirun", "-np", "2", "elutriaFoam", "-parallel"],
        cwd=two, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "constant/feed: seed is 2" in done.stdout


def test_a_result_is_labelled_by_what_was_run(case: Path) -> None:
    change(case, {f"{PARAMETERS}:gasVelocity": 3})
    assert Case(case).velocity() == 3
    assert Case(case).velocity_of_run() == 2
