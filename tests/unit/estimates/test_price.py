"""The price of a run: from its plan alone, and from runs that were made."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from elutria.estimates import machine
from elutria.estimates.price import (
    Price,
    Spent,
    amount,
    duration,
    in_words,
    model,
    price,
    spent,
    work,
)

PLAN: dict[str, Any] = {
    "mesh": {"cells": 10000, "volume_m3": 1e-3},
    "gas": {
        "superficial_m_s": 5.0, "through_time_s": 0.1, "changes_at": 0.01,
        "by_itself": {"what": "not known yet", "why": "it settles first"},
    },
    "drag": {"forces": ["SchillerNaumannDrag"]},
    "feed": {"parcels": 5000, "start_s": 0, "end_s": 1, "run_ends_s": 7},
    "expected": {
        "loading": 0.2, "gas_change": 0.03, "collisions": 0.13, "shortest_relaxation_s": 0.15,
    },
    "step": {
        "first_s": 0.004, "adjusts": True, "courant": 4.0, "largest_courant": 4,
        "largest_by_collisions_s": 0.03,
    },
}  # fmt: skip


def plan(**feed_or_expected: float) -> dict[str, Any]:
    changed = deepcopy(PLAN)
    for name, value in feed_or_expected.items():
        part = next(part for part in ("feed", "expected", "mesh", "gas") if name in changed[part])
        changed[part][name] = value
    return changed


def test_the_work_is_counted() -> None:
    done = work(PLAN)
    assert done.steps == pytest.approx(7 / 0.004)
    assert done.moved == pytest.approx(5000 * 0.8 / 0.004)
    assert work(plan(gas_change=0.005)).solved == 0  # the gas rests
    dense = work(plan(gas_change=0.9))
    assert dense.solved == pytest.approx(10000 * (20 + (0.35 * 1.8 + 0.1 * 5.2) / 0.004))
    heavy = work(plan(parcels=200))
    assert heavy.solved == pytest.approx(10000 * (20 + heavy.steps)), "around each parcel"
    assert work(plan(parcels=300)).solved == work(PLAN).solved
    assert work(plan(shortest_relaxation_s=0.001)).moved == done.moved, "its flight is exact"


def test_more_of_anything_costs_more() -> None:
    usual = price(PLAN, 1.0)
    for dearer in (plan(parcels=10000), plan(cells=20000), plan(gas_change=0.3)):
        assert price(dearer, 1.0).processor_s > usual.processor_s
    assert price(PLAN, 2.0).processor_s == pytest.approx(2 * usual.processor_s)


def test_a_plan_in_which_little_is_known_has_a_price() -> None:
    unknown = plan()
    unknown["gas"].update(superficial_m_s=None, through_time_s=None)
    unknown["expected"] = dict.fromkeys(unknown["expected"])
    unknown["feed"]["parcels"] = None
    unknown["step"]["largest_by_collisions_s"] = None
    assert price(unknown, 1.0).processor_s > 0


@pytest.mark.parametrize("fed", [1.0, None])
def test_a_run_that_does_not_say_when_it_ends_has_a_price(fed: float | None) -> None:
    endless = plan()
    endless["feed"].update(end_s=fed, run_ends_s=None)
    seconds = price(endless, 1.0).processor_s
    assert 0 < seconds < price(PLAN, 1.0).processor_s, "the last ones are not waited for"


def test_a_run_that_was_made_tells_what_the_same_costs() -> None:
    known = spent(PLAN, 30.0, 200.0, 8.0)
    found = price(PLAN, 1.0, [known])
    assert (found.processor_s, found.memory_mb, found.disk_mb) == pytest.approx((30, 200, 8))
    more = price(plan(parcels=10000), 1.0, [known]).processor_s
    ratio = model(work(plan(parcels=10000))) / model(work(PLAN))
    assert more == pytest.approx(30 * ratio)


def test_gas_that_may_never_be_steady_has_a_price_until_a_run_is_known() -> None:
    first = price(PLAN, 1.0)
    assert first.unsteady_s > 10 * first.processor_s
    asked = "; 8.9 min of processor where the gas is never steady"
    assert in_words(Price(14, 14, 240, 6, unsteady_s=520), 1).endswith(asked)
    assert "steady" not in in_words(Price(14, 14, 240, 6, unsteady_s=10), 1)
    assert price(PLAN, 1.0, [spent(PLAN, 30.0, 1, 1)]).unsteady_s == 0
    known = deepcopy(PLAN)
    known["gas"]["by_itself"]["what"] = "solved on every step"
    assert price(known, 1.0).unsteady_s == 0
    assert (first + first).unsteady_s == 2 * first.unsteady_s


def test_near_runs_say_more_than_far_ones_and_other_meshes_nothing() -> None:
    near, far = plan(loading=0.25), plan(loading=5.0)
    known = [spent(near, 10.0, 1, 1), spent(far, 1000.0, 1, 1)]
    ratios = [run.processor_s / run.model_s for run in known]
    found = price(PLAN, 1.0, known).processor_s / model(work(PLAN))
    assert ratios[0] < found < 1.3 * ratios[0] < ratios[1]
    other = spent(plan(cells=20000), 1e6, 1, 1)
    assert price(PLAN, 1.0, [other]) == price(PLAN, 1.0)


def test_runs_at_a_time_take_the_time_of_the_longest_at_least() -> None:
    cost = Price(10, 10, 100, 1) + Price(30, 30, 200, 2)
    assert (cost.processor_s, cost.memory_mb, cost.disk_mb, cost.runs) == (40, 200, 3, 2)
    assert (cost.wall_s(1), cost.wall_s(2), cost.wall_s(100)) == (40, 30, 30)


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.123, "0.12 s"), (35.4, "35 s"), (89, "89 s"), (252, "4.2 min"),
                          (5400, "1.5 h"), (float("nan"), "?")],
)  # fmt: skip
def test_times_in_words(seconds: float, text: str) -> None:
    assert duration(seconds) == text


def test_a_price_in_words() -> None:
    words = in_words(Price(250, 30, 240, 1300, 12), 2)
    assert words == (
        "12 runs: 4.2 min of processor, 2.1 min with 2 at a time, 480 MB of memory, 1.3 GB of disk"
    )
    assert in_words(Price(20, 20, 240, 6), 4) == (
        "1 run: 20 s of processor, 20 s, 240 MB of memory, 6 MB of disk"
    )
    assert amount(1240) == "1.2 GB"


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("ELUTRIA_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_the_machine_is_measured_once(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = machine.slowness()
    assert first > 0
    monkeypatch.setattr(machine, "_timed", None)
    assert machine.slowness() == first
    assert (cache / "machine.json").is_file()


def test_runs_are_remembered_and_a_spoilt_line_is_passed_over(cache: Path) -> None:
    run = spent(PLAN, 30.0, 200.0, 8.0)
    machine.keep(run)
    with (cache / "spent.jsonl").open("a") as file:
        file.write('{"key": 1}\nrubbish\n')
    machine.keep(run)
    known = machine.finished(machine.slowness())
    assert [known_run.key for known_run in known] == [run.key, run.key]
    assert [known_run.processor_s for known_run in known] == pytest.approx([30, 30])


@pytest.mark.usefixtures("cache")
def test_runs_are_known_to_other_machines_by_what_they_would_take_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nodes of a cluster share a home: what took 30 s on one takes 60 s on one half as fast."""
    monkeypatch.setattr(machine, "_timed", lambda _: machine.REFERENCE_S)
    machine.keep(spent(PLAN, 30.0, 200.0, 8.0))
    monkeypatch.setattr(machine.platform, "node", lambda: "another")
    monkeypatch.setattr(machine, "_timed", lambda _: 2 * machine.REFERENCE_S)
    assert machine.expected([PLAN])[0].processor_s == pytest.approx(60)


@pytest.mark.usefixtures("cache")
def test_runs_made_here_say_more_than_delivered_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "slowness", lambda: 3.0)
    once, thrice = machine.delivered(1.0), machine.delivered(3.0)
    assert once
    assert [run.processor_s for run in thrice] == pytest.approx([3 * r.processor_s for r in once])
    monkeypatch.setattr(machine, "delivered", lambda _: [spent(PLAN, 500.0, 1, 1)])
    assert machine.expected([PLAN])[0].processor_s == pytest.approx(500)
    machine.keep(spent(PLAN, 20.0, 1, 1))
    assert machine.expected([PLAN])[0].processor_s == pytest.approx(20)


def test_a_cache_that_cannot_be_written_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("ELUTRIA_CACHE", str(tmp_path / "file"))
    machine.keep(Spent("a", 1, 1, 1, 1, 1, 1, 1))
    assert machine.finished(1.0) == []
    assert machine.slowness() > 0
