"""The product's packages: each imports only itself and those below it."""

from __future__ import annotations

import ast
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "tools/elutria"
BELOW: dict[str, set[str]] = {"errors": set(), "tables": set(), "files": {"errors"}}
BELOW["warned"] = {"errors", "files"}
BELOW["openfoam"] = {"errors", "files"}
BELOW["physics"] = {"errors", "files", "openfoam"}
BELOW["case"] = {"errors", "files", "openfoam", "physics"}
BELOW["estimates"] = {"errors", "files", "tables", "openfoam", "physics", "case"}
BELOW["classification"] = {"errors", "files", "tables", "warned"}
BELOW["running"] = BELOW["estimates"] | {"estimates", "classification", "warned"}
BELOW["output"] = BELOW["running"]
BELOW["pages"] = BELOW["output"] | {"running", "output"}
BELOW["comparing"] = BELOW["pages"] | {"pages"}
BELOW["viewing"] = BELOW["running"] | {"running"}
"""What each room of the product may import besides itself; `cli` may import all."""


def imported(file: Path) -> set[str]:
    """The rooms that a file imports, at its head or in a function."""
    rooms = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        rooms |= {name.split(".")[1] for name in names if name.startswith("elutria.")}
    return rooms


def test_every_room_imports_only_what_lies_below_it() -> None:
    wrong = {}
    for room, below in BELOW.items():
        files = [PACKAGE / f"{room}.py", *(PACKAGE / room).glob("*.py")]
        found = {file: imported(file) - below - {room} for file in files if file.is_file()}
        assert found, room
        wrong |= {f"{file.relative_to(PACKAGE)}": up for file, up in found.items() if up}
    assert wrong == {}


def test_the_order_has_no_circle_and_names_every_room() -> None:
    passed: set[str] = set()
    for room, below in BELOW.items():
        assert below <= passed, room
        passed.add(room)
    rooms = {file.stem for file in PACKAGE.glob("*.py")} | {
        folder.parent.name for folder in PACKAGE.glob("*/__init__.py")
    }
    assert rooms - {"__init__", "__main__", "cli"} == passed
