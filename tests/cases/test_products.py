"""Three products from the solver to the tables, and outlets that are refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from elutria.classification.classify import classify
from elutria.classification.events import read_run
from elutria.errors import ElutriaError
from elutria_validation.chapters.budgets import LEDGER_ALLOWED, ledger_errors
from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import add_feed, solve, uniform

PRODUCTS = {"light": ["top"], "middlings": ["east"], "heavy": ["bottom"]}


def blown(folder: Path, outlets: object, **more: object) -> Path:
    """Grains thrown across gas that rises at 2 m/s, in a box that is open to the east."""
    case = BoxCase(gas_velocity=2, height=0.2, cells=(4, 4, 8), step=2e-3, end=2).make(folder)
    plan = case / "constant/polyMesh/boundary"
    text = re.sub(
        r"(east\s*\{\s*)type\s+wall;\s*inGroups\s+[^;]*;",
        r"\1type patch; inGroups 1(outflow);",
        plan.read_text(),
    )
    assert "inGroups 1(outflow);" in text
    plan.write_text(text)
    add_feed(
        case,
        {"outlets": outlets, "massFlowRate": 1e-3, "particles": 600, "duration": 0.2,
         "parcels": "evenSizes", "velocity": [1, 0, 0], "drainTime": 1,
         "materials": uniform(2650, 5e-5, 1e-3), **more},
    )  # fmt: skip
    return case


def test_three_products(tmp_path: Path, measured) -> None:
    case = blown(tmp_path / "case", PRODUCTS)
    said = solve(case)
    assert re.search(r"elutria: time \S+ fed \d+ light \d+ middlings \d+ heavy \d+ inside", said)
    for (name, kind), error in ledger_errors(case).items():
        measured(f"{name}: {kind} missing", error, LEDGER_ALLOWED[kind])
    run = read_run(case)
    assert run.events.products == list(PRODUCTS)
    assert run.events.partition_to == "heavy"
    size = {name: np.median(run.events.diameter[run.events.outlet == name]) for name in PRODUCTS}
    assert size["light"] < size["middlings"] < size["heavy"]
    rows = classify(run, 2.0, 1.0).product_partition
    assert {row["product"] for row in rows} == set(PRODUCTS)


def test_the_curve_of_another_product(tmp_path: Path) -> None:
    case = blown(tmp_path / "case", PRODUCTS, partitionTo="middlings", particles=20)
    solve(case)
    assert read_run(case).events.partition_to == "middlings"


@pytest.mark.parametrize(
    "outlets, said",
    [
        ({"light": ["top"], "heavy": ["bottom", "top"]}, "which light has, allowed"),
        ({"light": ["top"], "heavy": []}, "heavy has no patches, allowed"),
        ({"light": ["top"], "heavy": ["floor"]}, "names the patch floor, allowed"),
        ({"light": ["top"], "inside": ["bottom"]}, "is named inside, allowed"),
        ({}, "there is no outlet, allowed"),
    ],
)
def test_outlets_that_are_refused(tmp_path: Path, outlets: object, said: str) -> None:
    case = blown(tmp_path / "case", outlets)
    with pytest.raises(ElutriaError, match=re.escape(said)):
        solve(case)


def test_an_outlet_that_is_there_twice(tmp_path: Path) -> None:
    case = blown(tmp_path / "case", PRODUCTS)
    feed = case / "constant/feed"
    feed.write_text(feed.read_text().replace("middlings", "light"))
    with pytest.raises(ElutriaError, match="outlet light is there twice, allowed"):
        solve(case)


def test_a_curve_of_no_product(tmp_path: Path) -> None:
    case = blown(tmp_path / "case", PRODUCTS, partitionTo="coarse")
    with pytest.raises(ElutriaError, match="partitionTo is coarse, allowed"):
        solve(case)
