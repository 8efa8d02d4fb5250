"""Writes blockMesh's dictionary of a zigzag channel from system/simulationParameters.

z is up. Straight at the bottom and at the top; between them the stages, inclined to the right and to
the left in turn, so that two successive ones meet at stageAngle. Every block is cut level, which at a
bend is the bisector.
"""

from math import cos, radians, sin

from elutria.openfoam.blocks import Blocks, cells, count, write_mesh_plan


def mesh(parameters):
    stages = count(parameters, "stages", most=15)
    feed_stage = count(parameters, "feedStage", most=stages)
    angle = parameters.number("stageAngle", at_least=90, at_most=180, unit="degrees")
    size = parameters.number("cellSize", above=0, at_most=10, unit="m")
    depth, width, length, inlet, outlet = (
        parameters.number(name, at_least=size, at_most=10, unit="m")
        for name in (
            "channelDepth",
            "channelWidth",
            "stageLength",
            "inletLength",
            "outletLength",
        )
    )
    incline = radians(90 - angle / 2)  # from the vertical
    across = depth / cos(incline)  # the level section
    blocks = Blocks()
    x, z, slot = 0.0, 0.0, (0.0, 0.0)

    def rise(dx, dz):
        nonlocal x, z
        along_y, along_z = cells(width, size), cells(dz, size)
        low, high = (
            ((x, z), (x + across, z)),
            ((x + dx + across, z + dz), (x + dx, z + dz)),
        )
        blocks.add_prism((*low, *high), width, (cells(across, size), along_y, along_z))
        x, z = x + dx, z + dz

    rise(0, inlet)
    for stage in range(1, stages + 1):
        dx = length * sin(incline) * (1 if stage % 2 else -1)
        dz = length * cos(incline)
        if (
            stage == feed_stage
        ):  # in thirds: the feed comes in through the left wall of the middle
            rise(dx / 3, dz / 3)
            slot = (x + dx / 6, z + dz / 6)
            rise(dx / 3, dz / 3)
            rise(dx / 3, dz / 3)
        else:
            rise(dx, dz)
    rise(0, outlet)

    def patch_of(centre):
        if centre[2] < 1e-6:
            return "bottom"
        if centre[2] > z - 1e-6:
            return "top"
        near = abs(centre[0] - slot[0]) + abs(centre[2] - slot[1]) < 1e-6
        return "feedSlot" if near else "walls"

    return blocks.text(patch_of, ["bottom", "top"])


write_mesh_plan(mesh)
