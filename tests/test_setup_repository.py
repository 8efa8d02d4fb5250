"""What holds for the repository's files: the solver's layers, no path or host of one machine."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SOURCES = {".C", ".H", ".cpp", ".hpp", ".inl"}

# Folders of a part of the solver: each includes itself and those before it, no other
ORDER = {
    "solver/coupling": [
        "laws",
        "foam",
        "averaging",
        "parallel",
        "feed",
        "outlets",
        "contacts",
        "forces",
        "cloud",
    ],
    "solver/app/elutriaFoam": ["run", "gas", "schedule", "view"],
}


def includes(folder: Path) -> list[tuple[Path, str, str]]:
    """(file, kind of quote, name) of every #include below a folder, make's links left out."""
    found = []
    for file in sorted(folder.rglob("*")):
        if file.suffix in SOURCES and not file.is_symlink():
            pattern = r'^\s*#\s*include\s*([<"])([^>"]+)[>"]'
            found += [(file, *m) for m in re.findall(pattern, file.read_text(), re.M)]
    return found


def tracked_files() -> list[Path]:
    if shutil.which("git") is None:
        pytest.skip("no git on this machine")
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode != 0:
        pytest.skip("not a git clone")
    files = [ROOT / name for name in listed.stdout.split("\0") if name]
    return [file for file in files if file.is_file() and not file.is_symlink()]


# The particle engine's rooms: each may include itself and those before it.
ROOMS = ["core", "laws", "walls", "neighbours", "impacts", "parallel", "soft", "islands", "engine"]


def strange_includes(dem: Path) -> list[str]:
    """Includes in the engine of what it must not know: a later room, or a foreign library."""
    allowed = {"omp.h", "unistd.h", "immintrin.h", "doctest/doctest.h"}
    strange = []
    for file, quote, name in includes(dem):
        room = file.relative_to(dem).parts[0]
        if quote == "<":
            fine = name in allowed or name.isidentifier()
        elif room in ROOMS:
            known = Path(name).parts[0] in ROOMS[: ROOMS.index(room) + 1]
            fine = known and (dem / name).is_file()
        else:
            fine = any((folder / name).is_file() for folder in (dem, dem / room))
        if not fine:
            strange.append(f"{file.relative_to(dem)}: {name}")
    return strange


def test_each_room_of_the_engine_knows_only_those_before_it() -> None:
    dem = ROOT / "solver/dem"
    sources = {file for file, _, _ in includes(dem)}
    rooms = {file.relative_to(dem).parts[0] for file in sources}
    assert rooms == {*ROOMS, "tests", "bench"}
    assert strange_includes(dem) == []


def test_a_room_that_includes_a_later_one_is_found(tmp_path: Path) -> None:
    for room, included in (("soft", "engine/Engine.hpp"), ("engine", "soft/Cloud.hpp")):
        (tmp_path / room).mkdir()
        (tmp_path / room / Path(included).with_suffix(".cpp").name).write_text(
            f'#include "{included}"\n#include <vector>\n'
        )
    (tmp_path / "soft/Cloud.hpp").write_text("#include <fvMesh.H>\n")
    (tmp_path / "engine/Engine.hpp").touch()
    assert strange_includes(tmp_path) == [
        "soft/Cloud.hpp: fvMesh.H",
        "soft/Engine.cpp: engine/Engine.hpp",
    ]


def test_the_coupling_includes_nothing_of_the_application() -> None:
    above = {file.name for file in (ROOT / "solver/app").rglob("*.H")}
    coupling = ROOT / "solver/coupling"
    own = {file.name for file in coupling.rglob("*.H")}
    strangers = [
        f"{file.relative_to(ROOT)}: {name}"
        for file, _, name in includes(coupling)
        if Path(name).name in above - own or "app/" in name
    ]
    assert strangers == []


