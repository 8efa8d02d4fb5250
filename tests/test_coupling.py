"""The coupling library's C++ tests (doctest): laws, size distributions, averaging, dispersion."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize("name", ["elutriaLawsTests", "elutriaCouplingTests"])
def test_coupling(name: str) -> None:
    program = ROOT / "build/bin" / name
    assert program.is_file(), f"{program}: file not found; build it with solver/Allwmake"
    done = subprocess.run(
        [program, "--no-colors"], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    assert "test cases: 0 " not in done.stdout, "no test was found"
