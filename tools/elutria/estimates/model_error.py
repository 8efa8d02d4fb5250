"""How far the model may be off, as far as it was measured: beside chance's interval, never in it.

The cut size is compared with measurements in the verification book's chapter `measured`; for
sharpness and yield no measurement of a gravity classifier could be had, so nothing is said.
"""

from __future__ import annotations

from math import nan

from elutria.case.case import Case
from elutria.errors import InputError
from elutria.physics.laws import Grain

SPHERES = {
    "SchillerNaumannDrag": 0.053,
    "CliftDrag": 0.031,
    "HaiderLevenspielDrag": 0.087,
    "GanserDrag": 0.170,
    "HoelzerSommerfeldDrag": 0.085,
    "sphereDrag": 0.048,
    "DiFeliceDrag": 0.208,
    "WenYuVoidDrag": 0.053,
    "GidaspowDrag": 0.053,
    "BeetstraDrag": 0.347,
}
"""Largest relative error of d50 over nine pairs of gas velocity and drops (0.2 to 1 mm, Reynolds
number 10 to 270) by Gunn and Kinzer 1949: `elutria verify measured`."""
SHAPES = {"HaiderLevenspielDrag": 0.16, "GanserDrag": 0.22}
"""Mean error of the drag coefficient over the non-spherical particles of Chhabra et al. 1999,
Powder Technol. 101:288; that of d50 is at most as large, since d50 rises with the coefficient at
most in proportion."""


def model_errors(case: Case) -> dict[str, float]:
    """Relative error of d50 by material, and of `all`: of the worst of them. nan for a law, or a
    shape, of which no measurement says anything."""
    try:
        laws, shape = case.drag_laws(), case.drag_sphericity()
        grains = {one.name: one.grain for one in case.feed().materials}
    except InputError:
        return {}
    law = laws[0] if len(laws) == 1 else ""
    found = {name: _measured(grain, shape).get(law, nan) for name, grain in grains.items()}
    known = [value for value in found.values() if value == value]
    return {**found, "all": max(known) if len(known) == len(found) and known else nan}


def _measured(grain: Grain, shape: float | None) -> dict[str, float]:
    """What is known of each law for such grains; `shape` is the law's own sphericity, if any."""
    if (grain.flatness, grain.elongation, grain.velocities) != (1, 1, None):
        return {}
    return SPHERES if (shape or grain.sphericity) == 1 else SHAPES
