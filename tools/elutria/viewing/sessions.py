"""What a page shows: a run that is going on, which can be steered, or a recorded one."""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from elutria.case.case import Case
from elutria.errors import ElutriaError, InputError, one_line
from elutria.files import read_json
from elutria.running.marker import MARKER, SWEEP
from elutria.running.run import FRAMES
from elutria.viewing.control import Control
from elutria.viewing.frames import Frame, FrameReader, Scene
from elutria.viewing.recording import Recording
from elutria.viewing.server import PageServer
from elutria.viewing.statistics import Statistics, summary
from elutria.viewing.walls import read_walls

TICK = 0.015
"""Seconds between looks at the file."""
FITS = 1.0
"""Seconds between fits of the curve, at least."""
FATES = 0xFFFFFFFF
"""Begins a message that holds the parcels' fates."""
AS_FAST = 10.0
"""Seconds of a recording in a second, where no speed is asked for."""


class Session:
    """What both kinds have in common: pages are told of the scene, and of the statistics."""

    mode = ""

    def __init__(self, run: Path, server: PageServer | None = None):
        self.run = run
        self.control = Control()
        self.server = server or PageServer(self.wish)
        self.statistics: Statistics | None = None
        self.end = ("", "")
        """How a run ended that went on: state and text."""
        self._told = -1

    def wish(self, wish: dict[str, Any]) -> None:
        """What a page asks for."""
        if "control" in wish:
            self.control = self.control.changed(wish["control"])
            self.server.tell("control", {"control": asdict(self.control)})
            self.steer()

    def steer(self) -> None:
        """Do what `control` says."""

    async def play(self) -> None:
        """Show frames to the pages."""
        raise NotImplementedError

    def close(self) -> None:
        """Let go of the run's files."""

    def tell_state(self, state: str, text: str) -> None:
        self.server.tell("state", {"state": state, "text": text})

    def tell_scene(self, scene: Scene, duration: float) -> None:
        self.statistics = Statistics(scene)
        message = {"mode": self.mode, "scene": scene.json, "walls": read_walls(self.run).as_json()}
        message |= {"about": {**about(self.run), "duration_s": duration}}
        message |= {"control": asdict(self.control)}
        self.server.tell("scene", message)

    async def fit(self) -> None:
        """Keep the pages' curve up to date, in a thread beside the frames."""
        while True:
            await asyncio.sleep(FITS)
            statistics = self.statistics
            if statistics is None or len(statistics) == self._told:
                continue
            self._told = len(statistics)
            rows, since = statistics.rows(), statistics.since
            begin = time.monotonic()
            with contextlib.suppress(ElutriaError, ValueError, ArithmeticError):
                self.server.tell(
                    "statistics",
                    await asyncio.to_thread(summary, statistics.scene, rows, since),
                )
            # a fit of many parcels is left time for everything else
            await asyncio.sleep(3 * (time.monotonic() - begin))


class LiveSession(Session):
    """A run that is going on: `ended` says how it ended, None while it goes on. One that is not to
    be steered, as it is one of a sweep, is looked at alone."""

    def __init__(
        self,
        run: Path,
        ended: Callable[[], tuple[str, str] | None],
        server: PageServer | None = None,
        *,
        steers: bool = True,
    ):
        super().__init__(run, server)
        self.mode = "live" if steers else "watch"
        self._ended = ended
        self._now = 0.0
        self._over = False

    def wish(self, wish: dict[str, Any]) -> None:
        super().wish(wish)
        if "restart" in wish and self.statistics is not None:
            self.statistics.restart(self._now)
            self._told = -1

    def steer(self) -> None:
        if self._over or self.mode == "watch" or not (self.run / FRAMES).is_file():
            return
        with contextlib.suppress(ElutriaError):
            self.control.write(self.run)
        state = "paused" if self.control.pause else "running"
        self.tell_state(state, state)

    async def play(self) -> None:
        """Show frames as they come, until the run has ended."""
        reader = await self._opened()
        if reader is not None:
            with contextlib.closing(reader):
                self.tell_scene(reader.scene, 0.0)
                self.tell_state("running", "running")
                self.steer()
                await self._follow(reader)
        self._over = True
        self.end = self._ended() or ("ended", "the run has ended")
        self.tell_state(*self.end)

    async def _opened(self) -> FrameReader | None:
        """The frames, once there are any; None where the run ends without."""
        self.tell_state("starting", "the mesh is made, the gas settles")
        while True:
            with contextlib.suppress(InputError):
                return FrameReader(self.run)
            if self._ended() is not None:
                return None
            await asyncio.sleep(0.1)

    async def _follow(self, reader: FrameReader) -> None:
        assert self.statistics is not None
        while True:
            over = self._ended() is not None
            newest: Frame | None = None
            for frame in reader:
                self.statistics.add(frame.departures)
                if newest is not None and len(newest.samples) and not len(frame.samples):
                    frame = frame.with_samples(newest.samples)
                newest = frame
            if newest is not None:
                self._now = newest.time
                self.server.show(newest)
            elif over:
                return
            await asyncio.sleep(TICK)


