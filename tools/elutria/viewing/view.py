"""`elutria view`: a page of a case that it runs, or of a run or a sweep, going on or recorded."""

from __future__ import annotations

import asyncio
import contextlib
import shutil
import signal
import subprocess
import sys
import webbrowser
from collections.abc import Callable
from pathlib import Path

from elutria.case.case import Case
from elutria.errors import ElutriaError, InputError, one_line
from elutria.running.marker import FINISHED, MARKER, Identity, Marker
from elutria.running.run import FRAMES, locked
from elutria.viewing.sessions import LiveSession, Session, session_of
from elutria.viewing.sweeps import SweepSession, runs_in

Seen = Session | SweepSession
"""A run or a sweep that is looked at."""

MOST_LINES = 20
"""Of what the run says, as many are kept to say why it failed."""


class Run:
    """`elutria run CASE --frames` beside this process, with which it ends. What it says is shown
    where it is `told`."""

    def __init__(self, arguments: list[str], folder: Path, *, told: bool = False):
        self.folder = folder
        # of an earlier view: not to be taken for this run's
        with locked(folder):
            for stale in (folder / FRAMES, folder / FINISHED):
                stale.unlink(missing_ok=True)
        command = [sys.executable, "-m", "elutria", "run", *arguments, "--frames"]
        command += ["--to", str(folder)]
        if shutil.which("setpriv"):
            command = ["setpriv", "--pdeathsig", "TERM", *command]
        self._lines: list[str] = []
        self._process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=None if told else subprocess.DEVNULL,
            stderr=subprocess.PIPE, text=True, errors="replace",
        )  # fmt: skip

    def ended(self) -> tuple[str, str] | None:
        """How it ended: state and text; None while it goes on."""
        code = self._process.poll()
        if code is None:
            return None
        if not self._lines and self._process.stderr:
            self._lines = self._process.stderr.read().splitlines()[-MOST_LINES:]
        if code == 0:
            return "ended", "the run has ended"
        reason = self._lines[-1] if self._lines else f"exit code {code}"
        return "failed", one_line(reason.removeprefix("elutria: "), 400)

    def wait(self) -> None:
        """Until it has ended."""
        self._process.wait()

    def stop(self) -> None:
        """End it, if it has not ended."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(5)
                return
            self._process.kill()
            self._process.wait()


def is_run(folder: Path) -> bool:
    """Whether a folder is a run of elutria, or has frames or runs, and so is no case to be run."""
    return (folder / MARKER).is_file() or (folder / FRAMES).is_file() or bool(runs_in(folder))


def session_for(place: Path) -> Seen:
    """What there is to see of a run or a sweep."""
    return SweepSession(place) if runs_in(place) else session_of(place)


def look_on(session: Seen, port: int, say: Callable[[str], None], *, browser: bool) -> None:
    """Serve the page until Ctrl-C. Raises InputError where the port cannot be had."""
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(_serve(session, port, say, browser))


async def _serve(session: Seen, port: int, say: Callable[[str], None], browser: bool) -> None:
    try:
        address = await session.server.start(port)
    except OSError as error:
        raise InputError(f"--port {port}: {one_line(error)}; allowed: a free port, or 0") from error
    say(address)
    if browser:
        webbrowser.open(address)
    fits = asyncio.create_task(session.fit())
    try:
        await session.play()
        say(session.end[1])
        await asyncio.Event().wait()  # the page stays until it is told to go
    finally:
        fits.cancel()
        await session.server.stop()


def view_case(
    arguments: list[str], folder: Path, port: int, say: Callable[[str], None], *, browser: bool
) -> None:
    """Run a case and show it; it is ended when the page is."""
    running = Run(arguments, folder)
    try:
        look_on(LiveSession(folder, running.ended), port, say, browser=browser)
    finally:
        running.stop()


def run_case_to_end(arguments: list[str], folder: Path) -> None:
    """Run a case and record it. Raises ElutriaError where it fails."""
    running = Run(arguments, folder, told=True)
    try:
        running.wait()
    finally:
        running.stop()
    state, text = running.ended() or ("", "")
    if state == "failed":
        raise ElutriaError(text)


def folder_for(place: Path, to: Path | None) -> Path:
    """Where a case is run that is to be seen. Raises InputError where another run than a view's
    has its results."""
    if to is not None and (to / FINISHED).is_file():
        raise InputError(
            f"--to {to}: holds a finished run; allowed: another folder, or 'elutria view {to}' "
            "if it is what you want to see"
        )
    return (to or Path("results") / Case(place).name / "view").resolve()


def run_arguments(
    case: Path, velocity: float | None, settings: list[str], np: int, folder: Path
) -> list[str]:
    """What `elutria run` is told. Raises InputError where the case cannot be run so, or `folder`
    holds a run of other inputs, whose frames stay."""
    source = Case(case)
    chosen = source.settings_for(velocity, settings)
    source.check_settings(chosen)
    before = Marker.read(folder)
    if before and (found := before.identity.differences(Identity.of(source, chosen))):
        raise InputError(
            f"{folder}: holds a run of other inputs ({', '.join(found)}); allowed: another --to, "
            "or this one without that folder"
        )
    arguments = [str(case), "--np", str(np)]
    arguments += [] if velocity is None else ["--velocity", repr(velocity)]
    return arguments + [word for text in settings for word in ("--set", text)]
