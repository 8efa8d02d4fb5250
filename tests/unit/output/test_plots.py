"""Figures for a paper's column: drawn from the csv files alone, readable, with units."""

from __future__ import annotations

import os
import time
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.text import Text

from elutria import tables
from elutria.classification.classify import Classification, classify
from elutria.files import read_csv, write_csv
from elutria.output import plots
from elutria.output.cut_size_figure import cut_size_figure
from elutria.output.partition_figure import class_mean
from elutria.output.results import current_figures, read_results
from elutria.output.settings import Settings
from elutria.output.style import looks
from tests.support.synthetic import MATERIALS, synthetic


@cache
def classified(velocity: float, materials: tuple[str, ...]) -> Classification:
    return classify(synthetic(velocity, list(materials)), velocity, 1.0)


def results(folder: Path, velocities: list[float], materials: list[str]) -> Path:
    made = Classification()
    for velocity in velocities:
        made.extend(classified(velocity, tuple(materials)))
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
    for path in paths:  # what it shows stands beside it
        assert len(path.with_suffix(".csv").read_text().splitlines()) > len(velocities)
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
    assert {f"{u} m/s, loading {p}" for u in (4, 6) for p in (0.1, 0.3, 0.5)} <= said
    legend = {text.get_text() for text in figures["cut_size.png"].legends[0].get_texts()}
    assert {f"quartz, loading {p}" for p in (0.1, 0.3, 0.5)} <= legend
    panel = figures["contours.png"].axes[0]
    points = [line.get_xydata() for line in panel.lines if line.get_marker() == "o"]
    assert sorted(map(tuple, points[0])) == [(u, p) for u in (4, 6) for p in (0.1, 0.3, 0.5)]
    assert panel.collections, "no contour is drawn"


def test_words_and_vectors_stand_side_by_side(tmp_path: Path) -> None:
    """`--vary constant/feed:velocity=...` at one gas velocity: no axis of numbers has them."""
    name, values = "constant/feed:velocity", ["(0.5 0 0)", "(1 0 0)", 3.0]
    made = Classification(axes=(name,))
    for number, value in enumerate(values):
        run = synthetic(4.0 + number, ["quartz"])
        made.extend(classify(run, 4.0, 1.0).with_settings({name: value}))
    made.write(tmp_path)
    plots.write_figures(tmp_path)
    results = read_results(tmp_path)
    settings = Settings(results.summary, results.partition)
    (axes,) = cut_size_figure(settings, results.summary, []).axes
    assert [text.get_text() for text in axes.get_xticklabels()] == ["3", "(0.5 0 0)", "(1 0 0)"]
    rows = [row for row in results.summary if row["material"] == "quartz"]
    drawn = sorted(
        (float(x), float(y)) for line in axes.lines if line.get_marker() == "o"
        for x, y in zip(*line.get_data(), strict=True)
    )  # fmt: skip
    cuts = {row[name]: row["d50_m"] * 1e6 for row in rows}
    assert drawn == [(0, cuts[3.0]), (1, cuts["(0.5 0 0)"]), (2, cuts["(1 0 0)"])]


def test_one_line_of_points_has_no_contours(tmp_path: Path) -> None:
    names = [path.name for path in plots.write_figures(grid_results(tmp_path, [0.1]))]
    assert "contours.png" not in names


@pytest.fixture
def drawn(tmp_path: Path) -> dict[str, Figure]:
    """The figures of a sweep with two materials, by name."""
    folder = results(tmp_path, [4.0, 5.0, 6.0], list(MATERIALS))
    made = plots.figures(read_results(folder))
    return {f"{name}.png": figure for name, (figure, _, _) in made.items()}


def test_all_letters_can_be_read(drawn: dict[str, Figure]) -> None:
    for figure in drawn.values():
        texts = [t for t in figure.findobj(Text) if t.get_visible() and t.get_text()]
        assert min(text.get_fontsize() for text in texts) >= 7


def test_axes_have_units(drawn: dict[str, Figure]) -> None:
    for name in ("partition_curves.png", "size_distributions.png"):
        axes = drawn[name].axes
        labels = [a.get_xlabel() for a in axes] + [t.get_text() for t in drawn[name].texts]
        labels += [drawn[name].get_supxlabel()]
        assert any("µm" in label for label in labels)
        assert all(a.get_xscale() == "log" for a in axes)
    (axes,) = drawn["cut_size.png"].axes
    assert "m/s" in axes.get_xlabel()
    assert "µm" in axes.get_ylabel()


def test_series_are_told_apart_without_colour() -> None:
    series = looks(12)
    brightness = [np.dot(look.colour[:3], (0.299, 0.587, 0.114)) for look in series]
    assert np.all(np.diff(brightness) > 0.02)
    for one, other in pairwise(series):  # in print, neighbours differ in mark and line
        assert one.marker != other.marker
        assert one.line != other.line
    assert len({(look.marker, str(look.line)) for look in series}) == 12


