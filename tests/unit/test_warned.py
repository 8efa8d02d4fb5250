"""RUN/warnings.json: the solver's and the tool's warnings, told by kind over several runs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from elutria.errors import InputError
from elutria.warned import WARNINGS, Warned, grouped, read_warnings, set_tool_warnings

HEAVY = Warned("heavyParcels", "parcels are heavy", "12 %, allowed: 10 %", "feed more", 0.12,
               0, 1.5, 3, "elutriaFoam")  # fmt: skip
INSIDE = Warned("inside", "some is inside", "2 %", "increase drainTime", 0.02)


def test_the_tools_warnings_are_renewed_and_the_solvers_kept(tmp_path: Path) -> None:
    assert read_warnings(tmp_path) == []
    (tmp_path / WARNINGS).write_text(json.dumps([vars(HEAVY)]))
    for _ in range(2):
        set_tool_warnings(tmp_path, [INSIDE])
        assert read_warnings(tmp_path) == [HEAVY, INSIDE]
    set_tool_warnings(tmp_path, [])
    assert read_warnings(tmp_path) == [HEAVY]


def test_a_line_for_each_kind_names_the_runs_and_the_worst() -> None:
    heavier = Warned(**{**vars(HEAVY), "how_much": "30 %, allowed: 10 %", "size": 0.3})
    lines = grouped({"3 m/s": [HEAVY], "5 m/s": [heavier, INSIDE], "7 m/s": []})
    assert lines == [
        "3 m/s; 5 m/s: parcels are heavy: 30 %, allowed: 10 %; feed more (worst at 5 m/s)",
        "5 m/s: some is inside: 2 %; increase drainTime",
    ]


@pytest.mark.parametrize("text", ["{", "{}x", "[1]", '["word"]', "[{}]"])
def test_a_file_of_something_else_is_named(tmp_path: Path, text: str) -> None:
    (tmp_path / WARNINGS).write_text(text)
    with pytest.raises(InputError, match=WARNINGS):
        read_warnings(tmp_path)
