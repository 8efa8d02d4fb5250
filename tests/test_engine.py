"""The particle engine's C++ tests (doctest), one pytest item per suite or group."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

PROGRAM = Path(__file__).resolve().parents[1] / "build/bin/elutriaDemTests"

GROUPS = {
    "bounce": ["--test-suite=bounce"],
    "contact": ["--test-suite=contact"],
    "search": ["--test-suite=search"],
    "engine": ["--test-suite=engine"],
    "the rest": ["--test-suite-exclude=bounce,contact,search,engine"],
}


@pytest.mark.parametrize("group", GROUPS)
def test_engine(group: str) -> None:
    assert PROGRAM.is_file(), f"{PROGRAM}: file not found; build it with solver/Allwmake"
    done = subprocess.run(
        [PROGRAM, "--no-colors", *GROUPS[group]],
        env={**os.environ, "OMP_WAIT_POLICY": "passive"},  # cores may be shared
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    assert "assertions: 0 " not in done.stdout, "no test was found"