def test_products_are_told_apart_without_colour(drawn: dict[str, Figure]) -> None:
    for axes in drawn["size_distributions.png"].axes:
        hatches = [filled.get_hatch() for filled in axes.collections if filled.get_hatch()]
        assert len(hatches) == len(set(hatches)) == 2


@pytest.mark.parametrize("number", [3, 9])
def test_each_setting_has_its_panel(tmp_path: Path, number: int) -> None:
    velocities = [4.0, 5.0, 6.0, 6.5, 7.0, 7.5, 8.0, 8.5, 9.0][:number]
    read = read_results(results(tmp_path, velocities, ["quartz"]))
    figure, columns, rows = plots.figures(read)["size_distributions"]
    shown = [axes for axes in figure.axes if axes.get_visible()]
    assert [axes.texts[0].get_text() for axes in shown] == [f"{u:g} m/s" for u in velocities]
    across = {round(axes.get_subplotspec().get_position(figure).x0, 3)  # type: ignore[union-attr]
              for axes in shown}  # fmt: skip
    assert len(across) == (1 if number <= 3 else 2 if number <= 8 else 3)
    # products add up to what was fed, each class weighted with its width
    for velocity in velocities:
        own = [row for row in rows if row["gas_velocity_m_s"] == velocity]
        width = [np.log10(row["diameter_high_m"] / row["diameter_low_m"]) for row in own]
        fed = np.dot(width, [row["feed_per_decade"] for row in own])
        left = np.dot(width, [row["fines_per_decade"] + row["coarse_per_decade"] for row in own])
        assert fed == pytest.approx(1, rel=1e-6)
        assert left == pytest.approx(1, rel=1e-6)
    assert columns[0] == "gas_velocity_m_s"


@pytest.mark.parametrize("form", ["svg", pytest.param("pdf", marks=pytest.mark.slow)])
def test_figures_for_print_are_the_same_each_time(tmp_path: Path, form: str) -> None:
    folder = results(tmp_path, [5.0], ["quartz"])
    first = [path.read_bytes() for path in plots.write_figures(folder, [form])]
    assert [content[:5] for content in first] == [b"<?xml" if form == "svg" else b"%PDF-"] * 3
    assert [path.read_bytes() for path in plots.write_figures(folder, [form])] == first


def test_points_lie_on_what_the_curve_is_over_their_class() -> None:
    """A cut that is much sharper than a class: the point compares with the curve's mean there."""
    row = {"diameter_low_m": 500e-6, "diameter_high_m": 560e-6}
    size = np.geomspace(400e-6, 700e-6, 4001)
    step = [{"diameter_m": d, "partition_to_coarse": float(d > 520e-6)} for d in size]
    middle = float(np.sqrt(500e-6 * 560e-6))
    even = class_mean({**row, "diameter_m": middle}, step)
    assert even == pytest.approx(np.log(560 / 520) / np.log(560 / 500), abs=0.01)
    # mass that lies towards the coarse end counts there
    assert class_mean({**row, "diameter_m": middle * 1.01}, step) > even + 0.05


def test_a_decade_of_cut_sizes_makes_the_axis_logarithmic(tmp_path: Path) -> None:
    read = read_results(results(tmp_path, [4.0, 5.0], ["quartz"]))
    scales = []
    for factor in (1.0, 30.0):
        read.summary[-2]["d50_m"] *= factor
        (axes,) = plots.figures(read)["cut_size"][0].axes
        scales.append((axes.get_xscale(), axes.get_yscale()))
    assert scales == [("linear", "linear"), ("linear", "log")]


def test_what_a_sweep_varied_beside_the_velocity_parts_the_series(tmp_path: Path) -> None:
    """Columns that the tables do not know are settings, wherever both tables have them."""
    folder = results(tmp_path, [4.0, 6.0], ["quartz"])
    for name in ("summary", "partition", "curve"):
        head, *rows = (folder / f"{name}.csv").read_text().splitlines()
        rows = [f"{row},{loading}" for loading in (0.1, 0.5) for row in rows]
        (folder / f"{name}.csv").write_text("\n".join([f"{head},loading", *rows]) + "\n")
    read = read_results(folder)
    labels = [read.settings.label(setting) for setting in read.settings.all]
    assert labels == [f"{u} m/s, loading {x}" for u in (4, 6) for x in (0.1, 0.5)]
    figure, columns, rows = plots.figures(read)["partition_curves"]
    assert columns[:2] == ["gas_velocity_m_s", "loading"]
    assert {row["loading"] for row in rows} == {0.1, 0.5}
    curves = [line for line in figure.axes[0].lines if str(line.get_gid()).endswith("-curve")]
    assert len(curves) == 4


