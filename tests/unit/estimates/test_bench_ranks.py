"""`elutria bench ranks`: the constants that it draws from its rows."""

from __future__ import annotations

from dataclasses import asdict
from math import ceil, log2
from pathlib import Path

import pytest

from elutria.errors import InputError
from elutria.estimates.ranks import Shared
from elutria_validation.benchmarks.ranks import Options, measured, run
from elutria_validation.harness.job import Job

KNOWN = Shared(message=3e-6, reductions=250, uneven=1.7, start=0.2)


def row(scene: str, ranks: int) -> dict[str, object]:
    """A run that takes what KNOWN says: 12 s of gas in 80 solves, 900 exchanges."""
    solves, exchanges = 80, 900
    told = KNOWN.message * KNOWN.reductions * ceil(log2(ranks)) * solves if ranks > 1 else 0.0
    start = 0.5 + (KNOWN.start * ranks if ranks > 1 else 0.0)
    return {
        "scene": scene, "ranks": ranks, "gas_solves": solves, "start_s": start,
        "wall_s": start + 12 / ranks + told, "busiest": KNOWN.uneven if ranks > 1 else 1.0,
        "exchanges": exchanges, "exchange_s": KNOWN.message * exchanges * (ranks - 1),
    }  # fmt: skip


def test_constants_that_made_the_rows_are_found() -> None:
    scenes = ("column, frozen gas", "column, fine gas")
    rows = [row(scene, ranks) for scene in scenes for ranks in (1, 2, 4, 8, 16)]
    found = measured(rows)
    assert found is not None
    assert asdict(found) == pytest.approx(asdict(KNOWN))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (Options(ranks="2,4"), "ranks=2,4; allowed: 1 and more"),
        (Options(ranks="1,x"), "ranks=1,x; allowed"),
        (Options(scene="bet"), "scene=bet, did you mean 'bed'"),
    ],
)
def test_what_cannot_be_run_is_refused(tmp_path: Path, options: Options, said: str) -> None:
    with pytest.raises(InputError, match=said):
        run(Job(tmp_path), options)


def test_one_processor_tells_nothing() -> None:
    assert measured([row("bed", 1)]) is None
