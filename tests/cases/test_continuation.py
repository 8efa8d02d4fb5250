"""A run cut in pieces, in space (processors) or time (restart), gives what a whole run gives."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np

from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import CONTROL, add_feed, change, material, solve

FEED = {
    "massFlowRate": 2e-3,
    "particles": 400,
    "velocity": [0.2, 0, 0],
    "materials": material(2650, type="uniform", min=2e-4, max=6e-4),
}

PARCELS = {**FEED, "massFlowRate": 8e-3, "duration": 0.2, "parcels": "evenSizes"}
"""Each stands for many particles, or for a share of one, and meets others by chance."""


def column(folder: Path, feed: dict[str, object] = FEED, interval: float = 0.1) -> Path:
    box = BoxCase(gas_velocity=2, cells=(4, 4, 4), contacts=Contacts(), end=0.3, interval=interval)
    case = box.make(folder)
    add_feed(case, feed)
    return case


def run_until(case: Path, *ends: float) -> None:
    """Run the case in pieces that end at these times, s."""
    for end in ends:
        change(case, {f"{CONTROL}:endTime": end})
        solve(case)


def rows(case: Path) -> list[list[str]]:
    """All recorded rows, of every start of the run, sorted by time and number."""
    found = []
    for table in (case / "postProcessing/outlets").rglob("particles.csv"):
        found += [line.split(",") for line in table.read_text().splitlines()[1:]]
    return sorted(found, key=lambda row: (float(row[0]), int(row[3])))


def compare(one: Path, other: Path, measured, what: str) -> None:
    """The same particles left, through the same outlets; times and speeds to rounding."""
    first, second = rows(one), rows(other)
    numbers = [row[3] for row in first]
    assert len(numbers) > 100
    assert len(set(numbers)) == len(numbers)
    assert [row[1:5] for row in first] == [row[1:5] for row in second]
    values = [np.array([[float(row[i]) for i in (0, 7, 8, 9, 10)] for row in table])
              for table in (first, second)]  # fmt: skip
    measured(what, np.abs(values[0] - values[1]).max(), 1e-6)
    for case in (one, other):
        ledger = json.loads((case / "postProcessing/ledger.json").read_text())
        assert ledger["total"]["lost"]["parcels"] == 0
        left = sum(outlet["parcels"] for outlet in ledger["total"]["outlets"].values())
        assert left == len(numbers)


def test_two_processors_record_what_one_records(tmp_path: Path, measured) -> None:
    serial, parallel = (column(tmp_path / name) for name in ("serial", "parallel"))
    solve(serial)
    solve(parallel, processors=2)
    compare(serial, parallel, measured, "largest difference of a row, s and m/s")


def test_what_parcels_meet_by_chance_is_the_same_in_pieces(tmp_path: Path, measured) -> None:
    whole, parallel, parts = (
        column(tmp_path / name, PARCELS) for name in ("whole", "parallel", "parts")
    )
    log = solve(whole)
    assert float(re.findall(r"impacts +(\S+)", log)[-1]) > 200
    solve(parallel, processors=2)
    compare(whole, parallel, measured, "largest difference of a row, processors")
    run_until(parts, 0.1, 0.3)
    compare(whole, parts, measured, "largest difference of a row, restart")


def test_a_restart_goes_on_as_if_uninterrupted(tmp_path: Path, measured) -> None:
    whole, parts = (column(tmp_path / name) for name in ("whole", "parts"))
    solve(whole)
    run_until(parts, 0.1, 0.3)
    compare(whole, parts, measured, "largest difference of a row, s and m/s")


def test_the_ledger_of_many_starts_is_that_of_one(tmp_path: Path) -> None:
    whole, parts = (column(tmp_path / name, interval=0.025) for name in ("whole", "parts"))
    solve(whole)
    run_until(parts, *(0.025 * step for step in range(1, 13)))
    assert len(list((parts / "postProcessing/outlets").iterdir())) == 12
    ledgers = [(case / "postProcessing/ledger.json").read_bytes() for case in (whole, parts)]
    assert ledgers[0] == ledgers[1], "sums in another order differ in their last bits"


def test_a_restart_from_before_the_end_takes_back_what_was_recorded_later(
    tmp_path: Path, measured
) -> None:
    # as after a crash: the run had gone beyond the last time it wrote
    whole, parts = (column(tmp_path / name) for name in ("whole", "parts"))
    solve(whole)
    change(parts, {f"{CONTROL}:endTime": 0.2})
    solve(parts)
    change(parts, {f"{CONTROL}:endTime": 0.3, f"{CONTROL}:startFrom": "startTime",
                   f"{CONTROL}:startTime": 0.1})  # fmt: skip
    solve(parts)
    compare(whole, parts, measured, "largest difference of a row, s and m/s")


def test_a_feed_made_longer_goes_on_from_what_was_fed(tmp_path: Path, measured) -> None:
    # while its last parcels enter, which make the mass of the shorter feed exact
    case = column(tmp_path / "case", {**PARCELS, "duration": 0.05, "particles": 700}, 0.045)
    run_until(case, 0.045)
    before = rows(case)
    change(case, {"constant/feed:duration": 0.1, "constant/feed:particles": 1400})
    run_until(case, 0.135)
    assert rows(case)[: len(before)] == before
    total = json.loads((case / "postProcessing/ledger.json").read_text())["total"]
    assert total["injected"]["parcels"] == 1400
    assert total["lost"]["parcels"] == 0
    measured("mass fed", abs(total["injected"]["mass_kg"] / 8e-4 - 1), 1e-12)
    measured("mass that is nowhere", total["mass_closure_error"], 1e-12)
