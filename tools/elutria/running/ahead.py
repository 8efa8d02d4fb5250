"""How long a run still takes, from what its solver says after each step.

While it is fed, a column holds as many parcels as enter in the time that one stays (Little's law).
Afterwards it empties: those that hover longest leave last, so that the pace of the last halving
tells of the next ones. What is left of simulated time takes what the last steps took.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from math import inf, log, nan
from pathlib import Path
from typing import TYPE_CHECKING

from elutria.files import read_json

if TYPE_CHECKING:
    from elutria.running.solver import Step

_PACE_S = 30.0
"""Seconds of the clock over which the pace is taken."""


class Ahead:
    """Follows a run in `folder`, whose solver writes its plan to `plan` before the first step."""

    def __init__(self, plan: Path, clock: Callable[[], float] = time.monotonic):
        self._plan = plan
        self._clock = clock
        self._ends: tuple[float, float] | None = None
        self._began = clock()
        self._pace: deque[tuple[float, float]] = deque()
        self._emptying: list[tuple[float, int]] = []

    def left_s(self, step: Step) -> float:
        """Seconds of the clock until the run ends; nan where that is not known yet."""
        now = self._clock()
        self._pace.append((now, step.time))
        while len(self._pace) > 2 and now - self._pace[0][0] > _PACE_S:
            self._pace.popleft()
        (then, before), ends = self._pace[0], self._feed_and_run_end()
        if ends is None or not (step.time > before and now > then):
            return nan
        return self._simulated(step, *ends) * (now - then) / (step.time - before)

    def share(self, left_s: float) -> float:
        """How far the run is, 0..1, with so much left."""
        gone = self._clock() - self._began
        return gone / (gone + left_s)

    def _simulated(self, step: Step, feed_end: float, run_end: float) -> float:
        """Simulated time that is left (s)."""
        latest = max(run_end - step.time, 0.0)
        if step.time < feed_end:
            stay = step.time * step.inside / step.fed if step.fed else inf
            return min(latest, feed_end - step.time + stay * log(step.inside + 1))
        self._emptying.append((step.time, step.inside))
        if step.inside == 0:
            return 0.0
        earlier = [t for t, inside in self._emptying if inside >= 2 * step.inside]
        if earlier:
            halving = step.time - earlier[-1]
        else:
            first, inside = self._emptying[0]
            halving = max(log(2) * inside / step.fed * feed_end, step.time - first)
        return min(latest, halving * log(step.inside + 1) / log(2))

    def _feed_and_run_end(self) -> tuple[float, float] | None:
        """s; infinite where no entry says when: the run then ends at endTime."""
        if self._ends is None and self._plan.is_file():
            feed = read_json(self._plan).get("feed") or {}
            if {"end_s", "run_ends_s"} <= feed.keys():
                feed_end, run_end = feed["end_s"], feed["run_ends_s"]
                self._ends = (
                    inf if feed_end is None else feed_end,
                    inf if run_end is None else run_end,
                )
        return self._ends
