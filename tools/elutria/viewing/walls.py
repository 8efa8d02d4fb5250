"""The column's walls as a page draws them: triangles of the solid ones, lines where they bend."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria.errors import InputError
from elutria.files import read_text
from elutria.viewing.frames import FOLDER

BEND = cos(radians(20))
"""Neighbouring faces that bend by more have a line between them."""
MOST_TRIANGLES = 60_000
"""Of more walls only the lines are drawn."""
SOLID = ("wall",)
NOT_DRAWN = ("empty", "cyclic", "cyclicAMI", "cyclicACMI")


@dataclass(frozen=True)
class Walls:
    """Coordinates in m: `lines` (n, 2, 3); `triangles` (n, 3, 3) of the solid walls."""

    lines: NDArray[np.float64]
    triangles: NDArray[np.float64]

    def as_json(self) -> dict[str, Any]:
        return {
            "lines": [round(float(x), 7) for x in self.lines.ravel()],
            "triangles": [round(float(x), 7) for x in self.triangles.ravel()],
        }


@dataclass(frozen=True)
class _Face:
    corners: tuple[int, ...]
    group: str
    solid: bool


def read_walls(run: Path) -> Walls:
    """From postProcessing/frames/boundary.obj."""
    path = run / FOLDER / "boundary.obj"
    points: list[tuple[float, ...]] = []
    faces: list[_Face] = []
    group, kind = "", ""
    try:
        for line in read_text(path, limit=500_000_000).splitlines():
            words = line.split()
            if not words or words[0] == "#":
                continue
            if words[0] == "v":
                points.append((float(words[1]), float(words[2]), float(words[3])))
            elif words[0] == "g":
                group, kind = words[1], words[-1]
            elif words[0] == "f" and kind not in NOT_DRAWN:
                corners = tuple(len(points) + int(word) for word in words[1:])
                if min(corners) < 0 or max(corners) >= len(points):
                    raise ValueError(f"no such points: {line}")
                faces.append(_Face(corners, group, kind in SOLID))
    except (ValueError, IndexError) as error:
        raise InputError(f"{path}: is not a .obj file as the solver writes it ({error})") from error
    return _walls(np.array(points, float).reshape(-1, 3), faces)


def _walls(points: NDArray[np.float64], faces: list[_Face]) -> Walls:
    names = _merged(points)
    normals = _normals(points, faces)
    sides: dict[tuple[int, int], list[int]] = {}
    for number, face in enumerate(faces):
        ends = [names[corner] for corner in face.corners]
        for a, b in zip(ends, ends[1:] + ends[:1], strict=True):
            sides.setdefault((min(a, b), max(a, b)), []).append(number)
    place = {name: points[k] for k, name in enumerate(names)}
    lines = [
        (place[a], place[b]) for (a, b), around in sides.items() if _bends(around, faces, normals)
    ]
    triangles = [
        points[[face.corners[0], b, c]]
        for face in faces
        if face.solid
        for b, c in zip(face.corners[1:], face.corners[2:], strict=False)
    ]
    if len(triangles) > MOST_TRIANGLES:
        triangles = []
    return Walls(np.array(lines).reshape(-1, 2, 3), np.array(triangles).reshape(-1, 3, 3))


def _merged(points: NDArray[np.float64]) -> list[int]:
    """A name for each point, the same for points at the same place."""
    if not len(points):
        return []
    grain = max(float(np.ptp(points, axis=0).max()), 1e-30) * 1e-7
    _, names = np.unique(np.rint(points / grain).astype(np.int64), axis=0, return_inverse=True)
    return [int(name) for name in np.asarray(names).ravel()]


def _normals(points: NDArray[np.float64], faces: list[_Face]) -> NDArray[np.float64]:
    """Unit normals of polygons (n, 3)."""
    normals = np.zeros((len(faces), 3))
    sizes = np.array([len(face.corners) for face in faces], int)
    for size in np.unique(sizes):
        chosen = np.flatnonzero(sizes == size)
        corners = points[np.array([faces[k].corners for k in chosen])]
        arms = corners[:, 1:] - corners[:, :1]
        normals[chosen] = np.cross(arms[:, :-1], arms[:, 1:]).sum(axis=1)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None])


def _bends(around: list[int], faces: list[_Face], normals: NDArray[np.float64]) -> bool:
    """Whether a line belongs where these faces meet: not between the faces of one plane, nor
    within a thin wall, where two faces lie back to back on either side."""
    one, *others = around
    along = [float(normals[one] @ normals[other]) for other in others]
    if len(around) == 2:
        return faces[one].group != faces[others[0]].group or along[0] < BEND
    return not others or min(abs(x) for x in along) < BEND