@pytest.mark.parametrize("part", ORDER)
def test_folders_include_in_one_order(part: str) -> None:
    base, order = ROOT / part, ORDER[part]
    folders = {file.parent for file in base.rglob("*.[CH]") if not file.is_symlink()}
    strangers = {folder.name for folder in folders} - {base.name, "tests", *order}
    assert strangers == set(), f"{part}: folders without a place in the order"

    headers = {file.name for file in base.rglob("*.H") if not file.is_symlink()}
    arrows, wrong = 0, []
    for file, _, name in includes(base):
        here, to = file.parent.name, Path(name).parent.name
        where = f"{file.relative_to(ROOT)}: {name}"
        if to == "" and name in headers:
            wrong.append(f"{where}: named without its folder")
        elif to in order:
            arrows += to != here
            if here in order and order.index(to) > order.index(here):
                wrong.append(f"{where}: against the order")
    assert wrong == []
    assert arrows, f"{part}: no include between folders was found"


def test_the_coupling_laws_are_plain_cpp() -> None:
    """Laws include each other, the engine's core and the standard library, not OpenFOAM."""
    laws = ROOT / "solver/coupling/laws"
    headers = [*laws.rglob("*.h*"), *(ROOT / "solver/dem/core").glob("*.hpp")]
    own = {file.name for file in headers}
    found = [found for found in includes(laws) if found[0].suffix in {".hpp", ".cpp"}]
    assert found
    allowed = {"doctest/doctest.h"}
    strangers = [
        f"{file.relative_to(ROOT)}: {name}"
        for file, quote, name in found
        if not (Path(name).name in own if quote == '"' else name in allowed or name.isidentifier())
    ]
    assert strangers == []


def test_no_tracked_file_holds_a_path_of_this_machine() -> None:
    marks = [f"{place}/".encode() for place in {ROOT, Path.home()} - {Path("/")}]
    holding = [
        file.relative_to(ROOT)
        for file in tracked_files()
        if any(mark in file.read_bytes() for mark in marks)
    ]
    assert holding == []


def test_the_set_up_names_no_host() -> None:
    files = [ROOT / name for name in ("Allrun", "Alltest", "tools/requirements.lock")]
    files += [file for file in (ROOT / "etc").rglob("*") if file.is_file()]
    naming = [file.relative_to(ROOT) for file in files if "://" in file.read_text()]
    assert naming == []


def test_scripts_can_be_started_and_bash_understands_them() -> None:
    for name in (
        "Allrun",
        "Alltest",
        ".ci/run",
        "solver/Allwmake",
        "solver/Allwclean",
        "etc/setup/setup",
        "etc/setup/packages",
        "etc/setup/headers",
        "etc/setup/python",
        "etc/setup/solver",
        "etc/container/install",
        "etc/container/run",
    ):
        assert os.access(ROOT / name, os.X_OK), name
    for file in [*(ROOT / "etc").rglob("*"), *ROOT.glob("All*"), *(ROOT / "solver").glob("All*")]:
        if file.is_file() and file.name not in ("Dockerfile", "elutria.def"):
            subprocess.run(["bash", "-n", str(file)], check=True)


def test_the_two_container_recipes_are_one() -> None:
    """The same image, the clone in the same place, the same set-up, the same way in."""
    docker, apptainer = (
        (ROOT / "etc/container" / name).read_text() for name in ("Dockerfile", "elutria.def")
    )
    for pattern in (r"^FROM:? (\S+)$", r" \. (/\S+)$", r"(/\S+/install)\b", r"(/\S+/run)\b"):
        said = re.findall(pattern, docker, re.M | re.I)
        assert len(said) == 1, pattern
        assert re.findall(pattern, apptainer, re.M | re.I) == said
    install = ROOT / "etc/container/install"
    run = subprocess.run([str(install)], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout) == (2, "")


def test_python_code_is_clean() -> None:
    ruff = [sys.executable, "-m", "ruff", "check", "--quiet", "tools", "tests"]
    run = subprocess.run(ruff, cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.stdout + run.stderr == ""
