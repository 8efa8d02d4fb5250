"""The command line: codes, one-line errors, examples; nothing bad gets through or takes long."""

from __future__ import annotations

import json
import os
import random
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from elutria.cli import main

COMMANDS = [
    "check", "run", "sweep", "find", "classify", "plot", "report", "atlas", "vtk", "bench",
    "verify",
]  # fmt: skip
PARAMETERS = "system/simulationParameters"
TEXT_FILES = [
    "constant/feed",
    "system/simulationParameters",
    "constant/transportProperties",
    "constant/g",
    "constant/kinematicCloudProperties",
    "system/blockMeshDict",
]


class Outcome:
    """What a command left: its exit code and what it printed."""

    def __init__(self, code: int, out: str, err: str):
        self.code = code
        self.out = out
        self.err = err.strip()


def call(capsys: pytest.CaptureFixture[str], *arguments: object) -> Outcome:
    code = 0
    try:
        main([str(argument) for argument in arguments])
    except SystemExit as end:
        code = int(end.code or 0)
    captured = capsys.readouterr()
    return Outcome(code, captured.out, captured.err)


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_has_help_with_an_example(
    capsys: pytest.CaptureFixture[str], command: str
) -> None:
    outcome = call(capsys, command, "--help")
    assert outcome.code == 0
    assert f"Example: elutria {command}" in " ".join(outcome.out.split())


def test_check_says_what_was_understood(capsys: pytest.CaptureFixture[str], column: Path) -> None:
    before = sorted(column.rglob("*"))
    outcome = call(capsys, "check", column)
    assert outcome.code == 0
    for words in ("quartz", "2650", "SchillerNaumannDrag", "0.2 kg", "feedSlot"):
        assert words in outcome.out
    assert sorted(column.rglob("*")) == before


LOCALES = {
    "C": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    "UTF-8": {"LC_ALL": "C.UTF-8"},
}


@pytest.mark.parametrize("locale", LOCALES)
@pytest.mark.usefixtures("fake_solver")
def test_names_are_utf_8_whatever_the_locale(column: Path, tmp_path: Path, locale: str) -> None:
    def said(*words: str | bytes) -> tuple[int, str]:
        command = [sys.executable, "-m", "elutria", *words]
        done = subprocess.run(command, env={**os.environ, **LOCALES[locale]}, cwd=tmp_path,
                              capture_output=True, check=False)  # fmt: skip
        return done.returncode, done.stderr.decode()

    case = column.rename(tmp_path / "säule")
    few = ("--set", f"{PARAMETERS}:particles=50")
    assert said("run", case.name, "--velocity", "5", *few, "--to", "ergebnis-ö") == (0, "")
    assert json.loads((tmp_path / "ergebnis-ö/elutria.json").read_text())["case"] == "säule"
    assert said("sweep", case.name, "--velocity", "4,5", *few, "--to", "ü") == (0, "")
    assert said("check", b"s\xe4ule") == (
        2, "elutria: s\\xe4ule: is not UTF-8; allowed: names in UTF-8\n"
    )  # fmt: skip


@pytest.mark.parametrize(
    "arguments",
    [
        ["check", "nowhere"],
        ["check"],
        ["chekc", "CASE"],
        ["run", "nowhere"],
        ["run", "CASE", "--velocity", "0"],
        ["run", "CASE", "--velocity", "nan"],
        ["run", "CASE", "--velocity", "-3"],
        ["run", "CASE", "--velocity", "fast"],
        ["run", "CASE", "--set", "nonsense"],
        ["run", "CASE", "--set", "../outside:a=1"],
        ["run", "CASE", "--set", "/etc/passwd:a=1"],
        ["run", "CASE", "--set", "constant/fed:a=1"],
        ["run", "CASE", "--to", "CASE/results"],
        ["run", "CASE", "--to", "CASE"],
        ["run", "CASE", "--to", "/proc/nowhere/results"],
        ["run", "CASE", "--np", "0"],
        ["run", "CASE", "--to", "TMP/r", "--set", "constant/feed:materials/quartz/densty=1"],
        ["run", "CASE", "--to", "TMP/r", "--set", "constant/feed:materials/quartz/density=-1"],
        ["sweep", "CASE"],
        ["sweep", "CASE", "--velocity", "0:5:3"],
        ["sweep", "CASE", "--velocity", "5", "--replicates", "0"],
        ["sweep", "CASE", "--velocity", "5", "--jobs", "-1"],
        ["sweep", "CASE", "--velocity", "5", "--to", "/dev/null/x"],
        ["classify", "CASE"],
        ["classify", "nowhere"],
        ["plot", "nowhere"],
        ["plot", "CASE"],
        ["plot", "CASE", "--format", "jpg"],
        ["report", "nowhere"],
        ["atlas", "nowhere"],
        ["atlas", "CASE"],
        ["report", "CASE"],
        ["report", "CASE", "--to", "TMP/page.pdf"],
        ["bench", "nothing"],
        ["verify", "nothing"],
    ],
    ids=" ".join,
)
@pytest.mark.usefixtures("fake_solver")
def test_bad_input_is_code_2_and_one_line(
    capsys: pytest.CaptureFixture[str], column: Path, tmp_path: Path, arguments: list[str]
) -> None:
    places = {"CASE": str(column), "TMP": str(tmp_path)}
    words = [re.sub("CASE|TMP", lambda match: places[match[0]], word) for word in arguments]
    outcome = call(capsys, *words)
    assert outcome.code == 2, outcome.err
    assert outcome.err.startswith("elutria: ")
    assert "\n" not in outcome.err
    assert "Traceback" not in outcome.err


