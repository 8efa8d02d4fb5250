"""Measures the page of `elutria view` on a machine with this load: pictures and frames a second,
how long a slider takes to show, the solver's processor time against the run's time:

    python docs/rates.py

in the clone's root, with Chromium on PATH.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.cases.test_view_live import solver_of  # noqa: E402
from tests.support.browser import Browser, wait_for  # noqa: E402
from tests.support.frames import frame, write_run  # noqa: E402
from tests.unit.viewing.test_page import choose, viewed  # noqa: E402

SECONDS = 8.0
"""That rates are taken over."""
STATE = "[elutria.column.drawn, elutria.frames, elutria.frame.time, elutria.frame.count]"


def processor_s(process: int) -> float:
    """Processor time of a process, s."""
    words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def column(folder: Path, parcels: int) -> None:
    """The default column while it runs, fed so many parcels a second for a minute."""
    parameters = "system/simulationParameters"
    settings = [f"{parameters}:particles={60 * parcels}", f"{parameters}:feedTime=60"]
    words = [word for setting in settings for word in ("--set", setting)]
    run = folder / "run"
    seen = viewed(str(ROOT / "cases/column"), *words, "--to", str(run))
    with seen as (address, _), Browser() as browser:
        browser.open(address)
        browser.wait("window.elutria && elutria.frame && elutria.frame.time > 0.3", 300)
        choose(browser, "speed", 0)
        solver = wait_for(lambda: solver_of(run), 10, "the solver")
        before, spent, now = browser.ask(STATE), processor_s(solver), time.monotonic()
        time.sleep(SECONDS)
        after, spent = browser.ask(STATE), processor_s(solver) - spent
        passed = time.monotonic() - now
        drawn, frames, run_s = (after[k] - before[k] for k in range(3))
        print(
            f"the default column, {after[3]} parcels inside: {drawn / passed:.1f} pictures and "
            f"{frames / passed:.1f} frames a second; {run_s / passed:.2f} s of the run in a "
            f"second, {run_s / spent:.2f} s in a second of the solver's processor time"
        )
        choose(browser, "speed", 1)
        waits = [delay(browser, "gas", 0.1 * (-1) ** k) for k in range(5)]
        print(f"gas velocity, slider to picture: {median(waits):.2f} s, {max(waits):.2f} at most")
        waits = [delay(browser, "loading", 0.1 * (-1) ** k) for k in range(5)]
        print(f"loading, slider to picture: {median(waits):.2f} s, {max(waits):.2f} at most")
        assert browser.errors == []


def delay(browser: Browser, name: str, place: float) -> float:
    """Seconds from moving a slider to a picture of the column with what it asks for."""
    began = time.monotonic()
    choose(browser, name, place)
    browser.wait(f"Math.abs(elutria.frame.{name} - 4 ** {place}) < 1e-3", 60)
    drawn = browser.ask("elutria.column.drawn")
    browser.wait(f"elutria.column.drawn > {drawn}", 60)
    return time.monotonic() - began


def recorded(folder: Path, parcels: int) -> None:
    """A recording of parcels that stand in the column."""
    edge = round((parcels / 10) ** (1 / 3))
    many = [
        (k, (k % edge / edge, k // edge % edge / edge, k / parcels), 0.001, 0.0)
        for k in range(parcels)
    ]
    run = write_run(folder / f"run{parcels}", [frame(0.03 * k, many) for k in range(400)])
    with viewed(str(run)) as (address, _), Browser() as browser:
        browser.open(address)
        browser.wait("window.elutria && elutria.frames > 3", 120)
        drawn, now = browser.ask("elutria.column.drawn"), time.monotonic()
        time.sleep(SECONDS)
        rate = (browser.ask("elutria.column.drawn") - drawn) / (time.monotonic() - now)
        print(f"a recording of {parcels} parcels: {rate:.1f} pictures a second")


def main() -> None:
    """All rates, with the machine's load."""
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} before")
    with tempfile.TemporaryDirectory() as folder:
        column(Path(folder), 1000)
        recorded(Path(folder), 10_000)
    print(f"load {os.getloadavg()[0]:.1f} after")


if __name__ == "__main__":
    main()
