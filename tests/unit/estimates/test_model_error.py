"""The model's error beside chance's: what the verification book found, for the case's law."""

from __future__ import annotations

import csv
from math import isnan
from pathlib import Path

import pytest

from elutria.case.case import Case, Setting
from elutria.estimates.model_error import SPHERES, model_errors

ROOT = Path(__file__).resolve().parents[3]
CLOUD = "constant/kinematicCloudProperties"


def changed(tmp_path: Path, *settings: str) -> Case:
    return Case(ROOT / "cases/column").copy_to(tmp_path / "case", map(Setting.parse, settings))


def test_it_is_what_the_book_found() -> None:
    """Of every drag law: the largest error over the nine pairs of the chapter's rows."""
    with (ROOT / "docs/verification/measured/rows.csv").open() as file:
        rows = list(csv.DictReader(file))
    found = {
        row["case"]: float(row["error"])
        for row in rows
        if row["checked"].startswith("d50, m, worst of 9") and row["case"] in SPHERES
    }
    assert found.keys() == SPHERES.keys()
    for law, error in found.items():
        assert SPHERES[law] == pytest.approx(error, abs=6e-4), law


def test_spheres_have_that_of_their_law(tmp_path: Path) -> None:
    (name,) = (one.name for one in Case(ROOT / "cases/column").feed().materials)
    case = changed(tmp_path, f"constant/feed:materials/{name}/sphericity=1")
    (law,) = case.drag_laws()
    assert model_errors(case) == {name: SPHERES[law], "all": SPHERES[law]}


def test_other_shapes_have_none_by_a_law_of_spheres(tmp_path: Path) -> None:
    (name,) = (one.name for one in Case(ROOT / "cases/column").feed().materials)
    found = model_errors(changed(tmp_path, f"constant/feed:materials/{name}/sphericity=0.8"))
    assert isnan(found[name])
    assert isnan(found["all"])


def test_a_case_that_cannot_be_read_has_none(tmp_path: Path) -> None:
    case = changed(tmp_path)
    (case.path / CLOUD).unlink()
    assert model_errors(case) == {}
