"""Frames of a run: postProcessing/frames/frames.bin, as docs/user/outputs.md describes it.

The solver appends to the file while it is read: what is complete is taken, the rest waits.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from elutria.errors import InputError, one_line
from elutria.running.run import FRAMES

FOLDER = str(Path(FRAMES).parent)
MAGIC = b"ELUFRAM1"
MOST_HEAD = 10_000_000

HEAD = np.dtype(
    [
        ("bytes", "<u4"), ("particles", "<u4"), ("departures", "<u4"), ("samples", "<u4"),
        ("time", "<f8"), ("wall", "<f8"), ("inside", "<f8"), ("gas", "<f4"), ("loading", "<f4"),
        ("fed", "<u4"), ("lost", "<u4"), ("reserved", "<u4", 2),
    ]
)  # fmt: skip
PARTICLE = np.dtype(
    [
        ("position", "<u2", 3), ("diameter", "<u2"), ("rise", "<u2"), ("material", "<u2"),
        ("id", "<u4"),
    ]
)  # fmt: skip
DEPARTURE = np.dtype(
    [
        ("id", "<u4"), ("material", "<u2"), ("product", "<u2"), ("time", "<f4"), ("age", "<f4"),
        ("diameter", "<f4"), ("number", "<f4"),
    ]
)  # fmt: skip
SAMPLE = np.dtype("<u2")


@dataclass(frozen=True)
class Frame:
    """One frame: its bytes as they are in the file, and views of its parts."""

    content: bytes

    @cached_property
    def head(self) -> Any:
        return np.frombuffer(self.content, HEAD, 1)[0]

    @property
    def time(self) -> float:
        """Time of the run, s."""
        return float(self.head["time"])

    @property
    def particles(self) -> NDArray[Any]:
        """What is inside, records of PARTICLE (n,)."""
        return self._part(PARTICLE, HEAD.itemsize, "particles")

    @property
    def departures(self) -> NDArray[Any]:
        """What has left since the frame before, records of DEPARTURE (m,)."""
        begin = HEAD.itemsize + int(self.head["particles"]) * PARTICLE.itemsize
        return self._part(DEPARTURE, begin, "departures")

    @property
    def samples(self) -> NDArray[Any]:
        """Gas speed at the slice's points, mm/s; empty where it is as in the frame before."""
        begin = len(self.content) - int(self.head["samples"]) * SAMPLE.itemsize
        return self._part(SAMPLE, begin, "samples")

    def with_samples(self, samples: NDArray[Any]) -> Frame:
        """The same frame with another's gas."""
        head = np.frombuffer(self.content, HEAD, 1).copy()
        begin = len(self.content) - int(self.head["samples"]) * SAMPLE.itemsize
        head["samples"] = len(samples)
        head["bytes"] = begin + samples.nbytes
        return Frame(head.tobytes() + self.content[HEAD.itemsize : begin] + samples.tobytes())

    def _part(self, kind: np.dtype[Any], begin: int, count: str) -> NDArray[Any]:
        return np.frombuffer(self.content, kind, int(self.head[count]), begin)


@dataclass(frozen=True)
class Scene:
    """What holds for all frames of a run."""

    json: dict[str, Any]

    @property
    def box(self) -> NDArray[np.float64]:
        """Corners of the mesh's box (2, 3), m."""
        return np.array(self.json["box_m"], float)

    @property
    def materials(self) -> list[str]:
        return [material["name"] for material in self.json["materials"]]

    @property
    def densities(self) -> NDArray[np.float64]:
        """Density of each material, kg/m3."""
        return np.array([material["density_kg_m3"] for material in self.json["materials"]])

    @property
    def products(self) -> list[str]:
        return [str(name) for name in self.json["products"]]

    @property
    def partition_to(self) -> str:
        """The product whose share the curve is; recordings of before say nothing: the last."""
        return str(self.json.get("partition_to", self.products[-1]))

    def positions(self, frame: Frame) -> NDArray[np.float64]:
        """Where the parcels of a frame are (n, 3), m."""
        low, high = self.box
        return np.asarray(low + frame.particles["position"] / 65535 * (high - low))

    def diameters(self, frame: Frame) -> NDArray[np.float64]:
        """Their diameters (n,), m."""
        return np.asarray(frame.particles["diameter"] / 65535 * self.json["largest_diameter_m"])


def rises(frame: Frame) -> NDArray[np.float64]:
    """Upward velocities of a frame's parcels (n,), m/s."""
    return np.asarray((frame.particles["rise"] - 32768.0) / 1000)


class FrameReader:
    """Reads a run's frames from the first on, also while they are being written."""

    def __init__(self, run: Path):
        self.path = run / FRAMES
        try:
            self._file: BinaryIO = self.path.open("rb")
        except OSError as error:
            raise InputError(
                f"{self.path}: no frames were recorded ({error.strerror}); allowed: a case, or a "
                "run of 'elutria run --frames' or 'elutria view'"
            ) from error
        self.scene = Scene(self._read_head())
        self.place = self._file.tell()
        """Byte at which the next frame begins."""

    def close(self) -> None:
        """No more is read."""
        self._file.close()

    def _read_head(self) -> dict[str, Any]:
        start = self._file.read(len(MAGIC) + 4)
        length = int.from_bytes(start[len(MAGIC) :], "little")
        if not start.startswith(MAGIC) or len(start) != len(MAGIC) + 4 or length > MOST_HEAD:
            raise InputError(f"{self.path}: is not a file of frames (begins with {MAGIC.decode()})")
        try:
            head: dict[str, Any] = json.loads(self._file.read(length))
            Scene(head).positions(Frame(bytes(HEAD.itemsize)))
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise InputError(f"{self.path}: its head is not complete: {one_line(error)}") from error
        return head

    def read(self) -> Frame | None:
        """The next frame, None where there is none yet. Raises InputError for what is no frame."""
        frame = self._frame(self.place)
        if frame is not None:
            self.place += len(frame.content)
        return frame

    def read_at(self, place: int) -> Frame:
        """The frame that begins at a byte of the file."""
        frame = self._frame(place)
        if frame is None:
            raise InputError(f"{self.path}: byte {place}: a frame is gone")
        return frame

    def _frame(self, place: int) -> Frame | None:
        self._file.seek(place)
        start = self._file.read(HEAD.itemsize)
        if len(start) < HEAD.itemsize:
            return None
        head = np.frombuffer(start, HEAD, 1)[0]
        expected = (
            HEAD.itemsize
            + int(head["particles"]) * PARTICLE.itemsize
            + int(head["departures"]) * DEPARTURE.itemsize
            + int(head["samples"]) * SAMPLE.itemsize
        )
        if int(head["bytes"]) != expected:
            raise InputError(f"{self.path}: byte {place}: no frame begins here")
        content = start + self._file.read(expected - HEAD.itemsize)
        return Frame(content) if len(content) == expected else None

    def __iter__(self) -> Iterator[Frame]:
        """The frames that are there from here on."""
        while (frame := self.read()) is not None:
            yield frame
