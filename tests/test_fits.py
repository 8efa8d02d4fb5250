"""Fitted constants: found again by their scripts, in the source, and good on other data."""

from __future__ import annotations

import pytest

from elutria_validation.fits import onset_weight, own_wake
from elutria_validation.fits.__main__ import all_fits
from elutria_validation.fits.constants import Fit, lines


@pytest.fixture(scope="module")
def fits() -> list[Fit]:
    return all_fits()


def test_constants_stand_in_the_source_and_hold_on_other_data(fits: list[Fit]) -> None:
    assert [name for fit in fits for name in fit.missing()] == []
    assert [fit.title for fit in fits if not fit.passes] == []
    assert "fitted today" in "\n".join(lines(fits))


def test_those_that_are_found_again(fits: list[Fit]) -> None:
    viscous, inertial, onset = (
        {one.name: (float(one.text.split()[-1]), one.fitted) for one in fit.constants}
        for fit in fits
    )
    for used, fitted in onset.values():
        assert fitted == pytest.approx(used, rel=1e-5)
    for found, tolerance in (
        (viscous["cell alone"], 0.01), (inertial["cell alone"], 0.1),
        (inertial["kernel over cell"], 0.1),
    ):  # fmt: skip
        assert found[1] == pytest.approx(found[0], rel=tolerance)


def test_a_wrong_constant_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(onset_weight, "USED", ("0.3213419", *onset_weight.USED[1:]))
    wrong = onset_weight.fit()
    assert not wrong.passes
    assert wrong.missing() == ["theta^0, size"]


def test_the_grains_of_the_fit_are_none_of_the_chapter() -> None:
    judged = {(1e-4, 1), (5e-4, 1), (2e-3, 1), (8e-4, 5e-3), (1.5e-3, 5e-3)}
    used = {(one.diameter, getattr(one, "cell", None)) for one in own_wake.GRAINS}
    assert not used & judged
    assert not {one.diameter for one in own_wake.GRAINS if hasattr(one, "ratio")} & {
        1e-4, 5e-4, 2e-3
    }  # fmt: skip