def test_the_drawn_curve_passes_through_the_cut(tmp_path: Path) -> None:
    folder = results(tmp_path, [5.0], ["quartz"])
    rows = [r for r in read_csv(folder / "curve.csv", tables.CURVE) if r["material"] == "all"]
    summary = read_csv(folder / "summary.csv", ["d50_m"])[0]
    size, share, low, high = (np.array([row[name] for row in rows]) for name in tables.CURVE[2:])
    assert np.interp(summary["d50_m"], size, share) == pytest.approx(0.5, abs=2e-3)
    assert np.all((low <= share) & (share <= high))
    assert np.all(np.diff(share) >= 0)


def test_figures_say_at_which_velocities_runs_have_warnings(tmp_path: Path) -> None:
    folder = results(tmp_path, [4.0, 5.0], ["quartz"])
    found = read_results(folder)
    figure = Figure()
    plots._caption(figure, found.settings, found.summary)
    assert not [text for text in figure.findobj(Text) if text.get_text()]
    for row in found.summary:
        row["warnings"] = 2.0 if row["gas_velocity_m_s"] == 4 else 0.0
    plots._caption(figure, found.settings, found.summary)
    (said,) = [text for text in figure.findobj(Text) if text.get_text()]
    assert said.get_text().endswith(": 4\u00a0m/s"), "no line ends between number and unit"
    assert said.get_fontsize() >= 7


def test_axes_keep_their_labels_beside_warnings(tmp_path: Path) -> None:
    for velocities in ([5.0], [4.0, 4.5, 5.0, 5.5], [3 + 0.5 * k for k in range(9)]):
        found = read_results(results(tmp_path, velocities, ["quartz"]))
        for row in found.summary:
            row["warnings"] = 1.0
        figure = plots.figures(found)["size_distributions"][0]
        labels = [axes.get_xlabel() for axes in figure.axes if axes.get_xlabel()]
        across = {1: 1, 4: 2, 9: 3}[len(velocities)]
        assert len(labels) == across
        assert all("µm" in label for label in labels)


def test_products_have_the_names_of_the_case(tmp_path: Path) -> None:
    """Three products, of which the curve is that of the second."""
    folder = results(tmp_path, [4.0, 5.0], ["quartz"])
    rows = []
    for row in read_csv(folder / "partition.csv", tables.PARTITION):
        masses = {"light": 0.6 * row["fines_kg"], "heavy": row["coarse_kg"],
                  "dust": 0.4 * row["fines_kg"]}  # fmt: skip
        for name, mass in masses.items():
            own = {"material": row["material"], "product": name, "product_kg": mass}
            rows.append(dict.fromkeys(tables.PRODUCT_PARTITION, 0.0) | own)
    write_csv(folder / "product_partition.csv", tables.PRODUCT_PARTITION, rows)
    found = read_results(folder)
    assert found.products == {"fines": "light + dust", "coarse": "heavy"}
    figures = plots.figures(found)
    assert "to heavy" in figures["partition_curves"][0].axes[0].get_ylabel()
    words = {text.get_text() for text in figures["size_distributions"][0].findobj(Text)}
    assert {"feed", "light + dust", "heavy"} <= words
    assert not {"fines", "coarse"} & words


def test_figures_are_as_new_as_the_tables_or_not_current(tmp_path: Path) -> None:
    folder = results(tmp_path, [4.0, 6.0], ["quartz"])
    assert current_figures(folder, ["png"]) == []
    written = plots.write_figures(folder)
    assert current_figures(folder, ["png"]) == written
    assert current_figures(folder, ["png", "svg"]) == []
    results(folder, [4.0, 6.0], ["quartz"])  # the same tables
    assert current_figures(folder, ["png"]) == written
    results(folder, [4.0, 5.0, 6.0], ["quartz"])
    assert current_figures(folder, ["png"]) == []
    plots.write_figures(folder)
    written[0].unlink()
    assert current_figures(folder, ["png"]) == []


def test_figures_of_a_time_to_come_are_drawn_again(tmp_path: Path) -> None:
    """The clock was set back: tables that are written now look older than they."""
    folder = results(tmp_path, [4.0, 6.0], ["quartz"])
    for figure in plots.write_figures(folder):
        os.utime(figure, (time.time() + 3600,) * 2)
    assert current_figures(folder, ["png"]) == []


def test_figures_of_two_settings_are_current_with_their_contours(tmp_path: Path) -> None:
    folder = grid_results(tmp_path, [0.1, 0.3, 0.5])
    written = plots.write_figures(folder)
    assert "contours.png" in [figure.name for figure in written]
    assert sorted(current_figures(folder, ["png"])) == sorted(written)
