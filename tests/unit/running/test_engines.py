"""A sweep is the same on every engine: tables, resumption, what is told of what went wrong."""

from __future__ import annotations

import re
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from elutria.errors import InputError
from elutria.running import worker
from elutria.running.engine import open_engine
from tests.support import dask, slurm
from tests.support.engines import command, sweep, tables

LOADING = "system/simulationParameters:loading"


def starts(file: Path) -> int:
    return len(file.read_text().splitlines()) if file.exists() else 0


def wait_for(what: Path, seconds: float = 300) -> None:
    end = time.monotonic() + seconds
    while not what.exists():
        assert time.monotonic() < end, f"{what} does not come"
        time.sleep(0.05)


def alive(folder: Path) -> list[str]:
    """The processes of runs in a folder."""
    said = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True).stdout
    return [line for line in said.splitlines() if "running.worker" in line and str(folder) in line]


@pytest.fixture
def slurm_conf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    slurm.need()
    with slurm.slurm(tmp_path / "slurm") as conf:
        monkeypatch.setenv("SLURM_CONF", str(conf))
        yield conf


GRID = ("--velocity", "4:7:4", "--vary", f"{LOADING}=0.1,0.2,0.4")


@pytest.mark.slow
@pytest.mark.usefixtures("fake_solver")
def test_dask_makes_the_tables_of_the_local_sweep(column: Path, tmp_path: Path) -> None:
    dask.need()
    assert sweep(column, tmp_path / "local", "local", *GRID).returncode == 0
    with dask.dask(tmp_path / "dask") as (engine, _):
        done = sweep(column, tmp_path / "there", engine, *GRID)
    assert done.returncode == 0, done.stderr
    assert tables(tmp_path / "there") == tables(tmp_path / "local")
    assert len(tables(tmp_path / "local")["summary.csv"]) == 1 + 2 * 12


@pytest.mark.slow
@pytest.mark.usefixtures("fake_solver")
def test_slurm_makes_the_tables_of_the_local_sweep(
    column: Path, tmp_path: Path, slurm_conf: Path
) -> None:
    assert sweep(column, tmp_path / "local", "local", *GRID).returncode == 0
    done = sweep(column, tmp_path / "there", "slurm:partition=all", *GRID)
    assert done.returncode == 0, done.stderr
    assert tables(tmp_path / "there") == tables(tmp_path / "local")
    assert not (tmp_path / "there/.slurm").exists()
    log = (slurm_conf.parent / "slurmctld.log").read_text()
    assert re.search(r"JobId=\d+_\d+\(\d+\)", log), "no array was submitted"