class ReplaySession(Session):
    """A recorded run."""

    mode = "replay"

    def __init__(self, run: Path, server: PageServer | None = None):
        super().__init__(run, server)
        self.recording = Recording(run)
        self._time = self.recording.times[0]
        self._shown = -1
        self._first = 0
        self._counted = 0

    def wish(self, wish: dict[str, Any]) -> None:
        super().wish(wish)
        seek = wish.get("seek")
        if isinstance(seek, (int, float)) and seek == seek:
            self._time = min(max(float(seek), self.recording.times[0]), self.recording.times[-1])
        if "restart" in wish and self.statistics is not None:
            self.statistics.restart(self._time)
            self._first = self._counted = self._shown + 1
            self._told = -1

    def close(self) -> None:
        self.recording.close()

    async def play(self) -> None:
        """Show the frames at their pace while somebody looks, for as long as somebody may."""
        scene = self.recording.scene
        self.tell_scene(scene, self.recording.times[-1])
        self.server.tell("fates", FATES.to_bytes(4, "little") + self.recording.fates().tobytes())
        before = time.monotonic()
        while True:
            now = time.monotonic()
            if self.server.watched and not self.control.pause:
                self._time += (now - before) * (self.control.speed or AS_FAST)
            before = now
            self._show(self.recording.at(self._time))
            await asyncio.sleep(2 * TICK)

    def _show(self, number: int) -> None:
        if number == self._shown:
            return
        self._shown = number
        self._time = max(self._time, self.recording.times[0])
        at_end = number == len(self.recording) - 1
        self._count(number)
        try:
            self.server.show(self.recording.frame(number))
        except InputError as error:
            self.tell_state("failed", one_line(error))
            return
        self.tell_state("ended" if at_end else "running", "end" if at_end else "recorded")

    def _count(self, number: int) -> None:
        """Bring the statistics to what has left up to a frame."""
        assert self.statistics is not None
        if number + 1 < self._counted:
            since = self.statistics.since if number >= self._first else 0.0
            self._first = self._first if number >= self._first else 0
            self.statistics.restart(since)
            self._counted = self._first
        for departures in self.recording.departures[self._counted : number + 1]:
            self.statistics.add(departures)
        self._counted = number + 1


def is_going_on(run: Path) -> bool:
    """Whether an elutria is at work in a run's folder."""
    lock = run.resolve().parent / f".{run.resolve().name}.lock"
    try:
        with lock.open() as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


def session_of(run: Path, server: PageServer | None = None) -> Session:
    """What there is to see of a run: the run itself while it goes on, then what was recorded. A
    run of a sweep is not steered: its results would not be the sweep's."""
    if not is_going_on(run):
        return ReplaySession(run, server)

    def ended() -> tuple[str, str] | None:
        return None if is_going_on(run) else ("ended", "the run has ended")

    return LiveSession(run, ended, server, steers=not (run.parent / SWEEP).is_file())


def about(run: Path) -> dict[str, Any]:
    """The case's name, gas velocity and loading (None where it is given otherwise)."""
    known: dict[str, Any] = {"name": run.resolve().name, "gas_velocity_m_s": 1.0, "loading": None}
    with contextlib.suppress(ElutriaError):
        known["name"] = str(read_json(run / MARKER).get("case", known["name"]))
    with contextlib.suppress(ElutriaError):
        case = Case(run)
        known["gas_velocity_m_s"] = case.velocity()
        feed = case.dictionary("constant/feed")
        known["loading"] = feed.number("loading") if "loading" in feed else None
    return known
