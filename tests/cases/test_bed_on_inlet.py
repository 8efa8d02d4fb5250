"""Spheres that lie on the inlet feel the gas that comes in, as those above them do."""

from __future__ import annotations

from pathlib import Path

import pytest

from elutria_validation.chapters.bed import GIDASPOW, held_bed


@pytest.mark.parametrize("velocity", [0.1, 1.0])
def test_the_gas_is_as_fast_in_the_lowest_layer(tmp_path: Path, velocity: float) -> None:
    bed = held_bed(tmp_path / "case", 1e-3, 0.4, velocity, GIDASPOW, free=0)
    assert bed.speeds[:12] == pytest.approx([velocity / 0.4] * 12, rel=0.01)
