"""Contacts on every processor: what is recorded does not show how many there are."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from foamlib import FoamFile

from elutria import tables
from elutria_validation.harness.box import CLOSED, PERIODIC, BoxCase, Contacts, Pair, Treatment
from elutria_validation.harness.cases import (
    CONTROL,
    PLAN,
    add_feed,
    change,
    material,
    read_gas,
    solve,
)
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
    monkeypatch.setenv("ELUTRIA_EXACT", "yes")


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


def recorded(case: Path, start: str = "0") -> bytes:
    return (case / "postProcessing/outlets" / start / "particles.csv").read_bytes()


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
    work = pd.read_csv(parallel / "postProcessing/ranks.csv")
    assert tuple(work.columns) == tables.RANKS
    assert list(work["rank"]) == list(range(ranks))
    assert work["cells"].sum() == 4 * 4 * 12
    assert work["shared_islands"].sum() == pytest.approx(sum(shared), rel=1e-2)
    assert len(set(work["exchanges"])) == 1
    assert (work["sent_bytes"] > 0).all()
    assert recorded(parallel) == recorded(serial)


def test_a_feed_by_loading_is_the_same_to_the_last_bit(tmp_path: Path) -> None:
    # its rate is from sums over the inlet's faces, its focus from one over the cells
    feed: dict[str, object] = {"loading": 0.7, "particles": 100, "parcels": "evenSizes",
                               "duration": 0.01, "materials": FEED["materials"]}  # fmt: skip
    fed = []
    for name, ranks in (("serial", 1), ("parallel", 4)):
        case = decomposed(column(tmp_path / name, feed, "impact"), ranks)
        change(case, {f"{CONTROL}:writePrecision": 17, f"{CONTROL}:endTime": 0.012,
                      f"{CONTROL}:writeInterval": 0.012})  # fmt: skip
        solve(case, ranks)
        if ranks > 1:
            run_program(["reconstructPar", "-latestTime"], case)
        folder = case / "0.012/lagrangian/kinematicCloud"
        fed.append(
            [np.sort(np.asarray(FoamFile(folder / name)[None])) for name in ("d", "nParticle")]
        )
    assert len(fed[0][0]) > 90
    for serial, parallel in zip(*fed, strict=True):
        assert serial.tolist() == parallel.tolist()


@pytest.mark.parametrize(
    "ranks", [(2, 1), (1, 2), pytest.param((2, 3), marks=pytest.mark.slow)], ids=str
)
@pytest.mark.parametrize("feed", [FEED, PARCELS], ids=["particles", "parcels"])
def test_a_run_goes_on_with_another_number_of_ranks_as_if_uninterrupted(
    tmp_path: Path, feed: dict[str, object], ranks: tuple[int, int]
) -> None:
    whole = column(tmp_path / "whole", feed, "impact")
    solve(whole)
    parts = column(tmp_path / "parts", feed, "impact")
    change(parts, {f"{CONTROL}:writeFormat": "binary"})
    for number, end in zip(ranks, (0.1, 0.3), strict=True):
        change(parts, {f"{CONTROL}:endTime": end})
        solve(decomposed(parts, number), number)
        if number > 1:
            run_program(["reconstructPar", "-latestTime"], parts)

    pieces = [recorded(parts, start).splitlines() for start in ("0", "0.1")]
    assert min(len(piece) for piece in pieces) > 20
    assert pieces[0] + pieces[1][1:] == recorded(whole).splitlines()
    ledgers = [
        json.loads((case / "postProcessing/ledger.json").read_text())["total"]
        for case in (whole, parts)
    ]
    assert ledgers[0]["lost"]["parcels"] == 0
    assert ledgers[0] == ledgers[1]


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


@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_a_dense_bed_of_contact_steps_moves_alike(tmp_path: Path, ranks: int, measured) -> None:
    # Goldschmidt's grains, packed: they fall onto each other on both sides of the cuts
    spacing, across, layers = 2.6e-3, 8, 8
    random = np.random.default_rng(7)
    place = spacing * (0.5 + np.array(list(np.ndindex(layers, across, across)))[:, ::-1])
    place += random.uniform(-2e-5, 2e-5, place.shape)
    grains = Particles.of(
        place, random.uniform(-0.3, 0.3, place.shape),
        diameter=2.5e-3 * (1 - 1e-4 * np.linspace(0, 1, len(place))),
    )  # fmt: skip
    box = BoxCase(
        width=0.0208, depth=0.0208, height=0.06, cells=(4, 4, 12), ends="wall", end=0.01,
        contacts=Contacts(Pair(0.97, 0.1), treatment="soft"), interval=0.01,
    )  # fmt: skip

    def ends(name: str, number: int) -> np.ndarray:
        case = box.make(tmp_path / name, grains)
        change(case, {f"{DECOMPOSITION}:numberOfSubdomains": number})
        change(case, {f"{DECOMPOSITION}:coeffs/n": [number, 1, 1]})
        solve(case, number)
        if number > 1:
            work = pd.read_csv(case / "postProcessing/ranks.csv")
            assert (work["particle_steps"] > 0).all()
            assert (work["ghost_steps"] > 0).all()
            run_program(["reconstructPar", "-latestTime"], case)
        found = read_particles(case, "0.01")
        assert len(found.diameter) == len(place)
        return found.position[np.argsort(-found.diameter)]

    serial, parallel = ends("serial", 1), ends("parallel", ranks)
    assert np.abs(serial - place).max() > 5e-4
    measured("places in a bed, in diameters", np.abs(serial - parallel).max() / 2.5e-3, 1e-7)


@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_gas_and_parcels_move_each_other_alike(tmp_path: Path, ranks: int, measured) -> None:
    # of all sizes, through each other and to other ranks; nothing is chaotic for so short a time
    random = np.random.default_rng(2)
    extent, number = np.array([0.02, 0.02, 0.06]), 300
    grains = Particles.of(
        extent * (0.1 + 0.8 * random.random((number, 3))),
        random.uniform(-1, 1, (number, 3)),
        diameter=np.geomspace(3e-5, 6e-4, number)[random.permutation(number)],
    )
    box = BoxCase(
        width=extent[0], depth=extent[1], height=extent[2], cells=(4, 4, 12), gas_velocity=1,
        coupled=True, solve_gas=True, end=0.005, more={f"{CONTROL}:writePrecision": 17},
    )  # fmt: skip

    def ends(name: str, ranks: int) -> tuple[np.ndarray, np.ndarray]:
        case = decomposed(box.make(tmp_path / name, grains), ranks)
        solve(case, ranks)
        if ranks > 1:
            run_program(["reconstructPar", "-latestTime"], case)
        found = read_particles(case, "0.005")
        order = np.argsort(found.diameter)
        return found.position[order], found.velocity[order]

    serial, parallel = ends("serial", 1), ends("parallel", ranks)
    middle = extent[2] / 2
    before = grains.position[np.argsort(grains.diameter)]
    assert np.count_nonzero((before[:, 2] < middle) != (serial[0][:, 2] < middle)) > 10
    for what, one, several in zip(("places, m", "speeds, m/s"), serial, parallel, strict=True):
        measured(f"{what} of two-way coupled parcels", np.abs(one - several).max(), 1e-9)


@pytest.mark.slow
def test_two_way_coupled_rows_are_alike_but_for_what_contacts_make_of_rounding(
    tmp_path: Path, measured
) -> None:
    box = BoxCase(
        width=0.02, depth=0.02, height=0.06, cells=(4, 4, 12), gas_velocity=2, end=0.3,
        contacts=Contacts(), coupled=True, solve_gas=True, tolerance=(1e-7, 1e-3),
    )  # fmt: skip
    rows = {}
    for ranks in (1, 2):
        case = decomposed(box.make(tmp_path / str(ranks)), ranks)
        add_feed(case, {**FEED, "massFlowRate": 2e-4})
        solve(case, ranks)
        rows[ranks] = pd.read_csv(case / "postProcessing/outlets/0/particles.csv", index_col="id")
        total = json.loads((case / "postProcessing/ledger.json").read_text())["total"]
        assert total["lost"]["parcels"] == 0
        measured(f"mass that is nowhere, {ranks} ranks", total["mass_closure_error"], 1e-12)
    assert rows[1]["outlet"].value_counts().min() > 100
    one, two = (rows[ranks]["outlet"].rename(str(ranks)) for ranks in (1, 2))
    both = pd.concat([one, two], axis=1)
    elsewhere = float((both["1"] != both["2"]).mean())
    measured("share of parcels that leave elsewhere", elsewhere, 0.01)


def test_a_run_goes_on_where_a_rank_has_no_parcels(tmp_path: Path) -> None:
    # the gas had settled before the first of them, on all ranks
    box = BoxCase(
        width=0.02, depth=0.02, height=0.06, cells=(4, 4, 12), gas_velocity=2,
        coupled=True, solve_gas=True, end=0.005, interval=0.005,
        more={f"{PLAN}:convergeGas": "auto"},
    )  # fmt: skip
    case = box.make(tmp_path / "case")
    add_feed(case, FEED)
    change(case, {f"{DECOMPOSITION}:numberOfSubdomains": 2, f"{DECOMPOSITION}:coeffs/n": [2, 1, 1]})
    assert "gas settled" in solve(case, 2)
    run_program(["reconstructPar", "-latestTime"], case)
    assert (read_particles(case, "0.005").position[:, 0] < 0.01).all()

    change(case, {f"{CONTROL}:endTime": 0.01})
    times = re.findall(r"elutria: time (\S+)", solve(case, 2))
    assert float(times[0]) == pytest.approx(0.006)
    assert float(times[-1]) == pytest.approx(0.01)


CELL = 5e-3
"""m, side of the cells in which solids are spread."""


def shares_of_axis(place: np.ndarray, half: float, cells: int, periodic: bool) -> np.ndarray:
    """Part of [place - half, place + half] (m) in each cell along an axis, shape (n, cells). What
    lies beyond a wall stays inside."""
    low = CELL * np.arange(cells)
    parts = np.zeros((len(place), cells))
    for shift in (-CELL * cells, 0, CELL * cells) if periodic else (0,):
        at = place[:, None] + shift
        common = np.minimum(at + half, low + CELL) - np.maximum(at - half, low)
        parts += np.maximum(common, 0)
    return np.asarray(parts / parts.sum(axis=1, keepdims=True))


@pytest.mark.parametrize(
    "ranks", [1, 4, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 8))]
)
@pytest.mark.parametrize("periodic", [False, True], ids=["walls", "periodic"])
def test_solids_are_spread_over_cells_of_all_ranks(
    tmp_path: Path, periodic: bool, ranks: int, measured
) -> None:
    cells, diameter = (4, 4, 12), 4e-3
    place = np.random.default_rng(1).random((60, 3)) * CELL * np.array(cells)
    resting = {
        "width": 0.02, "depth": 0.02, "height": 0.06, "cells": cells, "gravity": 0,
        "forces": {}, "step": 1e-3, "end": 1e-3, "most_solids": 0.99,
        "more": {f"{CONTROL}:writePrecision": 15}, **(PERIODIC if periodic else CLOSED),
    }  # fmt: skip

    def solids(name: str, kernel: float, ranks: int) -> np.ndarray:
        box = BoxCase(**resting, kernel=kernel)
        case = box.make(tmp_path / name, Particles.of(place, 0, diameter=diameter))
        solve(decomposed(case, ranks), ranks)
        if ranks > 1:
            run_program(["reconstructPar", "-latestTime"], case)
        return read_gas(case, "0.001", "alpha.particles").ravel()

    # each a cube of its volume: its part in a cell is a product over the axes
    volume = np.pi / 6 * diameter**3
    x, y, z = (
        shares_of_axis(place[:, axis], volume ** (1 / 3) / 2, cells[axis], periodic)
        for axis in range(3)
    )
    exact = np.einsum("pi,pj,pk->kji", x, y, z).ravel() * volume / CELL**3
    measured("solids by overlap", np.abs(solids("overlap", 0, ranks) - exact).max(), 1e-12)
    if ranks > 1:
        smooth, serial = (solids(f"smooth{n}", CELL, n) for n in (ranks, 1))
        assert np.abs(serial - exact).max() > 0.01
        measured("solids smoothed, and serial", np.abs(smooth - serial).max(), 1e-12)