def test_colons_of_a_message_are_no_picture(
    capsys: pytest.CaptureFixture[str], column: Path
) -> None:
    assert "A:B:N" in call(capsys, "run", str(column), "--velocity", "-3").err


def test_debug_shows_where_it_came_from(capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "check", "nowhere", "--debug")
    assert outcome.code == 2
    assert "Traceback" in outcome.err


@pytest.mark.usefixtures("fake_solver")
def test_run_classify_and_plot_together(
    capsys: pytest.CaptureFixture[str], column: Path, tmp_path: Path
) -> None:
    to = tmp_path / "run"
    outcome = call(capsys, "run", column, "--velocity", "6", "--to", to)
    assert outcome.code == 0, outcome.err
    assert "column: " in outcome.out  # plain progress lines where there is no terminal
    figures = ["partition_curves.png", "cut_size.png", "size_distributions.png"]
    for figure in figures:
        (to / figure).unlink()
    assert call(capsys, "plot", to).code == 0
    assert all((to / figure).stat().st_size > 10_000 for figure in figures)
    (quartz, everything) = json.loads(call(capsys, "classify", to, "--json").out)
    assert quartz["d50_m"] == pytest.approx(600e-6, rel=0.05)
    assert everything["material"] == "all"


@pytest.fixture
def one_core() -> Iterator[None]:
    """This process, and those that it starts, may use one core alone."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    yield
    os.sched_setaffinity(0, before)


@pytest.mark.parametrize("command", ["run", "sweep"])
@pytest.mark.usefixtures("fake_solver", "one_core")
def test_processors_that_are_left_out_are_told(
    capsys: pytest.CaptureFixture[str], column: Path, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch, command: str,
) -> None:  # fmt: skip
    words = [command, column, "--velocity", "6", "--np", "8", "--to", tmp_path / "to"]
    outcome = call(capsys, *words)
    assert outcome.code == 0, outcome.err
    line = "--np 8 -> 1: there is 1 core here (ELUTRIA_EXACT=yes takes 8)"
    assert outcome.out.splitlines().count(line) == 1
    assert (", on 1 of 8 processors" in outcome.out) == (command == "sweep")
    assert line not in call(capsys, *words).out, "nothing is run"
    monkeypatch.setenv("ELUTRIA_EXACT", "no")
    words[-1] = tmp_path / "other"
    outcome = call(capsys, *words)
    assert (outcome.code, outcome.out) == (2, "")
    assert "ELUTRIA_EXACT=no; allowed: yes" in outcome.err


@pytest.mark.parametrize(
    "options, said",
    [
        ([], "--velocity: is missing"),
        (["--velocity", "5", "--points", "points.csv"], "--points points.csv: allowed: either"),
        (["--points", "nowhere.csv"], "nowhere.csv: file not found"),
        (["--velocity", "5", "--vary", f"{PARAMETERS}:loadin=1,2"], "loading"),
        (
            ["--velocity", "5", "--vary", f"{PARAMETERS}:loading=1,2", "--set",
             f"{PARAMETERS}:loading=3"],
            "is varied too",
        ),
        (["--velocity", "5", "--vary", f"{PARAMETERS}:loading=-1,2"], "loading"),
    ],
)  # fmt: skip
def test_a_sweep_over_nothing_is_one_line_and_runs_nothing(
    capsys: pytest.CaptureFixture[str],
    column: Path,
    tmp_path: Path,
    fake_solver: Path,
    options: list[str],
    said: str,
) -> None:
    outcome = call(capsys, "sweep", column, *options, "--to", tmp_path / "to")
    assert outcome.code == 2
    assert said in outcome.err
    assert "\n" not in outcome.err
    assert not fake_solver.exists()
    assert not (tmp_path / "to").exists()


@pytest.mark.usefixtures("fake_solver")
def test_a_failed_velocity_is_code_1_and_named(
    capsys: pytest.CaptureFixture[str],
    column: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("FAKE_FAIL_AT", "5")
    small = "system/simulationParameters:particles=200"
    to = tmp_path / "results"
    outcome = call(capsys, "sweep", column, "--velocity", "5,6", "--set", small, "--to", to)
    assert outcome.code == 1
    assert "5 m/s" in outcome.err
    assert "cell 12" in outcome.err
    assert "1 of 2 runs failed" in outcome.err


def spoil(text: str, draw: random.Random) -> str:
    """`text` as a tired user, a broken disk or someone nasty would leave it."""
    lines = text.splitlines()
    kind = draw.randrange(11)
    position = draw.randrange(len(text))
    if kind == 0:
        return text[:position]
    if kind == 1:
        return text[:position] + draw.choice('{}();"#$\x00\xff') + text[position:]
    if kind == 2:
        del lines[draw.randrange(len(lines))]
        return "\n".join(lines)
    if kind == 3:
        return "".join(chr(draw.randrange(256)) for _ in range(300))
    if kind == 4:
        return ""
    words = list(re.finditer(r"[A-Za-z]{4,}", text))
    numbers = list(re.finditer(r"(?<=\s)-?\d+(\.\d+)?(e-?\d+)?(?=[;\s)])", text))
    if kind == 5:
        match = draw.choice(words)
        return text[: match.start() + 1] + text[match.start() + 2 :]
    if kind == 6:
        return text.replace(";", "", 1)
    if kind == 7:
        return "(" * draw.randrange(1, 50_000) + text
    if kind == 8:
        return text + '\nevil #calc "system(\\"touch executed\\")";\n'
    if kind == 9:
        return text + '\n#include "/dev/zero"\n'
    match = draw.choice(numbers)
    value = draw.choice(["nan", "-1", "0", "1e300", "inf", "word", "(1 2)", "$nowhere", "#calc"])
    return text[: match.start()] + value + text[match.end() :]


def check_spoilt(
    capsys: pytest.CaptureFixture[str], column: Path, folder: Path, seeds: range
) -> None:
    for seed in seeds:
        draw = random.Random(seed)
        case = folder / draw.choice(["plain", "with space", "quo'te", 'dou"ble'])
        shutil.copytree(column, case)
        name = draw.choice(TEXT_FILES)
        text = (case / name).read_text()
        (case / name).write_text(spoil(text, draw), encoding="latin-1")
        outcome = call(capsys, "check", case)
        # what was spoilt may still be a case (a comment, a number): never anything but 0 or 2
        assert outcome.code in (0, 2), (seed, name, outcome.err)
        if outcome.code == 2:
            assert "\n" not in outcome.err, (seed, name, outcome.err)
            assert Path(name).name in outcome.err, (seed, name, outcome.err)
        assert not list(folder.rglob("executed"))
        shutil.rmtree(case)


def test_spoilt_dictionaries(
    capsys: pytest.CaptureFixture[str], column: Path, tmp_path: Path
) -> None:
    check_spoilt(capsys, column, tmp_path, range(25))


@pytest.mark.slow
def test_many_spoilt_dictionaries(
    capsys: pytest.CaptureFixture[str], column: Path, tmp_path: Path
) -> None:
    check_spoilt(capsys, column, tmp_path, range(1_000, 1_400))


def test_a_folder_that_cannot_be_written(
    capsys: pytest.CaptureFixture[str], column: Path, tmp_path: Path
) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    outcome = call(capsys, "sweep", column, "--velocity", "5", "--to", blocked / "results")
    assert outcome.code == 2
    assert "--to" in outcome.err


def test_the_module_is_the_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "elutria", "check", "nowhere"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
