"""OpenFOAM's programs in folders with names that OpenFOAM refuses."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from elutria.case.case import Case
from elutria.errors import InputError
from elutria.openfoam.started import started_in
from elutria.running.run import ask_plan, make_mesh

COLUMN = Path(__file__).resolve().parents[3] / "cases/column"


def test_a_plain_folder_leaves_the_command_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PWD", str(tmp_path))
    with started_in(tmp_path, ["blockMesh"]) as command:
        assert command == ["blockMesh"]


def test_a_start_from_a_folder_with_spaces_is_not_told_to_openfoam(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PWD", "/a folder/with spaces")
    with started_in(tmp_path, ["printenv", "PWD"]) as command:
        seen = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert seen.stdout == f"{tmp_path}\n"


@pytest.mark.parametrize("name", ["two words", "it's", 'say "yes"', "tab\there"])
def test_the_program_sees_a_name_that_openfoam_takes(tmp_path: Path, name: str) -> None:
    folder = tmp_path / name
    folder.mkdir()
    with started_in(folder, ["sh", "-c", "touch here; echo $PWD"]) as command:
        seen = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert (folder / "here").exists()
    assert not set(seen.rstrip("\n")) & set(" \t\"'")
    assert not Path(seen.strip()).exists()


@pytest.mark.skipif(shutil.which("blockMesh") is None, reason="no OpenFOAM on this machine")
def test_a_mesh_is_made_in_a_folder_with_spaces_and_quotes(tmp_path: Path) -> None:
    case = tmp_path / "a user's case"
    shutil.copytree(COLUMN, case)
    make_mesh(Case(case))
    assert (case / "constant/polyMesh/faces").is_file()


def test_a_refusal_names_the_case_and_what_its_mesh_is_made_from(tmp_path: Path) -> None:
    case = tmp_path / "two words"
    shutil.copytree(COLUMN, case, ignore=shutil.ignore_patterns("polyMesh", "[1-9]*"))
    plan = case / "system/blockMeshDict"
    text = plan.read_text()
    assert "faces ((0 4 7 3))" in text or "(0 4 7 3)" in text
    plan.write_text(text.replace("(0 4 7 3)", ""))  # of the walls: now of no patch
    with pytest.raises(InputError) as refused:
        ask_plan(Case(case))
    assert f"{case}/constant/polyMesh" in str(refused.value)
    assert "made from system/blockMeshDict" in str(refused.value)
