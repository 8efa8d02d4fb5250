"""A run as a film: .gif or .mp4 from its recorded frames, drawn by matplotlib; .html is the page
itself with the frames in it (standalone.py)."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elutria.errors import InputError, one_line
from elutria.files import atomic_write
from elutria.viewing.frames import Frame, Scene
from elutria.viewing.recording import Recording
from elutria.viewing.sessions import about
from elutria.viewing.standalone import write_standalone
from elutria.viewing.statistics import Statistics, summary
from elutria.viewing.sweeps import runs_in
from elutria.viewing.walls import Walls, read_walls

if TYPE_CHECKING:
    from matplotlib.animation import AbstractMovieWriter
    from matplotlib.axes import Axes

KINDS = (".mp4", ".gif", ".html")
RATE = 20
"""Frames of a film in a second."""
COLOURS = ("#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7", "#bbbbbb")
"""Okabe & Ito 2008; the page has the same."""
FITS = 10
"""Frames of a film from one fit of the curve to the next."""
SMALLEST = 2.0
"""Points across that a parcel is drawn with at least: smaller ones would not be seen."""
SIZE = (7.2, 6.4)
"""Inches, at 100 dots each."""


def writer_for(path: Path) -> AbstractMovieWriter:
    """Encodes a film. Raises InputError for another ending than a film has, or without ffmpeg."""
    from matplotlib.animation import FFMpegWriter, PillowWriter

    if path.suffix == ".gif":
        return PillowWriter(fps=RATE)
    if path.suffix != ".mp4":
        raise InputError(f"--record {path}; allowed: a file that ends in {', '.join(KINDS)}")
    if shutil.which("ffmpeg") is None:
        raise InputError(
            f"--record {path}: ffmpeg: not found on PATH; allowed: after 'apt-get install ffmpeg', "
            "or a .gif or .html file"
        )
    return FFMpegWriter(
        fps=RATE, codec="libx264", extra_args=["-pix_fmt", "yuv420p", "-crf", "22", "-an"]
    )


def check_film(to: Path) -> None:
    """Raise InputError where a film of this name cannot be made, before anything is run."""
    if to.suffix != ".html":
        writer_for(to)


def require_one(place: Path) -> None:
    """Raise InputError for the folder of a sweep: a film is of one run."""
    if runs := runs_in(place):
        names = one_line(", ".join(run.name for run in runs), 200)
        raise InputError(f"{place}: holds several runs; allowed: a film of one of them ({names})")


def record(run: Path, to: Path, speed: float, on_frame: Callable[[float], None]) -> None:
    """Write the film of a run's recording, `speed` s of the run in a second. `on_frame` gets the
    share that is done."""
    if to.suffix == ".html":
        write_standalone(run, to, about(run))
        return
    writer = writer_for(to)
    os.environ.setdefault("MPLBACKEND", "agg")
    import matplotlib.pyplot as plt

    recording = Recording(run)
    picture = _Picture(recording.scene, read_walls(run), _heaviest(recording))
    try:
        with atomic_write(to) as temporary, writer.saving(picture.figure, str(temporary), dpi=100):
            numbers = list(_numbers(recording, speed))
            for k, number in enumerate(numbers):
                picture.draw(recording, number, fit=k % FITS == 0 or k == len(numbers) - 1)
                writer.grab_frame()
                on_frame((k + 1) / len(numbers))
    finally:
        plt.close(picture.figure)
        recording.close()


def _numbers(recording: Recording, speed: float) -> Iterator[int]:
    """The recorded frames that make a film's."""
    first, last = recording.times[0], recording.times[-1]
    for time in np.arange(first, last + speed / RATE, speed / RATE):
        yield recording.at(float(time))


def _heaviest(recording: Recording) -> tuple[float, float]:
    """Smallest and largest diameter (m) of what leaves, the ends of the curve's axis."""
    rows = np.concatenate(recording.departures)
    if not len(rows):
        return 1e-4, 1e-3
    return float(rows["diameter"].min()), float(rows["diameter"].max())


