"""A blockMeshDict made of hexahedra, for the `Allmesh` of cases with any number of blocks.

Corners that coincide are one vertex. A face that two blocks share is inside; the case says to which
patch each other face belongs, by its centre.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from elutria.errors import ElutriaError
from elutria.openfoam.dictionary import Dictionary, read_dictionary

Point = tuple[float, float, float]

_FACES = ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7))
"""Of a hexahedron in blockMesh's order of corners, outwards."""
_HEAD = """FoamFile
{
    version     2.0;
    format      ascii;
    class       dictionary;
    object      blockMeshDict;
}

// Written by Allmesh from system/simulationParameters
"""


class Blocks:
    """Hexahedra, added one by one. Lengths in m."""

    def __init__(self) -> None:
        self._vertices: list[Point] = []
        self._index: dict[tuple[int, ...], int] = {}
        self._blocks: list[tuple[list[int], tuple[int, int, int], str]] = []

    def add(self, corners: Sequence[Point], cells: tuple[int, int, int], zone: str = "") -> None:
        """A block of eight corners in blockMesh's order, its cells along x, y, z, its cell zone."""
        self._blocks.append(([self._vertex(corner) for corner in corners], cells, zone))

    def add_prism(
        self, corners: Sequence[tuple[float, float]], depth: float, cells: tuple[int, int, int]
    ) -> None:
        """A block of four corners (x, z), anticlockwise from the lower left, from y 0 to depth."""
        (a, b, c, d) = corners
        self.add(
            [(x, y, z) for (x, z), y in ((a, 0.0), (b, 0.0), (b, depth), (a, depth))]
            + [(x, y, z) for (x, z), y in ((d, 0.0), (c, 0.0), (c, depth), (d, depth))],
            cells,
        )

    def _vertex(self, point: Point) -> int:
        key = tuple(round(x * 1e8) for x in point)
        if key not in self._index:
            self._index[key] = len(self._vertices)
            self._vertices.append(point)
        return self._index[key]

    def text(self, patch_of: Callable[[Point], str], open_patches: Sequence[str]) -> str:
        """The dictionary. `patch_of` gives the patch of a face by its centre; `open_patches` are
        those of type patch, all others are walls."""
        patches: dict[str, list[str]] = {}
        for face in self._outside():
            corners = [self._vertices[k] for k in face]
            x, y, z = (sum(corner[axis] for corner in corners) / 4 for axis in range(3))
            patches.setdefault(patch_of((x, y, z)), []).append(_list(face))
        lines = [_HEAD, "vertices", "("]
        lines += [f"    ({x:.10g} {y:.10g} {z:.10g})" for x, y, z in self._vertices]
        lines += [");", "", "blocks", "("]
        lines += [
            f"    hex {_list(corners)} {zone} {_list(cells)} simpleGrading (1 1 1)"
            for corners, cells, zone in self._blocks
        ]
        lines += [");", "", "edges ();", "", "boundary", "("]
        for name, faces in patches.items():
            kind = "patch" if name in open_patches else "wall"
            lines += [f"    {name}", "    {", f"        type {kind};", "        faces", "        ("]
            lines += [f"            {face}" for face in faces]
            lines += ["        );", "    }"]
        lines += [");", "", "mergePatchPairs ();", ""]
        return "\n".join(lines)

    def _outside(self) -> list[tuple[int, ...]]:
        seen: dict[frozenset[int], list[tuple[int, ...]]] = {}
        for corners, _, _ in self._blocks:
            for face in _FACES:
                own = tuple(corners[k] for k in face)
                seen.setdefault(frozenset(own), []).append(own)
        return [faces[0] for faces in seen.values() if len(faces) == 1]


def _list(numbers: Sequence[int]) -> str:
    return f"({' '.join(map(str, numbers))})"


def cells(length: float, size: float) -> int:
    """Cells of about `size` along `length`, at least one."""
    return max(1, round(length / size))


def write_mesh_plan(make: Callable[[Dictionary], str]) -> None:
    """constant/polyMesh/blockMeshDict of the case in the working directory, which `make` makes of
    its system/simulationParameters. An entry that is not allowed ends it with exit code 2."""
    try:
        parameters = read_dictionary(Path("system/simulationParameters"), Path())
        plan = Path("constant/polyMesh/blockMeshDict")
        plan.parent.mkdir(parents=True, exist_ok=True)
        plan.write_text(make(parameters))
    except ElutriaError as error:
        print(f"elutria: {error}", file=sys.stderr)
        sys.exit(error.exit_code)


def count(parameters: Dictionary, name: str, most: int, least: int = 1) -> int:
    """A whole number from `least` to `most`. Raises InputError for another."""
    value = parameters.number(name, at_least=least, at_most=most)
    if value != int(value):
        raise parameters.refuse(name, f"a whole number from {least} to {most}")
    return int(value)
