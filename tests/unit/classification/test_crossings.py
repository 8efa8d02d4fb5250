"""Counts at planes, against walks that are drawn and the closed form of the gambler's ruin."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from elutria import tables
from elutria.classification.crossings import (
    leave_below,
    leave_below_with_memory,
    plane_rows,
    read_counted,
    stage_rows,
    zone_rows,
)
from elutria.errors import InputError

PLANES, FIRST, UP, PARCELS = 6, 2, 0.55, 4000
SIZE, DENSITY, NUMBER = 5e-4, 2650.0, 3.0
KG = NUMBER * DENSITY * np.pi / 6 * SIZE**3


def ruin(planes: int, first: int, up: float) -> float:
    """To leave at the bottom from the plane `first` (0 is the lowest)."""
    s = (1 - up) / up
    return 1 - (1 - s ** (first + 1)) / (1 - s ** (planes + 1))


def walk(
    seed: int, after_up: float = UP, after_down: float = UP
) -> tuple[list[list[object]], list[list[object]]]:
    """Rows of crossings.csv and particles.csv: each parcel enters just below the plane FIRST, steps
    every second, and crosses some planes to and fro before it goes on. The chance of a step upwards
    is UP at first, then that after one upwards, or after one downwards."""
    random = np.random.default_rng(seed)
    crossings: list[list[object]] = []
    parcels: list[list[object]] = []
    for name in range(PARCELS):
        plane, below, time, chance = FIRST, True, 0.0, UP
        while 0 <= plane < PLANES:
            up = random.random() < chance
            chance = after_up if up else after_down
            times = int(random.integers(0, 2)) * 2 + (1 if below == up else 2)
            for k in range(times):
                direction = 1 if below == (k % 2 == 0) else -1
                crossings.append([time + 0.01 * (k + 1), plane, 0.1 * plane, direction, "quartz",
                                  name, SIZE, NUMBER])  # fmt: skip
            time, plane, below = time + 1, plane + (1 if up else -1), up
        outlet = "coarse" if plane < 0 else "fines"
        parcels.append([time, outlet, "quartz", name, SIZE, DENSITY, NUMBER, 0, 0, 0, time])
    return crossings, parcels


def written(folder: Path, walks: tuple[list[list[object]], list[list[object]]]) -> Path:
    """A run of these rows."""
    for where, columns, rows in zip(
        ("crossings/0/crossings.csv", "outlets/0/particles.csv"),
        (tables.CROSSINGS, tables.EVENTS), walks, strict=True,
    ):  # fmt: skip
        file = folder / "postProcessing" / where
        file.parent.mkdir(parents=True)
        pd.DataFrame(rows, columns=columns).to_csv(file, index=False)
    return folder


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("run"), walk(1))


@pytest.mark.parametrize("up", [0.2, 0.45, 0.7])
@pytest.mark.parametrize("planes, first", [(1, 0), (7, 3), (12, 0)])
def test_equal_stages_are_the_gamblers_ruin(up: float, planes: int, first: int) -> None:
    assert leave_below(np.full(planes, up))[first] == pytest.approx(ruin(planes, first, up))


def test_the_step_is_found_and_the_shares_follow(run: Path) -> None:
    counted = read_counted(run, "coarse")
    assert counted is not None
    (row,) = stage_rows(counted)
    assert row["parcels"] == PARCELS
    # four standard errors
    assert abs(row["step_up"] - UP) < 4 * np.sqrt(0.25 / row["steps"])
    expected = ruin(PLANES, FIRST, UP)
    error = np.sqrt(expected * (1 - expected) / PARCELS)
    assert abs(row["partition_by_stages"] - expected) < 4 * error
    assert abs(row["partition"] - expected) < 4 * error
    assert row["partition_error"] == pytest.approx(error, rel=0.1)


@pytest.mark.parametrize("planes", [1, 2, 7])
def test_without_memory_both_walks_are_one(planes: int) -> None:
    same = leave_below_with_memory(planes, {0: 0.4, 1: 0.4, -1: 0.4})
    assert same == pytest.approx(leave_below(np.full(planes, 0.4)))


def test_a_walk_that_goes_on_as_it_went_is_told_from_one_without_memory(tmp_path: Path) -> None:
    """Drawn with memory: the walk with memory says what left, that of equal stages does not."""
    counted = read_counted(
        written(tmp_path / "run", walk(2, after_up=0.8, after_down=0.35)), "coarse"
    )
    assert counted is not None
    (row,) = stage_rows(counted)
    many = 4 * np.sqrt(0.25 / (row["steps"] / 4))
    assert abs(row["step_up_after_up"] - 0.8) < many
    assert abs(row["step_up_after_down"] - 0.35) < many
    error = 4 * row["partition_error"]
    assert abs(row["partition_by_memory"] - row["partition"]) < error
    assert abs(row["partition_by_stages"] - row["partition"]) > error


def test_what_crosses_a_plane_is_what_leaves_beyond_it(run: Path) -> None:
    counted = read_counted(run, "coarse")
    assert counted is not None
    fines = float(np.sum(counted.parcels["outlet"] == "fines"))
    rows = plane_rows(counted)
    assert [row["height_m"] for row in rows] == pytest.approx(0.1 * np.arange(PLANES))
    for row in rows:
        net = fines if row["plane"] >= FIRST else fines - PARCELS
        assert row["up_number"] - row["down_number"] == pytest.approx(NUMBER * net)
        assert row["up_kg"] - row["down_kg"] == pytest.approx(KG * net)


def test_stays_add_up_to_the_time_inside(run: Path) -> None:
    counted = read_counted(run, "coarse")
    assert counted is not None
    rows = zone_rows(counted)
    assert len(rows) == PLANES + 1
    mean = counted.parcels["residence_time_s"].mean()
    assert sum(row["residence_time_s"] for row in rows) == pytest.approx(mean)
    assert sum(row["holdup_kg_s"] for row in rows) == pytest.approx(mean * PARCELS * KG)


def test_a_run_without_planes_has_none(tmp_path: Path) -> None:
    assert read_counted(tmp_path, "coarse") is None
    file = tmp_path / "postProcessing/crossings/0/crossings.csv"
    file.parent.mkdir(parents=True)
    file.write_text("time_s,plane\n")
    with pytest.raises(InputError, match=r"crossings.csv: first line must be time_s,plane,hei"):
        read_counted(tmp_path, "coarse")
