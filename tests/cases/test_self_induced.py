"""A case that names no correction of the self-induced velocity has it, and no feed is needed.

Allowed is what the verification book allows of the correction.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from elutria_validation.chapters.wake import Settling


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [3, 5])
def test_a_grain_coupled_both_ways_settles_as_if_alone(
    tmp_path: Path, measured, ratio: float
) -> None:
    grain = Settling(5e-4, ratio)
    measured("slip, by default", abs(grain.error(tmp_path / "default", None)), 0.03)
    assert abs(grain.error(tmp_path / "off", False)) > 0.05, "the scene does not tell them apart"
