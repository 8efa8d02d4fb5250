"""How far particles are from walls and from each other: who is outside, who hangs in mid-air."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from elutria_validation.harness.particles import Particles, read_particles

Array = NDArray[np.float64]


def read_cloud(case: Path, time: str) -> tuple[NDArray[np.int64], Particles]:
    """The ids and the particles of an ASCII time, in order of the ids."""
    file = case / time / "lagrangian/kinematicCloud/origId"
    if not file.is_file():
        return np.empty(0, dtype=np.int64), read_particles(case, time)
    body = file.read_text().partition("}")[2]
    numbers = np.array(re.findall(r"-?\d+", body), dtype=np.int64)
    return np.sort(numbers[1:]), read_particles(case, time)


def wall_surfaces(case: Path) -> list[Array]:
    """Triangles (n, 3, 3), m, of all faces of type wall of an ASCII mesh, by the corner in which
    those of a face meet: where a face is warped, each choice is another surface."""
    mesh = case / "constant/polyMesh"
    number = r"[-+\d.e]+"
    rows = re.findall(
        rf"\(({number}) ({number}) ({number})\)", (mesh / "points").read_text().partition("}")[2]
    )
    points = np.array(rows, dtype=float)
    faces = re.findall(r"\d+\(([\d ]+)\)", (mesh / "faces").read_text().partition("}")[2])
    polygons: list[Array] = []
    for patch in re.findall(r"\{([^}]*)\}", (mesh / "boundary").read_text().partition("}")[2]):
        if not re.search(r"type\s+wall;", patch):
            continue
        first, count = (int(re.search(rf"{name}\s+(\d+)", patch)[1]) for name in  # type: ignore
                        ("startFace", "nFaces"))  # fmt: skip
        polygons += [
            points[[int(k) for k in face.split()]] for face in faces[first : first + count]
        ]
    return [
        np.array([t for polygon in polygons for t in _fan(np.roll(polygon, -corner, axis=0))])
        for corner in range(max(len(polygon) for polygon in polygons))
    ]


def _fan(polygon: Array) -> list[Array]:
    return [np.stack([polygon[0], b, c]) for b, c in pairwise(polygon[1:])]


def distances(places: Array, triangles: Array) -> Array:
    """Distance (m) of each place (n, 3) to the nearest triangle, of those around it. Ericson 2005,
    section 5.1.5."""
    nearest = cKDTree(triangles.mean(axis=1)).query(places, k=min(40, len(triangles)))[1]
    a, b, c = (triangles[nearest, k] for k in range(3))
    place = places[:, None]
    best = np.minimum.reduce([_to_edge(place, p, q) for p, q in ((a, b), (b, c), (c, a))])
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=2)
    height = np.sum((place - a) * normal, axis=2) / area
    foot = place - (height / area)[..., None] * normal
    within = np.ones(area.shape, dtype=bool)
    for p, q in ((a, b), (b, c), (c, a)):
        within &= np.sum(np.cross(q - p, foot - p) * normal, axis=2) >= 0
    return np.asarray(np.where(within, np.minimum(best, np.abs(height)), best).min(axis=1))


def _to_edge(place: Array, p: Array, q: Array) -> Array:
    along = q - p
    share = np.clip(np.sum((place - p) * along, axis=2) / np.sum(along**2, axis=2), 0, 1)
    return np.asarray(np.linalg.norm(place - p - share[..., None] * along, axis=2))


def gap_to_others(cloud: Particles) -> Array:
    """Gap (m) between each particle's surface and the nearest other one's."""
    if len(cloud.diameter) < 2:
        return np.full(len(cloud.diameter), np.inf)
    apart = np.linalg.norm(cloud.position[:, None] - cloud.position[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    return np.asarray((apart - (cloud.diameter[:, None] + cloud.diameter[None]) / 2).min(axis=1))
