"""What the set-up says when it cannot go on: which step, why, what to do."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.foam_tree import foam_tree

ROOT = Path(__file__).resolve().parents[1]
TOOLS = ("bash", "cat", "cut", "dirname", "env", "grep", "mkdir", "printf", "sed", "tail")

PACKAGES = "openfoam openfoam-examples bzip2 g++ make cmake doctest-dev"


@pytest.fixture
def bare_machine(tmp_path: Path) -> Path:
    """A folder of programs for PATH: a user who is not root, apt, no OpenFOAM, no compiler."""
    programs = tmp_path / "programs"
    programs.mkdir()
    for tool in TOOLS:
        (programs / tool).symlink_to(shutil.which(tool) or f"/bin/{tool}")
    for name, answer in {"id": "echo 1000", "apt-get": "exit 1", "dpkg-query": "exit 1"}.items():
        (programs / name).write_text(f"#!/bin/sh\n{answer}\n")
        (programs / name).chmod(0o755)
    return programs


def packages_step(programs: Path, **more: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(ROOT / "etc/setup/packages")],
        env={"PATH": str(programs), "HOME": str(programs), **more},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )


def test_without_root_and_openfoam_the_packages_are_named(bare_machine: Path) -> None:
    run = packages_step(bare_machine)
    assert run.returncode == 1
    assert run.stdout == ""
    why, what_to_do = run.stderr.splitlines()
    assert why.startswith(f"elutria: failed: packages: missing: {PACKAGES}")
    assert f"apt-get install {PACKAGES}" in what_to_do


def test_a_sourced_openfoam_asks_for_no_openfoam_and_installs_nothing(bare_machine: Path) -> None:
    foam = foam_tree(bare_machine / "foam")
    (bare_machine / "sudo").symlink_to("/bin/true")
    run = packages_step(bare_machine, WM_PROJECT_DIR=str(foam))
    assert run.returncode == 1
    assert "missing: g++ make cmake doctest-dev" in run.stderr
    assert "nothing is installed system-wide" in run.stderr
    assert "install openfoam" not in run.stderr


def test_an_openfoam_without_wmake_is_refused_before_anything_is_done(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "etc", tmp_path / "clone/etc")
    foam = foam_tree(tmp_path / "foam", wmake=False)
    run = subprocess.run(
        [str(tmp_path / "clone/etc/setup/setup")],
        env={"PATH": "/usr/bin:/bin", "WM_PROJECT_DIR": str(foam)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stdout) == (1, "")
    assert "has no wmake: install its development package (openfoam2412-dev)" in run.stderr
    assert [file.name for file in (tmp_path / "clone").iterdir()] == ["etc"]


@pytest.mark.parametrize(
    ("version", "ours", "package"),
    [
        ((3, 9), False, "python3.11-venv"),
        ((3, 11), True, "python3-venv"),
        ((3, 14), True, "python3-venv"),
        ((3, 15), False, "python3.11-venv"),
    ],
)
def test_the_pythons_are_those_that_the_pinned_packages_support(
    tmp_path: Path, version: tuple[int, int], ours: bool, package: str
) -> None:
    """With a python3 that says to be of another version."""
    python = tmp_path / "python3"
    python.write_text(
        f"#!/bin/sh\nshift; exec '{sys.executable}' -c "
        f"'import sys; sys.version_info = {version}; exec(sys.argv.pop(1))' \"$@\"\n"
    )
    python.chmod(0o755)
    script = """
        elutriaRoot="$1"; source "$1/etc/setup/places"
        isOurPython python3 && echo ours || echo other
        packageForVenv
    """
    run = subprocess.run(
        ["bash", "-c", script, "bash", str(ROOT)],
        env={"PATH": f"{tmp_path}:/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.split() == ["ours" if ours else "other", package]


def test_a_machine_without_apt_is_told_so(bare_machine: Path) -> None:
    (bare_machine / "apt-get").unlink()
    run = packages_step(bare_machine)
    assert run.returncode == 1
    assert "no apt-get" in run.stderr


def test_a_failing_step_shows_its_reason_and_its_log(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "etc", tmp_path / "etc")
    script = """
        elutriaRoot="$1"; source "$1/etc/setup/messages"
        logged "some step" "do this" bash -c 'echo first; echo "x.C:1: error: second"; exit 3'
        echo not reached
    """
    run = subprocess.run(
        ["bash", "-c", script, "bash", str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stdout) == (1, "")
    lines = run.stderr.splitlines()
    assert str(tmp_path / "build/log/some-step.log") in lines[0]
    assert lines[-2:] == ["elutria: failed: some step: x.C:1: error: second", "elutria: do this"]


def test_an_argument_that_is_none_is_refused_before_anything_is_done() -> None:
    run = subprocess.run(
        [str(ROOT / "Allrun"), "--quik"], capture_output=True, text=True, check=False
    )
    assert run.returncode == 2
    assert "--quik" in run.stderr
    assert run.stdout == ""


def test_allwmake_without_tools_says_what_to_do(bare_machine: Path) -> None:
    run = subprocess.run(
        [str(ROOT / "solver/Allwmake")],
        env={"PATH": str(bare_machine)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 1
    assert run.stderr.startswith("Allwmake: failed: make is not installed")


def test_the_python_step_believes_only_a_finished_environment(tmp_path: Path) -> None:
    """A .venv without its stamp, as a killed set-up leaves it, is made anew."""
    shutil.copytree(ROOT / "etc", tmp_path / "etc")
    (tmp_path / "tools/validation").mkdir(parents=True)
    (tmp_path / "tools/requirements.lock").write_text("no-such-package==1.0\n")
    for project in ("tools", "tools/validation"):
        (tmp_path / project / "pyproject.toml").touch()
    (tmp_path / ".venv/bin").mkdir(parents=True)
    (tmp_path / ".venv/left-over").touch()
    run = subprocess.run(
        [str(tmp_path / "etc/setup/python")],
        env={**os.environ, "PIP_NO_INDEX": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 1
    assert (
        "failed: Python environment: ERROR: No matching distribution found for no-such-package"
        in run.stderr
    )
    assert not (tmp_path / ".venv/left-over").exists()
    assert not (tmp_path / ".venv/stamp").exists()
