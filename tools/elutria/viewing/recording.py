"""A run's frames as a whole: to go to any time of it, and to know how each parcel ends."""

from __future__ import annotations

from bisect import bisect_right
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria.errors import InputError
from elutria.viewing.frames import Frame, FrameReader, Scene


class Recording:
    """The complete frames of a run. Raises InputError where there is none."""

    def __init__(self, run: Path):
        self._reader = FrameReader(run)
        self.times: list[float] = []
        self.departures: list[NDArray[Any]] = []
        self._places: list[int] = []
        self._samples: list[int] = []
        """For each frame, the frame that holds the gas which it shows."""
        while True:
            place = self._reader.place
            frame = self._reader.read()
            if frame is None:
                break
            self._places.append(place)
            self._samples.append(
                len(self.times) if len(frame.samples) or not self.times else self._samples[-1]
            )
            self.times.append(frame.time)
            self.departures.append(frame.departures.copy())
        if not self.times:
            raise InputError(f"{self._reader.path}: holds no frame yet")

    @property
    def scene(self) -> Scene:
        return self._reader.scene

    def __len__(self) -> int:
        return len(self.times)

    def close(self) -> None:
        self._reader.close()

    def at(self, time: float) -> int:
        """Number of the last frame at or before a time (s), the first where there is none."""
        return max(bisect_right(self.times, time) - 1, 0)

    def frame(self, number: int) -> Frame:
        """A frame, with the gas as it was then."""
        frame = self._reader.read_at(self._places[number])
        source = self._samples[number]
        if source == number:
            return frame
        return frame.with_samples(self._reader.read_at(self._places[source]).samples)

    def fates(self) -> NDArray[np.uint8]:
        """For each parcel's number, the product it leaves with, from 1; 0: it stays inside."""
        rows = np.concatenate(self.departures)
        fates = np.zeros(int(rows["id"].max()) + 1 if len(rows) else 0, np.uint8)
        fates[rows["id"]] = rows["product"] + 1
        return fates
