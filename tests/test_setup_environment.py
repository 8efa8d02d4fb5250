"""`source etc/bashrc`: quiet, repeatable, from anywhere, beside an OpenFOAM already sourced."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.foam_tree import foam_tree

ROOT = Path(__file__).resolve().parents[1]
REPORT = 'for v in "$@"; do printf "%s=%s\\n" "$v" "${!v-}"; done'


def sourced(
    bashrc: Path,
    names: list[str],
    cwd: Path,
    path: str = "/usr/bin:/bin",
    times: int = 1,
    **more: str,
) -> dict[str, str]:
    """Environment variables after sourcing, in a shell that stops at errors and has no others."""
    script = f'set -eu; b="$1"; shift; for i in $(seq {times}); do source "$b"; done; {REPORT}'
    run = subprocess.run(
        ["bash", "-c", script, "bash", str(bashrc), *names],
        cwd=cwd,
        env={"PATH": path, **more},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stderr == ""
    return dict(line.split("=", 1) for line in run.stdout.splitlines())


@pytest.fixture
def clone_with_spaces(tmp_path: Path) -> Path:
    clone = tmp_path / "a clone with spaces"
    shutil.copytree(ROOT / "etc", clone / "etc")
    return clone


def test_programs_come_first_on_the_path(tmp_path: Path) -> None:
    found = sourced(
        ROOT / "etc/bashrc", ["PATH", "LD_LIBRARY_PATH", "WM_PROJECT_VERSION"], tmp_path
    )
    assert found["PATH"].split(":")[:2] == [f"{ROOT}/.venv/bin", f"{ROOT}/build/bin"]
    assert found["LD_LIBRARY_PATH"] == f"{ROOT}/build/lib"
    assert found["WM_PROJECT_VERSION"] == "v1912"


def test_python_keeps_compiled_modules_whatever_the_machine_says(tmp_path: Path) -> None:
    name = "PYTHONDONTWRITEBYTECODE"
    assert sourced(ROOT / "etc/bashrc", [name], tmp_path, **{name: "1"}) == {name: ""}


def test_a_path_with_spaces_sourced_twice_by_relative_name(clone_with_spaces: Path) -> None:
    found = sourced(Path("bashrc"), ["PATH", "LD_LIBRARY_PATH"], clone_with_spaces / "etc", times=2)
    assert (
        found["PATH"]
        == f"{clone_with_spaces}/.venv/bin:{clone_with_spaces}/build/bin:/usr/bin:/bin"
    )
    assert found["LD_LIBRARY_PATH"] == f"{clone_with_spaces}/build/lib"


def test_the_clone_sourced_last_wins(clone_with_spaces: Path, tmp_path: Path) -> None:
    first = sourced(ROOT / "etc/bashrc", ["PATH"], tmp_path)["PATH"]
    second = sourced(clone_with_spaces / "etc/bashrc", ["PATH"], tmp_path, path=first)["PATH"]
    assert second.startswith(f"{clone_with_spaces}/.venv/bin:")


def test_a_sourced_openfoam_environment_stays(tmp_path: Path) -> None:
    mine = {
        "WM_PROJECT_DIR": str(foam_tree(tmp_path / "foam")),
        "WM_PROJECT_VERSION": "v2412",
        "FOAM_USER_LIBBIN": "/somewhere",
        "LD_LIBRARY_PATH": "/its/libraries",
    }
    found = sourced(ROOT / "etc/bashrc", [*mine, "PATH"], tmp_path, **mine)
    assert found.pop("PATH").startswith(f"{ROOT}/.venv/bin:{ROOT}/build/bin:")
    assert found.pop("LD_LIBRARY_PATH") == f"{ROOT}/build/lib:/its/libraries"
    assert found.items() <= mine.items()


@pytest.mark.parametrize(
    ("release", "wmake", "why"),
    [
        ("2412", False, "has no wmake: install its development package (openfoam2412-dev)"),
        ("", True, "is not openfoam.com's"),
        ("1906", True, "is v1906: source v1912 or later"),
    ],
)
def test_an_openfoam_that_cannot_be_used_is_refused(
    tmp_path: Path, release: str, wmake: bool, why: str
) -> None:
    """Its own programs and libraries would stay in front of Debian's: nothing is changed."""
    foam = foam_tree(tmp_path / "foam", release, wmake)
    script = 'source "$1" || echo "$?: $WM_PROJECT_DIR $PATH"'
    run = subprocess.run(
        ["bash", "-c", script, "bash", str(ROOT / "etc/bashrc")],
        env={"PATH": "/usr/bin:/bin", "WM_PROJECT_DIR": str(foam)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout == f"1: {foam} /usr/bin:/bin\n"
    assert run.stderr.startswith(
        f"elutria: failed: environment: the sourced OpenFOAM, {foam}, {why}"
    )
    assert len(run.stderr.splitlines()) == 1


@pytest.mark.parametrize(("user", "allowed"), [("0", "1"), ("1000", "")])
@pytest.mark.parametrize("foreign", [False, True])
def test_open_mpi_is_let_run_as_root_for_root_only(
    tmp_path: Path, user: str, allowed: str, foreign: bool
) -> None:
    (tmp_path / "id").write_text(f"#!/bin/sh\necho {user}\n")
    (tmp_path / "id").chmod(0o755)
    more = {"WM_PROJECT_DIR": str(foam_tree(tmp_path / "foam"))} if foreign else {}
    found = sourced(
        ROOT / "etc/bashrc",
        ["OMPI_ALLOW_RUN_AS_ROOT"],
        tmp_path,
        path=f"{tmp_path}:/usr/bin:/bin",
        **more,
    )
    assert found["OMPI_ALLOW_RUN_AS_ROOT"] == allowed


def test_run_functions_make_and_clean_a_case(tmp_path: Path) -> None:
    case = tmp_path / "a case"
    for folder in (
        "0.orig",
        "0.5",
        "1e-05",
        "2",
        "2 of mine",
        "processor0",
        "postProcessing",
        "system",
    ):
        (case / folder).mkdir(parents=True)
    (case / "0.orig/U").write_text("field")
    script = """
        . "$1/etc/runFunctions"
        restore0Dir && test -f 0/U
        runApplication echo said && grep -q said log.echo
        ! ( runApplication false )
        cleanCase
    """
    subprocess.run(["bash", "-ec", script, "bash", str(ROOT)], cwd=case, check=True)
    assert sorted(p.name for p in case.iterdir()) == ["0.orig", "2 of mine", "system"]
