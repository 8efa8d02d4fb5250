"""A run that is ended at any moment goes on with the same command to the same files.

Killed solver, killed rank, full disk: the rows of all starts together are those of the run nobody
touched, byte for byte; the ledger and what is inside too.
(A killed sweep: tests/unit/running/test_run.py.)
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from elutria import tables
from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import CONTROL, PARAMETERS, add_feed, material
from elutria_validation.harness.programs import run_program
from tests.conftest import COLUMN

MOMENTS = [0.6, 0.85, *(pytest.param(None, marks=pytest.mark.slow, id=f"random {k}")
                        for k in range(18))]  # fmt: skip
YIELD = ["--mca", "mpi_yield_when_idle", "1"]  # the cores may be shared
SERIAL, PARALLEL = ["elutriaFoam"], ["mpirun", *YIELD, "-np", "2", "elutriaFoam", "-parallel"]


def scene(folder: Path, processors: int = 1) -> Path:
    """A collision-rich feed in gas that it slows, solved when due, with its own time steps."""
    own_steps = {
        "adjustTimeStep": True, "maxCo": 0.4, "maxDeltaT": 1e-3, "purgeWrite": 2,
        "writeControl": "adjustableRunTime", "writeFormat": "binary",
    }  # fmt: skip
    case = BoxCase(
        gas_velocity=3, side_velocity="noSlip", width=0.04, depth=0.04, cells=(6, 6, 12),
        coupled=True, contacts=Contacts(), solve_gas="auto", gas_tolerance=0.001, step=5e-4,
        end=0.4, interval=0.02,
        more={f"{CONTROL}:{name}": value for name, value in own_steps.items()},
    ).make(folder)  # fmt: skip
    quartz = material(2650, type="uniform", min=2e-4, max=6e-4)
    add_feed(case, {"massFlowRate": 2e-3, "particles": 300, "velocity": [0.4, 0, 0],
                    "drainTime": 0.2, "materials": quartz})  # fmt: skip
    if processors > 1:
        run_program(["decomposePar"], case)
    return case


def finish(case: Path, command: list[str]) -> None:
    """The same command until the run is over."""
    done = subprocess.run(command, cwd=case, capture_output=True, text=True, check=False)
    (case / "log").write_text(done.stdout + done.stderr)
    assert done.returncode == 0, done.stdout[-800:] + done.stderr[-400:]


def outcome(case: Path) -> tuple[list[str], bytes, bytes]:
    """Rows of all starts in order, what is inside, the ledger."""
    files = (case / "postProcessing/outlets").glob("*/particles.csv")
    rows = []
    for table in sorted(files, key=lambda path: float(path.parent.name)):
        head, *lines = table.read_text().splitlines()
        assert head == ",".join(tables.EVENTS)
        rows += lines
    inside, ledger = (case / "postProcessing" / n for n in ("inside.csv", "ledger.json"))
    return rows, inside.read_bytes(), ledger.read_bytes()


def check(found: tuple[list[str], bytes, bytes], whole: tuple[list[str], bytes, bytes]) -> None:
    numbers = [row.split(",")[3] for row in found[0]]
    assert len(numbers) == len(set(numbers)), "a row is there twice"
    assert found[0] == whole[0]
    assert found[1] == whole[1]
    assert found[2] == whole[2]


@pytest.fixture(scope="module")
def untouched(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], tuple]:
    """The meshed case, its outcome and its seconds, by number of processors; each run once."""
    known: dict[int, tuple] = {}

    def get(processors: int) -> tuple:
        if processors not in known:
            place = tmp_path_factory.mktemp(f"untouched{processors}")
            case = scene(place / "whole", processors)
            shutil.copytree(case, place / "fresh")
            start = time.monotonic()
            finish(case, SERIAL if processors == 1 else PARALLEL)
            seconds = time.monotonic() - start
            rows = outcome(case)
            assert len(rows[0]) > 100
            known[processors] = place / "fresh", rows, seconds
        return known[processors]

    return get


def share(moment: float | None, name: str) -> float:
    """A share of the whole run: the given one, or a random one of the test's own."""
    return random.Random(name).uniform(0.05, 1.0) if moment is None else moment


def killed(case: Path, command: list[str], seconds: float, who: Callable[[int], int]) -> None:
    """Start a command and kill one of its processes after some seconds."""
    process = subprocess.Popen(
        command, cwd=case, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True,
    )  # fmt: skip
    time.sleep(seconds)
    with contextlib.suppress(ProcessLookupError):  # it may be over
        os.kill(who(process.pid), signal.SIGKILL)
    process.wait(timeout=60)


@pytest.mark.parametrize("moment", MOMENTS)
def test_a_killed_solver(
    tmp_path: Path, untouched, request: pytest.FixtureRequest, moment: float | None
) -> None:
    fresh, whole, seconds = untouched(1)
    case = tmp_path / "case"
    shutil.copytree(fresh, case)
    part = share(moment, request.node.name)
    for _ in range(2):  # killed again when it goes on
        killed(case, SERIAL, part * seconds, lambda pid: pid)
    finish(case, SERIAL)
    check(outcome(case), whole)


