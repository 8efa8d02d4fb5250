"""Runs and sweeps with a stand-in for the solver: nothing twice, nothing half, others go on."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import pytest

from elutria import tables
from elutria.case.case import Case
from elutria.errors import ElutriaError, InputError
from elutria.estimates import ranks
from elutria.files import read_csv
from elutria.running.axes import grid, parse_velocities
from elutria.running.marker import Marker
from elutria.running.results import Results
from elutria.running.run import PLAN, Goal, is_finished, run_case
from elutria.running.solver import Step, follow
from elutria.running.sweep import plan, run_sweep
from tests.support.sweeps import SMALL, Silent, sweep


def started(starts: Path) -> list[str]:
    return starts.read_text().splitlines() if starts.exists() else []


@pytest.mark.usefixtures("fake_solver")
def test_a_run_is_a_copy_with_its_settings(column: Path, tmp_path: Path) -> None:
    before = (column / "system/simulationParameters").read_text()
    case = Case(column)
    to = tmp_path / "runs/one"
    seen: list[float] = []
    copy = run_case(
        case, to, case.settings_for(5.5, SMALL), on_step=lambda share, _: seen.append(share)
    )
    assert copy.velocity() == 5.5
    assert (column / "system/simulationParameters").read_text() == before
    assert not (column / "postProcessing").exists()
    assert (to / "0/U.air").is_file()
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1)
    assert "// m/s" in (to / "system/simulationParameters").read_text()


def test_what_is_finished_is_not_run_again(column: Path, fake_solver: Path, tmp_path: Path) -> None:
    case, to = Case(column), tmp_path / "one"
    for _ in range(3):
        run_case(case, to, case.settings_for(5, SMALL))
    assert len(started(fake_solver)) == 1
    # another seed, or a changed case, is another run
    run_case(case, to, case.settings_for(5, [*SMALL, "system/simulationParameters:seed=2"]))
    feed = column / "constant/feed"
    feed.write_text(feed.read_text().replace("2650", "2700"))
    run_case(case, to, case.settings_for(5, SMALL))
    assert len(started(fake_solver)) == 3


def test_processors_that_do_not_pay_are_left_out(
    column: Path, fake_solver: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case, to = Case(column), tmp_path / "one"
    said: list[str] = []
    settings = case.settings_for(5, SMALL)
    for cores in (1, 2):  # what is finished or under way is the same on another machine
        monkeypatch.setattr(ranks, "cores", lambda cores=cores: cores)
        run_case(case, to, settings, 8, say=said.append)
    assert said == ["--np 8 -> 1: there is 1 core here (ELUTRIA_EXACT=yes takes 8)"]
    assert len(started(fake_solver)) == 1
    assert json.loads((to / "finished.json").read_text())["np"] == 1
    marker = Marker.read(to)
    assert marker is not None
    assert marker.np == 1
    (to / "finished.json").unlink()
    run_case(case, to, settings, 8, say=said.append)
    assert said[1:] == ["--np 8 -> 1: the run that goes on has 1"]


def test_a_user_may_insist_on_processors(
    column: Path, fake_solver: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, text in (("mpirun", 'shift 2; exec "$@"'), ("decomposePar", "echo End")):
        program = tmp_path / "programs" / name
        program.write_text(f"#!/bin/sh\n{text}\n")
        program.chmod(0o755)
    monkeypatch.setenv("ELUTRIA_EXACT", "yes")
    case, to = Case(column), tmp_path / "one"
    said: list[str] = []
    run_case(case, to, case.settings_for(5, SMALL), 8, say=said.append)
    assert said == []
    assert json.loads((to / "finished.json").read_text())["np"] == 8
    assert "numberOfSubdomains 8;" in (to / "system/decomposeParDict").read_text()
    assert len(started(fake_solver)) == 1


@pytest.mark.usefixtures("fake_solver")
def test_a_folder_of_someone_else_is_left_alone(column: Path, tmp_path: Path) -> None:
    to = tmp_path / "precious"
    to.mkdir()
    (to / "thesis.tex").write_text("years of work")
    case = Case(column)
    with pytest.raises(InputError, match="not a run of elutria"):
        run_case(case, to, case.settings_for(5, SMALL))
    assert (to / "thesis.tex").read_text() == "years of work"


@pytest.mark.parametrize("name", ["with space", "quo'te", 'dou"ble', "$(touch x)", "a;b", "-n"])
@pytest.mark.usefixtures("fake_solver")
def test_odd_names_of_folders(column: Path, tmp_path: Path, name: str) -> None:
    case = Case(column)
    run_case(case, tmp_path / name, case.settings_for(5, SMALL))
    assert (tmp_path / name / "finished.json").is_file()
    assert not list(tmp_path.rglob("x"))


@pytest.mark.usefixtures("fake_solver")
def test_a_solver_that_fails_gives_its_reason(
    column: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case, to = Case(column), tmp_path / "one"
    monkeypatch.setenv("FAKE_FAIL_AT", "5")
    with pytest.raises(ElutriaError, match=r"time 0\.5, cell 12: velocity is not finite"):
        run_case(case, to, case.settings_for(5, SMALL))
    assert not (to / "finished.json").exists()
    monkeypatch.delenv("FAKE_FAIL_AT")
    monkeypatch.setenv("FAKE_CUT_AT", "5")  # ends with exit code 0, but without its last word
    with pytest.raises(ElutriaError, match="elutriaFoam failed"):
        run_case(case, to, case.settings_for(5, SMALL))
    monkeypatch.delenv("FAKE_CUT_AT")
    run_case(case, to, case.settings_for(5, SMALL))


def test_without_a_solver_nothing_is_begun(
    column: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    case = Case(column)
    with pytest.raises(InputError, match=r"elutriaFoam: not found on PATH.*etc/bashrc"):
        run_case(case, tmp_path / "one", case.settings_for(5, []))
    assert not (tmp_path / "one").exists()


def test_two_in_one_folder_do_not_mix(
    column: Path, fake_solver: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAKE_SLEEP", "3")
    to = tmp_path / "one"
    module = ["-m", "elutria.running.worker"]
    command = [sys.executable, *module, str(column), str(to), "1", "", "1", *SMALL]
    first = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    wait_for(lambda: len(started(fake_solver)) == 1)
    case = Case(column)
    with pytest.raises(ElutriaError, match="locked by another elutria"):
        run_case(case, to, case.settings_for(None, SMALL))
    first.terminate()
    first.wait()


def wait_for(condition: object, seconds: float = 600) -> None:
    end = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.02)


@pytest.mark.parametrize(
    "text, expected",
    [
        ("3:10:8", [3, 4, 5, 6, 7, 8, 9, 10]),
        ("5", [5]),
        ("6,4.5,6", [4.5, 6]),
        ("1:1:1", [1]),
        ("0.1:0.3:3", [0.1, 0.2, 0.3]),
    ],
)
def test_velocities(text: str, expected: list[float]) -> None:
    assert parse_velocities(text) == expected


@pytest.mark.parametrize(
    "text", ["0", "nan", "-3", "inf", "", "a", "3:10", "3:10:0", "3:10:2.5", "3,,4", "1e9", "3;4"]
)
def test_bad_velocities(text: str) -> None:
    with pytest.raises(InputError, match=r"--velocity .*allowed: A:B:N"):
        parse_velocities(text)


def test_a_sweep_makes_the_tables(column: Path, fake_solver: Path, tmp_path: Path) -> None:
    to = tmp_path / "results"
    result = sweep(column, to, "4:5:2")
    assert not result.failures
    rows = read_csv(to / "summary.csv", tables.SUMMARY)
    assert [(r["gas_velocity_m_s"], r["material"]) for r in rows] == [
        (u, m) for u in (4, 5) for m in ("quartz", "all")
    ]
    for row in rows:
        assert row["d50_m"] == pytest.approx(row["gas_velocity_m_s"] * 1e-4, rel=0.15)
        assert row["d50_low_m"] < row["d50_m"] < row["d50_high_m"]
        assert row["particles_fed"] == 400
        assert row["particles_lost"] == 0
    assert sweep(column, to, "4:5:2").skipped == 2
    assert len(started(fake_solver)) == 2
    # one velocity more: only that one is run
    sweep(column, to, "4:6:3")
    assert len(started(fake_solver)) == 3


def test_replicates_have_their_own_seeds(column: Path, fake_solver: Path, tmp_path: Path) -> None:
    result = sweep(column, tmp_path / "results", "5", replicates=3)
    assert sorted(started(fake_solver)) == ["5 1", "5 2", "5 3"]
    assert result.tables.summary[0]["particles_fed"] == 1200


def test_a_velocity_that_fails_leaves_the_others(
    column: Path, fake_solver: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    to = tmp_path / "results"
    monkeypatch.setenv("FAKE_FAIL_AT", "5")
    result = sweep(column, to, "4:5:2")
    assert list(result.failures) == ["5 m/s"]
    assert "cell 12" in result.failures["5 m/s"]
    rows = read_csv(to / "summary.csv", tables.SUMMARY)
    assert {row["gas_velocity_m_s"] for row in rows} == {4}
    assert json.loads((to / "sweep.json").read_text())["failed"]
    monkeypatch.delenv("FAKE_FAIL_AT")
    assert not sweep(column, to, "4:5:2").failures
    assert sorted(started(fake_solver)) == ["4 1", "5 1", "5 1"]


def without_times(path: Path) -> list[dict[str, object]]:
    rows = read_csv(path, tables.SUMMARY)
    return [{k: str(v) for k, v in row.items() if k != "wall_time_s"} for row in rows]


@pytest.mark.parametrize(
    "moment", [0.7, *(pytest.param(0.08 * k, marks=pytest.mark.slow) for k in range(1, 20))]
)
def test_a_killed_sweep_goes_on_and_ends_the_same(
    column: Path, fake_solver: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: float
) -> None:
    whole, to = tmp_path / "whole", tmp_path / "killed"
    sweep(column, whole, "4:6:3")
    fake_solver.unlink()
    monkeypatch.setenv("FAKE_SLEEP", "0.5")
    command = [
        sys.executable, "-m", "elutria", "sweep", str(column), "--velocity", "4:6:3",
        "--to", str(to), "--set", SMALL[0],
    ]  # fmt: skip
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    wait_for(lambda: len(started(fake_solver)) >= 1)
    time.sleep(moment)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    monkeypatch.setenv("FAKE_SLEEP", "0")
    before = [velocity for velocity in (4, 5, 6) if (to / f"U{velocity}/finished.json").is_file()]
    time.sleep(0.3)  # its workers end with it
    assert not sweep(column, to, "4:6:3").failures
    for name in ("partition.csv", "fit.csv"):
        assert (to / name).read_bytes() == (whole / name).read_bytes()
    assert without_times(to / "summary.csv") == without_times(whole / "summary.csv")
    for velocity in before:
        assert started(fake_solver).count(f"{velocity} 1") == 1


def workers(folder: Path) -> list[int]:
    """Processes of the runs below a folder."""
    listed = subprocess.run(["pgrep", "-f", f"elutria.running.worker.*{folder}"],
                            capture_output=True, text=True, check=False)  # fmt: skip
    return [int(word) for word in listed.stdout.split()]


def test_any_executor_makes_the_same_tables(
    column: Path, fake_solver: Path, tmp_path: Path
) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    sweep(column, here, "4:6:3")
    assert len(started(fake_solver)) == 3
    case = Case(column)
    members = plan(case, there, grid(case, "4:6:3", []), 1, SMALL)
    with ProcessPoolExecutor(2) as executor:
        assert not run_sweep(Results(case, there, SMALL), members, executor, 1, Silent()).failures
    for name in ("partition.csv", "fit.csv", "curve.csv"):
        assert (here / name).read_bytes() == (there / name).read_bytes()


def test_an_executor_that_breaks_fails_its_runs_by_name(
    column: Path, tmp_path: Path, fake_solver: Path
) -> None:
    class Broken(ThreadPoolExecutor):
        def submit(self, *_: object, **__: object) -> Future[None]:  # type: ignore[override]
            future: Future[None] = Future()
            future.set_exception(BrokenExecutor("a worker was lost"))
            return future

    case = Case(column)
    members = plan(case, tmp_path / "to", grid(case, "4,5", []), 1, SMALL)
    result = run_sweep(Results(case, tmp_path / "to", SMALL), members, Broken(1), 1, Silent())
    assert result.failures == dict.fromkeys(("4 m/s", "5 m/s"), "BrokenExecutor: a worker was lost")
    assert started(fake_solver) == []


def test_a_run_that_is_killed_leaves_the_others(
    column: Path, fake_solver: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAKE_SLEEP", "6")
    to = tmp_path / "results"

    def kill_one() -> None:
        wait_for(lambda: "4 1" in started(fake_solver))
        os.kill(workers(to / "U4")[0], signal.SIGKILL)

    killer = threading.Thread(target=kill_one)
    killer.start()
    result = sweep(column, to, "4,5")
    killer.join()
    assert list(result.failures) == ["4 m/s"]
    assert result.failures["4 m/s"].startswith("it was killed (SIGKILL, as the system does")
    assert (to / "U5/finished.json").is_file()


def test_ctrl_c_ends_the_runs_and_says_how_to_go_on(
    column: Path, fake_solver: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAKE_SLEEP", "3600")
    to = tmp_path / "results"
    command = [sys.executable, "-m", "elutria", "sweep", str(column), "--velocity", "4,5"]
    process = subprocess.Popen(
        [*command, "--to", str(to), "--set", SMALL[0]],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # ours may be ignored
    )  # fmt: skip
    wait_for(lambda: len(started(fake_solver)) == 2)
    os.kill(process.pid, signal.SIGINT)  # to it alone, not to its runs
    _, said = process.communicate(timeout=600)
    assert process.returncode == 1
    assert said == "elutria: interrupted; the same command goes on where it stopped\n"
    assert workers(to) == []


def test_no_table_is_left_half_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from elutria.files import write_csv

    path = tmp_path / "table.csv"
    write_csv(path, ["a"], [{"a": 1.0}])

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(ElutriaError, match="No space left on device") as caught:
        write_csv(path, ["a"], [{"a": 2.0}])
    assert caught.value.exit_code == 1
    assert path.read_text() == "a\n1\n"
    assert list(tmp_path.iterdir()) == [path]


def test_a_marker_of_other_inputs_does_not_count(tmp_path: Path) -> None:
    (tmp_path / "finished.json").write_text('{"inputs": "a", "wall_time_s": 1}')
    assert is_finished(tmp_path, "a")
    assert not is_finished(tmp_path, "b")
    (tmp_path / "finished.json").write_text('{"inputs": "a", "wall')
    assert not is_finished(tmp_path, "a")


def test_progress_goes_to_one(tmp_path: Path) -> None:
    goal = Goal(tmp_path, asked=100, latest=20)
    assert goal.share(Step(0.1, 0, {}, 0, 0)) == pytest.approx(0.005)
    assert goal.share(Step(0.5, 100, {"fines": 40, "coarse": 60}, 0, 0)) == 1
    assert Goal(tmp_path, None, 2.0).share(Step(1.0, 5, {"fines": 1, "coarse": 1}, 3, 0)) == 0.5


def test_progress_is_of_the_parcels_that_the_solver_plans(tmp_path: Path) -> None:
    plan = tmp_path / PLAN
    plan.parent.mkdir(parents=True)
    plan.write_text('{"feed": {"parcels": 200}}')
    step = Step(0.5, 100, {"fines": 40, "coarse": 60}, 0, 0)
    assert Goal(tmp_path, asked=100, latest=20).share(step) == 0.5
    plan.write_text('{"feed": null}')
    assert Goal(tmp_path, asked=100, latest=20).share(step) == 1


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 300 kB, where the machine lets us mount one."""
    place = tmp_path / "disk"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(place)]
    if subprocess.run(mount, capture_output=True, check=False).returncode != 0:
        pytest.skip("may not mount a file system")
    yield place
    subprocess.run(["umount", str(place)], check=True)


