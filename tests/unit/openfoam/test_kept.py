"""What a program said of a case is asked for once, and again as soon as it could be otherwise."""

from __future__ import annotations

import json
import os
import shutil
import sys
from pathlib import Path

import pytest

from elutria.errors import InputError
from elutria.openfoam import kept
from elutria.openfoam.asked import _answers, ask

PROGRAM = """#!/bin/sh
echo "$PWD" >> "{starts}"
file=$(sed 's/.*value *\\([^;]*\\);.*/\\1/' system/controlDict)
echo 'elutria: dictionaries {{"system/controlDict": {{"entries":'
echo '{{"value": "'$file'", "case": "'$PWD'/constant"}},'
echo '"own": ["value", "case"], "repeated": [], "included": []}}}}'
"""


@pytest.fixture
def starts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of the starts of a solver that tells a value and the case's folder."""
    monkeypatch.setenv("ELUTRIA_CACHE", str(tmp_path / "cache"))
    place = tmp_path / "programs/bin"
    place.mkdir(parents=True)
    program = place / "elutriaFoam"
    program.write_text(PROGRAM.format(starts=tmp_path / "starts"))
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(place), prepend=":")
    (tmp_path / "starts").write_text("")
    return tmp_path / "starts"


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "case"
    for folder in ("constant", "system"):
        (path / folder).mkdir(parents=True)
    (path / "system/controlDict").write_text("value 1;")
    return path


def asked(case: Path) -> tuple[str, str]:
    """What a new call of elutria reads."""
    _answers.cache_clear()
    found = ask(case, "system/controlDict")
    assert found is not None
    return found.entries["value"], found.entries["case"]


def number(starts: Path) -> int:
    return len(starts.read_text().splitlines())


def test_a_copy_of_a_case_is_not_asked_about_again(starts: Path, case: Path) -> None:
    assert asked(case) == ("1", f"{case}/constant")
    copy = Path(shutil.copytree(case, case.with_name("copy")))
    assert asked(case) == ("1", f"{case}/constant")
    assert asked(copy) == ("1", f"{copy}/constant")
    assert number(starts) == 1


def test_what_has_changed_is_asked_for_again(starts: Path, case: Path) -> None:
    asked(case)
    file = case / "system/controlDict"
    stat = file.stat()
    file.write_text("value 2;")
    os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))  # of the same date and size
    assert asked(case)[0] == "2"
    (case / "constant/feed").write_text("more 1;")
    asked(case)
    assert number(starts) == 3
    program = Path(shutil.which("elutriaFoam") or "")
    program.write_text(program.read_text() + "# another build\n")
    asked(case)
    assert number(starts) == 4


@pytest.mark.parametrize(
    ("text", "times"),
    [
        ('#include "parameters"', 1),
        ('#include "../constant/parameters"', 1),
        ('#include "$FOAM_CASE/system/parameters"', 1),
        ('#include "<system>/parameters"', 1),
        ('#include "../../parameters"', 2),
        ('#includeIfPresent "../more/parameters"', 2),
        ('#include "/etc/hostname"', 2),
        ('#include "~/parameters"', 2),
        ('#includeEtc "controlDict"', 2),
        ("#includeFunc probes", 2),
        ("name $FOAM_CASENAME;", 2),
    ],
)
def test_a_case_that_reads_elsewhere_is_asked_about_each_time(
    starts: Path, case: Path, text: str, times: int
) -> None:
    (case / "constant/feed").write_text(f"a 1;\n{text}\nb 2;\n")
    asked(case)
    asked(case)
    assert number(starts) == times


def test_a_variable_of_the_environment_is_part_of_what_is_read(
    starts: Path, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (case / "constant/feed").write_text("seed ${ELUTRIA_TEST_SEED};")
    asked(case)
    monkeypatch.setenv("ELUTRIA_TEST_SEED", "3")
    asked(case)
    monkeypatch.setenv("ELUTRIA_TEST_SEED", "4")
    asked(case)
    asked(case)
    assert number(starts) == 3


def test_a_spoilt_answer_is_asked_for_again(starts: Path, case: Path) -> None:
    asked(case)
    (answer,) = (starts.parent / "cache/cases").iterdir()
    answer.write_text(answer.read_text()[:-20])
    assert asked(case)[0] == "1"
    answer.write_text("[]")
    assert asked(case)[0] == "1"
    assert number(starts) == 3


def test_a_cache_that_cannot_be_written_keeps_nothing(
    starts: Path, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ELUTRIA_CACHE", str(starts))
    asked(case)
    assert asked(case)[0] == "1"
    assert number(starts) == 2


def test_the_longest_unused_answers_go_first(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ELUTRIA_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(kept, "_MOST", 20)
    for age in range(20):
        kept.keep(f"{age}", case, {"age": age})
        os.utime(tmp_path / f"cache/cases/{age}.json", (1000 - age, 1000 - age))
    assert kept.read("19", case) == {"age": 19}  # used just now
    kept.keep("new", case, {})
    names = {
        json.loads(file.read_text()).get("age") for file in (tmp_path / "cache/cases").iterdir()
    }
    assert names == {None, 19, *range(17)}


def test_a_plan_is_of_a_mesh_as_old_as_it_is(case: Path) -> None:
    from elutria.running.known import _dates

    assert _dates(case) == []
    (case / "constant/polyMesh").mkdir()
    (case / "constant/polyMesh/faces").write_text("")
    before = _dates(case)
    os.utime(case / "system/controlDict", (1, 1))
    assert before != _dates(case)


@pytest.mark.parametrize(
    ("does", "ends"),
    [
        ("while time.process_time() < 1.5: pass", True),
        ("time.sleep(60)", False),  # a pipe
        ("while True: pass", False),  # a device
    ],
    ids=["on a busy machine", "waits", "never ends"],
)
def test_a_reader_may_wait_for_the_processor_alone(
    starts: Path, case: Path, monkeypatch: pytest.MonkeyPatch, does: str, ends: bool
) -> None:
    monkeypatch.setattr("elutria.openfoam.asked._LONGEST_WAIT", 1.0)
    monkeypatch.setattr("elutria.openfoam.asked._LONGEST_WORK", 2.5)
    program = starts.parent / "programs/bin/elutriaFoam"
    said = program.with_name("said")
    program.rename(said)
    program.write_text(
        f"#!{sys.executable}\nimport os, time\n{does}\nos.execv({str(said)!r}, [{str(said)!r}])\n"
    )
    program.chmod(0o755)
    if ends:
        assert asked(case)[0] == "1"
    else:
        with pytest.raises(InputError, match=r"takes more than 1 s to read"):
            asked(case)
