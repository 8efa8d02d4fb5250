"""Makes the pictures of the live page, the report and the atlas, of a sweep with recorded frames:

    python docs/pictures.py results/column

in the clone's root, with Chromium on PATH. `system/frames` of the case has `record yes;`.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.support.browser import Browser  # noqa: E402

LARGEST = 200_000
"""Bytes of a picture."""
SEEN_AT = 0.93
"""Time of the run, s, that the picture of the live page shows."""


def elutria(*arguments: str) -> subprocess.Popen[str]:
    """A command of the tool at work."""
    command = [sys.executable, "-m", "elutria", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def save(browser: Browser, to: Path, height: int) -> None:
    """What the browser shows, its upper part, in as few colours as the picture needs."""
    browser.picture(to)
    picture = Image.open(to).convert("RGB")
    picture = picture.crop((0, 0, picture.width, min(height, picture.height)))
    picture.quantize(256, dither=Image.Dither.NONE).save(to, optimize=True)
    assert to.stat().st_size < LARGEST, f"{to}: {to.stat().st_size} bytes"
    print(to.relative_to(ROOT))


def picture_of_page(
    command: str, results: Path, to: Path, size: tuple[int, int], state: str = ""
) -> None:
    """The report or the atlas, in a state of its sliders."""
    width, height = size
    with tempfile.TemporaryDirectory() as folder, Browser(width, height + 150) as browser:
        page = Path(folder) / "page.html"
        if elutria(command, str(results), "--to", str(page)).wait() != 0:
            raise SystemExit(f"elutria {command} failed")
        browser.open(page.as_uri() + state)
        browser.wait("document.readyState === 'complete'")
        time.sleep(1)
        save(browser, to, height)


def picture_of_view(results: Path, to: Path) -> None:
    """The page of `elutria view` with the middle run of the sweep."""
    process = elutria("view", "--no-browser", str(results))
    try:
        assert process.stdout is not None
        with Browser(1280, 950) as browser:
            browser.open(process.stdout.readline().strip())
            browser.wait("window.elutria && elutria.frames > 2")
            buttons = "[...document.querySelectorAll('#runs button')]"
            middle = f"{buttons}.find((button, k, all) => 2 * k + 1 >= all.length)"
            browser.ask(f"{middle}.click()")
            browser.wait(f"{middle}.ariaCurrent === 'true'")
            time.sleep(1)
            browser.wait("elutria.frame")
            browser.ask("document.getElementById('pause').click()")
            browser.ask(
                "(() => { const e = document.getElementById('time');"
                f" e.value = {SEEN_AT}; e.dispatchEvent(new Event('input')); }})()"
            )
            browser.ask("document.getElementById('slice').click()")
            browser.ask(
                "(() => { const e = document.getElementById('larger');"
                " e.value = '2'; e.dispatchEvent(new Event('input')); })()"
            )
            browser.wait(f"Math.abs(elutria.frame.time - {SEEN_AT}) < 0.1")
            browser.wait("elutria.statistics && elutria.statistics.curve.length > 10")
            time.sleep(3)
            save(browser, to, 800)
    finally:
        process.terminate()
        process.wait(20)


def main() -> None:
    """All three pictures."""
    results = Path(sys.argv[1])
    picture_of_view(results, ROOT / "docs/user/view.png")
    picture_of_page("report", results, ROOT / "docs/report.png", (1060, 1300))
    state = "#gas_velocity_m_s=5.5&quartz.d63=0.0007"
    picture_of_page("atlas", results, ROOT / "docs/atlas.png", (1280, 1130), state)


if __name__ == "__main__":
    main()