def test_a_full_disk_is_code_1_and_leaves_nothing_that_looks_whole(
    column: Path, fake_solver: Path, small_disk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAKE_SLEEP", "0.1")
    case = Case(column)
    settings = case.settings_for(5, ["system/simulationParameters:particles=20000"])
    with pytest.raises(ElutriaError) as caught:
        run_case(case, small_disk / "run", settings)
    assert caught.value.exit_code == 1
    assert "\n" not in str(caught.value)
    assert len(started(fake_solver)) == 1
    assert not (small_disk / "run/finished.json").exists()
    # room again: the same command goes through
    smaller = case.settings_for(5, ["system/simulationParameters:particles=200"])
    run_case(case, small_disk / "run", smaller)


def test_every_line_reaches_the_log(tmp_path: Path) -> None:
    """Also of a program that ends at once: none is taken by another reader."""
    (tmp_path / "system").mkdir()
    (tmp_path / "system/controlDict").write_text("endTime 1;\n")
    numbers = "fed 1 fines 0 coarse 0 inside 1 lost 0"
    script = f"for i in range(3000): print('elutria: time', i, '{numbers}')"
    for attempt in range(5):
        seen: list[Step] = []
        command = [sys.executable, "-c", f"{script}\nprint('elutria: finished')"]
        outcome = follow(tmp_path, command, f"log.{attempt}", seen.append)
        assert outcome.complete
        assert [step.time for step in seen] == list(range(3000))
        assert (tmp_path / f"log.{attempt}").read_text().count("\n") == 3001


def test_a_program_that_is_not_there_is_an_outcome(tmp_path: Path) -> None:
    (tmp_path / "system").mkdir()
    (tmp_path / "system/controlDict").write_text("endTime 1;\n")
    assert not follow(tmp_path, ["no-such-program"], "log", lambda _: None).complete


@pytest.mark.parametrize("script", ["kill -9 $$", "exit 137"], ids=["itself", "mpirun's"])
def test_a_program_that_is_killed_says_so(tmp_path: Path, script: str) -> None:
    (tmp_path / "system").mkdir()
    (tmp_path / "system/controlDict").write_text("endTime 1;\n")
    outcome = follow(tmp_path, ["sh", "-c", script], "log", lambda _: None)
    assert outcome.reason.startswith("it was killed (SIGKILL, as the system does where memory is")
    assert not follow(tmp_path, ["false"], "log", lambda _: None).reason