class _Picture:
    """The column from the side, and beside it the partition curve."""

    def __init__(self, scene: Scene, walls: Walls, sizes: tuple[float, float]):
        import matplotlib.pyplot as plt

        self.scene = scene
        self.across, self.up = _view(scene)
        self.figure = plt.figure(figsize=SIZE, facecolor="white")
        low, high = (self._flat(corner[None])[0] for corner in scene.box)
        width = float(np.clip(abs(high[0] - low[0]) / abs(high[1] - low[1]), 0.15, 0.6))
        self.figure.subplots_adjust(left=0.09, right=0.97, bottom=0.09, top=0.94)
        grid = self.figure.add_gridspec(1, 2, width_ratios=[width, 1 - width], wspace=0.25)
        self.column: Axes = self.figure.add_subplot(grid[0])
        self.curve: Axes = self.figure.add_subplot(grid[1])
        self._draw_column(walls, low, high)
        self._draw_axes(sizes)
        self.statistics = Statistics(scene)
        self._counted = 0

    def _flat(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, 3) as they are seen (n, 2), mm."""
        return 1000 * points @ np.column_stack([self.across, self.up])

    def _draw_column(
        self, walls: Walls, low: NDArray[np.float64], high: NDArray[np.float64]
    ) -> None:
        from matplotlib.collections import LineCollection

        lines = self._flat(walls.lines.reshape(-1, 3)).reshape(-1, 2, 2)
        self.column.add_collection(LineCollection(list(lines), colors="0.4", linewidths=0.8))
        ends = np.sort([low, high], axis=0)
        margin = 0.02 * float(np.ptp(ends[:, 1]))
        self.column.set(
            xlim=(ends[0, 0] - margin, ends[1, 0] + margin),
            ylim=(ends[0, 1] - margin, ends[1, 1] + margin),
            aspect="equal", xlabel="mm", ylabel="mm",
        )  # fmt: skip
        self.dots = self.column.scatter([], [], s=1, linewidths=0)

    def _draw_axes(self, sizes: tuple[float, float]) -> None:
        low, high = 1e6 * np.array(sizes)
        self.curve.set(xscale="log", xlim=(0.95 * low, 1.05 * high), ylim=(-0.02, 1.02))
        of_all = ", of all" if len(self.scene.materials) > 1 else ""
        self.curve.set(xlabel="size, µm", ylabel=f"share to {self.scene.partition_to}{of_all}")
        ticks = [d * 10**k for k in range(-1, 6) for d in (1, 2, 3, 5)]
        shown = [tick for tick in ticks if 0.95 * low <= tick <= 1.05 * high]
        self.curve.set_xticks(shown, [f"{tick:g}" for tick in shown])
        self.curve.minorticks_off()
        self.curve.grid(color="0.9")
        for name, colour in zip(self.scene.materials, COLOURS, strict=False):
            self.curve.scatter([], [], s=16, color=colour, label=name)
        if len(self.scene.materials) > 1:
            self.curve.legend(loc="upper left", fontsize=8)
        (self.line,) = self.curve.plot([], [], color="#0072b2")
        self.band: Any = None

    def draw(self, recording: Recording, number: int, *, fit: bool) -> None:
        """The frame of a number, and what has left by then."""
        frame = recording.frame(number)
        for departures in recording.departures[self._counted : number + 1]:
            self.statistics.add(departures)
        self._counted = max(self._counted, number + 1)
        self._draw_parcels(frame)
        if fit:
            self._draw_curve()
        left = len(self.statistics)
        self.column.set_title(f"{frame.time:.2f} s", fontsize=10, loc="left")
        self.curve.set_title(f"{left} of {int(frame.head['fed'])} parcels have left", fontsize=10)

    def _draw_parcels(self, frame: Frame) -> None:
        places = self._flat(self.scene.positions(frame))
        bounds = self.column.get_window_extent()
        dots_per_mm = bounds.height / float(np.ptp(self.column.get_ylim()))
        points = 1000 * self.scene.diameters(frame) * dots_per_mm * 72 / self.figure.dpi
        colours = np.array(COLOURS)[frame.particles["material"] % len(COLOURS)]
        self.dots.set_offsets(places.reshape(-1, 2))
        self.dots.set_sizes(np.maximum(points, SMALLEST) ** 2)
        self.dots.set_facecolor(list(colours))

    def _draw_curve(self) -> None:
        data = summary(self.scene, self.statistics.rows(), 0.0)
        if not data["curve"]:
            return
        sizes, share, low, high = np.array(data["curve"]).T
        self.line.set_data(1e6 * sizes, share)
        if self.band is not None:
            self.band.remove()
        self.band = self.curve.fill_between(1e6 * sizes, low, high, color="#56b4e9", alpha=0.3)


def _view(scene: Scene) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Directions to the right and upward of a view from the side: the wider one."""
    up = np.array(scene.json["up"], float)
    span = np.ptp(scene.box, axis=0) * (1 - np.abs(up))
    across = np.eye(3)[int(np.argmax(span))]
    across -= (across @ up) * up
    return across / np.linalg.norm(across), up
