"""Meshes on which particles get lost if they ever do: zigzags, twisted cylinders, baffles.

Each is a blockMeshDict with patches `bottom` and `top` (open), `walls`, and a `feedSlot` wall or a
cell zone `entrance`. Lengths in m.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

_HEAD = "FoamFile { version 2.0; format ascii; class dictionary; object blockMeshDict; }\n"


def _plan(vertices: list[tuple], blocks: str, boundary: str, edges: str = "") -> str:
    points = "\n".join(f"({x:.12g} {y:.12g} {z:.12g})" for x, y, z in vertices)
    return (
        f"{_HEAD}vertices (\n{points}\n);\nblocks ({blocks});\nedges ({edges});\n"
        f"boundary ({boundary}\ndefaultFaces {{ type wall; faces (); }});\nmergePatchPairs ();\n"
        "defaultPatch { name walls; type wall; }\n"
    )


def zigzag(bends: int = 4, width: float = 0.02, cells: int = 4) -> str:
    """A channel that turns by about 100 degrees at each bend; the feed enters in its middle."""
    vertices, blocks = [], []
    for level in range(bends + 2):
        side, up = (level % 2) * 1.2 * width, level * width
        vertices += [(side + x, y, up) for x, y in ((0, 0), (width, 0), (width, width), (0, width))]
    for level in range(bends + 1):
        corners = " ".join(str(4 * level + k) for k in range(8))
        zone = "entrance" if level == (bends + 1) // 2 else ""
        blocks.append(f"hex ({corners}) {zone} ({cells} {cells} {cells}) simpleGrading (1 1 1)")
    last = 4 * (bends + 1)
    boundary = (
        "bottom { type patch; faces ((0 3 2 1)); }"
        f"top {{ type patch; faces (({last} {last + 1} {last + 2} {last + 3})); }}"
    )
    return _plan(vertices, "\n".join(blocks), boundary)


def cylinder(radius: float = 0.02, height: float = 0.1, across: int = 4, along: int = 12) -> str:
    """An O-grid with arcs: four blocks round one. Twisted afterwards by `twist`."""
    inner, outer = 0.5 * radius, radius / 2**0.5
    ring = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    levels = [0, 0.4 * height, 0.6 * height, height]
    vertices, blocks, arcs = [], [], []
    for z in levels:
        vertices += [(inner * x, inner * y, z) for x, y in ring]
        vertices += [(outer * x, outer * y, z) for x, y in ring]
    for level in range(3):
        a, b = 8 * level, 8 * level + 8
        cells = max(2, along // 3)
        zone = "entrance" if level == 1 else ""
        size = f"{zone} ({across} {across} {cells}) simpleGrading (1 1 1)"
        low, high = (" ".join(str(n + k) for k in range(4)) for n in (a, b))
        blocks.append(f"hex ({low} {high}) {size}")
        for k in range(4):
            m = (k + 1) % 4
            blocks.append(
                f"hex ({a + 4 + k} {a + 4 + m} {a + m} {a + k} "
                f"{b + 4 + k} {b + 4 + m} {b + m} {b + k}) {size}"
            )
    for level, z in enumerate(levels):
        for k in range(4):
            m = (k + 1) % 4
            x, y = (ring[k][0] + ring[m][0]) / 2 * radius, (ring[k][1] + ring[m][1]) / 2 * radius
            arcs.append(f"arc {8 * level + 4 + k} {8 * level + 4 + m} ({x:.12g} {y:.12g} {z:.12g})")
    ends = []
    for name, base in (("bottom", 0), ("top", 24)):
        faces = [f"({base} {base + 1} {base + 2} {base + 3})"]
        faces += [f"({base + 4 + k} {base + 4 + (k + 1) % 4} {base + (k + 1) % 4} {base + k})"
                  for k in range(4)]  # fmt: skip
        ends.append(f"{name} {{ type patch; faces ({' '.join(faces)}); }}")
    return _plan(vertices, "\n".join(blocks), "\n".join(ends), "\n".join(arcs))


def baffled(side: float = 0.02, cells: int = 4) -> str:
    """A shaft of two boxes side by side, apart by a wall without thickness in its lower half."""
    s, h = side, 2 * side
    # the left box's right side and the right box's left side meet in points of their own below
    vertices = []
    for z in (0, h, 2 * h):
        for x in (0, s):
            vertices += [(x, 0, z), (x, s, z)]
        own = z < h
        vertices += [(s, 0, z), (s, s, z)] if own else []
        vertices += [(2 * s, 0, z), (2 * s, s, z)]
    low = {"l": (0, 2, 3, 1), "r": (4, 6, 7, 5)}
    middle = {"l": (8, 10, 11, 9), "r": (10, 12, 13, 11)}
    high = {"l": (14, 16, 17, 15), "r": (16, 18, 19, 17)}
    blocks = []
    for begin, end, zone in ((low, middle, ""), (middle, high, "entrance")):
        for k in "lr":
            corners = " ".join(str(v) for v in (*begin[k], *end[k]))
            size = f"({cells} {cells} {2 * cells})"
            blocks.append(f"hex ({corners}) {zone} {size} simpleGrading (1 1 1)")
    boundary = (
        "bottom { type patch; faces ((0 1 3 2) (4 5 7 6)); }"
        "top { type patch; faces ((14 16 17 15) (16 18 19 17)); }"
    )
    return _plan(vertices, "\n".join(blocks), boundary)


def twist(case: Path, turns: float) -> None:
    """Turn the points (ASCII) of a mesh about the z axis, in proportion to their height."""
    path = case / "constant/polyMesh/points"
    head, brace, body = path.read_text().partition("}")
    count = int(re.search(r"\n(\d+)\s*\(", body)[1])
    numbers = re.findall(r"\(([-\d.e+]+) ([-\d.e+]+) ([-\d.e+]+)\)", body)
    points = np.array(numbers, dtype=float)
    assert len(points) == count
    angle = 2 * np.pi * turns * points[:, 2] / np.ptp(points[:, 2])
    x, y = points[:, 0].copy(), points[:, 1].copy()
    points[:, 0] = np.cos(angle) * x - np.sin(angle) * y
    points[:, 1] = np.sin(angle) * x + np.cos(angle) * y
    rows = "\n".join(f"({a!r} {b!r} {c!r})" for a, b, c in points.tolist())
    path.write_text(f"{head}{brace}\n\n{count}\n(\n{rows}\n)\n")


def barred(cell: float = 2e-3) -> str:
    """A flat shaft, 40 x 8 mm and 160 mm high, with a square bar of 8 mm across it that sheds
    vortices; the feed enters above it. Planes of symmetry in front and at the back."""
    x, z = (0, 0.016, 0.024, 0.040), (0, 0.040, 0.048, 0.160)
    vertices = [(x[i], y, z[k]) for k in range(4) for y in (0, 0.008) for i in range(4)]
    blocks, front, back = [], [], []
    for k in range(3):
        for i in range(3):
            if (k, i) == (1, 1):
                continue  # the bar
            low = [8 * k + i + n for n in (0, 1, 5, 4)]
            high = [n + 8 for n in low]
            across, along = (round((s[n + 1] - s[n]) / cell) for s, n in ((x, i), (z, k)))
            corners = " ".join(str(n) for n in low + high)
            blocks.append(f"hex ({corners}) ({across} 1 {along}) simpleGrading (1 1 1)")
            front.append(f"({low[0]} {low[1]} {high[1]} {high[0]})")
            back.append(f"({low[3]} {low[2]} {high[2]} {high[3]})")
    boundary = (
        "bottom { type patch; faces ((0 4 5 1) (1 5 6 2) (2 6 7 3)); }"
        "top { type patch; faces ((24 25 29 28) (25 26 30 29) (26 27 31 30)); }"
        "feedSlot { type wall; faces ((16 24 28 20)); }"
        f"front {{ type symmetryPlane; faces ({' '.join(front)}); }}"
        f"back {{ type symmetryPlane; faces ({' '.join(back)}); }}"
    )
    return _plan(vertices, "\n".join(blocks), boundary)
