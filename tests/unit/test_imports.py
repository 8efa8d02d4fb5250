"""Starting the command loads no more than it needs: a start is paid for at every call."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.made_results import make_results

HEAVY = {"numpy", "scipy", "pandas", "matplotlib", "PyFoam", "foamlib", "fluids", "pydantic"}


def modules(*arguments: str) -> set[str]:
    """The modules that a command has imported when it ends."""
    script = (
        "import contextlib, io, json, sys\n"
        "from elutria.cli import main\n"
        "with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):\n"
        f"    main({list(arguments)!r})\n"
        "print(json.dumps(sorted(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert not done.stderr, done.stderr
    return set(json.loads(done.stdout.splitlines()[-1]))


def heavy(names: set[str]) -> set[str]:
    """The heavy packages among modules."""
    return HEAVY & {name.partition(".")[0] for name in names}


@pytest.mark.parametrize("arguments", [["--help"], ["sweep", "--help"], ["classify", "--help"]])
def test_help_needs_no_heavy_package(arguments: list[str]) -> None:
    found = modules(*arguments)
    assert heavy(found) == set()
    assert len(found) < 450


def test_figures_need_neither_tables_of_parcels_nor_fits(tmp_path: Path) -> None:
    """matplotlib, and numpy for it, are most of the start."""
    results = make_results(tmp_path / "results", [4.0, 6.0])
    found = modules("plot", str(results))
    assert heavy(found) == {"numpy", "matplotlib"}
    assert not {"matplotlib.pyplot", "IPython", "tkinter"} & found
    assert len(found) < 700
