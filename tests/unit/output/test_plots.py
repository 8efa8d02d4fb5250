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
from elutria.files import read_csv, write_csv
from elutria.output import plots
from tests.support.synthetic import MATERIALS, synthetic


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


def test_figures_say_at_which_velocities_runs_have_warnings(tmp_path: Path) -> None:
    folder = results(tmp_path, [4.0, 5.0], ["quartz"])
    summary = read_csv(folder / "summary.csv", ["gas_velocity_m_s", "warnings"])
    figure = Figure()
    plots._caption(figure, summary)
    assert not [text for text in figure.findobj(Text) if text.get_text()]
    for row in summary:
        row["warnings"] = 2.0 if row["gas_velocity_m_s"] == 4 else 0.0
    plots._caption(figure, summary)
    (said,) = [text.get_text() for text in figure.findobj(Text) if text.get_text()]
    assert said.endswith(": 4 m/s")
