"""The measuring half is a package of its own: its rooms' order, and that the product knows none."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
import typer

from elutria import cli

TOOLS = Path(__file__).resolve().parents[2] / "tools"
PACKAGE = TOOLS / "validation/elutria_validation"
ROOMS = ("references", "harness", "book", "chapters", "benchmarks", "fits")
"""Each may import itself and those before it; `commands` may import all."""


def imported(file: Path) -> set[str]:
    """Modules that a file imports, at its head or in a function."""
    modules = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            modules |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
    return modules


def test_every_room_imports_only_those_before_it() -> None:
    assert {folder.parent.name for folder in PACKAGE.glob("*/__init__.py")} == set(ROOMS)
    wrong = {}
    for number, room in enumerate(ROOMS):
        later = tuple(
            f"elutria_validation.{other}." for other in (*ROOMS[number + 1 :], "commands")
        )
        for file in (PACKAGE / room).glob("*.py"):
            found = [name for name in imported(file) if f"{name}.".startswith(later)]
            if found:
                wrong[f"{room}/{file.name}"] = found
    assert wrong == {}


def test_nothing_of_the_product_imports_it() -> None:
    files = list((TOOLS / "elutria").rglob("*.py"))
    assert files
    names = {file.name for file in files if "elutria_validation" in file.read_text()}
    assert names == set()


def test_without_it_its_commands_say_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cli, "app", typer.Typer())
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **_: ())
    cli._add_commands()
    for name in ("bench", "verify"):
        with pytest.raises(SystemExit) as ended:
            cli.main([name, "all", "--quick"])
        assert ended.value.code == 2
        said = capsys.readouterr().err
        assert said.startswith(f"elutria: {name}: is not installed")
        assert "pip install -e tools/validation" in said
