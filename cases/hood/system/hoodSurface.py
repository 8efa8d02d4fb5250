"""Writes the surface of the hood, constant/polyMesh/hood.stl, and blockMesh's dictionary of a box of
cells around it, from system/simulationParameters.

z is up. A cylinder, open at the bottom; in its lid a round opening; three rectangular ducts end on its
wall: one radial and one tangential, through which gas enters, and a radial one near the lid, through
which gas and grains leave. Each solid of the file becomes a patch of its name.

For a surface of your own leave surface() out, and copy your file to constant/polyMesh/hood.stl: the box
is put around whatever is there.
"""

from itertools import chain, pairwise
from math import asin, cos, pi, sin
from pathlib import Path

from elutria.openfoam.blocks import Blocks, cells, write_mesh_plan

STL = Path("constant/polyMesh/hood.stl")
SEGMENTS = 96  # of the circle, about


class Duct:
    """A rectangular duct that ends on the cylinder's wall: between two angles (rad) and two heights,
    along its direction; `end` is how far its mouth is from the axis."""

    def __init__(self, name, side, angles, heights, end):
        self.name, self.side, self.angles, self.heights, self.end = (
            name,
            side,
            angles,
            heights,
            end,
        )

    def covers(self, angle, z):
        (a, b), (low, high) = self.angles, self.heights
        return a < angle < b and low < z < high


def ducts(parameters, radius, height):
    found = []
    for name, side, tangential in (
        ("sideInlet", 1, False),
        ("tangentialInlet", -1, True),
        ("sideOutlet", 1, False),
    ):
        wide, high = (
            parameters.number(name + part, above=0, at_most=radius, unit="m")
            for part in ("Width", "Height")
        )
        low = parameters.number(
            name + "At", above=0, at_most=height - 1.01 * high, unit="m"
        )
        # angles around the duct's own direction: a radial duct lies on it, a tangential one beside it
        across = (
            (radius - wide, radius) if tangential else (-wide / 2, wide / 2)
        )
        angles = tuple(asin(y / radius) for y in across)
        found.append(Duct(name, side, angles, (low, low + high), 1.6 * radius))
    a, _, c = found
    if a.heights[1] > c.heights[0] and c.heights[1] > a.heights[0]:
        raise parameters.refuse("sideOutletAt", "clear of the side inlet")
    return found


def steps(ends, most):
    """From the first to the last of `ends`, each of them met, in steps of at most `most`."""
    ends = sorted(ends)
    found = [ends[0]]
    for low, high in pairwise(ends):
        pieces = max(1, round((high - low) / most + 0.5))
        found += [low + (high - low) * (k + 1) / pieces for k in range(pieces)]
    return [x for k, x in enumerate(found) if k == 0 or x - found[k - 1] > 1e-9]


def surface(parameters):
    """The faces of each patch, of three or four points, anticlockwise seen from outside."""
    radius, height, opening = (
        parameters.number(name, above=0, at_most=10, unit="m")
        for name in ("radius", "height", "topRadius")
    )
    if opening >= radius:
        raise parameters.refuse("topRadius", f"below radius, {radius:g} m")
    found = ducts(parameters, radius, height)
    patches = {"walls": []}

    # each duct's angles around its own direction, as angles of the cylinder
    turned = {d: [x + (0 if d.side > 0 else pi) for x in d.angles] for d in found}
    angles = steps([-pi / 2, 1.5 * pi, *chain(*turned.values())], 2 * pi / SEGMENTS)
    heights = steps([0, height, *chain(*(d.heights for d in found))], height)

    def at(angle, z, r=radius):
        return (r * cos(angle), r * sin(angle), z)

    for a, b in pairwise(angles):
        for low, high in pairwise(heights):
            middle, z = (a + b) / 2, (low + high) / 2
            if not any(
                d.covers(middle - (0 if d.side > 0 else pi), z) for d in found
            ):
                patches["walls"].append((at(a, low), at(b, low), at(b, high), at(a, high)))
        bottom = (at(a, 0), at(0, 0, 0), at(b, 0))
        patches.setdefault("bottom", []).append(bottom)
        patches.setdefault("top", []).append(
            (at(a, height, opening), at(b, height, opening), at(0, height, 0))
        )
        ring = [at(x, height, r) for x, r in ((a, radius), (b, radius), (b, opening), (a, opening))]
        patches["walls"].append(tuple(ring))
    for duct in found:
        add_duct(patches, duct, angles, turned[duct], radius)
    return patches


def add_duct(patches, duct, angles, ends, radius):
    """Floor, roof and sides from the cylinder's wall out to the mouth, and the mouth."""
    low, high = duct.heights
    x_end = duct.side * duct.end
    rim = [x for x in angles if ends[0] - 1e-9 < x < ends[1] + 1e-9]
    inner = [(radius * cos(x), radius * sin(x)) for x in rim]
    patches[duct.name] = []
    for (xa, ya), (xb, yb) in pairwise(inner):
        for z, turn in ((low, 1), (high, -1)):
            level = ((xa, ya, z), (xb, yb, z), (x_end, yb, z), (x_end, ya, z))
            patches["walls"].append(level[::turn])
        patches[duct.name].append(
            ((x_end, ya, low), (x_end, yb, low), (x_end, yb, high), (x_end, ya, high))
        )
    for (x, y), turn in ((inner[0], 1), (inner[-1], -1)):
        upright = ((x, y, low), (x_end, y, low), (x_end, y, high), (x, y, high))
        patches["walls"].append(upright[::turn])


def write_stl(patches):
    """ASCII, a solid for each patch; a quadrilateral is two triangles."""
    lines = []
    for name, faces in patches.items():
        lines.append(f"solid {name}")
        for face in faces:
            for k in range(1, len(face) - 1):
                corners = face[0], face[k], face[k + 1]
                lines += ["facet normal 0 0 0", " outer loop"]
                lines += [" vertex {:.9g} {:.9g} {:.9g}".format(*p) for p in corners]
                lines += [" endloop", "endfacet"]
        lines.append(f"endsolid {name}")
    STL.write_text("\n".join(lines) + "\n")


def box(size):
    """A block of cells around the surface that is there, half a cell beyond it."""
    vertices = [
        tuple(map(float, line.split()[1:]))
        for line in STL.read_text().splitlines()
        if line.split()[:1] == ["vertex"]
    ]
    low = [min(p[k] for p in vertices) - 0.55 * size for k in range(3)]
    many = [cells(max(p[k] for p in vertices) + 0.55 * size - low[k], size) for k in range(3)]
    high = [low[k] + many[k] * size for k in range(3)]
    (a, c, e), (b, d, f) = low, high
    blocks = Blocks()
    blocks.add(
        [(x, y, z) for z in (e, f) for x, y in ((a, c), (b, c), (b, d), (a, d))],
        tuple(many),
    )
    return blocks.text(lambda _: "outside", [])


def mesh(parameters):
    size = parameters.number("cellSize", above=0, at_most=10, unit="m")
    write_stl(surface(parameters))
    return box(size)


write_mesh_plan(mesh)
