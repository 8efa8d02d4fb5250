"""The verification book: that it can fail, its page, its notes, and the cases that it runs."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass, fields, replace
from math import nan
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np
import pytest
from foamlib import FoamFile

from elutria import cli
from elutria.errors import InputError
from elutria_validation import commands
from elutria_validation.book.page import ORDER, read_notes
from elutria_validation.book.rows import Chapter, Row, Section
from elutria_validation.book.writing import write_chapter
from elutria_validation.chapters import drag
from elutria_validation.chapters import measured_riser as riser
from elutria_validation.chapters.measured_bed import seen
from elutria_validation.harness import box
from elutria_validation.harness.box import BoxCase, Contacts, Material, Pair
from elutria_validation.harness.job import Job, option, parse_options
from elutria_validation.harness.particles import Particles, read_particles, write_particles
from elutria_validation.harness.programs import project_root

BOOK = project_root() / "docs/verification"


def section(name: str, ours: float) -> Section:
    """A section with one judged row, of reference 1."""
    row = Row.relative("here", f"value of {name}, m", 1.0, ours, 0.01, "1 %")
    return Section(f"Case of {name}", "What is <checked>.", "What was found.", [row])


def judged(name: str, ours: float) -> Any:
    """A chapter's module with one section."""
    sections = (lambda _folder, _quick: section(name, ours),)
    return SimpleNamespace(NAME=name, TITLE=name.title(), HELP="", SECTIONS=sections)


def test_a_row_passes_fails_or_informs() -> None:
    assert Row.relative("a", "b", 2.0, 2.01, 0.01).verdict == "pass"
    assert Row.relative("a", "b", 2.0, 2.1, 0.01).verdict == "FAIL"
    assert Row.relative("a", "b", 2.0, nan, 0.01).verdict == "FAIL"
    assert Row.relative("a", "b", 2.0, 2.1, None).verdict == "info"
    assert Row.size("a", "b", -0.1, 0.01).verdict == "FAIL"
    worst = Row.worst("a", "b", ["here", "there"], [1.0, 2.0], [1.0, 2.2], 0.05)
    assert (worst.verdict, worst.reference, worst.ours) == ("FAIL", 2.0, 2.2)
    assert "there" in worst.checked
    assert Row.worst("a", "b", ["here", "there"], [1, 1], [1, nan], 0.05).verdict == "FAIL"


def verify(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str]:
    """Exit code of `elutria verify ...` and the lines on its standard error."""
    code = 0
    try:
        cli.main(["verify", *map(str, arguments)])
    except SystemExit as ended:
        code = int(ended.code or 0)
    return code, capsys.readouterr().err


@pytest.mark.parametrize(("force", "code"), [("GanserDrag", 0), ("SchillerNaumannDrag", 1)])
def test_a_wrong_law_in_the_solver_turns_the_book_red(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    force: str,
    code: int,
) -> None:
    """Rows judge Ganser's law; the solver computes `force`."""

    def ganser(folder: Path, _quick: bool) -> Section:
        found = Section("Ganser", "")
        drag._table_rows(found, folder, "GanserDrag", True, (0.7,))
        return found

    monkeypatch.setattr(drag, "SECTIONS", (ganser,))
    monkeypatch.setattr(drag, "force", lambda _name, s: {force: {"sphericity": s}})
    ended, said = verify(capsys, "drag", "--to", tmp_path / "drag")
    assert ended == code
    assert ("FAIL GanserDrag, sphericity 0.7: Cd, by Kratos" in said) == (code == 1)


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
        chapter = Chapter(name, name.title(), [section(name, ours)])
        write_chapter(Job(tmp_path / name, say=lambda _: None), chapter)
    page = (tmp_path / "index.md").read_text()
    assert page.index("Case of drag") < page.index("Case of bed")
    assert "1 of 2 rows pass" in page
    assert "| [Case of bed](#case-of-bed) | 0 of 1 | 50 | 1 % | FAIL |" in page
    assert "| here | value of bad, m | 1 | 1.5 | 0.5 | 0.01 | 1 % | FAIL |".replace(
        "bad", "bed"
    ) in page  # fmt: skip
    assert "**Found.** What was found." in page
    assert "What is &lt;checked&gt;." in (tmp_path / "index.html").read_text()
    rows = list(csv.DictReader((tmp_path / "bed/rows.csv").open()))
    assert [row["verdict"] for row in rows] == ["FAIL"]
    assert json.loads((tmp_path / "bed/chapter.json").read_text())["machine"]["openfoam"]


