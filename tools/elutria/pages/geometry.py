"""The mesh's outline as a picture: its edges as lines, the patches of feed and products filled."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from foamlib import FoamFile
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from elutria.output.style import COLUMN_WIDTH

Array = NDArray[np.float64]
SHARP = 20.0
"""Faces that meet at a larger angle (degrees) have an edge between them."""
MOST_FACES = 5_000_000


@dataclass(frozen=True)
class Outline:
    """Corner points (n, 3) in m, lines (m, 2) between them, and faces of named patches."""

    points: Array
    lines: NDArray[np.int64]
    patches: dict[str, list[NDArray[np.int64]]]


def read_outline(mesh: Path, named: set[str]) -> Outline | None:
    """The outline of constant/polyMesh, with the faces of the `named` patches; None where the mesh
    is not there or is too large to be drawn."""
    if not all((mesh / name).is_file() for name in ("points", "faces", "boundary")):
        return None
    points = np.asarray(FoamFile(mesh / "points")[None], dtype=float)
    faces = _faces(FoamFile(mesh / "faces")[None])
    if len(faces) > MOST_FACES:
        return None
    boundary: list[NDArray[np.int64]] = []
    patch_of: list[int] = []
    patches: dict[str, list[NDArray[np.int64]]] = {}
    entries: Any = FoamFile(mesh / "boundary")[None]
    for number, (name, patch) in enumerate(entries):
        start = int(patch["startFace"])
        own = [] if patch["type"] == "empty" else faces[start : start + int(patch["nFaces"])]
        boundary += own
        patch_of += [number] * len(own)
        if name in named:
            patches[str(name)] = own
    return Outline(points, _edges(points, boundary, np.array(patch_of)), patches)


def _faces(content: Any) -> list[NDArray[np.int64]]:
    """Faces as corner numbers, of a binary file (offsets, numbers) or of an ASCII list."""
    if isinstance(content, tuple):
        offsets, numbers = content
        return np.split(np.asarray(numbers, dtype=np.int64), np.asarray(offsets)[1:-1])
    return [np.asarray(face, dtype=np.int64) for face in content]


def _edges(
    points: Array, faces: list[NDArray[np.int64]], patch_of: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Edges where the surface bends, ends, or passes from a patch to another."""
    normals = np.array([_normal(points[face]) for face in faces])
    count = np.array([face.size for face in faces])
    start = np.concatenate(faces)
    end = np.concatenate([np.roll(face, -1) for face in faces])
    owner = np.repeat(np.arange(len(faces)), count)
    pairs = np.sort(np.column_stack([start, end]), axis=1)
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    pairs, owner = pairs[order], owner[order]
    first = np.ones(len(pairs), dtype=bool)
    first[1:] = np.any(pairs[1:] != pairs[:-1], axis=1)
    begins = np.flatnonzero(first)
    number = np.diff(np.append(begins, len(pairs)))
    kept = number != 2
    two = begins[number == 2]
    one, other = owner[two], owner[two + 1]
    bends = np.sum(normals[one] * normals[other], axis=1) < np.cos(np.radians(SHARP))
    kept[number == 2] = bends | (patch_of[one] != patch_of[other])
    return np.asarray(pairs[begins[kept]])


def _normal(corners: Array) -> Array:
    """Unit normal of a polygon."""
    around = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    length = float(np.linalg.norm(around))
    return np.asarray(around / length if length > 0 else around)


def project(points: Array, down: Array) -> Array:
    """Points (n, 3) seen from above at an angle, gravity pointing down: (n, 2)."""
    up = -down / np.linalg.norm(down)
    side = np.eye(3)[int(np.argmin(np.abs(up)))]
    right = np.cross(side, up)
    right /= np.linalg.norm(right)
    away = np.cross(up, right)
    turn, tilt = np.radians(30), np.radians(20)
    x = points @ right * np.cos(turn) + points @ away * np.sin(turn)
    depth = -points @ right * np.sin(turn) + points @ away * np.cos(turn)
    return np.column_stack([x, points @ up * np.cos(tilt) + depth * np.sin(tilt)])


def outline_figure(outline: Outline, roles: dict[str, tuple[str, str]], down: Array) -> Figure:
    """The outline with its patches named; `roles` says what each is for, and its colour."""
    seen = project(outline.points, down)
    span = np.ptp(seen, axis=0)
    height = float(np.clip(COLUMN_WIDTH * 0.6 * span[1] / max(span[0], 1e-12), 1.5, 5.0))
    figure = Figure(figsize=(COLUMN_WIDTH, height))
    axes = figure.subplots()
    middles = {name: seen[np.concatenate(faces)].mean(axis=0)
               for name, faces in outline.patches.items() if faces}  # fmt: skip
    heights = _apart({name: float(at[1]) for name, at in middles.items()}, 0.06 * span.max())
    for name, middle in middles.items():
        faces, (role, colour) = outline.patches[name], roles[name]
        filled = [seen[face] for face in faces]
        axes.add_collection(
            PolyCollection(filled, facecolor=colour, alpha=0.55, edgecolor="none", zorder=2)
        )
        axes.annotate(
            f"{name}: {role}", middle, fontsize=7, va="center",
            xytext=(seen[:, 0].max() + 0.12 * span.max(), heights[name]),
            arrowprops={"arrowstyle": "-", "linewidth": 0.5, "color": "0.4"},
        )  # fmt: skip
    lines = LineCollection(list(seen[outline.lines]), colors="0.25", linewidths=0.6, zorder=3)
    axes.add_collection(lines)
    axes.set_aspect("equal")
    low, high = seen.min(axis=0), seen.max(axis=0)
    axes.set_xlim(low[0] - 0.05 * span.max(), high[0] + 0.12 * span.max())
    axes.set_ylim(low[1] - 0.03 * span.max(), high[1] + 0.03 * span.max())
    axes.axis("off")
    return figure


def _apart(places: dict[str, float], least: float) -> dict[str, float]:
    """The places, moved up where they are nearer than `least` to the one below."""
    moved: dict[str, float] = {}
    last = -np.inf
    for name, place in sorted(places.items(), key=lambda item: item[1]):
        last = max(place, last + least)
        moved[name] = last
    return moved
