"""Stock's tutorials of dense clouds run beside stock, 50 steps each.

MPPICFoam's have stock's springs put in instead of its packing, damping and isotropy; DPMFoam and
elutriaFoam read the same dictionaries, elutriaFoam the springs as its own contacts. What may
differ:

- parcels of patchInjection: stock rounds their number by chance in each step;
- their places: stock moves them twice in the step in which they enter, so that more of them are
  far from the inlet;
- the gas' pressure where cells are as small as two particles: stock has a particle's volume in the
  cell of its centre, so that neighbours in an even bed hold 0.26 and 0.52 of solids, through which
  gas passes more easily than through 0.31 everywhere.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elutria_validation.harness.cases import MODELS, change, times
from elutria_validation.harness.particles import read_particles
from tests.support.tutorials import Tutorial, made, outcome, springs, tutorials

SOI = f"{MODELS}/injectionModels/model1/SOI"
SPRINGS = {"Goldschmidt": (2.5e-3, 1e3), "column": (3e-4, 1e3), "injectionChannel": (8e-4, 1e3),
           "cyclone": (1.8e-4, 1e2)}  # fmt: skip
"""Distance (m) and modulus (Pa) of contacts: soft ones cost stock few steps."""

FALL, MEAN = "fall", "pressure"


def of_mppic(name: str, cells: dict[str, str] | None = None, surface: str = "", **more: Any) -> Any:
    return Tutorial(f"MPPICFoam/{name}", {**springs(*SPRINGS[name]), **more}, cells or {}, surface)


TUTORIALS = [
    # tutorial, parcels (absolute), which pressure, and by how much it may differ, relatively
    (Tutorial("DPMFoam/Goldschmidt"), 0, FALL, 0.2),
    # cells of three times the side: the same void fraction by centres as by overlap
    (Tutorial("DPMFoam/Goldschmidt", cells={"(2 30 90)": "(1 10 30)"}, steps=5), 0, FALL, 0.01),
    (of_mppic("Goldschmidt"), 0, FALL, 0.05),
    (of_mppic("injectionChannel"), 10, MEAN, 0.1),
    # its feed begins after a second; coarse cells
    (
        of_mppic("cyclone", {"(33 33 63)": "(16 16 31)"}, "cyclone.stl.gz", **{SOI: 0}),
        10,
        MEAN,
        0.1,
    ),
]


def both(tutorial: Tutorial, folder: Path) -> tuple[Any, Any]:
    """What came of the tutorial in stock's solver and in ours."""
    root = tutorials()
    if root is None:
        pytest.skip("no tutorials are installed")
    theirs = outcome(made(tutorial, root, folder / "stock"), "DPMFoam")
    case = made(tutorial, root, folder / "ours")
    change(case, {f"{MODELS}/collisionModel": "cellList"})
    return theirs, outcome(case, "elutriaFoam")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tutorial", "parcels", "which", "off"), TUTORIALS, ids=lambda x: getattr(x, "name", "")
)
def test_beside_stock(
    tmp_path: Path, measured: Any, tutorial: Tutorial, parcels: int, which: str, off: float
) -> None:
    theirs, ours = both(tutorial, tmp_path)
    assert theirs.fed > 500
    assert abs(ours.fed - theirs.fed) <= parcels
    assert ours.parcels == ours.fed - ours.escaped
    assert ours.escaped == theirs.escaped
    random = 2e-3 if parcels else 1e-9  # of random sizes
    assert ours.fed_mass == pytest.approx(theirs.fed_mass, rel=random)
    assert ours.mass == pytest.approx(theirs.mass, rel=random)
    measured("solids in the gas", abs(ours.solids / theirs.solids - 1), 0.02 if parcels else 1e-6)
    difference = abs(getattr(ours, which) / getattr(theirs, which) - 1)
    measured("pressure", difference, off)


@pytest.mark.slow
def test_the_column_beside_stock_and_ergun(tmp_path: Path, measured: Any) -> None:
    """A closed box in which all falls. Gas rises as much as solids fall; its pressure is of Ergun's
    drag at that slip. Stock's gas velocity differs in sign from cell to cell, and its pressure is
    less than half of that: it is not compared. Gravity is in MPPICFoam's packing model."""
    gravity = {f"{MODELS}/particleForces/gravity": {}}
    theirs, ours = both(of_mppic("column", **gravity), tmp_path)
    for name in ("parcels", "fed", "escaped"):
        assert getattr(ours, name) == getattr(theirs, name)
    assert ours.mass == pytest.approx(theirs.mass, rel=1e-9)
    assert ours.solids == pytest.approx(theirs.solids, rel=1e-6)

    case = tmp_path / "ours"
    falling = -np.mean(read_particles(case, times(case)[-1]).velocity[:, 2])
    s, density, viscosity, d, height = ours.solids, 1.2, 1.2e-5, 3e-4, 0.3
    slip = falling / (1 - s)  # of particles through gas that makes room for them
    drag = 150 * s**2 * viscosity / ((1 - s) * d**2) + 1.75 * density * s * slip / d
    ergun = drag * slip / (1 - s) * height / density
    measured("pressure beside Ergun's", abs(ours.fall / ergun - 1), 0.1)
