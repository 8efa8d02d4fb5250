"""Planes that count: what crosses them is what leaves beyond."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elutria.case.case import Case, Setting
from elutria.classification.crossings import plane_rows, read_counted, stage_rows, zone_rows
from elutria.running.run import run_case
from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import CONTROL, add_feed, change, material, solve
from elutria_validation.harness.programs import project_root, run_program

LOW, HIGH = 0.15, 0.35  # m, below and above the slot of the column


def column(folder: Path, drain: float) -> Path:
    case = Case(project_root() / "cases/column").copy_to(folder / "case", [])
    feed = case.path / "constant/feed"
    feed.write_text(f"{feed.read_text()}\nplanes ({LOW} {HIGH});\n")
    settings = {"particles": 60, "feedTime": 0.2, "cellsWide": 4, "cellsDeep": 4, "cellsBelow": 10,
                "cellsSlot": 1, "cellsAbove": 10, "drainTime": drain}  # fmt: skip
    known = (case.path / "system/simulationParameters").read_text()
    chosen = [Setting("system/simulationParameters", name, str(value))
              for name, value in settings.items() if name in known]  # fmt: skip
    return run_case(case, folder / "run", chosen).path


def accounts_close(run: Path) -> None:
    counted = read_counted(run, "coarse")
    assert counted is not None
    assert counted.heights == pytest.approx([LOW, HIGH])
    weight = counted.parcels["n_particle"]
    left = {name: float(weight[counted.parcels["outlet"] == name].sum())
            for name in ("fines", "coarse")}  # fmt: skip
    assert min(left.values()) > 0
    net = np.zeros(2)
    for row in plane_rows(counted):
        net[row["plane"]] += row["up_number"] - row["down_number"]
    assert net == pytest.approx([-left["coarse"], left["fines"]], rel=1e-9)
    inside = sum(row["residence_time_s"] for row in zone_rows(counted))
    assert inside > 0
    assert all(0 <= row["partition_by_stages"] <= 1 for row in stage_rows(counted))


def test_what_crosses_a_plane_leaves_beyond_it(tmp_path: Path) -> None:
    accounts_close(column(tmp_path, 2))


FEED = {
    "massFlowRate": 2e-3, "particles": 600, "duration": 0.2, "velocity": [0.2, 0, 0],
    "planes": [0.01, 0.03, 0.05],
    "materials": material(2650, type="uniform", min=2e-4, max=6e-4),
}  # fmt: skip
"""Of a box of 0.06 m that two processors share at its middle, where a plane is."""


def box(folder: Path, **entries: object) -> Path:
    case = BoxCase(
        width=0.02, depth=0.02, height=0.06, cells=(4, 4, 12), gas_velocity=2,
        contacts=Contacts(treatment="impact"), end=0.3, interval=0.1,
    ).make(folder)  # fmt: skip
    add_feed(case, {**FEED, **entries})
    change(case, {f"{DECOMPOSITION}:numberOfSubdomains": 2, f"{DECOMPOSITION}:coeffs/n": [1, 1, 2]})
    return case


DECOMPOSITION = "system/decomposeParDict"


def counted(case: Path) -> list[list[str]]:
    """Rows of all starts, one after the other."""
    folder = case / "postProcessing/crossings"
    files = sorted(folder.glob("*/crossings.csv"), key=lambda file: float(file.parent.name))
    return [line.split(",") for file in files for line in file.read_text().splitlines()[1:]]


def walks_close(rows: list[list[str]]) -> None:
    """Who crosses a plane next crosses it back, or the one beyond: none is missed, none is there
    twice."""
    last: dict[str, tuple[int, int]] = {}
    for row in rows:
        plane, direction, parcel = int(row[1]), int(row[3]), row[5]
        if parcel in last:
            before, went = last[parcel]
            assert plane == before + (went if went == direction else 0), (parcel, row)
        last[parcel] = plane, direction
    assert len(last) > 300


def alike(one: list[list[str]], other: list[list[str]]) -> None:
    """The same crossings; their times to rounding."""
    assert [row[1:] for row in one] == [row[1:] for row in other]
    assert [float(row[0]) for row in one] == pytest.approx(
        [float(row[0]) for row in other], abs=1e-9
    )


def test_two_processors_count_what_one_counts(tmp_path: Path) -> None:
    serial, parallel = (box(tmp_path / name) for name in ("serial", "parallel"))
    solve(serial)
    solve(parallel, processors=2)
    rows = counted(serial)
    walks_close(rows)
    walks_close(counted(parallel))
    alike(rows, counted(parallel))


@pytest.mark.parametrize("ranks", [(1, 1), (2, 1), (1, 2)], ids=str)
def test_a_restart_counts_on(tmp_path: Path, ranks: tuple[int, int]) -> None:
    whole, parts = (box(tmp_path / name) for name in ("whole", "parts"))
    solve(whole)
    change(parts, {f"{CONTROL}:writeFormat": "binary"})
    for number, end in zip(ranks, (0.1, 0.3), strict=True):
        change(parts, {f"{CONTROL}:endTime": end})
        solve(parts, number)
        if number > 1:
            run_program(["reconstructPar", "-latestTime"], parts)
    walks_close(counted(parts))
    alike(counted(whole), counted(parts))


def test_a_restart_from_before_forgets_what_was_counted_later(tmp_path: Path) -> None:
    whole, parts = (box(tmp_path / name) for name in ("whole", "parts"))
    solve(whole)
    for start, end in ((0, 0.2), (0.1, 0.3)):
        change(parts, {f"{CONTROL}:endTime": end, f"{CONTROL}:startFrom": "startTime",
                       f"{CONTROL}:startTime": start})  # fmt: skip
        solve(parts)
    alike(counted(whole), counted(parts))


@pytest.mark.parametrize(
    ("planes", "words"),
    [([0.03, 0.01], "planes has 0.01 after 0.03"), ([0.001 * k for k in range(201)], "200")],
)
def test_planes_that_cannot_be(tmp_path: Path, planes: list[float], words: str) -> None:
    case = box(tmp_path / "case", planes=planes)
    with pytest.raises(Exception, match=words):
        solve(case)
