"""Who looks after lost, stuck and hidden particles sees them."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from elutria_validation.benchmarks import containment
from elutria_validation.chapters.budgets import LEDGER_ALLOWED
from elutria_validation.harness.box import CLOSED, BoxCase
from elutria_validation.harness.clearance import watch
from elutria_validation.harness.job import Job
from elutria_validation.harness.particles import Particles, write_particles

RADIUS = 1e-3  # m
FLIES, LIES, HANGS, LEANS, HIDES = range(5)
PLACES = np.array(
    [
        (0.03, 0.03, 0.03),
        (0.05, 0.05, RADIUS),
        (0.07, 0.07, 0.05),
        (0.05, 0.05 + 2 * RADIUS, RADIUS),  # at the one that lies
        (0.02, 0.07, 0.95 * RADIUS),
    ]
)
PLATE = np.array([[(0.06, 0.06, 0.051), (0.08, 0.06, 0.051), (0.07, 0.09, 0.051)]])


def test_who_hangs_and_who_is_in_a_wall_is_seen(tmp_path: Path) -> None:
    case = BoxCase(**CLOSED).make(tmp_path / "case")
    for time, way in (("0.5", 0), ("1", 5 * RADIUS)):
        places = PLACES.copy()
        places[FLIES, 0] += way
        write_particles(case, Particles.of(places, diameter=2 * RADIUS), time)
    found = watch(case, ["0.5", "1"])
    assert found.particles == 2 * len(PLACES)
    assert found.hanging == 1
    assert found.deepest == pytest.approx(0.05, rel=1e-6)
    # a surface just above the one that hangs: it rests there
    assert watch(case, ["0.5", "1"], [PLATE]).hanging == 0


@pytest.mark.slow
def test_nobody_is_lost_in_the_classifiers(
    tmp_path: Path, measured: Callable[[str, float, float], None]
) -> None:
    """`elutria bench containment` with few parcels; a million of them is the same call."""
    containment.run(
        Job(tmp_path, quick=True), containment.Options(200, ",".join(containment.CASES))
    )
    with (tmp_path / "containment.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["case"] for row in rows] == list(containment.CASES)
    for row in rows:
        assert int(row["lost"]) == 0
        assert int(row["left"]) + int(row["inside"]) == int(row["parcels"])
        measured(f"{row['case']}: number", float(row["number_error"]), LEDGER_ALLOWED["number"])
        measured(f"{row['case']}: mass", float(row["mass_error"]), LEDGER_ALLOWED["mass_kg"])
        measured(f"{row['case']}: deepest", float(row["deepest"]), 0.01)
        measured(f"{row['case']}: hanging", int(row["hanging"]), 0)
