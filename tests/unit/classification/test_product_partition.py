"""Any number of products: their tables, and which one the curve is of."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from elutria import tables
from elutria.classification.classify import classify
from elutria.classification.events import Account, Events, Run, join, read_run
from elutria.errors import InputError
from elutria.files import read_csv
from elutria.openfoam.dictionary import set_entry

NAMES = ["dust", "light", "heavy"]


def three(number: int, partition_to: str = "heavy") -> Run:
    """Of even log sizes; to dust with 1 - T(d/0.4 mm), of the rest to heavy with T(d/mm)."""
    random = np.random.default_rng(5)
    diameter = 10 ** random.uniform(-4, -2.5, number)
    to_dust = random.random(number) > 1 / (1 + (diameter / 4e-4) ** -6)
    to_heavy = random.random(number) < 1 / (1 + (diameter / 1e-3) ** -6)
    outlet = np.where(to_dust, "dust", np.where(to_heavy, "heavy", "light")).astype(object)
    outlet[::50] = "inside"
    events = Events(
        material=np.full(number, "ore"),
        outlet=pd.Categorical(outlet, [*NAMES, "inside"]),
        diameter=diameter,
        density=np.full(number, 4000.0),
        number=1e-12 / diameter**3,
        time=np.linspace(0, 1, number),
        partition_to=partition_to,
    )
    none = (0.0, 0.0)
    account = Account((number, events.mass.sum()), dict.fromkeys(NAMES, none), none, none)
    return Run(events, {"ore": account, "all": account})


def test_each_product_has_its_share_of_each_size() -> None:
    run = three(20_000)
    result = classify(run, 5.0, 1.0)
    rows = [row for row in result.product_partition if row["material"] == "all"]
    assert [row["product"] for row in rows[:3]] == NAMES
    for one in (row for row in result.partition if row["material"] == "all"):
        own = [row for row in rows if row["diameter_low_m"] == one["diameter_low_m"]]
        mass = [row["product_kg"] for row in own]
        assert sum(mass) == pytest.approx(one["fines_kg"] + one["coarse_kg"])
        assert sum(row["partition"] for row in own) == pytest.approx(1)
        assert own[-1]["cumulative"] == pytest.approx(1)
        assert own[1]["cumulative"] == pytest.approx((mass[0] + mass[1]) / sum(mass))
        # the curve of the last product
        assert mass[2] == one["coarse_kg"]
        same = {"partition": "partition_to_coarse", "ci_low": "ci_low", "ci_high": "ci_high"}
        for name, other in same.items():
            assert own[2][name] == pytest.approx(one[other], abs=1e-12)
        # what was drawn: outside of the interval in one class of twenty
        size = one["diameter_m"]
        dust = 1 / (1 + (size / 4e-4) ** 6)
        assert own[0]["ci_low"] - 0.04 < dust < own[0]["ci_high"] + 0.04


def test_the_cut_is_that_of_the_product_asked_for() -> None:
    heavy = classify(three(20_000), 5.0, 1.0).summary[0]
    assert heavy["d50_m"] == pytest.approx(1e-3, rel=0.02)
    dust = classify(three(20_000, "dust"), 5.0, 1.0)
    left = three(20_000).events
    mass = left.mass[left.has_left].sum()
    own = left.mass[left.outlet == "dust"].sum()
    assert dust.summary[0]["fines_yield"] == pytest.approx(1 - own / mass)


def test_replicates_keep_their_products() -> None:
    both = join([three(500, "light"), three(500, "light")])
    assert both.events.products == NAMES
    assert both.events.partition_to == "light"
    assert len(both.events) == 1000


def test_the_table_is_written(tmp_path: Path) -> None:
    classify(three(2_000, "light"), 5.0, 1.0).write(tmp_path)
    rows = read_csv(tmp_path / "product_partition.csv", tables.PRODUCT_PARTITION)
    assert {row["product"] for row in rows} == set(NAMES)


@pytest.fixture
def finished(column: Path, fake_solver: Path) -> Path:
    assert not fake_solver.exists()
    set_entry(column / "system/simulationParameters", "particles", "1000", column)
    subprocess.run(["elutriaFoam"], cwd=column, check=True, capture_output=True)
    return column


def test_products_and_their_curve_are_read_from_the_ledger(finished: Path) -> None:
    path = finished / "postProcessing/ledger.json"
    ledger = json.loads(path.read_text())
    assert read_run(finished).events.partition_to == "coarse"
    ledger["partition_to"] = "fines"
    path.write_text(json.dumps(ledger))
    events = read_run(finished).events
    assert events.products == ["fines", "coarse"]
    assert np.array_equal(events.is_coarse, np.asarray(events.outlet == "fines"))
    ledger["partition_to"] = "nowhere"
    path.write_text(json.dumps(ledger))
    with pytest.raises(InputError, match="partition_to: nowhere; allowed: fines, coarse"):
        read_run(finished)
