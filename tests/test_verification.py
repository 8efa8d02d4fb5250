"""The verification book: its page, a fast sample of its references, and all of it (slow)."""

from __future__ import annotations

import csv
import importlib
import json
from math import nan
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from elutria import cli
from elutria_validation import commands
from elutria_validation.book import page
from elutria_validation.book.book import Chapter, Row, write_chapter
from elutria_validation.chapters import bed, contacts, dispersion, drag, wake
from elutria_validation.chapters.contacts import collide, linear
from elutria_validation.harness.common import Options, project_root
from elutria_validation.harness.scene import Particles, write_particles


def judged(name: str, ours: float) -> Any:
    """A chapter's module with one judged row, of reference 1."""

    def run(options: Options) -> Chapter:
        chapter = Chapter(name, name.title())
        row = Row.relative("here", f"value of {name}, m", 1.0, ours, 0.01)
        chapter.section(f"Case of {name}", "").rows.append(row)
        return write_chapter(options, chapter)

    return SimpleNamespace(NAME=name, HELP="", run=run)


def test_a_row_passes_fails_or_informs() -> None:
    assert Row.relative("a", "b", 2.0, 2.01, 0.01).verdict == "pass"
    assert Row.relative("a", "b", 2.0, 2.1, 0.01).verdict == "FAIL"
    assert Row.relative("a", "b", 2.0, float("nan"), 0.01).verdict == "FAIL"
    assert Row.relative("a", "b", 2.0, 2.1, None).verdict == "info"


def verify(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str]:
    """Exit code of `elutria verify ...` and the lines on its standard error."""
    code = 0
    try:
        cli.main(["verify", *map(str, arguments)])
    except SystemExit as ended:
        code = int(ended.code or 0)
    return code, capsys.readouterr().err


@pytest.mark.parametrize(
    ("force", "code"), [("HaiderLevenspielDrag", 0), ("SchillerNaumannDrag", 1)]
)
def test_a_wrong_law_in_the_solver_turns_the_book_red(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    force: str,
    code: int,
) -> None:
    """Rows judge Haider and Levenspiel's law; the solver computes `force`."""
    monkeypatch.setattr(drag, "SINGLE", ((force, "Haider-Levenspiel", 0.7),))
    monkeypatch.setattr(drag, "_suspensions", lambda *_: None)
    monkeypatch.setattr(drag, "_out_of_range", lambda *_: None)
    ended, said = verify(capsys, "drag", "--to", tmp_path / "drag")
    assert ended == code
    assert (f"FAIL {force} (Haider-Levenspiel), sphericity 0.7" in said) == (code == 1)


def test_all_chapters_run_before_the_book_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    modules = {"bad": judged("bad", 1.5), "none": judged("none", nan), "good": judged("good", 1.0)}
    monkeypatch.setattr(commands, "modules", lambda _: modules)
    code, said = verify(capsys, "all", "--to", tmp_path)
    assert code == 1
    assert "bad: FAIL here: value of bad, m: 0.5, allowed 0.01" in said
    assert "none: FAIL here: value of none, m: nan, allowed 0.01" in said
    assert "elutria: verify all: 2 judged rows failed" in said
    assert "good" not in said
    assert all((tmp_path / name / "chapter.json").is_file() for name in modules)
    monkeypatch.setattr(commands, "modules", lambda _: {"good": modules["good"]})
    assert verify(capsys, "all", "--to", tmp_path)[0] == 0


def test_the_page_summarises_all_chapters(tmp_path: Path) -> None:
    for name, ours in (("drag", 1.0), ("bed", 1.5)):
        chapter = Chapter(name, name.title())
        section = chapter.section(f"Case of {name}", "What is <checked>.", "What was found.")
        section.rows.append(Row.relative("here", "value, m", 1.0, ours, 0.01, "1 %"))
        write_chapter(Options(tmp_path / name, say=lambda _: None), chapter)
    page = (tmp_path / "index.md").read_text()
    assert page.index("Case of drag") < page.index("Case of bed")
    assert "1 of 2 rows pass" in page
    assert "| [Case of bed](#case-of-bed) | 0 of 1 | 50 | 1 % | FAIL |" in page
    assert "What is &lt;checked&gt;." in (tmp_path / "index.html").read_text()
    rows = list(csv.DictReader((tmp_path / "bed/rows.csv").open()))
    assert [row["verdict"] for row in rows] == ["FAIL"]
    assert json.loads((tmp_path / "bed/chapter.json").read_text())["machine"]["openfoam"]


