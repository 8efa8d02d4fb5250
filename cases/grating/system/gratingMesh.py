"""Writes blockMesh's dictionary of a column with lattices of bars, from system/simulationParameters.

z is up. A square shaft; at each of gratingHeights a layer of bars along y, and on it one of bars along
x, both across the whole shaft, equally spaced, with half a gap at the walls. gratingModel resolved:
bars are left out of the mesh, their faces are walls. gratingModel porous: layers are cells of the
zone `gratings`, and the bars are a surface, constant/polyMesh/bars.obj.
"""

import itertools
from pathlib import Path

from elutria.openfoam.blocks import Blocks, cells, count, write_mesh_plan


def across(side, bars, width):
    """Where bars and gaps begin and end, and of each part whether it is a bar."""
    gap = (side - bars * width) / bars
    ends = [0.0]
    for _ in range(bars):
        ends += [ends[-1] + gap / 2, ends[-1] + gap / 2 + width, ends[-1] + gap + width]
    ends[-1] = side
    return ends, [False, True, False] * bars


def bar_faces(ends, side, low, high, along_y):
    """The four long faces of each bar of a layer, as pairs of triangles of corners (m)."""
    for a, b in zip(ends[1::3], ends[2::3], strict=True):
        ring = [(a, low), (b, low), (b, high), (a, high)]
        for (p, z), (q, w) in zip(ring, ring[1:] + ring[:1], strict=True):
            face = [(p, 0, z), (q, 0, w), (q, side, w), (p, side, z)]
            if not along_y:
                face = [(y, x, z) for x, y, z in face]
            yield from ([face[0], face[1], face[2]], [face[0], face[2], face[3]])


def write_surface(path, triangles):
    """A Wavefront .obj file."""
    corners = [f"v {x:.9g} {y:.9g} {z:.9g}\n" for t in triangles for x, y, z in t]
    faces = [f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}\n" for k in range(len(triangles))]
    path.write_text("".join(["o bars\n", *corners, *faces]))


def mesh(parameters):
    size, side, height, thick, slot_at, slot = (
        parameters.number(name, above=0, at_most=10, unit="m")
        for name in (
            "cellSize",
            "side",
            "height",
            "barThickness",
            "slotHeight",
            "slotOpening",
        )
    )
    bars = count(parameters, "bars", most=50)
    bar = parameters.number(
        "barWidth", at_least=size, at_most=side / bars - size, unit="m"
    )
    if thick < size:
        raise parameters.refuse("barThickness", f"at least cellSize, {size:g} m")
    heights = parameters.numbers("gratingHeights")
    porous = parameters.word("gratingModel", ["resolved", "porous"]) == "porous"
    layers = [(at, at + 2 * thick) for at in heights] + [(slot_at, slot_at + slot)]
    ends = [0.0, *(z for low, high in sorted(layers) for z in (low, high)), height]
    if any(b - a < size for a, b in itertools.pairwise(ends)):
        raise parameters.refuse(
            "gratingHeights",
            f"gratings of {2 * thick:g} m, each clear of the slot, of each other and of the ends by "
            f"cellSize, {size:g} m",
        )
    levels = sorted({*ends, *(at + thick for at in heights)})
    xs, is_bar = across(side, bars, bar)
    blocks, surface = Blocks(), []
    for low, high in itertools.pairwise(levels):
        along_y = any(abs(low - at) < 1e-9 for at in heights)
        along_x = any(abs(low - at - thick) < 1e-9 for at in heights)
        if along_y or along_x:
            surface += bar_faces(xs, side, low, high, along_y)
        zone = "gratings" if porous and (along_y or along_x) else ""
        for i, j in ((i, j) for i in range(3 * bars) for j in range(3 * bars)):
            if porous or not (along_y and is_bar[i] or along_x and is_bar[j]):
                x, y, z = (xs[i], xs[i + 1]), (xs[j], xs[j + 1]), (low, high)
                corners = [
                    (x[a], y[b], c)
                    for c in z
                    for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))
                ]
                number = tuple(cells(b - a, size) for a, b in (x, y, z))
                blocks.add(corners, number, zone)
    if porous:
        write_surface(Path("constant/polyMesh/bars.obj"), surface)

    def patch_of(centre):
        x, _, z = centre
        if z < 1e-6 or z > height - 1e-6:
            return "bottom" if z < 1e-6 else "top"
        if x < 1e-6 and slot_at < z < slot_at + slot:
            return "feedSlot"
        inner = all(1e-6 < value < side - 1e-6 for value in centre[:2])
        return "bars" if inner else "walls"

    return blocks.text(patch_of, ["bottom", "top"])


write_mesh_plan(mesh)
