"""A Chromium without a window, where there is one: prints pages."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from elutria.errors import ElutriaError, one_line
from elutria.files import atomic_write

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
SECONDS = 120


def find_browser() -> str | None:
    """The program, None where none is installed."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


def run_browser(program: str, arguments: list[str]) -> subprocess.CompletedProcess[str]:
    """Run it headless with a profile of its own, which is thrown away."""
    with tempfile.TemporaryDirectory() as profile:
        command = [program, "--headless", "--disable-gpu", f"--user-data-dir={profile}"]
        if os.geteuid() == 0:  # root has no sandbox; the pages are our own
            command.append("--no-sandbox")
        return subprocess.run(
            [*command, *arguments], capture_output=True, text=True, check=False, timeout=SECONDS
        )


def print_pdf(program: str, page: Path, to: Path) -> Path:
    """Print a page to a PDF file. Raises ElutriaError when the browser does not."""
    with atomic_write(to) as temporary:
        try:
            done = run_browser(
                program,
                [f"--print-to-pdf={temporary}", "--no-pdf-header-footer", page.resolve().as_uri()],
            )
        except subprocess.TimeoutExpired as error:
            raise ElutriaError(f"{program}: did not print {page} within {SECONDS} s") from error
        if not temporary.is_file():
            raise ElutriaError(f"{program}: did not print {page}: {one_line(done.stderr)}")
    return to
