"""Draws a run written in ASCII: python docs/cases/picture.py RUN PICTURE. Gas speed in the middle
layer of cells, and the grains at the last time, coloured by size."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from elutria.output.plots import STYLE
from elutria_validation.harness.cases import read_gas, times
from elutria_validation.harness.particles import read_particles
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

TICKS = (20, 50, 100, 200, 500, 1000, 2000)


def middle_cells(run: Path) -> tuple[NDArray[np.int64], list[NDArray[np.float64]]]:
    """Cells that the middle plane along y cuts, and their outlines (x, z), mm."""

    def body(name: str) -> str:
        return (run / "constant/polyMesh" / name).read_text().partition("}")[2]

    points = np.array(re.findall(r"\((\S+) (\S+) (\S+)\)", body("points")), dtype=float)
    faces = [
        [int(k) for k in f.split()]
        for f in re.findall(r"\d\(([\d ]+)\)", body("faces"))
    ]
    corners: dict[int, set[int]] = {}
    for name in ("owner", "neighbour"):
        for face, cell in zip(faces, re.findall(r"\d+", body(name))[1:], strict=False):
            corners.setdefault(int(cell), set()).update(face)
    cells = np.array(sorted(corners))
    along = [points[list(corners[cell]), 1] for cell in cells]
    layers = np.unique(np.array([y.mean() for y in along]).round(6))
    middle = layers[len(layers) // 2]
    chosen = cells[[y.min() <= middle < y.max() for y in along]]
    outlines = []
    for cell in chosen:
        flat = np.unique(
            (1e3 * points[list(corners[cell])][:, [0, 2]]).round(5), axis=0
        )
        away = flat - flat.mean(axis=0)
        outlines.append(flat[np.argsort(np.arctan2(away[:, 1], away[:, 0]))])
    return chosen, outlines


def draw(run: Path, picture: Path) -> None:
    """Gas and grains side by side; lengths in mm."""
    last = times(run)[-1]
    cells, outlines = middle_cells(run)
    speed = np.linalg.norm(read_gas(run, last), axis=1)[cells]
    cloud = read_particles(run, last)
    place, size = 1e3 * cloud.position, 1e6 * cloud.diameter
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3.4, 4.6))
        gas, grains = figure.subplots(1, 2, sharey=True)
        shown = gas.add_collection(
            PolyCollection(outlines, array=speed, edgecolor="face", lw=0.1)
        )
        figure.colorbar(
            shown, ax=gas, label="gas speed  (m/s)", location="top", aspect=12
        )
        grains.add_collection(
            PolyCollection(outlines, facecolor="0.93", edgecolor="0.93", lw=0.1)
        )
        scale = mpl.colors.LogNorm(size.min(), size.max())
        dots = grains.scatter(place[:, 0], place[:, 2], c=size, s=3, lw=0, norm=scale)
        bar = figure.colorbar(
            dots, ax=grains, label="diameter  (µm)", location="top", aspect=12
        )
        ticks = [t for t in TICKS if 0.99 * size.min() < t < 1.01 * size.max()]
        bar.set_ticks(ticks, labels=[str(t) for t in ticks])
        bar.minorticks_off()
        for axes in (gas, grains):
            axes.autoscale_view()
            axes.set_aspect("equal")
            axes.set_xticks([0, int(round(max(o[:, 0].max() for o in outlines), -1))])
            axes.set_xlabel("$x$  (mm)")
        gas.set_ylabel("$z$  (mm)")
        figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    draw(Path(sys.argv[1]), Path(sys.argv[2]))