@pytest.mark.slow
def test_the_runs_of_a_killed_worker_go_on_elsewhere(
    column: Path, tmp_path: Path, fake_solver: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dask.need()
    monkeypatch.setenv("FAKE_SLEEP", "6")
    to = tmp_path / "there"
    with dask.dask(tmp_path / "dask") as (engine, workers):
        process = subprocess.Popen(command(column, to, engine, "--velocity", "4:6:3"))
        wait_for(to / "U4/progress.txt")
        wait_for(to / "U5/progress.txt")
        workers[0].send_signal(signal.SIGKILL)
        assert process.wait(500) == 0
    assert starts(fake_solver) == 4
    assert len(list(to.glob("U*/log.elutriaFoam.1"))) == 1, "one run goes on after its worker"
    monkeypatch.setenv("FAKE_SLEEP", "0")
    assert sweep(column, tmp_path / "local", "local", "--velocity", "4:6:3").returncode == 0
    assert tables(to) == tables(tmp_path / "local")


@pytest.mark.slow
@pytest.mark.usefixtures("fake_solver")
def test_a_worker_without_openfoam_is_named_and_not_used(column: Path, tmp_path: Path) -> None:
    dask.need()
    bare = {"PATH": "/nowhere"}
    with dask.dask(tmp_path / "dask", ({}, bare)) as (engine, _):
        done = sweep(column, tmp_path / "there", engine, "--velocity", "4,5")
    assert done.returncode == 0, done.stderr
    lines = [line for line in done.stdout.splitlines() if "elutriaFoam: not found" in line]
    assert len(lines) == 1
    assert lines[0].startswith("worker tcp://127.0.0.1:")
    with dask.dask(tmp_path / "bare", (bare,)) as (engine, _):
        done = sweep(column, tmp_path / "bare_results", engine, "--velocity", "4,5")
    assert done.returncode == 2
    assert "none of its 1 workers can be used" in done.stderr
    assert not (tmp_path / "bare_results").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("fake_solver")
def test_parallel_runs_ask_for_as_many_slots(column: Path, tmp_path: Path) -> None:
    dask.need()
    with dask.dask(tmp_path / "none", ({},)) as (engine, _):
        done = sweep(column, tmp_path / "there", engine, "--velocity", "4", "--np", "2")
    assert done.returncode == 2
    assert "has 0 slots, a run has --np 2" in done.stdout
    with dask.dask(tmp_path / "two", ({},), ("--nthreads", "4", "--resources", "slots=2")) as (
        engine,
        _,
    ):
        done = sweep(column, tmp_path / "there", engine, "--velocity", "4,5")
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.usefixtures("fake_solver")
def test_who_interrupts_a_sweep_ends_its_runs_everywhere(
    column: Path, tmp_path: Path, fake_solver: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dask.need()
    to = tmp_path / "there"
    with dask.dask(tmp_path / "dask") as (engine, _):
        assert sweep(column, to, engine, "--velocity", "4").returncode == 0
        monkeypatch.setenv("FAKE_SLEEP", "200")
    with dask.dask(tmp_path / "slow") as (engine, _):
        process = subprocess.Popen(
            # a test that was started in the background ignores it otherwise
            ["env", "--default-signal=INT", *command(column, to, engine, "--velocity", "4:6:3")],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip
        wait_for(to / "U6/0.5/seed")
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=300)[0]
        assert process.returncode == 1
        assert "interrupted; the same command goes on" in said
        assert "1 of 3 runs are finished" in said
        time.sleep(2)
        assert not alive(to)
        assert not list(to.glob(".asked-*"))
    monkeypatch.setenv("FAKE_SLEEP", "0")
    before = starts(fake_solver)
    assert sweep(column, to, "local", "--velocity", "4:6:3").returncode == 0
    assert starts(fake_solver) == before + 2


@pytest.mark.slow
@pytest.mark.usefixtures("fake_solver", "slurm_conf")
def test_a_job_that_slurm_ends_is_one_line_and_the_others_go_on(
    column: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAKE_SLEEP", "8")
    to = tmp_path / "there"
    process = subprocess.Popen(
        command(column, to, "slurm", "--velocity", "4:6:3"),
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    wait_for(to / "U4/progress.txt")
    jobs = subprocess.run(["squeue", "-h", "-r", "-o", "%i"], capture_output=True, text=True,
                          check=True).stdout.split()  # fmt: skip
    subprocess.run(["scancel", min(jobs)], check=True)
    said = process.communicate(timeout=500)[0]
    assert process.returncode == 1
    assert "1 of 3 runs failed" in said
    assert len([line for line in said.splitlines() if line.startswith("4 m/s:")]) >= 1
    assert (to / "U5/finished.json").is_file()
    monkeypatch.setenv("FAKE_SLEEP", "0")
    done = sweep(column, to, "slurm", "--velocity", "4:6:3")
    assert done.returncode == 0, done.stderr
    assert (to / "U4/log.elutriaFoam.1").is_file()


def test_a_run_ends_when_nobody_asks_for_it_any_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who asked was killed: its file is there, but is not touched; or has left: there is none."""
    monkeypatch.setattr(worker, "GONE_AFTER", 1.0)
    monkeypatch.setattr(worker, "ASKED_EVERY", 0.2)
    with worker.asking(tmp_path) as asked:
        process = subprocess.Popen(["sleep", "3"])
        worker._wait(process, asked)
        assert process.returncode == 0, "ended although it is asked for"
    assert asked.mark() is None
    asked.file.touch()
    for gone in (lambda: None, asked.file.unlink):
        gone()
        process = subprocess.Popen(["sleep", "100"])
        began = time.monotonic()
        worker._wait(process, asked)
        assert process.returncode == -signal.SIGTERM
        assert time.monotonic() - began < 20


@pytest.mark.parametrize(
    ("engine", "reason"),
    [
        ("cloud", "--engine 'cloud'; allowed: local, dask:ADDRESS"),
        ("dask", "--engine 'dask'; allowed: local, dask:ADDRESS"),
        ("slurm:", "--engine 'slurm:'; allowed: local, dask:ADDRESS"),
    ],
)
@pytest.mark.usefixtures("fake_solver")
def test_an_engine_that_is_none_is_refused(
    column: Path, tmp_path: Path, engine: str, reason: str
) -> None:
    done = sweep(column, tmp_path / "there", engine, "--velocity", "4")
    assert done.returncode == 2
    assert done.stderr.startswith(f"elutria: {reason}")
    assert not (tmp_path / "there").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("fake_solver")
def test_an_engine_that_does_not_answer_is_one_line(column: Path, tmp_path: Path) -> None:
    dask.need()
    address = f"dask:tcp://127.0.0.1:{slurm.free_port()}"
    done = sweep(column, tmp_path / "there", address, "--velocity", "4")
    assert done.returncode == 2
    assert done.stderr.startswith(f"elutria: --engine {address}: no scheduler answers")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "there").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("fake_solver", "slurm_conf")
def test_what_slurm_refuses_is_one_line(column: Path, tmp_path: Path) -> None:
    done = sweep(column, tmp_path / "there", "slurm:partition=nowhere", "--velocity", "4")
    assert done.returncode == 2
    assert "--engine slurm:partition=nowhere: Slurm refuses it" in done.stderr
    assert "invalid partition" in done.stderr.lower()
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("engine", ["dask:tcp://127.0.0.1:1", "slurm:partition=short"])
def test_an_engine_without_its_package_is_one_line(
    engine: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("elutria.running.engine.find_spec", lambda _: None)
    with pytest.raises(InputError, match=rf"^--engine {engine}: \w+ is not installed; allowed: "):
        open_engine(engine, 0, 1, (tmp_path, tmp_path), print)
