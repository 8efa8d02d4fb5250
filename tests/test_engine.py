"""The particle engine's C++ tests (doctest), plain and under sanitizers; memory over a long run."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = ROOT / "build/bin/elutriaDemTests"
BENCH = ROOT / "build/bin/elutriaDemBench"

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


@pytest.mark.slow
def test_engine_under_sanitizers() -> None:
    """No input of the tests reads out of bounds, leaks or does what the language leaves open."""
    folder = ROOT / "build/sanitized"
    options = ["-DELUTRIA_SANITIZE=ON", f"-DELUTRIA_PRODUCTS={folder}"]
    libraries = f"{folder / 'lib'}:{os.environ.get('LD_LIBRARY_PATH', '')}"  # not the usual build's
    for command in (
        ["cmake", "-S", ROOT / "solver/dem", "-B", folder, *options],
        ["cmake", "--build", folder, "--target", "elutriaDemTests", "-j2"],
        [folder / "bin/elutriaDemTests", "--no-colors"],
    ):
        done = subprocess.run(
            command,
            env={
                **os.environ,
                "LD_LIBRARY_PATH": libraries,
                "OMP_WAIT_POLICY": "passive",
                "UBSAN_OPTIONS": "print_stacktrace=1",
            },
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]


def test_memory_stays_flat() -> None:
    """Spheres settle, then rest: no more memory at the end than just after settling."""
    done = subprocess.run(
        [BENCH, "box", "particles=500", "steps=60000", "report=10000"],
        capture_output=True,
        text=True,
        check=True,
    )
    reports = [json.loads(line) for line in done.stdout.splitlines()]
    for what in ("process_bytes_per_particle", "engine_bytes_per_particle"):
        after_settling, at_the_end = reports[2][what], reports[-1][what]
        assert at_the_end <= 1.05 * after_settling, what
