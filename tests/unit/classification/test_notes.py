"""What follows from a run's tables as warnings."""

from __future__ import annotations

import numpy as np
import pytest

from elutria.classification.classify import classify
from elutria.classification.notes import absent, inside
from tests.support.synthetic import synthetic


def test_what_did_not_leave_is_said() -> None:
    run = synthetic(5.0, ["quartz"])
    tables = classify(run, 5.0, 1.0)
    assert inside(tables.partition) == []
    assert tables.summary[0]["warnings"] == 0
    hovering = (run.events.diameter > 480e-6) & (run.events.diameter < 520e-6)
    run.events.outlet[hovering] = "inside"
    tables = classify(run, 5.0, 1.0, 2)
    (warning,) = tables.notes
    assert warning.name == "inside"
    assert "still in the column" in warning.what
    assert "drainTime" in warning.what_to_set
    # half of ln(520/480)
    shift = float(warning.how_much.split("shift by up to ")[1].split(" %")[0])
    assert shift == pytest.approx(4, abs=0.6)
    assert [row["warnings"] for row in tables.summary] == [3, 3]


def test_a_size_that_the_curve_does_not_reach_is_said() -> None:
    run = synthetic(5.0, ["quartz"])
    tables = classify(run, 5.0, 1.0)
    assert absent(tables.summary, tables.curves) == []
    run.events.outlet[::2] = "coarse"  # a bypass of a half
    tables = classify(run, 5.0, 1.0)
    assert np.isnan(tables.summary[0]["d25_m"])
    (warning,) = absent(tables.summary, tables.curves)
    assert warning.what.startswith("the curve of quartz has no d25")
    assert "100 % of 3000 um" in warning.how_much
    finest = 100 * tables.curves[0]["partition_to_coarse"]
    said = float(warning.how_much.split("left, ")[1].split(" %")[0])
    assert said == pytest.approx(finest, rel=1e-2)
    assert finest > 25
    (warning,) = absent(tables.summary, tables.curves, "heavy")
    assert warning.how_much.endswith("go to heavy")