def test_one_section_is_made_anew_among_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ours = {"first": 1.0, "second": 1.0, "third": 1.0}

    def make(name: str) -> Any:
        def run(_folder: Path, _quick: bool) -> Section:
            return section(name, ours[name])

        run.__name__ = name
        return run

    module = judged("drag", 1.0)
    module.SECTIONS = [make(name) for name in ours]
    monkeypatch.setattr(commands, "modules", lambda _: {"drag": module})
    folder = tmp_path / "drag"
    assert verify(capsys, "drag", "--section", "third", "--to", folder)[0] == 0
    assert verify(capsys, "drag", "--to", folder)[0] == 0
    ours.update(first=3.0, second=1.5)
    code, said = verify(capsys, "drag", "--section", "second", "--to", folder)
    assert code == 1
    assert "FAIL here: value of second, m: 0.5" in said
    rows = list(csv.DictReader((folder / "rows.csv").open()))
    assert [row["ours"] for row in rows] == ["1", "1.5", "1"]
    code, said = verify(capsys, "drag", "--section", "secund", "--to", folder)
    assert code == 2
    assert "--section secund, did you mean 'second'?; allowed: first, second, third" in said
    assert verify(capsys, "all", "--section", "first", "--to", tmp_path)[0] == 2


def test_the_book_in_the_repository_links_to_what_is_there() -> None:
    page = (BOOK / "index.md").read_text()
    pictures = [part.split(")")[0] for part in page.split("](")[1:] if ".png)" in part]
    assert len(pictures) >= 10
    assert all((BOOK / picture).is_file() for picture in pictures)


def test_a_note_says_when_it_was_true_and_belongs_to_a_section() -> None:
    files = sorted((BOOK / "notes").glob("*.md"))
    assert files
    for file in files:
        assert file.stem in ORDER
        titles = {
            one["title"]
            for one in json.loads((BOOK / file.stem / "chapter.json").read_text())["sections"]
        }
        notes = read_notes(file)
        assert notes
        assert notes.keys() <= titles
        for note in notes.values():
            assert note.written.startswith("written 20")
            assert ", commit " in note.written


@dataclass(frozen=True)
class Own:
    number: int = option(10, quick=3, least=1, unit="of them")
    share: float = option(0.5)
    kind: Literal["a", "b"] = option("a")
    place: str | None = option(None)


