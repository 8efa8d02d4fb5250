"""The benchmark of the zigzag: the settings of its runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from foamlib import FoamFile

from elutria_validation.benchmarks.zigzag import POINTS, Point, make_case
from elutria_validation.harness.programs import project_root

ROOT = project_root()


@pytest.mark.parametrize("point", POINTS, ids=lambda point: point.name)
def test_a_point_changes_what_it_says(tmp_path: Path, point: Point) -> None:
    case = tmp_path / "case"
    make_case(case, point, 3, 50)
    parameters = FoamFile(case / "system/simulationParameters")
    assert parameters["cellSize"] == pytest.approx(0.005 / point.mesh, rel=1e-3)
    assert (parameters["seed"], parameters["particles"]) == (3, 50)
    for name in point.changes:
        file, _, entry = name.partition(":")
        keys = tuple(entry.split("/"))
        found, before = (FoamFile(where / file)[keys] for where in (case, ROOT / "cases/zigzag"))
        assert found != before, name
    if point.ranks > 1:
        decomposition = FoamFile(case / "system/decomposeParDict")
        assert decomposition["numberOfSubdomains"] == point.ranks
    assert (case / "0/omega.air").exists() == (point.name == "kOmegaSST")
    assert (case / "0/epsilon.air").exists() != (point.name == "kOmegaSST")
