"""Each word of stock's cloud dictionaries, on a tiny case: as stock, or refused by name."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import MODELS, add_feed, solve, uniform
from tests.support.stock_words import PAGE, WORDS, Word, make, page, row, tried


@pytest.mark.slow
def test_every_word_of_stocks_dictionaries(tmp_path: Path) -> None:
    """The page of the manual says what came of each; none is taken and then not done."""
    found = {}
    for number, word in enumerate(WORDS):
        found[word] = tried(word, tmp_path / str(number))
    silent = [f"{word.kind} {word.name}: {outcome}" for word, outcome in found.items()
              if not outcome.sound]  # fmt: skip
    assert not silent, "\n".join(silent)
    assert PAGE.read_text() == page(found)


@pytest.mark.parametrize("word", WORDS, ids=lambda word: f"{word.kind} {word.name}")
def test_the_page_has_every_word(word: Word) -> None:
    assert f"| {row(word)} |" in PAGE.read_text()


STICK: Any = {"type": "stick", "e": 0.5, "mu": 0, "writeToFile": True}
STUCK = Word(
    "patch interaction", "stick",
    {f"{MODELS}/patchInteractionModel": "standardWallInteraction",
     f"{MODELS}/standardWallInteractionCoeffs": STICK},
    gas_velocity=0,
)  # fmt: skip


def test_fates_of_parcels_are_told_as_by_stock(tmp_path: Path) -> None:
    """At each patch, in the log of the last time and in the model's file, line by line."""
    told, lines = {}, {}
    for solver in ("DPMFoam", "elutriaFoam"):
        case = make(STUCK, tmp_path / solver, contacts=False)
        log = solve(case, solver=solver)
        told[solver] = re.findall(
            r"- (?:escape|stick) +[^\n]*= (\d+),", log.rpartition("Cloud:")[2]
        )
        (file,) = (case / "postProcessing").rglob("standardWallInteraction*.dat")
        lines[solver] = len(file.read_text().splitlines())
    assert sum(map(int, told["DPMFoam"])) == 9
    assert told["elutriaFoam"] == told["DPMFoam"]
    assert lines["elutriaFoam"] == lines["DPMFoam"]


def test_the_feed_is_in_stocks_totals(tmp_path: Path) -> None:
    case = BoxCase(gas_velocity=2, cells=(2, 2, 3), end=0.02).make(tmp_path / "case")
    add_feed(case, {"loading": 0.1, "materials": uniform(2650, 1e-3, 1.1e-3)})
    log = solve(case)
    added, mass = re.findall(r"- (?:parcels added|mass introduced) += (\S+)", log)
    injected = json.loads((case / "postProcessing/ledger.json").read_text())["total"]["injected"]
    assert int(added) == injected["parcels"] > 0
    assert float(mass) == pytest.approx(injected["mass_kg"], rel=1e-5)
