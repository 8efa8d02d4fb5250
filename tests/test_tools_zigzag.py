"""The benchmark of the zigzag: the settings of its runs, its table and figure."""

from __future__ import annotations

import itertools
from pathlib import Path

import matplotlib as mpl
import pytest
from foamlib import FoamFile
from matplotlib.backends.backend_agg import FigureCanvasAgg

from elutria.cli import main
from elutria.output.style import STYLE
from elutria_validation.benchmarks.zigzag import POINTS, Point, Row, figure, make_case, table
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


def table_row(point: Point, d50: float, sharpness: float, seconds: float = 100.0) -> Row:
    return {
        "point": point.name, "cell_size_m": point.cell, "ranks": 1, "seeds": 1, "parcels": 10,
        "inside": 0, "d50_m": d50, "d50_low_m": 0.99 * d50, "d50_high_m": 1.01 * d50,
        "d50_error": 0.5, "sharpness": sharpness, "sharpness_sd": 0.01, "sharpness_error": 0.5,
        "seconds": seconds,
    }  # fmt: skip


def test_rows_of_an_earlier_table_are_compared_with_the_finest_mesh(tmp_path: Path) -> None:
    known = {point.name: point for point in POINTS}
    given = [
        table_row(known["mesh x 1.4"], 700e-6, 0.85),
        table_row(known["as delivered"], 665e-6, 0.9),
        table_row(known["gas by points, mesh x 1.4"], 600e-6, 0.8),
    ]
    rows = table(tmp_path, POINTS, 2, given)
    assert [row["point"] for row in rows] == [row["point"] for row in given]
    errors = [(row["d50_error"], row["sharpness_error"]) for row in rows]
    assert errors == [pytest.approx(e) for e in ((0, 0), (-0.05, 0.05), (-1 / 7, -0.05))]


def test_an_earlier_table_is_read_before_anything_is_run(tmp_path: Path) -> None:
    with pytest.raises(SystemExit) as end:
        main(["bench", "zigzag", "--quick", "--option", "earlier=nowhere.csv",
              "--to", str(tmp_path)])  # fmt: skip
    assert end.value.code == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("seconds", [(18, 20), (150, 170), (18, 170), (18, 700), (18, 2700)])
def test_labels_of_the_figure_are_apart(seconds: tuple[float, float]) -> None:
    with mpl.rc_context(STYLE):
        drawing = figure([table_row(POINTS[0], 600e-6, 0.9, taken) for taken in seconds])
    canvas = FigureCanvasAgg(drawing)
    canvas.draw()
    for axes in drawing.axes:
        low, high = axes.get_xlim()
        places = zip(axes.get_xticks(), axes.get_xticklabels(), strict=True)
        shown = [label for place, label in places if low <= place <= high and label.get_text()]
        boxes = [label.get_window_extent(canvas.get_renderer()) for label in shown]
        assert len(boxes) >= 2
        gaps = [after.x0 - before.x1 for before, after in itertools.pairwise(boxes)]
        assert min(gaps) > 4, [label.get_text() for label in shown]
