"""What a page shows of a sweep: a list of its runs, and the one of them that was chosen."""

from __future__ import annotations

import asyncio
import re
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

from elutria.errors import ElutriaError, InputError, one_line
from elutria.running.marker import MARKER
from elutria.running.run import FRAMES
from elutria.viewing.server import PageServer
from elutria.viewing.sessions import Session, is_going_on, session_of

LOOKS = 1.0
"""Seconds between looks at the folder: a sweep that goes on makes further runs."""
OF_A_RUN = ("scene", "fates", "statistics", "control", "state")
"""Kinds of messages that are about the run that is shown."""


def runs_in(results: Path) -> list[Path]:
    """The runs of a folder of results, by the numbers in their names."""
    found = [marker.parent for marker in results.glob(f"*/{MARKER}")]
    return sorted(found, key=lambda run: _in_order(run.name))


def _in_order(name: str) -> list[tuple[float, str]]:
    """Words and numbers of a name: U10 after U9."""
    parts = re.split(r"(\d+(?:\.\d+)?)", name)
    return [(float(part), "") if k % 2 else (-1.0, part) for k, part in enumerate(parts)]


class SweepSession:
    """The runs of a sweep. It shows the run that goes on, else the first that was recorded, until
    another is chosen. Raises InputError where nothing was recorded or is being recorded."""

    def __init__(self, results: Path):
        self.server = PageServer(self.wish)
        self.results = results
        self.end = ("ended", "")
        self._session: Session | None = None
        self._chosen = ""
        self._again = asyncio.Event()
        runs = self._runs()
        if not any(run["state"] for run in runs):
            raise InputError(
                f"{results}: none of its {len(runs)} runs has recorded frames; allowed: after "
                "'elutria sweep' of a case with 'record yes;' in system/frames, or "
                "'elutria run CASE --frames'"
            )

    def _runs(self) -> list[dict[str, str]]:
        """Name and state of each run: live, recorded, or empty where there is nothing to see."""
        found = []
        for run in runs_in(self.results):
            seen = (run / FRAMES).is_file()
            live = (seen or (run / "system/frames").is_file()) and is_going_on(run)
            state = "live" if live else "recorded" if seen else ""
            found.append({"name": run.name, "state": state})
        return found

    def wish(self, wish: dict[str, Any]) -> None:
        """What a page asks for: another run, or something of the one that is shown."""
        name = wish.get("run")
        if name in [run["name"] for run in self._runs() if run["state"]]:
            self._chosen = str(name)
            self._again.set()
        elif self._session is not None:
            self._session.wish(wish)

    async def fit(self) -> None:
        """The curve is that of the run's own session."""

    async def play(self) -> None:
        """Show one run after the other, for as long as somebody may look on."""
        while True:
            self._choose()
            shown = asyncio.create_task(self._show())
            while not self._again.is_set():
                self.server.tell("runs", {"runs": self._runs(), "chosen": self._chosen})
                with suppress(TimeoutError):
                    await asyncio.wait_for(self._again.wait(), LOOKS)
                if shown.done() and self._live():
                    break  # the sweep has gone on
            shown.cancel()
            with suppress(asyncio.CancelledError):
                await shown
            self._chosen = self._chosen if self._again.is_set() else ""
            self._again.clear()

    def _live(self) -> str:
        """Name of the first run that goes on."""
        return next((run["name"] for run in self._runs() if run["state"] == "live"), "")

    def _choose(self) -> None:
        """The run that goes on, else the first that was recorded, where none was chosen."""
        recorded = [run["name"] for run in self._runs() if run["state"]]
        self._chosen = self._chosen or self._live() or (recorded or [""])[0]

    async def _show(self) -> None:
        """The chosen run, until its end or for ever."""
        self.server.forget(OF_A_RUN)
        try:
            self._session = session_of(self.results / self._chosen, self.server)
            with closing(self._session):
                fits = asyncio.create_task(self._session.fit())
                try:
                    await self._session.play()
                finally:
                    fits.cancel()
        except ElutriaError as error:
            self.server.tell("state", {"state": "failed", "text": one_line(error)})
