"""Writes blockMesh's dictionary of a column with lattices of bars, from system/simulationParameters.

z is up. A square shaft; at each of gratingHeights a layer of bars along y, and on it one of bars along
x, both across the whole shaft, equally spaced, with half a gap at the walls. Bars are left out of the
mesh: their faces are walls.
"""

import itertools

from elutria.openfoam.blocks import Blocks, cells, count, write_mesh_plan


def across(side, bars, width):
    """Where bars and gaps begin and end, and of each part whether it is a bar."""
    gap = (side - bars * width) / bars
    ends = [0.0]
    for _ in range(bars):
        ends += [ends[-1] + gap / 2, ends[-1] + gap / 2 + width, ends[-1] + gap + width]
    ends[-1] = side
    return ends, [False, True, False] * bars


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
    blocks = Blocks()
    for low, high in itertools.pairwise(levels):
        along_y = any(abs(low - at) < 1e-9 for at in heights)
        along_x = any(abs(low - at - thick) < 1e-9 for at in heights)
        for i, j in ((i, j) for i in range(3 * bars) for j in range(3 * bars)):
            if not (along_y and is_bar[i] or along_x and is_bar[j]):
                x, y, z = (xs[i], xs[i + 1]), (xs[j], xs[j + 1]), (low, high)
                corners = [
                    (x[a], y[b], c)
                    for c in z
                    for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))
                ]
                number = tuple(cells(b - a, size) for a, b in (x, y, z))
                blocks.add(corners, number)

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
