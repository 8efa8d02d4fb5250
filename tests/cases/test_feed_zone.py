"""A feed from a cell zone: uniform over the zone's volume, inside the mesh, the same on any number
of processors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import add_feed, material, solve, times
from elutria_validation.harness.particles import read_particles
from elutria_validation.harness.programs import run_program

Array = NDArray[np.float64]
HEIGHT, FED = 0.1, 3000


def fed(folder: Path, processors: int = 1, sheared: float = 0.0) -> Array:
    """Places (n, 3) of a feed from a zone of flat cells, 100 x 100 x 5 mm, just after it entered.

    `sheared` moves the top sideways by that share of the height and warps the cells.
    """
    case = BoxCase(cells=(1, 1, 20), gravity=0, step=1e-9, end=2e-9).make(folder)
    plan = case / "system/blockMeshDict"
    plan.write_text(plan.read_text().replace("6 7) (", "6 7) entrance ("))
    if sheared:
        top = f"({sheared * HEIGHT} 0 $height) ($width {sheared * HEIGHT} $height)"
        plan.write_text(plan.read_text().replace("(0 0 $height) ($width 0 $height)", top))
    run_program(["blockMesh"], case)
    quartz = material(2650, type="fixedValue", value=1e-5)
    add_feed(case, {"massFlowRate": 1e6, "particles": FED, "materials": quartz})
    text = (case / "constant/feed").read_text().replace("patch west", "zone entrance")
    (case / "constant/feed").write_text(text)
    solve(case, processors)
    if processors > 1:
        run_program(["reconstructPar"], case)
    return read_particles(case, times(case)[-1]).position


def test_a_zone_of_flat_cells_is_filled_evenly(tmp_path: Path, measured) -> None:
    place = fed(tmp_path / "case")
    assert place.shape == (FED, 3)
    grid = (np.arange(FED) + 0.5) / FED
    for axis, name in enumerate("xyz"):
        difference = np.abs(np.sort(place[:, axis]) / HEIGHT - grid).max()
        measured(f"{name}: Kolmogorov-Smirnov distance", difference, 1.63 / FED**0.5)
    correlation = np.abs(np.corrcoef(place.T) - np.eye(3)).max()
    measured("correlation of the coordinates", correlation, 3.3 / FED**0.5)


def test_the_places_do_not_depend_on_the_processors(tmp_path: Path, measured) -> None:
    serial, parallel = (fed(tmp_path / str(n), n, sheared=0.3) for n in (1, 2))
    measured("largest difference, m", np.abs(serial - parallel).max(), 1e-13)
