"""What follows from a run's tables as warnings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elutria.classification.classify import classify
from elutria.classification.events import read_run
from elutria.classification.notes import absent
from elutria.files import write_csv, write_json
from elutria.tables import EVENTS
from tests.support.synthetic import synthetic


def test_what_did_not_leave_is_said() -> None:
    run = synthetic(5.0, ["quartz"])
    tables = classify(run, 5.0, 1.0)
    assert tables.notes == []
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
    run.events.outlet[run.events.diameter > 480e-6] = "inside"  # no cut, and none that shifts
    (warning, _) = classify(run, 5.0, 1.0).notes
    assert "d50" not in warning.how_much


@pytest.mark.parametrize(
    "over, entry", [(2.5, "drainTime"), (2.6, "endTime"), (None, "endTime"), ("", "drainTime")]
)
def test_what_ended_a_run_is_what_is_to_be_increased(
    tmp_path: Path, over: float | str | None, entry: str
) -> None:
    """`over`: when feed and drain time end, as the plan says it; "" without a plan."""
    folder = tmp_path / "postProcessing"
    (folder / "outlets/0").mkdir(parents=True)
    one = {"parcels": 1, "number": 1, "mass_kg": 1}
    none = dict.fromkeys(one, 0)
    account = {"injected": one, "outlets": {"fines": none, "coarse": none}, "inside": one,
               "lost": none, "mass_closure_error": 0}  # fmt: skip
    ledger = {"time_s": 2.5, "seed": 1, "partition_to": "coarse", "total": account}
    write_json(folder / "ledger.json", {**ledger, "materials": {"quartz": account}})
    write_csv(folder / "outlets/0/particles.csv", EVENTS, [])
    row = dict.fromkeys(EVENTS, 1.0) | {"outlet": "inside", "material": "quartz", "id": 0}
    row |= {"diameter_m": (6 / 2650 / np.pi) ** (1 / 3), "density_kg_m3": 2650.0}
    write_csv(folder / "inside.csv", EVENTS, [row])
    if over != "":
        write_json(folder / "plan.json", {"feed": {"run_ends_s": over}})
    (warning, *_) = classify(read_run(tmp_path), 5.0, 1.0).notes
    assert warning.name == "inside"
    assert warning.what_to_set.startswith(f"increase {entry} of ")


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
