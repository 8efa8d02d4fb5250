"""What a case lets one expect: orders of magnitude from closed forms, before anything is run."""

from __future__ import annotations

from math import isnan
from pathlib import Path

import pytest

from elutria.case.case import Case
from elutria.estimates.scene import Scene, block_mesh_box, expect
from elutria.openfoam.dictionary import set_entry


def scene(case: Path) -> Scene:
    column = Case(case)
    return expect(column, column.velocity(), column.gas(), column.feed(), block_mesh_box(column))


def test_the_box_of_the_default_case(column: Path) -> None:
    box = block_mesh_box(Case(column))
    assert box is not None
    assert box.size == pytest.approx([0.05, 0.05, 0.5])
    assert (box.smallest_cell, box.largest_cell) == pytest.approx((5e-3, 5e-3))


def test_rates_follow_from_loading_and_gas(column: Path) -> None:
    expected = scene(column)
    assert expected.feed_rate == pytest.approx(0.2 * 1.2 * 6 * 0.05**2)
    assert 5_000 < expected.particle_rate < 20_000
    assert expected.shortest_relaxation < 0.3 < expected.longest_relaxation


def test_a_thin_feed_meets_nobody_and_leaves_the_gas_alone(column: Path) -> None:
    before = scene(column)
    set_entry(column / "system/simulationParameters", "loading", "0.0002")
    thin = scene(column)
    for name in ("collisions", "gas_change", "solids_fraction", "inside"):
        assert getattr(thin, name) == pytest.approx(getattr(before, name) / 1000, rel=1e-6)
    assert thin.shortest_relaxation == before.shortest_relaxation


def test_without_a_block_mesh_the_column_is_not_known(column: Path) -> None:
    (column / "system/blockMeshDict").unlink()
    expected = scene(column)
    assert isnan(expected.inside)
    assert expected.fastest_fall > 0
