"""Starting the command loads no more than it needs: a start is paid for at every call."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

COLUMN = Path(__file__).resolve().parents[2] / "cases/column"
HEAVY = {"numpy", "scipy", "pandas", "matplotlib", "PyFoam", "foamlib", "fluids"}


def loaded(*arguments: str) -> set[str]:
    """The heavy packages that a command has imported when it ends."""
    script = (
        "import contextlib, io, json, sys\n"
        "from elutria.cli import main\n"
        "with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):\n"
        f"    main({list(arguments)!r})\n"
        "print(json.dumps(sorted({name.partition('.')[0] for name in sys.modules})))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return HEAVY & set(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize("arguments", [["--help"], ["sweep", "--help"], ["classify", "--help"]])
def test_help_needs_no_heavy_package(arguments: list[str]) -> None:
    assert loaded(*arguments) == set()


def test_check_draws_and_fits_nothing() -> None:
    heavy = loaded("check", str(COLUMN))
    assert not heavy & {"pandas", "matplotlib", "PyFoam"}
