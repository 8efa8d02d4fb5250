"""The runs that are delivered, and how `elutria bench price` makes them anew."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from elutria.estimates import machine
from elutria.running.worker import Job as Run
from elutria_validation.benchmarks import price as bench
from elutria_validation.harness.job import Job
from tests.unit.estimates.test_price import PLAN


def made(folder: Path, slow: float, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """delivered.json of a machine that takes `slow` times the reference's time, always."""

    def perform(run: Run) -> None:
        run.folder.mkdir(parents=True)
        paid = {"processor_s": 10 * slow, "memory_mb": 145.0, "disk_mb": 6.0}
        (run.folder / "finished.json").write_text(json.dumps(paid))

    monkeypatch.setenv("ELUTRIA_CACHE", str(folder / "cache"))
    monkeypatch.setattr(machine, "_timed", lambda _: slow * machine.REFERENCE_S)
    monkeypatch.setattr(bench, "perform", perform)
    monkeypatch.setattr(bench, "plans", lambda *_: [PLAN])
    bench.run(Job(folder, quick=True, say=lambda _: None), bench.Options(particles=200))
    found: dict[str, Any] = json.loads((folder / "delivered.json").read_text())
    return found


def test_a_machine_twice_as_slow_delivers_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual, slow = (made(tmp_path / str(s), s, monkeypatch) for s in (1.0, 2.0))
    assert [run["processor_s"] for run in usual["runs"]] == pytest.approx([10.0])
    assert slow["runs"] == usual["runs"]
    assert slow["provenance"]["probe_s"] == pytest.approx([2 * machine.REFERENCE_S])
    assert {"made", "processor", "command", "commit"} <= set(slow["provenance"])


def test_what_is_delivered_says_how_it_was_made() -> None:
    kept = json.loads(files("elutria.estimates").joinpath("delivered.json").read_text())
    assert {"made", "command", "probe_s"} <= set(kept["provenance"])
    assert machine.delivered(1.0)