def test_the_book_in_the_repository_links_to_what_is_there() -> None:
    book = project_root() / "docs/verification"
    page = (book / "index.md").read_text()
    pictures = [part.split(")")[0] for part in page.split("](")[1:] if ".png)" in part]
    assert len(pictures) >= 10
    assert all((book / picture).is_file() for picture in pictures)


def test_sample_bounce(tmp_path: Path) -> None:
    exact = contacts.Bounce(5e4, 0.9, 9.81)
    ball = Particles.of((0.5, 0.5, 0.5), diameter=0.2, density=2600.0)
    found = collide(
        tmp_path / "case", ball, linear(5e4, 0.9), step=5e-3, duration=0.6, writes=6, gravity=9.81,
        contacts=contacts.FINE,
    )  # fmt: skip
    error = max(abs(p.position[0, 2] - exact.at(t)) for t, p in found.items())
    assert error < 1.4e-4


def test_sample_drag_of_a_suspension(tmp_path: Path) -> None:
    law = drag.SUSPENSION_LAWS["GidaspowDrag"]
    force = {"GidaspowDrag": {"alphac": "alpha.air"}}
    found, said = drag.drag_coefficients(tmp_path / "case", force, 0.4)
    errors = [abs(cd / law(re, 0.6) - 1) for cd, re in zip(found, drag.REYNOLDS, strict=True)]
    assert max(errors) < 1e-6
    assert "is used at" not in said


def test_sample_packed_bed(tmp_path: Path) -> None:
    found = bed.held_bed(tmp_path / "case", 1e-3, 0.4, 1.0, bed.STOCK)
    error = abs(found.middle / bed.ergun(1.0, 1e-3, 0.4) - 1)
    assert error < 0.01


def test_sample_well_mixed(tmp_path: Path) -> None:
    """Chi-squared of 20 slices below its 95 % limit where turbulence decays to the walls."""

    def turbulence(height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        k = 1.5 * (0.1 + 0.4 * height) ** 2
        return k, k / 0.0415

    places = dispersion.spread(tmp_path / "case", dispersion.CONTINUOUS, turbulence, 4000)
    counts, _ = np.histogram(places, 20, (0, 1))
    assert ((counts - 200) ** 2 / 200).sum() < 30.1


def test_sample_own_wake(tmp_path: Path) -> None:
    plain = wake.settling_error(tmp_path / "plain", 5e-4, 2, corrected=False)
    corrected = wake.settling_error(tmp_path / "corrected", 5e-4, 2, corrected=True)
    assert abs(corrected) / abs(plain) < 0.3


def test_sample_own_wake_in_gas_at_rest(tmp_path: Path) -> None:
    """A grain that the gas holds stays in the wake it had when the gas was last solved."""
    plain = wake.own_share(tmp_path / "plain", 8e-4, 5e-3, 0.0, gas="auto", corrected=False)
    corrected = wake.own_share(tmp_path / "corrected", 8e-4, 5e-3, 0.0, "auto", corrected=True)
    assert plain > 0.005
    assert abs(corrected) < 0.001


@pytest.mark.slow
@pytest.mark.parametrize("name", page.ORDER)
def test_a_chapter_runs_whole(tmp_path: Path, name: str) -> None:
    module = importlib.import_module(f"elutria_validation.chapters.{name}")
    chapter = module.run(Options(tmp_path / name, quick=True, say=print))
    assert [row for row in chapter.rows if row.allowed is not None]
    assert [row.failure for row in chapter.failed] == []


def test_a_scene_has_every_field_that_openfoam_must_read(tmp_path: Path) -> None:
    """Those of CollidingParcel and KinematicParcel in v1912 to v2512 (their readFields)."""
    write_particles(tmp_path, Particles.of((0.5, 0.5, 0.5)))
    kinematic = "active typeId nParticle d dTarget U rho age tTurb UTurb UCorrect"
    pair = "PairAccessed PairOrigProcOfOther PairOrigIdOfOther PairData"
    wall = "WallAccessed WallPRel WallData"
    records = [f"collisionRecords{name}" for name in f"{pair} {wall}".split()]
    wanted = {*kinematic.split(), "f", "angularMomentum", "torque", *records}
    there = {file.name for file in (tmp_path / "0/lagrangian/kinematicCloud").iterdir()}
    assert wanted - there == set()
