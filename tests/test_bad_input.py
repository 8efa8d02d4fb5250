"""Malformed dictionaries, feeds, meshes and results: one line, code 2, soon; nothing is executed.

The inputs are made from a seed (support/malformed.py). What came of them, by kind, is listed
at the end of the output.
"""

from __future__ import annotations

import random
import re
import shutil
import signal
import time
from pathlib import Path

import pytest

from elutria.cli import main
from elutria_validation.harness.programs import run_program
from tests.support import malformed
from tests.support.malformed import Input

SECONDS = 5
SEED = 20_260
FOLDERS = ["plain", "with space", "quo'te", 'dou"ble', "$(touch executed)", "semi;colon", "-n"]
DICTIONARIES = [
    malformed.FEED, malformed.PARAMETERS, malformed.GAS, malformed.GRAVITY, malformed.CLOUD,
    malformed.CONTROL, "system/blockMeshDict",
]  # fmt: skip


def case_inputs(seed: int) -> list[Input]:
    """Of dictionaries and feeds, for `elutria check` and `elutria sweep`."""
    draw = random.Random(seed)
    inputs = list(malformed.entry_inputs(draw))
    for file in DICTIONARIES:
        target = "feed" if file == malformed.FEED else "dictionary"
        inputs += malformed.file_inputs(draw, file, target)
    return inputs


def result_inputs(seed: int) -> list[Input]:
    """Of a run's tables, for `elutria classify`."""
    draw = random.Random(seed)
    tables = ["postProcessing/outlets/0/particles.csv", "postProcessing/inside.csv"]
    inputs = []
    for file in (*tables, "postProcessing/ledger.json"):
        made = malformed.file_inputs(draw, file, "result")
        inputs += [i for i in made if (i.kind, file) not in LEGAL]
    for file in tables:
        inputs += malformed.table_inputs(draw, file)
    return inputs


def figure_inputs(seed: int) -> list[Input]:
    """Of a sweep's tables, for `elutria plot`."""
    draw = random.Random(seed)
    inputs = []
    for file in ("summary.csv", "partition.csv", "curve.csv"):
        inputs += [i for i in malformed.file_inputs(draw, file, "result")
                   if (i.kind, file) not in LEGAL]  # fmt: skip
        inputs += malformed.table_inputs(draw, file)
    return inputs


# no input at all: a figure goes without its fitted curves
LEGAL = {("absent", "curve.csv")}


class TookTooLong(Exception):
    """Raised by the alarm."""


def call(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, float]:
    """Code, error output and seconds of a command; stopped when it hangs."""

    def stop(*_: object) -> None:
        raise TookTooLong

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(4 * SECONDS)
    start = time.process_time()  # the machine may be shared
    code = 0
    try:
        main(list(arguments))
    except SystemExit as end:
        code = int(end.code or 0)
    except TookTooLong:
        code = -1
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    return code, capsys.readouterr().err.strip(), time.process_time() - start


def judge(given: Input, command: str, where: Path, code: int, said: str, seconds: float) -> str:
    """What is wrong with an answer; empty when it is as it must be."""
    complaints = []
    if code != 2:
        complaints.append(f"code {code}")
    if seconds > SECONDS:
        complaints.append(f"{seconds:.1f} s")
    if "\n" in said or not said.startswith("elutria: "):
        complaints.append("not one line")
    if "Traceback" in said or "internal error" in said:
        complaints.append("traceback")
    if Path(given.file).name not in said and Path(given.file).parent.name not in said:
        complaints.append("does not name the file")
    if given.entry and given.entry not in said and not re.search(r"on line \d+", said):
        complaints.append(f"does not name {given.entry}")
    if list(where.rglob("executed")) or Path("executed").exists():
        complaints.append("executed something")
    malformed.outcomes[given.kind, command, "refused" if not complaints else "WRONG"] += 1
    return f"{command} of {given}: {', '.join(complaints)}: {said[:300]}" if complaints else ""


def check_all(
    capsys: pytest.CaptureFixture[str],
    sound: Path,
    place: Path,
    inputs: list[Input],
    command: list[str],
    seed: int = SEED,
) -> None:
    """Spoil copies of `sound`, one input each, and give them to a command."""
    draw, wrong = random.Random(seed), []
    for given in inputs:
        folder = place / draw.choice(FOLDERS)
        shutil.copytree(sound, folder, symlinks=True)
        given.spoil(folder)
        arguments = [word.replace("CASE", str(folder)) for word in command]
        wrong.append(judge(given, command[0], place, *call(capsys, *arguments)))
        shutil.rmtree(folder)
    wrong = [text for text in wrong if text]
    assert not wrong, f"{len(wrong)} of {len(inputs)}:\n" + "\n".join(wrong)


