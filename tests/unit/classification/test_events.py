"""Outlet tables and ledgers: what is whole is read, what is not is refused."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from elutria.classification.events import join, read_run
from elutria.errors import InputError
from elutria.openfoam.dictionary import set_entry


@pytest.fixture
def finished(column: Path, fake_solver: Path) -> Path:
    """A case with the files of a finished run."""
    assert not fake_solver.exists()
    set_entry(column / "system/simulationParameters", "particles", "4000", column)
    subprocess.run(["elutriaFoam"], cwd=column, check=True, capture_output=True)
    return column


def table(case: Path) -> Path:
    return case / "postProcessing/outlets/0/particles.csv"


def change_ledger(case: Path, change: Any) -> None:
    path = case / "postProcessing/ledger.json"
    ledger = json.loads(path.read_text())
    change(ledger)
    path.write_text(json.dumps(ledger))


def test_a_whole_run_is_read(finished: Path) -> None:
    run = read_run(finished)
    assert len(run.events) == 4_000
    assert (~run.events.has_left).sum() == 20
    account = run.accounts["all"]
    assert account.injected[0] == 4_000
    assert abs(account.mass_closure_error) < 1e-12
    assert run.events.mass.sum() == pytest.approx(account.injected[1])


def test_a_parcel_takes_few_bytes(finished: Path) -> None:
    """Names are categories of a byte each: 34 bytes where text of a fixed width took 584."""
    events = read_run(finished).events
    assert 34 <= events.nbytes / len(events) < 34.1
    assert join([read_run(finished)] * 2).events.nbytes < 68.1 * len(events)


def test_materials_of_several_files_are_told_apart(finished: Path) -> None:
    head, *rows = table(finished).read_text().splitlines(keepends=True)
    later = finished / "postProcessing/outlets/0.5/particles.csv"
    later.parent.mkdir()
    table(finished).write_text(head + "".join(rows[:1_000]))
    later.write_text(head + "".join(rows[1_000:]).replace("quartz", "magnetite"))
    (finished / "postProcessing/outlets/0.7").mkdir()
    (finished / "postProcessing/outlets/0.7/particles.csv").write_text(head)
    events = read_run(finished).events
    assert len(events.of_material("magnetite")) == len(rows) - 1_000
    assert len(events.of_material("quartz")) == 1_000 + 20  # those inside


def test_tables_of_several_times_are_joined(finished: Path) -> None:
    whole = read_run(finished)
    head, *rows = table(finished).read_text().splitlines(keepends=True)
    later = finished / "postProcessing/outlets/0.5/particles.csv"
    later.parent.mkdir()
    table(finished).write_text(head + "".join(rows[:1_000]))
    later.write_text(head + "".join(rows[1_000:]))
    again = read_run(finished)
    assert (again.events.diameter == whole.events.diameter).all()


def test_replicates_are_added(finished: Path) -> None:
    run = read_run(finished)
    both = join([run, run])
    assert len(both.events) == 8_000
    assert both.accounts["quartz"].injected[0] == 8_000
    assert both.accounts["all"].outlets["fines"][1] == pytest.approx(
        2 * run.accounts["all"].outlets["fines"][1]
    )


def test_a_table_cut_anywhere_is_refused(finished: Path) -> None:
    text = table(finished).read_text()
    for length in (0, 5, 150, len(text) // 2, len(text) - 1, text.rindex("\n", 0, -1) + 1):
        table(finished).write_text(text[:length])
        with pytest.raises(InputError, match=r"particles.csv|tables are incomplete"):
            read_run(finished)


def test_a_row_twice_is_refused(finished: Path) -> None:
    text = table(finished).read_text()
    table(finished).write_text(text + text.splitlines(keepends=True)[-1])
    with pytest.raises(InputError, match="more than one row"):
        read_run(finished)


@pytest.mark.parametrize(
    "old, new",
    [
        (",2650,", ",-2650,"),
        (",2650,", ",nan,"),
        (",2650,", ",heavy,"),
        (",2650,", ","),
        (",coarse,", ",sideways,"),
        (",quartz,", ",quartz,quartz,"),
        ("diameter_m", "diameter_mm"),
        ("0,", "\x00,"),
    ],
)
def test_a_row_that_cannot_be_is_refused(finished: Path, old: str, new: str) -> None:
    text = table(finished).read_text()
    table(finished).write_text(text.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        read_run(finished)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["inside.csv", "outlets/0/particles.csv"])
def test_a_row_longer_than_the_head_is_refused(finished: Path, name: str) -> None:
    path = finished / "postProcessing" / name
    text = path.read_text()
    for row in (1, -1):
        lines = text.splitlines()
        lines[row] += ",1,2"
        path.write_text("\n".join(lines) + "\n")
        with pytest.raises(InputError, match=path.name):
            read_run(finished)


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "null", "{}", '{"total": 1}', '{"total": {}, "materials": {}}', "\x00"]
)
def test_a_ledger_that_is_none_is_refused(finished: Path, text: str) -> None:
    (finished / "postProcessing/ledger.json").write_text(text)
    with pytest.raises(InputError, match=r"ledger.json"):
        read_run(finished)


def test_a_ledger_that_disagrees_is_refused(finished: Path) -> None:
    def more_mass(ledger: dict[str, Any]) -> None:
        ledger["total"]["outlets"]["fines"]["mass_kg"] *= 1.01

    change_ledger(finished, more_mass)
    with pytest.raises(InputError, match="incomplete"):
        read_run(finished)


def test_no_run_is_no_run(column: Path) -> None:
    with pytest.raises(InputError, match=r"ledger.json: file not found"):
        read_run(column)
