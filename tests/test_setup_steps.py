"""Each step of the set-up finds out itself what is done: nothing twice, nothing half believed."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.foam_tree import foam_tree

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
    monkeypatch.setenv("WM_PROJECT_DIR", str(foam_tree(clone / "foam")))
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


@pytest.fixture
def one_source(tmp_path: Path) -> Callable[[str], subprocess.CompletedProcess[str]]:
    """Compiles a text as the coupling's only source, against the headers of a release."""
    root = tmp_path / "a clone"
    foam = foam_tree(tmp_path / "foam")
    for header in (
        "OpenFOAM/lnInclude/Time.H",
        "finiteVolume/lnInclude/fvCFD.H",
        "lagrangian/intermediate/lnInclude/KinematicCloud.H",
    ):
        (foam / "src" / header).parent.mkdir(parents=True)
        (foam / "src" / header).touch()
    old = "struct Old { virtual ~Old() = default; virtual void hook() {} };\n"
    (foam / "src/OpenFOAM/lnInclude/Old.H").write_text(old)
    shutil.copytree(ROOT / "etc", root / "etc")
    for part in ("coupling", "app/elutriaFoam"):
        (root / "solver" / part / "Make").mkdir(parents=True)
        (root / "solver" / part / "Make/files").write_text("part.C\n\nLIB = $(HERE)/lib\n")
        (root / "solver" / part / "Make/options").touch()
        (root / "solver" / part / "part.C").touch()
    shutil.copy(ROOT / "solver/Allwmake", root / "solver")

    def run(text: str) -> subprocess.CompletedProcess[str]:
        (root / "solver/coupling/part.C").write_text(text)
        return subprocess.run(
            [str(root / "solver/Allwmake"), "--headers", str(foam)],
            capture_output=True,
            text=True,
            check=False,
        )

    return run


def test_sources_are_compiled_against_the_headers_of_a_release(
    one_source: Callable[[str], subprocess.CompletedProcess[str]], tmp_path: Path
) -> None:
    run = one_source('#include "Old.H"\nstatic_assert(OPENFOAM == 2412);\n')
    assert (run.returncode, run.stderr) == (0, "")
    assert "compile with OpenFOAM v2412" in run.stdout
    assert sorted(f.name for f in tmp_path.rglob("part*")) == ["part.C", "part.C"]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("int answer = none;\n", "not declared"),
        (
            '#include "Old.H"\nstruct New : Old { virtual void hook(); };\n',
            "can be marked override",
        ),
    ],
)
def test_a_source_that_a_release_does_not_take_is_told(
    one_source: Callable[[str], subprocess.CompletedProcess[str]], text: str, complaint: str
) -> None:
    run = one_source(text)
    assert run.returncode == 1
    assert complaint in run.stderr
    assert "Allwmake: failed: coupling does not compile with OpenFOAM v2412" in run.stderr


def test_a_folder_that_is_no_release_is_refused(tmp_path: Path) -> None:
    run = subprocess.run(
        [str(ROOT / "solver/Allwmake"), "--headers", str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 1
    assert f"'{tmp_path}' is not the source of an OpenFOAM release" in run.stderr


def test_only_a_list_that_names_a_header_that_has_gone_is_made_anew(tmp_path: Path) -> None:
    """A list of v2012 and later ends with the comment #END."""
    (tmp_path / "there.H").touch()
    for name, header in {"whole": "there.H", "old": "gone.H"}.items():
        text = f"$(OBJECTS_DIR)/part.o: \\\n{header} \\\n$(LIB_SRC)/far.H\n\n#END\n"
        (tmp_path / f"{name}.dep").write_text(text)
    script = """
        eval "$(sed -n '/^forgetGoneHeaders()/,/^}/p' "$1/solver/Allwmake")"
        forgetGoneHeaders
    """
    subprocess.run(["bash", "-ec", script, "bash", str(ROOT)], cwd=tmp_path, check=True)
    assert [file.name for file in tmp_path.glob("*.dep")] == ["whole.dep"]


# --- the page of elutria view

FAKE_NPM = """#!/bin/bash
echo "$1" >> '{root}/calls'
[ ! -e '{root}/broken' ] || {{ echo "npm error network"; exit 1; }}
for word; do case "$word" in --outfile=*) echo page > "${{word#--outfile=}}";; esac; done
"""


@pytest.fixture
def page(clone: Path, tmp_path: Path) -> Callable[[], tuple[int, str, bool, list[str]]]:
    """Runs the page's step: exit code, what it said, whether there is a page, calls of npm."""
    shutil.copytree(ROOT / "tools/page", clone / "tools/page",
                    ignore=shutil.ignore_patterns("node_modules"))  # fmt: skip
    (clone / "tools/elutria/viewing/static").mkdir(parents=True)
    (clone / "build").mkdir(exist_ok=True)
    (clone / "programs").mkdir()
    (clone / "programs/npm").write_text(FAKE_NPM.format(root=clone))
    (clone / "programs/npm").chmod(0o755)
    environment = {
        "PATH": f"{clone}/programs:/usr/bin:/bin",
        "ELUTRIA_CACHE": str(tmp_path / "cache"),
    }

    def run() -> tuple[int, str, bool, list[str]]:
        (clone / "calls").unlink(missing_ok=True)
        step = subprocess.run(
            [str(clone / "etc/setup/page")],
            env=environment, capture_output=True, text=True, check=False,
        )  # fmt: skip
        calls = clone / "calls"
        built = (clone / "tools/elutria/viewing/static/page.js").is_file()
        names = calls.read_text().split() if calls.exists() else []
        return step.returncode, step.stdout + step.stderr, built, names

    return run


def test_the_page_is_built_once_and_anew_when_it_changed(
    clone: Path, page: Callable[[], tuple[int, str, bool, list[str]]]
) -> None:
    assert page()[::2] == (0, True)
    assert page()[3] == []
    (clone / "tools/page/src/main.js").write_text("changed")
    assert page()[3] == ["ci", "run"]


def test_a_page_of_the_cache_needs_no_npm(
    clone: Path, page: Callable[[], tuple[int, str, bool, list[str]]]
) -> None:
    page()
    (clone / "tools/elutria/viewing/static/page.js").unlink()
    assert page()[2:] == (True, [])


def test_without_the_network_there_is_no_page_and_the_setup_goes_on(
    clone: Path, page: Callable[[], tuple[int, str, bool, list[str]]]
) -> None:
    (clone / "broken").touch()
    code, said, built, _ = page()
    assert (code, built) == (0, False)
    assert "until then there is no 'elutria view'" in said
    (clone / "broken").unlink()
    assert page()[::2] == (0, True)
