"""Figures for a paper's column: drawn from the csv files alone, readable, with units."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.text import Text

from elutria import tables
from elutria.classification.classify import Classification, classify
from elutria.classification.curves import MODELS
from elutria.classification.events import Account, Events, Run
from elutria.files import read_csv, write_csv
from elutria.output import plots
from elutria.output.report import absent_notes, inside_notes

MATERIALS = {"quartz": (2650.0, 100e-6), "magnetite": (5200.0, 70e-6)}


def synthetic(velocity: float, materials: list[str], number: int = 2_000) -> Run:
    random = np.random.default_rng(int(velocity * 10))
    name = random.choice(materials, number)
    diameter = random.lognormal(np.log(600e-6), 0.45, number)
    cut = np.array([MATERIALS[m][1] for m in name]) * velocity
    coarse = random.random(number) < MODELS[0].share(diameter / cut, 2.0)
    events = Events(
        material=name,
        outlet=np.where(coarse, "coarse", "fines"),
        diameter=diameter,
        density=np.array([MATERIALS[m][0] for m in name]),
        number=np.ones(number),
        time=np.zeros(number),
    )
    fed = (float(number), float(events.mass.sum()))
    none = (0.0, 0.0)
    account = Account(fed, {"fines": none, "coarse": fed}, none, none)
    return Run(events, {**dict.fromkeys(materials, account), "all": account})


def results(folder: Path, velocities: list[float], materials: list[str]) -> Path:
    made = Classification()
    for velocity in velocities:
        made.extend(classify(synthetic(velocity, materials), velocity, 1.0))
    made.write(folder)
    rows = [
        {"gas_velocity_m_s": u, "material": m, "law": "Clift", "cut_size_m": u * MATERIALS[m][1]}
        for m in materials
        for u in (2.0, 5.0, 9.0)
    ]
    write_csv(folder / "theory.csv", tables.THEORY, rows)
    return folder


@pytest.mark.parametrize(
    "velocities, materials",
    [([4.0, 5.0, 6.5, 8.0], ["quartz"]), ([5.0], ["quartz"]), ([4.0, 6.0], list(MATERIALS))],
    ids=["sweep", "one velocity", "two materials"],
)
def test_figures_come_from_the_tables(
    tmp_path: Path, velocities: list[float], materials: list[str]
) -> None:
    paths = plots.write_figures(results(tmp_path, velocities, materials))
    assert [path.name for path in paths] == [
        "partition_curves.png", "cut_size.png", "size_distributions.png",
    ]  # fmt: skip
    for path in paths:
        height, width = imread(path).shape[:2]
        assert width == pytest.approx(85 / 25.4 * 300, abs=2)
        assert 0.5 < height / width < 2.2


LOADING = "system/simulationParameters:loading"


def grid_results(folder: Path, loadings: list[float]) -> Path:
    """Runs over gas velocity and loading, which moves the cut."""
    made = Classification(axes=(LOADING,))
    for loading in loadings:
        for velocity in (4.0, 6.0):
            run = synthetic(velocity * (1 + loading), ["quartz"])
            made.extend(classify(run, velocity, 1.0).with_settings({LOADING: loading}))
    made.write(folder)
    return folder


def test_two_settings_give_families_and_contours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figures: dict[str, Figure] = {}

    def keep(figure: Figure, path: Path) -> Path:
        figure.draw_without_rendering()
        figures[path.name] = figure
        return path

    monkeypatch.setattr(plots, "save", keep)
    plots.write_figures(grid_results(tmp_path, [0.1, 0.3, 0.5]))
    said = {text.get_text() for text in figures["partition_curves.png"].findobj(Text)}
    assert {"loading 0.1", "loading 0.3", "loading 0.5", "4 m/s", "6 m/s"} <= said
    legend = {text.get_text() for text in figures["cut_size.png"].legends[0].get_texts()}
    assert legend == {"loading 0.1", "loading 0.3", "loading 0.5"}
    panel = figures["contours.png"].axes[0]
    points = [line.get_xydata() for line in panel.lines if line.get_marker() == "o"]
    assert sorted(map(tuple, points[0])) == [(u, p) for u in (4, 6) for p in (0.1, 0.3, 0.5)]
    assert panel.collections, "no contour is drawn"


def test_one_line_of_points_has_no_contours(tmp_path: Path) -> None:
    names = [path.name for path in plots.write_figures(grid_results(tmp_path, [0.1]))]
    assert "contours.png" not in names


@pytest.fixture
def drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Figure]:
    """The figures of a sweep with two materials, by name."""
    kept: dict[str, Figure] = {}
    save: Callable[[Figure, Path], Path] = plots.save

    def keep(figure: Figure, path: Path) -> Path:
        kept[path.name] = figure
        return save(figure, path)

    monkeypatch.setattr(plots, "save", keep)
    plots.write_figures(results(tmp_path, [4.0, 5.0, 6.0], list(MATERIALS)))
    return kept


def test_all_letters_can_be_read(drawn: dict[str, Figure]) -> None:
    for figure in drawn.values():
        texts = [t for t in figure.findobj(Text) if t.get_visible() and t.get_text()]
        assert min(text.get_fontsize() for text in texts) >= 7


def test_axes_have_units(drawn: dict[str, Figure]) -> None:
    for name in ("partition_curves.png", "size_distributions.png"):
        axes = drawn[name].axes
        assert "µm" in axes[-1].get_xlabel()
        assert all(a.get_xscale() == "log" and a.get_ylabel() for a in axes)
    (axes,) = drawn["cut_size.png"].axes
    assert "m/s" in axes.get_xlabel()
    assert "µm" in axes.get_ylabel()


def test_velocities_are_told_apart_without_colour() -> None:
    colours = plots.velocity_colours([3.0, 4, 5, 6, 7, 8, 9, 10])
    brightness = [np.dot(colour[:3], (0.299, 0.587, 0.114)) for colour in colours.values()]
    assert np.all(np.diff(brightness) > 0.04)
    assert mpl.colors.to_rgb(plots.MATERIAL_COLOURS[0]) != mpl.colors.to_rgb(
        plots.MATERIAL_COLOURS[1]
    )


def test_the_drawn_curve_passes_through_the_cut(tmp_path: Path) -> None:
    folder = results(tmp_path, [5.0], ["quartz"])
    rows = [r for r in read_csv(folder / "curve.csv", tables.CURVE) if r["material"] == "all"]
    summary = read_csv(folder / "summary.csv", ["d50_m"])[0]
    size, share, low, high = (np.array([row[name] for row in rows]) for name in tables.CURVE[2:])
    assert np.interp(summary["d50_m"], size, share) == pytest.approx(0.5, abs=2e-3)
    assert np.all((low <= share) & (share <= high))
    assert np.all(np.diff(share) >= 0)


def test_what_did_not_leave_is_said() -> None:
    run = synthetic(5.0, ["quartz"])
    assert inside_notes(classify(run, 5.0, 1.0).partition) == []
    hovering = (run.events.diameter > 480e-6) & (run.events.diameter < 520e-6)
    run.events.outlet[hovering] = "inside"
    (line,) = inside_notes(classify(run, 5.0, 1.0).partition)
    assert "5 m/s" in line
    assert "still in the column" in line
    assert "um" in line
    # half of ln(520/480)
    assert float(line.split("shift by up to ")[1].split(" %")[0]) == pytest.approx(4, abs=0.6)


def test_a_size_that_the_curve_does_not_reach_is_said() -> None:
    run = synthetic(5.0, ["quartz"])
    tables = classify(run, 5.0, 1.0)
    assert absent_notes(tables.summary, tables.curves) == []
    run.events.outlet[::2] = "coarse"  # a bypass of a half
    tables = classify(run, 5.0, 1.0)
    assert np.isnan(tables.summary[0]["d25_m"])
    (line,) = absent_notes(tables.summary, tables.curves)
    assert line.startswith("5 m/s, quartz: no d25")
    assert "100 % of 3000 um" in line
    finest = 100 * tables.curves[0]["partition_to_coarse"]
    assert float(line.split("left: ")[1].split(" %")[0]) == pytest.approx(finest, rel=1e-2)
    assert finest > 25
