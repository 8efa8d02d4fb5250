"""Writes blockMesh's dictionary of a cascade from system/simulationParameters.

z is up. A shaft into which shelves reach from the left and from the right wall in turn, each sloping
down to its lip. A shelf is a plate that is left out of the mesh. The mesh follows the shelves: their
lower and upper sides go on as lines of cells to the opposite wall.
"""

import itertools
from math import radians, tan

from elutria.openfoam.blocks import Blocks, cells, count, write_mesh_plan


def mesh(parameters):
    size = parameters.number("cellSize", above=0, at_most=10, unit="m")
    width, depth, spacing, end, thick = (
        parameters.number(name, at_least=size, at_most=10, unit="m")
        for name in ("width", "depth", "shelfSpacing", "endLength", "shelfThickness")
    )
    shelves = count(parameters, "shelves", most=20)
    feed_shelf = count(parameters, "feedShelf", most=shelves)
    slope = tan(
        radians(parameters.number("shelfAngle", at_least=0, at_most=60, unit="degrees"))
    )
    reach = parameters.number(
        "shelfReach", at_least=size, at_most=width - size, unit="m"
    )
    if spacing < reach * slope + thick + size:
        least = reach * slope + thick + size
        raise parameters.refuse(
            "shelfSpacing", f"at least {least:g} m, for the shelf's own height"
        )

    xs = sorted({0.0, round(reach, 9), round(width - reach, 9), width})

    def line(shelf, lift):
        """Heights at xs of a shelf's lower side and of the line that goes on from its lip."""
        from_root = (x if shelf % 2 else width - x for x in xs)
        root = end + reach * slope + (shelf - 1) * spacing + lift
        return [root - slope * min(x, reach) for x in from_root]

    top = 2 * end + reach * slope + (shelves - 1) * spacing + thick
    lines = [[0.0] * len(xs)]
    for shelf in range(1, shelves + 1):
        lines += [line(shelf, 0), line(shelf, thick)]
    lines.append([top] * len(xs))

    blocks = Blocks()
    for k, (low, high) in enumerate(itertools.pairwise(lines)):
        mean = sum(b - a for a, b in zip(low, high, strict=True)) / len(xs)
        for i in range(len(xs) - 1):
            middle = (xs[i] + xs[i + 1]) / 2
            from_root = middle if (k + 1) // 2 % 2 else width - middle
            if k % 2 and from_root < reach:
                continue  # the shelf itself
            corners = [(xs[i], low[i]), (xs[i + 1], low[i + 1])]
            corners += [(xs[i + 1], high[i + 1]), (xs[i], high[i])]
            across = cells(xs[i + 1] - xs[i], size)
            blocks.add_prism(
                corners, depth, (across, cells(depth, size), cells(mean, size))
            )

    root = (
        0 if feed_shelf % 2 else -1
    )  # the feed falls on a shelf from the wall above it
    above, below = lines[2 * feed_shelf + 1][root], lines[2 * feed_shelf][root]

    def patch_of(centre):
        x, _, z = centre
        if z < 1e-6 or z > top - 1e-6:
            return "bottom" if z < 1e-6 else "top"
        if abs(x - xs[root]) < 1e-6 and below < z < above:
            return "feedSlot"
        return "walls"

    return blocks.text(patch_of, ["bottom", "top"])


write_mesh_plan(mesh)
