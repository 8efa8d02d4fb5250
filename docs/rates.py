"""Measures the page of `elutria view` on this machine, with the load that it has, and writes the
table between the marks in docs/user/view.md:

    python docs/rates.py             # two minutes, with Chromium on PATH; --print writes nothing

in the clone's root: pictures and frames a second, how long a slider takes to show, the solver's
processor time against the run's time.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from elutria_validation.harness.provenance import machine  # noqa: E402
from tests.cases.test_view_live import solver_of  # noqa: E402
from tests.support.browser import Browser, wait_for  # noqa: E402
from tests.support.frames import frame, write_run  # noqa: E402
from tests.unit.viewing.test_page import choose, viewed  # noqa: E402

PAGE = ROOT / "docs/user/view.md"
MARKS = "<!-- python docs/rates.py -->", "<!-- end -->"
SECONDS = 8.0
"""That rates are taken over."""
STATE = "[elutria.column.drawn, elutria.frames, elutria.frame.time, elutria.frame.count]"
MOVED = """new Promise((done) => {{
  const slider = document.getElementById("{name}"), began = performance.now();
  slider.value = {place};
  slider.dispatchEvent(new Event("input"));
  const look = () => {{
    const shown = Math.abs(elutria.frame.{name} - 4 ** {place}) < 1e-3 && !elutria.column.stale;
    shown ? done((performance.now() - began) / 1000) : setTimeout(look, 4);
  }};
  look();
}})"""
"""Moves a slider and waits for a picture with what it asks for; gives the seconds between them."""
Row = tuple[str, str, str]
"""What, measured, wanted."""


def processor_s(process: int) -> float:
    """Processor time of a process, s."""
    words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def column(folder: Path, fed: int) -> Iterator[Row]:
    """The default column while it runs, fed so many parcels a second."""
    parameters = "system/simulationParameters"
    settings = [f"{parameters}:particles={100 * fed}", f"{parameters}:feedTime=100"]
    words = [word for setting in settings for word in ("--set", setting)]
    run = folder / "run"
    seen = viewed(str(ROOT / "cases/column"), *words, "--to", str(run))
    with seen as (address, _), Browser() as browser:
        browser.open(address)
        browser.wait("window.elutria && elutria.frame && elutria.frame.time > 1", 300)
        choose(browser, "speed", 0)
        solver = wait_for(lambda: solver_of(run), 10, "the solver")
        before, spent, now = browser.ask(STATE), processor_s(solver), time.monotonic()
        time.sleep(SECONDS)
        after, spent = browser.ask(STATE), processor_s(solver) - spent
        passed = time.monotonic() - now
        drawn, frames, run_s = (after[k] - before[k] for k in range(3))
        inside = f"the default column, {after[3]} parcels inside, live"
        yield f"{inside}: s of the run in a second", f"{run_s / passed:.2f}", "0.5"
        yield "s of the run in a second of the solver's processor time", f"{run_s / spent:.2f}", ""
        yield "pictures a second", f"{drawn / passed:.1f}", ""
        yield "frames a second", f"{frames / passed:.1f}", "30 at most"
        choose(browser, "speed", 1)
        for name in ("gas", "loading"):
            waits = [delay(browser, name, 0.1 * (-1) ** k) for k in range(9)]
            measured = f"{median(waits):.2f} s ({max(waits):.2f} s)"
            yield f"slider of the {name} to picture, median (longest) of 9", measured, "0.5 s"
        assert browser.errors == []


def delay(browser: Browser, name: str, place: float) -> float:
    """Seconds from moving a slider to a picture of the column with what it asks for."""
    return float(browser.ask(MOVED.format(name=name, place=place)))


def recorded(folder: Path, parcels: int) -> Iterator[Row]:
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
        yield f"a recording of {parcels} parcels, pictures a second", f"{rate:.1f}", "30"


def main() -> None:
    """All rates, with the machine's load."""
    load = os.getloadavg()[0]
    rows: list[Row] = [("without a GPU (SwiftShader)", "measured", "wanted"), ("---",) * 3]
    with tempfile.TemporaryDirectory() as folder:
        for row in (*column(Path(folder), 800), *recorded(Path(folder), 10_000)):
            print(": ".join(row[:2]))
            rows.append(row)
    now = machine()
    told = (
        f"Made {now['made'][:10]} on {now['cores']} cores ({now['processor']}), load {load:.1f} "
        f"before and {now['load_before']:.1f} after."
    )
    print(told)
    if "--print" not in sys.argv:
        table = "\n".join(f"| {' | '.join(row)} |" for row in rows)
        begin, end = map(re.escape, MARKS)
        text, found = re.subn(
            f"{begin}.*{end}", lambda _: f"{MARKS[0]}\n{table}\n\n{told}\n{MARKS[1]}",
            PAGE.read_text(), flags=re.DOTALL,
        )  # fmt: skip
        assert found == 1, f"{PAGE} lacks its marks"
        PAGE.write_text(text)


if __name__ == "__main__":
    main()
