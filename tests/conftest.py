"""What all tests share: the `slow` marker and its option, a small case, a stand-in solver."""

from __future__ import annotations

import shlex
import shutil
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).resolve().parent
COLUMN = HERE.parent / "cases/column"
gathered: Counter[tuple[str, str, str]] = Counter()
"""What the processes that ran the tests found of malformed inputs."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--slow", action="store_true", help="run the tests marked slow too")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("filterwarnings", "ignore:invalid escape:DeprecationWarning")  # PyFoam
    config.addinivalue_line("markers", "slow: takes more than a few seconds; run with --slow")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--slow"):
        return
    for item in items:
        if item.get_closest_marker("slow"):  # keywords have the names of folders too
            item.add_marker(pytest.mark.skip(reason="slow: run with --slow"))


def outcomes() -> Counter[tuple[str, str, str]]:
    """Of malformed inputs, in this process: number by kind, command and outcome."""
    found: Counter[tuple[str, str, str]] = getattr(
        sys.modules.get("tests.support.malformed"), "outcomes", Counter()
    )
    return found


def pytest_sessionfinish(session: pytest.Session) -> None:
    if hasattr(session.config, "workeroutput"):  # one of several processes
        session.config.workeroutput["malformed"] = [[*key, n] for key, n in outcomes().items()]


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    for *key, number in getattr(node, "workeroutput", {}).get("malformed", []):
        gathered[tuple(key)] += number


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    found = outcomes() + gathered
    if found:
        terminalreporter.section("malformed inputs: kind, command, outcome, number")
        for (kind, command, outcome), number in sorted(found.items()):
            terminalreporter.write_line(f"{kind:17} {command:12} {outcome:8} {number}")
        terminalreporter.write_line(f"{'all':39} {sum(found.values())}")


@pytest.fixture
def column(tmp_path: Path) -> Path:
    """A copy of the default case, to be changed at will."""
    case = tmp_path / "column"
    for folder in ("0.orig", "constant", "system"):
        shutil.copytree(COLUMN / folder, case / folder)
    shutil.rmtree(case / "constant/polyMesh", ignore_errors=True)
    return case


@pytest.fixture
def fake_solver(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """elutriaFoam and blockMesh that only pretend, first on PATH; gives the file of their starts"""
    programs = tmp_path / "programs"
    programs.mkdir()
    # a shebang line cannot hold a path with spaces
    command = shlex.join([sys.executable, str(HERE / "support/fake_solver.py")])
    solver = programs / "elutriaFoam"
    solver.write_text(f'#!/bin/sh\nexec {command} "$@"\n')
    mesher = programs / "blockMesh"
    mesher.write_text("#!/bin/sh\necho End\n")
    for program in (solver, mesher):
        program.chmod(0o755)
    starts = tmp_path / "starts"
    monkeypatch.setenv("FAKE_STARTS", str(starts))
    monkeypatch.setenv("PATH", str(programs), prepend=":")
    return starts
