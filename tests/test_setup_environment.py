"""`source etc/bashrc`: quiet, repeatable, from anywhere, beside an OpenFOAM already sourced."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

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
    for part in ("wmake", "etc"):
        (tmp_path / part).mkdir()
    (tmp_path / "etc/bashrc").touch()
    mine = {
        "WM_PROJECT_DIR": str(tmp_path),
        "WM_PROJECT_VERSION": "v2412",
        "FOAM_USER_LIBBIN": "/somewhere",
        "LD_LIBRARY_PATH": "/its/libraries",
    }
    found = sourced(ROOT / "etc/bashrc", [*mine, "PATH"], tmp_path, **mine)
    assert found.pop("PATH").startswith(f"{ROOT}/.venv/bin:{ROOT}/build/bin:")
    assert found.pop("LD_LIBRARY_PATH") == f"{ROOT}/build/lib:/its/libraries"
    assert found.items() <= mine.items()


@pytest.mark.parametrize(("user", "allowed"), [("0", "1"), ("1000", "")])
def test_open_mpi_is_let_run_as_root_for_root_only(tmp_path: Path, user: str, allowed: str) -> None:
    (tmp_path / "id").write_text(f"#!/bin/sh\necho {user}\n")
    (tmp_path / "id").chmod(0o755)
    found = sourced(
        ROOT / "etc/bashrc", ["OMPI_ALLOW_RUN_AS_ROOT"], tmp_path, path=f"{tmp_path}:/usr/bin:/bin"
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
