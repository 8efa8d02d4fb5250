"""The page in a real browser: it draws what the frames say, and its controls do what they say."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from elutria.viewing.film import record
from elutria.viewing.recording import Recording
from tests.support.browser import HOW_TO_INSTALL, Browser, chromium, wait_for
from tests.support.frames import falling, frame, write_run

PAGE = Path(__file__).resolve().parents[3] / "tools/elutria/viewing/static/page.js"
pytestmark = [
    pytest.mark.skipif(chromium() is None, reason=HOW_TO_INSTALL),
    pytest.mark.skipif(not PAGE.is_file(), reason="the page is not built: etc/setup/page"),
]


@contextmanager
def viewed(*arguments: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """`elutria view`: its address, and the process."""
    command = [sys.executable, "-m", "elutria", "view", "--no-browser", *arguments]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip(), process
    finally:
        process.terminate()
        process.wait(20)


def click(browser: Browser, name: str) -> None:
    browser.ask(f"document.getElementById('{name}').click()")


def choose(browser: Browser, name: str, value: object) -> None:
    browser.ask(
        f"(() => {{ const e = document.getElementById('{name}'); e.value = {json.dumps(value)};"
        "for (const kind of ['input', 'change']) e.dispatchEvent(new Event(kind)); })()"
    )


def test_a_known_parcel_is_where_it_should_be(tmp_path: Path) -> None:
    """One sphere of 20 mm in a box: its disc has the pixels that optics says, and its colour."""
    ball = frame(0, [(7, (0.5, 0.5, 0.25), 0.002, 1.0)], samples=[1000] * 6)
    run = write_run(tmp_path / "ball", [ball])
    with viewed(str(run)) as (address, _), Browser() as browser:
        browser.open(address)
        browser.wait("window.elutria && elutria.frame && elutria.column.drawn > 0")
        browser.ask("elutria.column.enlarge(10)")
        time.sleep(0.5)
        place = browser.ask("elutria.column.pixelOf(7)")
        camera = browser.ask(
            "(() => { const c = elutria.column.camera; return [c.position.toArray(),"
            " elutria.column.controls.target.toArray(), c.fov, elutria.column.canvas.height]; })()"
        )
        shot = browser.picture(tmp_path / "shot.png").astype(int)
        assert browser.errors == []
    eye, target, fov, height = np.array(camera[0]), np.array(camera[1]), camera[2], camera[3]
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, [0, 0, 1]) / np.linalg.norm(np.cross(ahead, [0, 0, 1]))
    arm = np.array([0.025, 0.025, 0.125]) - eye
    pixels = height / 2 / np.tan(np.radians(fov / 2)) / (arm @ ahead)
    expected = [
        450 + pixels * (arm @ right), height / 2 - pixels * (arm @ np.cross(right, ahead))
    ]  # fmt: skip
    assert place == pytest.approx(expected, abs=1.5)
    orange = (shot[:, :, 0] > 90) & (shot[:, :, 2] < 60) & (shot[:, :, 1] > 50)
    orange[:, 895:] = False  # the legend
    rows, columns = np.nonzero(orange)
    assert [columns.mean(), rows.mean()] == pytest.approx(expected, abs=3)
    assert np.ptp(columns) + 1 == pytest.approx(0.02 * pixels, rel=0.15)


def test_a_recording_plays_and_obeys(tmp_path: Path) -> None:
    run = write_run(tmp_path / "falling", falling(count=80))
    with viewed(str(run)) as (address, process), Browser() as browser:
        browser.open(address)
        browser.wait("window.elutria && elutria.frames > 3")
        shot = browser.picture()[:, :890]
        assert (np.abs(shot.astype(int) - shot[2, 2]).max(axis=2) > 60).sum() > 500
        click(browser, "pause")
        time.sleep(0.5)
        stopped = browser.ask("elutria.frame.time")
        time.sleep(0.5)
        assert browser.ask("elutria.frame.time") == stopped
        choose(browser, "time", 3.0)
        browser.wait("Math.abs(elutria.frame.time - 3) < 0.06", 10)
        browser.wait("elutria.statistics && elutria.statistics.curve.length > 10", 30)
        assert "µm" in browser.ask("document.getElementById('d50').textContent")
        choose(browser, "colour", "fate")
        # blue: goes up; orange: goes down
        names = browser.ask(
            "[...document.querySelectorAll('#legend span')].map(s => s.textContent)"
        )
        assert names == ["still inside", "fines", "coarse"]
        ends = browser.ask("[...elutria.column.particles.fates]")
        assert ends == Recording(run).fates().tolist()
        process.kill()
        browser.wait("elutria.state === 'gone'", 20)
        assert (
            browser.ask("document.getElementById('state').textContent") == "elutria view has ended"
        )
        assert browser.ask("elutria.frame.time") == pytest.approx(3, abs=0.06)
        assert browser.errors == []


def test_a_run_of_a_sweep_is_chosen(tmp_path: Path) -> None:
    for name, parcels in (("U5", 80), ("U6", 120)):
        run = write_run(tmp_path / name, falling(80, parcels))
        (run / "elutria.json").write_text(json.dumps({"case": name}))
    (tmp_path / "U7").mkdir()
    (tmp_path / "U7/elutria.json").write_text("{}")
    with viewed(str(tmp_path)) as (address, _), Browser() as browser:
        browser.open(address)
        browser.wait("window.elutria && elutria.frames > 3")
        assert browser.ask("document.getElementById('name').textContent") == "U5"
        assert browser.ask("elutria.frame.fed") <= 80
        buttons = browser.ask(
            "[...document.querySelectorAll('#runs button')].map(b => [b.textContent, b.disabled])"
        )
        assert buttons == [["U5", False], ["U6", False], ["U7", True]]
        choose(browser, "colour", "fate")
        browser.ask("document.querySelectorAll('#runs button')[1].click()")
        browser.wait("document.getElementById('name').textContent === 'U6'", 20)
        browser.wait("elutria.frame && elutria.frame.count > 80", 20)
        browser.wait("document.querySelector('#runs [aria-current=true]').textContent === 'U6'")
        ends = browser.ask("[...elutria.column.particles.fates]")
        assert ends == Recording(tmp_path / "U6").fates().tolist()
        # what was chosen for the run before holds for this one
        assert browser.ask("elutria.column.particles.material.uniforms.colouring.value") == 3
        shot = browser.picture()[:, :890]
        assert (np.abs(shot.astype(int) - shot[2, 2]).max(axis=2) > 60).sum() > 500
        assert browser.errors == []


def test_a_page_that_is_one_file_plays_without_a_server(tmp_path: Path) -> None:
    run = write_run(tmp_path / "falling", falling(count=80))
    page = tmp_path / "film.html"
    record(run, page, 1.0, lambda _: None)
    with Browser() as browser:
        browser.open(page.as_uri())
        browser.wait("window.elutria && elutria.frames > 3")
        browser.wait("elutria.statistics && elutria.statistics.parcels > 0")
        assert browser.ask("performance.getEntriesByType('resource').length") == 0
        # its curves are fitted already: there is nobody to begin anew
        assert browser.ask("document.getElementById('restart').offsetParent") is None
        assert browser.errors == []


@pytest.mark.slow
def test_ten_thousand_parcels_move_without_a_gpu(tmp_path: Path) -> None:
    """All are drawn, in software; how fast is in docs/user/view.md."""
    many = [(k, (k % 21 / 20, k // 21 % 21 / 20, k / 10_000), 0.001, 0.0) for k in range(10_000)]
    run = write_run(tmp_path / "many", [frame(0.02 * k, many) for k in range(100)])
    with viewed(str(run)) as (address, _), Browser() as browser:
        browser.open(address)
        browser.wait("window.elutria && elutria.frames > 3")
        drawn = wait_for(lambda: browser.ask("elutria.column.drawn"), 90, "pictures")
        browser.wait(f"elutria.column.drawn > {drawn + 5}", 120)
        assert browser.ask("elutria.frame.count") == 10_000
        assert browser.errors == []