@pytest.mark.slow
def test_a_killed_run_of_the_tool_goes_on(tmp_path: Path) -> None:
    """`elutria run`, killed with its solver on the way: what was recorded stays, and the rest of
    the feed follows. (The turbulent gas comes back to rounding, so that rows differ later.)"""
    few = {"particles": "300", "feedTime": "0.5", "drainTime": "0.5"}
    settings = [w for k, v in few.items() for w in ("--set", f"{PARAMETERS}:{k}={v}")]
    settings += ["--set", f"{CONTROL}:writeInterval=0.1"]
    command = [sys.executable, "-m", "elutria", "run", str(COLUMN), *settings, "--to"]
    whole, case = tmp_path / "whole", tmp_path / "case"
    subprocess.run([*command, str(whole)], check=True, stdout=subprocess.DEVNULL)
    process = subprocess.Popen([*command, str(case)], stdout=subprocess.DEVNULL)
    written, mark = case / "0.3/uniform/feed", case / "elutriaUnfinished.0.3"
    while (mark.exists() or not written.is_file()) and process.poll() is None:
        time.sleep(0.02)
    process.kill()
    process.wait()
    time.sleep(1)  # its solver ends with it
    assert not (case / "finished.json").exists()
    subprocess.run([*command, str(case)], check=True, stdout=subprocess.DEVNULL)
    assert len(list((case / "postProcessing/outlets").iterdir())) == 2, "it began again"
    found, expected = (outcome(run)[0] for run in (case, whole))
    before = [row for row in expected if float(row.split(",")[0]) <= 0.3]
    assert len(before) > 5
    assert found[: len(before)] == before
    numbers = [row.split(",")[3] for row in found]
    assert len(numbers) == len(set(numbers)), "a row is there twice"
    accounts = [json.loads(outcome(run)[2])["total"] for run in (case, whole)]
    assert accounts[0]["injected"] == accounts[1]["injected"]
    assert accounts[0]["lost"]["parcels"] == 0


def a_rank(pid: int) -> int:
    """A process that mpirun started."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    ranks = [int(child) for child in children
             if "elutriaFoam" in Path(f"/proc/{child}/cmdline").read_text()]  # fmt: skip
    return random.Random(pid).choice(ranks) if ranks else pid


@pytest.mark.slow
@pytest.mark.parametrize("moment", [None] * 20)
def test_a_killed_rank(
    tmp_path: Path, untouched, request: pytest.FixtureRequest, moment: float | None
) -> None:
    fresh, whole, seconds = untouched(2)
    case = tmp_path / "case"
    shutil.copytree(fresh, case)
    killed(case, PARALLEL, share(moment, request.node.name) * seconds, a_rank)
    finish(case, PARALLEL)
    check(outcome(case), whole)


@pytest.mark.parametrize("moment", [0.2, *MOMENTS])  # 0.2: not even the plan fits
def test_a_full_disk(
    tmp_path: Path, untouched, request: pytest.FixtureRequest, moment: float | None
) -> None:
    """No file can grow beyond a limit: the run ends with code 1 and a line, or as if killed."""
    fresh, whole, _ = untouched(1)
    case = tmp_path / "case"
    shutil.copytree(fresh, case)
    limit = int(200 + share(moment, request.node.name) ** 2 * 16_000)

    def small_files() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    done = subprocess.run(
        SERIAL, cwd=case, capture_output=True, text=True, check=False, preexec_fn=small_files
    )
    if done.returncode != 0:
        assert "elutria: failed: cannot write" in done.stdout, done.stdout[-600:]
        assert done.returncode == 1
    finish(case, SERIAL)
    check(outcome(case), whole)


@pytest.mark.slow
@pytest.mark.parametrize("moment", range(20))
def test_a_disk_that_is_really_full(tmp_path: Path, untouched, moment: int) -> None:
    fresh, whole, _ = untouched(1)
    disk = tmp_path / "disk"
    disk.mkdir()
    needed = sum(path.stat().st_size for path in fresh.rglob("*") if path.is_file())
    kilobytes = needed // 1024 + 250 + random.Random(moment).randrange(20, 900)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", str(disk)]
    if subprocess.run(mount, capture_output=True, check=False).returncode != 0:
        pytest.skip("may not mount a file system")
    try:
        case = disk / "case"
        shutil.copytree(fresh, case)
        done = subprocess.run(SERIAL, cwd=case, capture_output=True, text=True, check=False)
        assert done.returncode in (0, 1), done.stdout[-400:]
        subprocess.run(["mount", "-o", "remount,size=200m", str(disk)], check=True)
        finish(case, SERIAL)
        check(outcome(case), whole)
    finally:
        subprocess.run(["umount", str(disk)], check=True)
