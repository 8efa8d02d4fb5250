"""Entries that foamlib does not read are changed in the text."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from elutria.errors import InputError
from elutria.openfoam.dictionary import set_entry
from elutria.openfoam.text import line_with, values_of, with_value

TEXT = """\
FoamFile { version 2.0; format ascii; class dictionary; object d; }
/* gasVelocity 1; */
fast yes; // gasVelocity 2;
#ifeq $fast yes
gasVelocity 6; // m/s
#else
gasVelocity 3;
#endif
half #eval{ 0.5*$gasVelocity };
list ( { gasVelocity 7; } (1 2) );
said "gasVelocity 8; {";
inner { gasVelocity 4; deeper { x (0 0 1); } }
"""


def evaluated(file: Path, entry: str) -> str:
    """As OpenFOAM reads it: an oracle that is not of this project."""
    asked = ["foamDictionary", "-entry", entry, "-value", str(file)]
    done = subprocess.run(asked, capture_output=True, text=True, check=True, env=os.environ)
    return done.stdout.strip()


def test_each_value_of_an_entry_is_found() -> None:
    def found(*keys: str) -> list[str]:
        return [TEXT[start:end] for start, end in values_of(TEXT, keys)]

    assert found("gasVelocity") == ["6", "3"]
    assert found("inner", "gasVelocity") == ["4"]
    assert found("inner", "deeper", "x") == ["(0 0 1)"]
    assert found("half") == ["#eval{ 0.5*$gasVelocity }"]
    assert found("list") == ["( { gasVelocity 7; } (1 2) )"]
    assert found("deeper") == []


def test_nothing_but_the_value_changes() -> None:
    changed = with_value(TEXT, ["gasVelocity"], "5.5")
    assert changed == re.sub(r"^gasVelocity \d", "gasVelocity 5.5", TEXT, flags=re.MULTILINE)


@pytest.mark.parametrize("fast", ["yes", "no"])
def test_openfoam_reads_what_was_set(tmp_path: Path, fast: str) -> None:
    file = tmp_path / "d"
    file.write_text(TEXT.replace("fast yes", f"fast {fast}", 1))
    assert evaluated(file, "gasVelocity") == ("6" if fast == "yes" else "3")
    set_entry(file, "gasVelocity", "5")
    assert evaluated(file, "gasVelocity") == "5"
    assert evaluated(file, "half") == "2.5"


def test_an_entry_that_is_not_there_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "d"
    file.write_text(TEXT)
    with pytest.raises(InputError, match="d: "):
        set_entry(file, "gasVelocty", "5")
    assert file.read_text() == TEXT


def test_the_line_of_an_expression_is_found() -> None:
    assert line_with(TEXT, "0.5 * $gasVelocity") == 9
    assert line_with(TEXT, "gasVelocity 8") == 11
    assert line_with(TEXT, "nothing of it") == 0