def some(inputs: list[Input], number: int) -> list[Input]:
    return random.Random(SEED).sample(inputs, number)


CHECK, CLASSIFY, PLOT = ["check", "CASE"], ["classify", "CASE", "--json"], ["plot", "CASE"]


@pytest.fixture
def run_of(column: Path, fake_solver: Path, tmp_path: Path) -> Path:  # noqa: ARG001
    """A finished run with its tables, of a stand-in for the solver."""
    small = "system/simulationParameters:particles=200"
    main(["run", str(column), "--to", str(tmp_path / "run"), "--set", small])
    shutil.rmtree(tmp_path / "run/0")
    return tmp_path / "run"


@pytest.fixture
def meshed(column: Path) -> Path:
    """The column with an ASCII mesh of few cells and nothing that makes it."""
    plan = column / "system/blockMeshDict"
    text = plan.read_text().replace("(10 10 49)", "(2 2 5)")
    plan.write_text(text.replace("(10 10 2)", "(2 2 1)"))
    control = column / "system/controlDict"
    text = control.read_text()
    control.write_text(text.replace("binary", "ascii"))
    run_program(["blockMesh"], column)
    control.write_text(text)
    plan.unlink()
    return column


def test_some_dictionaries_and_feeds(
    capsys: pytest.CaptureFixture[str], column: Path, tmp_path: Path
) -> None:
    check_all(capsys, column, tmp_path / "in", some(case_inputs(SEED), 40), CHECK)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_all_dictionaries_and_feeds(
    capsys: pytest.CaptureFixture[str], column: Path, tmp_path: Path, seed: int
) -> None:
    check_all(capsys, column, tmp_path / "in", case_inputs(seed), CHECK, seed)


@pytest.mark.parametrize("number", [4, pytest.param(0, marks=pytest.mark.slow)])
def test_what_openfoam_takes_without_a_word(
    capsys: pytest.CaptureFixture[str], column: Path, tmp_path: Path, number: int
) -> None:
    inputs = list(malformed.silent_inputs("0.orig"))
    check_all(capsys, column, tmp_path / "in", some(inputs, number or len(inputs)), CHECK)


def test_some_meshes(capsys: pytest.CaptureFixture[str], meshed: Path, tmp_path: Path) -> None:
    inputs = list(malformed.mesh_inputs(random.Random(SEED)))
    check_all(capsys, meshed, tmp_path / "in", some(inputs, 15), CHECK)


@pytest.mark.slow
def test_all_meshes(capsys: pytest.CaptureFixture[str], meshed: Path, tmp_path: Path) -> None:
    inputs = list(malformed.mesh_inputs(random.Random(1)))
    check_all(capsys, meshed, tmp_path / "in", inputs, CHECK)


@pytest.mark.parametrize(
    ("make", "command", "number"),
    [(result_inputs, CLASSIFY, 12), (figure_inputs, PLOT, 12)],
    ids=["classify", "plot"],
)
def test_some_results(
    capsys: pytest.CaptureFixture[str], run_of: Path, tmp_path: Path, make, command, number
) -> None:
    capsys.readouterr()
    check_all(capsys, run_of, tmp_path / "in", some(make(SEED), number), command)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "command"),
    [(result_inputs, CLASSIFY), (figure_inputs, PLOT)],
    ids=["classify", "plot"],
)
def test_all_results(
    capsys: pytest.CaptureFixture[str], run_of: Path, tmp_path: Path, make, command
) -> None:
    capsys.readouterr()
    check_all(capsys, run_of, tmp_path / "in", make(1), command)


@pytest.mark.parametrize("number", [8, pytest.param(80, marks=pytest.mark.slow)])
def test_a_sweep_of_what_is_malformed_starts_nothing(
    capsys: pytest.CaptureFixture[str],
    column: Path,
    fake_solver: Path,
    tmp_path: Path,
    number: int,
) -> None:
    # a sweep reads the feed and the parameters, and gives the velocity itself
    inputs = [i for i in case_inputs(SEED + 1) if i.target == "feed"]
    command = ["sweep", "CASE", "--velocity", "5", "--to", str(tmp_path / "results")]
    check_all(capsys, column, tmp_path / "in", some(inputs, number), command)
    assert not fake_solver.exists()
