"""Each step of the set-up finds out itself what is done: nothing twice, nothing half believed."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

FAKE_BUILD = """#!/bin/bash
echo build >> ../calls
[ ! -e broken ] || { echo "x.C:1: error: broken"; exit 1; }
[ ! -e slow ] || sleep 60
mkdir -p ../build/bin && touch ../build/bin/elutriaFoam && chmod +x ../build/bin/elutriaFoam
"""


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A clone whose solver/Allwmake and Allwclean only note that they were called."""
    root = tmp_path / "a clone"
    shutil.copytree(ROOT / "etc", root / "etc")
    (root / "solver").mkdir()
    for name, text in {
        "Allwmake": FAKE_BUILD.replace("../", f"'{root}'/").replace("-e ", f"-e '{root}'/solver/"),
        "Allwclean": f"#!/bin/bash\necho clean >> '{root}'/calls\n",
    }.items():
        (root / "solver" / name).write_text(text)
        (root / "solver" / name).chmod(0o755)
    (root / "solver/part.C").write_text("first")
    return root


@pytest.fixture
def build(clone: Path) -> Callable[[], tuple[int, list[str]]]:
    """Runs the solver step: exit code and which scripts it called."""

    def run() -> tuple[int, list[str]]:
        (clone / "calls").unlink(missing_ok=True)
        step = subprocess.run([str(clone / "etc/setup/solver")], capture_output=True, check=False)
        calls = clone / "calls"
        return step.returncode, calls.read_text().split() if calls.exists() else []

    return run


def test_the_solver_is_built_once(build: Callable[[], tuple[int, list[str]]]) -> None:
    assert build() == (0, ["build"])
    assert build() == (0, [])


def test_a_changed_source_is_built(clone: Path, build: Callable[[], tuple[int, list[str]]]) -> None:
    build()
    (clone / "solver/part.C").write_text("second")
    assert build() == (0, ["build"])


def test_what_make_leaves_in_the_tree_is_no_change(
    clone: Path, build: Callable[[], tuple[int, list[str]]]
) -> None:
    build()
    for folder in ("solver/lnInclude", "solver/Make/linux64GccDPInt32Opt"):
        (clone / folder).mkdir(parents=True)
        (clone / folder / "part.o").touch()
    assert build() == (0, [])


def test_a_failed_build_is_tried_again(
    clone: Path, build: Callable[[], tuple[int, list[str]]]
) -> None:
    build()
    (clone / "solver/broken").touch()
    assert build() == (1, ["build"])
    (clone / "solver/broken").unlink()
    assert build() == (0, ["build"])


def test_a_killed_build_starts_from_scratch(
    clone: Path, build: Callable[[], tuple[int, list[str]]]
) -> None:
    (clone / "solver/slow").touch()
    step = subprocess.Popen([str(clone / "etc/setup/solver")], start_new_session=True)
    while not (clone / "calls").exists():
        time.sleep(0.02)
    os.killpg(step.pid, 9)
    step.wait()
    (clone / "solver/slow").unlink()
    assert build() == (0, ["clean", "build"])
    assert build() == (0, [])


def test_another_openfoam_starts_from_scratch(
    clone: Path, build: Callable[[], tuple[int, list[str]]], monkeypatch: pytest.MonkeyPatch
) -> None:
    build()
    foam = clone / "foam"
    for part in ("wmake", "etc"):
        (foam / part).mkdir(parents=True)
    (foam / "etc/bashrc").touch()
    monkeypatch.setenv("WM_PROJECT_DIR", str(foam))
    assert build() == (0, ["clean", "build"])


def test_headers_in_the_cache_are_taken_as_they_are(tmp_path: Path) -> None:
    """A folder of the right version is whole, since it is renamed into its place."""
    shutil.copytree(ROOT / "etc", tmp_path / "etc")
    (tmp_path / "programs").mkdir()
    answer = "#!/bin/sh\necho 'installed 1912.200626-1'\n"
    (tmp_path / "programs/dpkg-query").write_text(answer)
    (tmp_path / "programs/dpkg-query").chmod(0o755)
    (tmp_path / "cache/openfoam-1912.200626-1").mkdir(parents=True)
    environment = {
        "PATH": f"{tmp_path}/programs:/usr/bin:/bin",
        "ELUTRIA_CACHE": str(tmp_path / "cache"),
    }
    run = subprocess.run(
        [str(tmp_path / "etc/setup/headers")],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout == "elutria: OpenFOAM headers: all there\n"
