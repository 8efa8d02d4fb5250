"""The ledger of the default column closes, and the same seed gives the same files."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from elutria_validation.chapters.budgets import LEDGER_ALLOWED, ledger_errors
from elutria_validation.harness.cases import CONTROL, change, solve
from elutria_validation.harness.programs import project_root, run_program


@pytest.fixture(scope="module")
def short_column(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The default column, the first 200 particles at 10 m/s, run twice."""
    runs = []
    for name in ("first", "second"):
        case = tmp_path_factory.mktemp("column") / name
        column = project_root() / "cases/column"
        for folder in ("0.orig", "constant", "system"):
            shutil.copytree(
                column / folder, case / folder, ignore=shutil.ignore_patterns("polyMesh")
            )
        change(
            case,
            {
                "system/simulationParameters:particles": 200,
                "system/simulationParameters:feedTime": 0.05,
                "system/simulationParameters:gasVelocity": 10,
                "system/simulationParameters:drainTime": 0.4,
                f"{CONTROL}:writeInterval": 0.05,
            },
        )
        shutil.copytree(case / "0.orig", case / "0")
        run_program(["blockMesh"], case)
        solve(case)
        runs.append(case)
    return runs


def test_ledger_of_the_default_column_closes(short_column: list[Path], measured) -> None:
    for (name, kind), error in ledger_errors(short_column[0]).items():
        measured(f"{name}: {kind} that is missing over the feed", error, LEDGER_ALLOWED[kind])
    ledger = json.loads((short_column[0] / "postProcessing/ledger.json").read_text())
    assert ledger["total"]["injected"]["parcels"] == 200
    assert ledger["total"]["outlets"]["fines"]["parcels"] > 50


def test_the_same_seed_gives_the_same_files(short_column: list[Path]) -> None:
    tables = [list((run / "postProcessing/outlets").rglob("particles.csv")) for run in short_column]
    (first,), (second,) = tables
    assert first.read_bytes().count(b"\n") > 50
    assert first.read_bytes() == second.read_bytes()
    for name in ("inside.csv", "ledger.json"):
        one, other = (run / "postProcessing" / name for run in short_column)
        assert one.read_bytes() == other.read_bytes()
