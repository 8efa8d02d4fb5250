"""`elutria view` of a case, in a browser: live, steered by its sliders, to its end or death."""

from __future__ import annotations

import os
import re
import signal
import time
from pathlib import Path

import pytest

from elutria_validation.harness.cases import change
from tests.cases.test_frames import box
from tests.support.browser import HOW_TO_INSTALL, Browser, chromium, wait_for
from tests.unit.viewing.test_page import PAGE, choose, click, viewed

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(chromium() is None, reason=HOW_TO_INSTALL),
    pytest.mark.skipif(not PAGE.is_file(), reason="the page is not built: etc/setup/page"),
]


def endless(folder: Path) -> Path:
    case = box(folder, end=1000, solve_gas=True)
    change(case, {"constant/feed:duration": 900, "constant/feed:particles": 900_000})
    return case


def solver_of(run: Path) -> int:
    """Process of the solver that works in a run's folder."""
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().split(b"\0")
            if words[0].endswith(b"elutriaFoam") and (folder / "cwd").resolve() == run.resolve():
                return int(folder.name)
        except OSError:
            continue
    return 0


def test_sliders_act_on_the_column_and_death_is_told(tmp_path: Path) -> None:
    case, run = endless(tmp_path / "case"), tmp_path / "run"
    log = run / "log.elutriaFoam"
    with viewed(str(case), "--to", str(run)) as (address, _), Browser() as browser:
        browser.open(address)
        browser.wait("window.elutria && elutria.frames > 3 && elutria.state === 'running'", 120)
        began = time.monotonic()
        choose(browser, "gas", 0.2)
        browser.wait("Math.abs(elutria.frame.gas - 4 ** 0.2) < 1e-3", 60)
        print(f"slider to picture: {time.monotonic() - began:.2f} s")
        assert re.search(r"elutria: gas velocity 1.32 times, loading 1 times", log.read_text())
        choose(browser, "loading", 0.5)
        browser.wait("Math.abs(elutria.frame.loading - 2) < 1e-3", 60)
        assert re.search(r"elutria: gas velocity 1.32 times, loading 2 times", log.read_text())
        browser.wait("document.getElementById('gas-now').textContent === '2.64 m/s'", 5)
        assert len(re.findall(r"\(\S+ \S+ \S+\)", (run / "system/steering").read_text())) >= 2

        click(browser, "pause")
        browser.wait("elutria.state === 'paused'")
        time.sleep(1)
        stopped = browser.ask("elutria.frame.time")
        time.sleep(1)
        assert browser.ask("elutria.frame.time") == stopped
        click(browser, "pause")
        browser.wait(f"elutria.frame.time > {stopped}", 30)

        os.kill(wait_for(lambda: solver_of(run), 10, "the solver"), signal.SIGKILL)
        browser.wait("elutria.state === 'failed'", 30)
        assert "elutriaFoam failed" in browser.ask("document.getElementById('state').textContent")
        frames = browser.ask("elutria.column.drawn")
        browser.ask("elutria.column.enlarge(2)")
        browser.wait(f"elutria.column.drawn > {frames}", 20)  # what is there can still be looked at
        assert browser.errors == []


def test_a_run_ends_and_is_replayed(tmp_path: Path) -> None:
    case, run = box(tmp_path / "case"), tmp_path / "run"
    with viewed(str(case), "--to", str(run)) as (address, _), Browser() as browser:
        browser.open(address)
        browser.wait("window.elutria && elutria.state === 'ended'", 120)
        browser.wait("Math.abs(elutria.frame.time - 0.3) < 1e-9", 5)
        assert browser.errors == []
    with viewed(str(run)) as (address, _), Browser() as browser:
        browser.open(address)
        browser.wait("window.elutria && elutria.frames > 2 && elutria.state === 'ended'", 60)
        browser.wait("Math.abs(elutria.frame.time - 0.3) < 1e-9", 5)


def test_the_solver_ends_with_the_page(tmp_path: Path) -> None:
    case, run = endless(tmp_path / "case"), tmp_path / "run"
    with viewed(str(case), "--to", str(run)) as (_, process):
        wait_for(lambda: solver_of(run), 60, "the solver")
        process.kill()
        wait_for(lambda: not solver_of(run), 20, "its end")
