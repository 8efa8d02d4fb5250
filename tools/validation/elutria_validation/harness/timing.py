"""Times of programs, taken in turns, so that drifts of the machine reach all alike."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import Any


def against_stock(
    name: str, steps: Mapping[str, float], seconds: Mapping[str, Sequence[float]], stock: str
) -> dict[str, Any]:
    """A row: variant, step (s), wall seconds of its steps, of a simulated second, over stock's.

    `seconds` are those of single steps, taken in turns, so that the k-th of all belong together.
    """
    own = [value / steps[name] for value in seconds[name]]
    others = [value / steps[stock] for value in seconds[stock]]
    return {
        "variant": name,
        "time_step_s": steps[name],
        "seconds_per_step": statistics.median(seconds[name]),
        "low": min(seconds[name]),
        "high": max(seconds[name]),
        "seconds_per_simulated_second": statistics.median(own),
        "speed_over_stock": statistics.median(o / s for o, s in zip(others, own, strict=True)),
    }
