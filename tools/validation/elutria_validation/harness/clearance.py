"""How far particles are from walls and from each other: who is outside, who hangs in mid-air."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from elutria_validation.harness.particles import Particles, read_particles

Array = NDArray[np.float64]
NEAR, FEW = 40, 200
"""Triangles, nearest by their middles, of which the nearest one is taken; of so few, all."""
CHUNK = 5000
"""Places that are looked at together, for the memory's sake."""


@dataclass(frozen=True)
class Watched:
    """Of all particles at all times that were looked at: how deep the deepest was in a wall, over
    its radius, and how many were in the same place at two times with nothing near them."""

    particles: int
    deepest: float
    hanging: int


def watch(case: Path, at: Iterable[str], more: Iterable[Array] = ()) -> Watched:
    """Look at the ASCII times `at`, in their order. Walls are those of the mesh and `more`
    triangles (n, 3, 3), m. At rest is who moved less than a tenth of its radius from one of the
    times to the next and touches neither a wall nor another to a twentieth of it."""
    surfaces = wall_surfaces(case)
    added = [np.concatenate([*more])] if more else []
    particles, deepest, hanging, before = 0, 0.0, 0, None
    for time in at:
        ids, cloud = read_cloud(case, time)
        radius = cloud.diameter / 2
        # a warped face has several surfaces; outside is who is outside all of them
        gap = np.max([distances(cloud.position, walls) for walls in surfaces], axis=0) - radius
        for walls in added:
            gap = np.minimum(gap, distances(cloud.position, walls) - radius)
        particles += len(ids)
        deepest = max(deepest, float((-gap / radius).max(initial=0)))
        if before is not None:
            here, there = np.isin(ids, before[0]), np.isin(before[0], ids)
            moved = np.linalg.norm(cloud.position[here] - before[1].position[there], axis=1)
            free = np.minimum(gap, gap_to_others(cloud))[here] > 0.05 * radius[here]
            hanging += int(np.sum(free & (moved < 0.1 * radius[here])))
        before = ids, cloud
    return Watched(particles, deepest, hanging)


def read_obj(file: Path) -> Array:
    """Triangles (n, 3, 3), m, of a Wavefront .obj file that has nothing else."""
    lines = [line.split() for line in file.read_text().splitlines()]
    points = np.array([words[1:] for words in lines if words[:1] == ["v"]], dtype=float)
    faces = np.array([words[1:] for words in lines if words[:1] == ["f"]], dtype=int)
    return np.asarray(points[faces - 1])


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
    tree = cKDTree(triangles.mean(axis=1))
    parts = [places[k : k + CHUNK] for k in range(0, len(places), CHUNK)]
    return np.concatenate([np.empty(0), *(_distances(part, triangles, tree) for part in parts)])


def _distances(places: Array, triangles: Array, tree: cKDTree) -> Array:
    count = len(triangles) if len(triangles) <= FEW else NEAR
    nearest = tree.query(places, k=count)[1].reshape(len(places), -1)
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
    """Gap (m) between each particle's surface and the nearest other one's, of the 16 whose
    centres are nearest."""
    if len(cloud.diameter) < 2:
        return np.full(len(cloud.diameter), np.inf)
    count = min(17, len(cloud.diameter))
    apart, others = cKDTree(cloud.position).query(cloud.position, k=count)
    return np.asarray(
        (apart[:, 1:] - (cloud.diameter[:, None] + cloud.diameter[others[:, 1:]]) / 2).min(axis=1)
    )
