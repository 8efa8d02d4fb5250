"""The benchmark of the cascade: scales, settings and comparisons, without a run of the solver."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from foamlib import FoamFile

from elutria_validation.benchmarks.accuracy_error import Cut
from elutria_validation.benchmarks.cascade import (
    POINTS,
    REFERENCE,
    THIN,
    Options,
    Point,
    figure,
    make_case,
    row,
)
from elutria_validation.harness.programs import project_root


def ideal(point: Point, blunt: float = 8, middle: float = 1.3) -> Cut:
    """The cut of a machine that knows nothing but terminal velocity over gas velocity."""
    diameter = np.geomspace(point.size(0.5), point.size(2.2), 400)
    settling = np.array([point.settling(d) for d in diameter])
    share = 1 / (1 + (middle / settling) ** blunt)
    return Cut(point.size(middle), 0.0, 0.8, 0.0, diameter, share)


@pytest.mark.parametrize("velocity", [3.0, 4.5, 9.0])
@pytest.mark.parametrize("settling", [1.0, 1.3, 2.0])
def test_newtons_law_balances_at_one_froude_number(velocity: float, settling: float) -> None:
    """Weight is drag: Fr = 3/4 Cd (v/U)^2, with Cd = 0.44."""
    point = Point(velocity, viscosity=THIN)
    froude = point.per_metre() * point.size(settling)
    assert froude == pytest.approx(0.33 * settling**2, rel=1e-3)


def test_what_the_terminal_velocity_decides_is_foretold_by_the_closed_form() -> None:
    for point in POINTS:
        found = row(point, ideal(point), REFERENCE, ideal(REFERENCE))
        assert found["settling50_change"] == pytest.approx(0, abs=1e-6)
        assert found["fr50_change"] == pytest.approx(found["fr50_change_closed_form"], abs=1e-6)
        assert found["curve_settling"] < 2e-3
        if point.viscosity == THIN:
            assert (found["fr50_change"], found["curve_froude"]) == pytest.approx((0, 0), abs=2e-3)
        else:
            assert found["fr50_change"] > 0.1, "in air the drag coefficient is above Newton's"
            assert found["curve_froude"] > 0.02


def test_a_machine_that_cuts_elsewhere_is_seen_in_both_scales() -> None:
    point = Point(3, viscosity=THIN)
    found = row(point, ideal(point, middle=1.43), REFERENCE, ideal(REFERENCE))
    assert found["settling50_change"] == pytest.approx(0.1, abs=1e-6)
    assert found["fr50_change"] == pytest.approx(0.21, abs=2e-3)
    assert min(found["curve_froude"], found["curve_settling"]) > 0.1


@pytest.mark.parametrize("point", POINTS, ids=lambda point: point.name)
def test_a_point_changes_what_it_says(tmp_path: Path, point: Point) -> None:
    options = Options(parcels=50, seed=3)
    case = make_case(tmp_path / "case", point, options)
    parameters = FoamFile(case / "system/simulationParameters")
    assert (parameters["gasVelocity"], parameters["seed"]) == (point.velocity, 3)
    assert parameters["cellSize"] == parameters["shelfThickness"] == options.cell
    assert (parameters["shelves"], parameters["feedShelf"]) == (5, 3)
    feed = FoamFile(case / "constant/feed")
    assert feed["materials", "quartz", "density"] == point.density
    sizes = feed["materials", "quartz", "sizeDistribution"]
    # terminal velocities of 1.2 to 3.2 times the gas': in Newton's law Fr is 0.475 to 3.38
    assert point.per_metre() * sizes["min"] >= 0.475
    assert point.settling(sizes["max"]) == pytest.approx(3.2, rel=1e-4)
    assert FoamFile(case / "constant/transportProperties")["nu"] == point.viscosity
    was = FoamFile(project_root() / "cases/cascade/constant/transportProperties")
    assert was["nu"] == 1.5e-5


def test_the_figure_shows_every_point_in_both_scales() -> None:
    drawing = figure(POINTS, [ideal(point) for point in POINTS])
    assert [len(axes.lines) for axes in drawing.axes] == [len(POINTS)] * 2
