"""How many processors a run is given: never more than are faster."""

from __future__ import annotations

import os
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from elutria.errors import InputError
from elutria.estimates import ranks
from elutria.estimates.price import model, work
from elutria.estimates.ranks import Choice, paying, run_s
from tests.unit.estimates.test_price import PLAN


def plan(cells: float, parcels: float, gas_change: float = 0.03) -> dict[str, Any]:
    changed = deepcopy(PLAN)
    changed["mesh"]["cells"] = cells
    changed["feed"]["parcels"] = parcels
    changed["expected"]["gas_change"] = gas_change
    return changed


SMALL, LARGE = plan(400, 300), plan(4e6, 1e6, 0.3)


def test_one_processor_takes_what_a_run_is_expected_to_cost() -> None:
    for case in (PLAN, SMALL, LARGE):
        assert run_s(case, 1) == pytest.approx(model(work(case)))


@pytest.mark.parametrize("case", [PLAN, SMALL, LARGE], ids=["column", "small", "large"])
@pytest.mark.parametrize("asked", [1, 2, 5, 8, 64, 1000])
@pytest.mark.parametrize("cores", [1, 2, 16, 1024])
def test_no_number_up_to_the_one_asked_for_is_faster(
    case: dict[str, Any], asked: int, cores: int
) -> None:
    chosen = paying(case, asked, cores)
    assert 1 <= chosen.np <= min(asked, cores)
    allowed = range(1, min(asked, cores) + 1)
    assert run_s(case, chosen.np) == min(run_s(case, np) for np in allowed)
    assert (chosen.why == "") == (chosen.np == asked)
    assert paying(case, chosen.np, cores) == Choice(chosen.np)


def test_a_small_run_takes_one_and_a_large_one_all() -> None:
    assert paying(SMALL, 8, 16).np == 1
    assert paying(LARGE, 16, 16) == Choice(16)
    assert run_s(LARGE, 16) < run_s(LARGE, 1) / 8


def test_the_line_has_the_numbers() -> None:
    line = paying(SMALL, 8, 4).why
    assert line.startswith("--np 8 -> 1: there are 4 cores here; 400 cells and 300 parcels take ")
    assert " s on 4, " in line
    assert line.endswith(" s on 1 (ELUTRIA_EXACT=yes takes 8)")
    assert paying(LARGE, 16, 1).why == (
        "--np 16 -> 1: there is 1 core here (ELUTRIA_EXACT=yes takes 16)"
    )


def test_a_plan_in_which_little_is_known_has_a_number() -> None:
    unknown = plan(400, 300)
    unknown["gas"].update(superficial_m_s=None, through_time_s=None)
    unknown["expected"] = dict.fromkeys(unknown["expected"])
    unknown["feed"].update(parcels=None, end_s=None, run_ends_s=None)
    assert paying(unknown, 8, 8).np >= 1


def test_cores_are_physical(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert 1 <= ranks.cores() <= len(os.sched_getaffinity(0))
    for cpu, siblings in enumerate(("0,2", "1,3", "0,2", "1,3")):
        topology = tmp_path / f"cpu{cpu}/topology"
        topology.mkdir(parents=True)
        (topology / "thread_siblings_list").write_text(siblings + "\n")
    monkeypatch.setattr(ranks, "CPUS", tmp_path)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1, 2, 3})
    assert ranks.cores() == 2
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 2, 7, 8})
    assert ranks.cores() == 3, "of two cores nothing is known"


def test_a_user_insists_with_one_word(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ELUTRIA_EXACT", raising=False)
    assert not ranks.exact()
    monkeypatch.setenv("ELUTRIA_EXACT", "yes")
    assert ranks.exact()
    monkeypatch.setenv("ELUTRIA_EXACT", "8")
    with pytest.raises(InputError, match="ELUTRIA_EXACT=8; allowed: yes, or not set"):
        ranks.exact()
