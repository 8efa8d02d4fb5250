"""`--budget`: processor time that replicates may take, spent where the answer is known least."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite

from elutria.errors import InputError, one_line
from elutria.running.axes import Point

UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}
_UNKNOWN = 1.0
"""Half-width over d50 of a cut of which an end of the interval is not known."""


@dataclass(frozen=True)
class Known:
    """Of a point: half-width of the interval of d50 over d50, its runs, and what one takes (s)."""

    half_width: float
    runs: int
    run_s: float

    def gain(self) -> float:
        """By how much the square of the half-width falls with a further run, for each second."""
        width = self.half_width if isfinite(self.half_width) else _UNKNOWN
        if self.half_width != self.half_width or self.run_s <= 0:
            return 0.0  # no cut: nothing to know
        return float(width**2 / (self.runs + 1) / self.run_s)

    def with_one_more(self) -> Known:
        """As a further run is expected to make it."""
        narrower = (self.runs / (self.runs + 1)) ** 0.5
        return replace(self, half_width=self.half_width * narrower, runs=self.runs + 1)


@dataclass(frozen=True)
class Budget:
    """Processor seconds for all runs of a sweep, those that are there included."""

    processor_s: float

    def further_runs(self, points: Mapping[Point, Known]) -> dict[Point, int]:
        """How many more runs each point gets now; none when no run fits any more.

        A round takes half of what is left, so that the next one can follow what it found.
        """
        spent = sum(known.runs * known.run_s for known in points.values())
        left = self.processor_s - spent
        round_s, now, added = left / 2, dict(points), dict.fromkeys(points, 0)
        while fits := [p for p in now if now[p].run_s <= left and now[p].gain() > 0]:
            best = max(fits, key=lambda point: now[point].gain())
            if any(added.values()) and now[best].run_s > round_s:
                break
            added[best] += 1
            left, round_s = left - now[best].run_s, round_s - now[best].run_s
            now[best] = now[best].with_one_more()
        return {point: count for point, count in added.items() if count}


def parse_budget(text: str) -> Budget:
    """`90s`, `10min` or `2h` of processor time."""
    match = re.fullmatch(r"([0-9.]+(?:e[0-9]+)?)\s*(s|min|h)", text.strip())
    try:
        seconds = float(match[1]) * UNITS[match[2]] if match else 0.0
    except ValueError:
        seconds = 0.0
    if not (isfinite(seconds) and seconds > 0):
        raise InputError(f"--budget '{one_line(text, 40)}'; allowed: such as 90s, 10min or 2h")
    return Budget(seconds)
