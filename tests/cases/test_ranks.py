"""Contacts on every processor: what is recorded does not show how many there are."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from elutria_validation.harness.box import BoxCase, Contacts, Pair, Treatment
from elutria_validation.harness.cases import CONTROL, add_feed, change, material, solve
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.harness.programs import run_program

FEED = {
    "massFlowRate": 2e-3,
    "particles": 600,
    "duration": 0.2,
    "velocity": [0.2, 0, 0],
    "materials": material(2650, type="uniform", min=2e-4, max=6e-4),
}
PARCELS = {**FEED, "massFlowRate": 8e-3, "parcels": "evenSizes"}
"""Each stands for many particles, or for a share of one, and meets others by chance."""

DECOMPOSITION = "system/decomposeParDict"


@pytest.fixture(autouse=True)
def _more_ranks_than_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMPI_MCA_rmaps_base_oversubscribe", "1")
    monkeypatch.setenv("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe")
    monkeypatch.setenv("OMPI_MCA_mpi_yield_when_idle", "1")


def column(folder: Path, feed: dict[str, object], treatment: Treatment, threads: int = 1) -> Path:
    """A narrow column that blows half of what falls in from the side upwards; its gas is frozen."""
    box = BoxCase(
        width=0.02, depth=0.02, height=0.06, cells=(4, 4, 12), gas_velocity=2,
        contacts=Contacts(treatment=treatment, more={"threads": threads}), end=0.3, interval=0.1,
    )  # fmt: skip
    case = box.make(folder)
    add_feed(case, feed)
    return case


def decomposed(case: Path, ranks: int) -> Path:
    pieces = [2, 1, 2] if ranks == 4 else [1, 1, ranks]
    change(
        case, {f"{DECOMPOSITION}:numberOfSubdomains": ranks, f"{DECOMPOSITION}:coeffs/n": pieces}
    )
    return case


def recorded(case: Path) -> bytes:
    return (case / "postProcessing/outlets/0/particles.csv").read_bytes()


@pytest.mark.parametrize(
    "ranks", [3, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 4, 8))]
)
@pytest.mark.parametrize("feed", [FEED, PARCELS], ids=["particles", "parcels"])
def test_impacts_in_frozen_gas_are_recorded_alike_to_the_byte(
    tmp_path: Path, feed: dict[str, object], ranks: int
) -> None:
    serial = column(tmp_path / "serial", feed, "impact")
    log = solve(serial)
    assert float(re.findall(r"impacts +(\S+)", log)[-1]) > 500
    assert len(recorded(serial).splitlines()) > 300

    parallel = decomposed(column(tmp_path / "parallel", feed, "impact", threads=2), ranks)
    log = solve(parallel, ranks)
    shared = [float(n) for n in re.findall(r"(\S+) shared islands", log)]
    assert len(shared) == ranks
    assert sum(shared) > 0, "no island reached over processors"
    assert recorded(parallel) == recorded(serial)


def test_contacts_go_on_with_another_number_of_ranks(tmp_path: Path, measured) -> None:
    # a heap that has come to rest on a floor: its history is what holds it
    heap = Particles.of(
        [(0.004 + 0.0022 * (k % 6), 0.01, 0.0011 + 0.0021 * (k // 6)) for k in range(24)],
        [(0.02 * (k % 5 - 2), 0, 0) for k in range(24)],
        diameter=2e-3,
    )
    box = BoxCase(
        width=0.02, depth=0.02, height=0.06, cells=(4, 4, 12), ends="wall", end=0.1,
        contacts=Contacts(Pair(0.4, 0.5), wall_pair=Pair(0.4, 0.5)), interval=0.05,
    )  # fmt: skip
    case = decomposed(box.make(tmp_path / "case", heap), 2)
    solve(case, 2)
    run_program(["reconstructPar", "-latestTime"], case)
    change(case, {f"{CONTROL}:endTime": 0.12, f"{CONTROL}:writeInterval": 0.02})
    copies = {name: tmp_path / name for name in ("one", "three", "forgetful")}
    for copy in copies.values():
        shutil.copytree(case, copy)
    solve(copies["one"])
    solve(decomposed(copies["three"], 3), 3)
    run_program(["reconstructPar", "-latestTime"], copies["three"])
    for file in (copies["forgetful"] / "0.1/uniform/lagrangian/kinematicCloud").glob("contact*"):
        file.unlink()
    solve(copies["forgetful"])
    one, three, forgetful = (read_particles(copy, "0.12").position for copy in copies.values())
    measured("places on 3 ranks and on 1, in diameters", np.abs(three - one).max() / 2e-3, 1e-9)
    assert np.abs(forgetful - one).max() / 2e-3 > 1e-6, "the history made no difference"
