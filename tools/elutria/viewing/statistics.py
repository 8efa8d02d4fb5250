"""What has left, as a partition curve that grows: from the departures in the frames."""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from elutria.classification.classify import fit_events
from elutria.classification.events import INSIDE, Events
from elutria.classification.partition import class_limits, partition_table
from elutria.viewing.frames import DEPARTURE, Scene

POINTS = 61
"""Of the curve, as it is sent."""
FEWEST = 30
"""Parcels from which on a curve is fitted."""


class Statistics:
    """Departures from a time on. The share is that of the feed's partition curve."""

    def __init__(self, scene: Scene):
        self.scene = scene
        self.since = 0.0
        self._parts: list[NDArray[Any]] = []

    def __len__(self) -> int:
        return sum(len(part) for part in self._parts)

    def restart(self, since: float) -> None:
        """Forget all; what leaves from `since` (s) on counts."""
        self.since = since
        self._parts = []

    def add(self, departures: NDArray[Any]) -> None:
        """Records of DEPARTURE, one after the other in time."""
        chosen = departures[departures["time"] >= self.since]
        if len(chosen):
            self._parts.append(chosen)

    def rows(self) -> NDArray[Any]:
        """All records that count."""
        return np.concatenate([np.empty(0, DEPARTURE), *self._parts])


def summary(scene: Scene, rows: NDArray[Any], since: float) -> dict[str, Any]:
    """The curve (rows of size in m, share, lower and upper limit), the size classes in the same
    form, the cut size with its interval, and each product's mass (kg) by material."""
    events = _events(scene, rows)
    result: dict[str, Any] = {
        "kind": "statistics", "since": since, "parcels": len(rows),
        "curve": [], "classes": [], "d50": None, "products": _products(scene, rows, events),
    }  # fmt: skip
    if len(rows) >= FEWEST and np.ptp(events.diameter) > 0:
        limits = class_limits(float(events.diameter.min()), float(events.diameter.max()))
        result["classes"] = [
            [entry.diameter, entry.share, entry.share_low, entry.share_high]
            for entry in partition_table(events, limits)
        ]
        fit = fit_events(events)
        if fit.curve is not None:
            sizes = np.geomspace(events.diameter.min(), events.diameter.max(), POINTS)
            result["curve"] = np.column_stack([sizes, *fit.band(sizes)]).tolist()
            result["d50"] = [value if isfinite(value) else None for value in fit.sizes[0.50]]
    return result


def _events(scene: Scene, rows: NDArray[Any]) -> Events:
    return Events(
        material=_named(rows["material"], scene.materials),
        outlet=_named(rows["product"], [*scene.products, INSIDE]),
        diameter=rows["diameter"].astype(float),
        density=scene.densities[rows["material"]],
        number=rows["number"].astype(float),
        time=rows["time"].astype(float) - rows["age"],
        partition_to=scene.partition_to,
    )


def _named(codes: NDArray[Any], names: list[str]) -> Any:
    """Categories by their numbers."""
    return pd.Categorical.from_codes(codes.astype(np.int64), pd.Index(names))


def _products(scene: Scene, rows: NDArray[Any], events: Events) -> list[dict[str, Any]]:
    masses = np.zeros((len(scene.materials), len(scene.products)))
    np.add.at(masses, (rows["material"], rows["product"]), events.mass)
    table = dict(zip(scene.materials, masses, strict=True))
    if len(table) > 1:
        table["all"] = masses.sum(axis=0)
    return [{"material": name, "mass_kg": list(map(float, row))} for name, row in table.items()]