def test_options_are_typed_and_a_short_run_has_its_own() -> None:
    assert parse_options(Own, [], quick=False) == Own()
    assert parse_options(Own, [], quick=True).number == 3
    found = parse_options(Own, ["number=7", "share=1e-3", "kind=b", "place=x=y"], quick=True)
    assert found == Own(7, 1e-3, "b", "x=y")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("nunber=3", "nunber, did you mean 'number'?; allowed: number=10 of them, share=0.5"),
        ("number=three", "number=three; allowed: a whole number >= 1"),
        ("number=0", "number=0; allowed: a whole number >= 1"),
        ("share=nan", "share=nan; allowed: a number"),
        ("kind=c", "kind=c; allowed: a or b"),
        ("number", "is not KEY=VALUE"),
    ],
)
def test_an_option_that_is_not_known_or_no_number_is_one_line(given: str, said: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_options(Own, [given], quick=False)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("command", ["bench neighbours", "bench column", "verify drag"])
def test_a_misspelt_option_of_a_command_is_refused(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main([*command.split(), "--option", "largets=3"])
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--option largets" in line
    assert "allowed:" in line


def test_the_defaults_of_a_box_are_what_its_files_say() -> None:
    words: dict[Any, set[Any]] = {True: {True, "on"}, False: {False, "off"}}
    checked = 0
    for one in fields(BoxCase):
        for place in one.metadata.get("places", ()):
            file, _, entry = place.partition(":")
            if isinstance(one.default, (int, float, str)):
                written: Any = FoamFile(box.TEMPLATE / file)[tuple(entry.split("/"))]
                assert written in words.get(one.default, {one.default}), place
                checked += 1
    assert checked > 15


def test_a_box_writes_what_differs_and_nothing_else() -> None:
    usual = BoxCase().settings()
    assert usual == {"system/controlDict:endTime": 1.0, "system/controlDict:writeInterval": 1.0}
    law = Contacts(Pair(0.9, 0.1), wall_pair=Pair(0.5), particle=Material(1e8), step_fraction=0.01)
    found = replace(
        BoxCase(), width=0.2, cells=(1, 1, 4), ends="wall", gravity=0, contacts=law, interval=0.1
    ).settings()
    contacts = "constant/kinematicCloudProperties:subModels/cellListCoeffs"
    parameters = "system/simulationParameters"
    assert found[f"{parameters}:width"] == 0.2
    assert f"{parameters}:height" not in found
    assert found[f"{parameters}:cellsAlong"] == 4
    assert found[f"{parameters}:bottomGroup"] == "closed"
    assert found[f"{parameters}:gravity"] == 0
    assert found["system/controlDict:writeInterval"] == 0.1
    assert found[f"{contacts}/particleWall"]["restitution"] == 0.5
    assert found[f"{contacts}/wall"]["youngsModulus"] == 1e8
    assert found[f"{contacts}/stepFraction"] == 0.01


def test_particles_come_back_as_they_were_written(tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    start = Particles.of(random.normal(size=(5, 3)), random.normal(size=(5, 3)),
                         random.normal(size=(5, 3)), 1e-3 * random.uniform(size=5))  # fmt: skip
    write_particles(tmp_path, start)
    found = read_particles(tmp_path, "0")
    for name in ("position", "velocity", "diameter", "density"):
        assert np.array_equal(getattr(found, name), getattr(start, name))
    assert np.allclose(found.spin, start.spin, rtol=1e-14)
    assert len(read_particles(tmp_path, "1").diameter) == 0


def test_a_sphere_is_seen_from_above_where_none_lies_on_it() -> None:
    def share(*others: tuple[float, float, float, float]) -> float:
        placed = np.array([(0.0, 0.0, 0.0, 2.0), *others])
        return seen(Particles.of(placed[:, :3], diameter=placed[:, 3]), 0, 2000)

    assert share() == 1
    assert share((0, 0, -1, 9)) == 1
    assert share((0, 0, 1, 9)) == 0
    assert share((0, 0, 1, 1)) == pytest.approx(0.75, abs=0.01)
    assert share((0.5, 0, 1, 1), (-0.5, 0, 2, 1)) == pytest.approx(0.5, abs=0.01)
    assert share((1, 0, 1, 2)) == pytest.approx(1 - (2 / 3 - 3**0.5 / (2 * np.pi)), abs=0.01)


def test_hold_up_is_that_of_grains_laid_at_known_places() -> None:
    """A lattice, twice as dense beside both walls and none above 1 m; half of the times empty."""
    x, z = (np.arange(n) + 0.5 for n in (70, 1000))
    across = np.sort(np.r_[x, x[:7] + 0.25, x[-7:] - 0.25]) * 1e-3
    place = np.stack(np.meshgrid(across, [1e-3], z * 1e-3), axis=-1).reshape(-1, 3)
    none = np.empty((0, 3))
    speed = np.full(len(place), 0.5)
    found = riser.Grains([place, none] * 4, [speed, none[:, 0]] * 4, volume=2e-9, depth=2e-3)
    assert found.beside(0.8, "core") == pytest.approx(0.5)
    assert found.within(0.7, 0.9, (0.0, 0.1)).mean() == pytest.approx(1.0)
    assert found.beside(0.8, "walls") == pytest.approx(13 / (2 * 6.65))
    assert found.beside(1.2, "walls") == 0
    assert found.along(np.array([0.5, 1.3])) == pytest.approx([0.6, 0.0])
    assert found.mean == pytest.approx(0.6 * 0.9 / 1.3)
    assert found.flux == pytest.approx(0.5 * riser.DENSITY * found.mean)
    assert found.chance == pytest.approx(0, abs=1e-12)


def test_what_was_measured_in_the_riser_has_the_published_means() -> None:
    """0.0210 and 0.0347 from 0.1 to 1.4 m: integrals of all digitised points."""
    for velocity, mean in ((6.74, 0.0210), (5.95, 0.0347)):
        assert riser.measured_mean(velocity) == pytest.approx(mean, rel=0.02)
        for place in ("core", "wall", "other wall"):
            assert list(riser.measured(velocity, place)[0]) == [0.8, 1.1, 1.4]


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
