"""The solver's laws as Python gets them, against `fluids` and against tables of the literature."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fluids import drag as fluids_drag

from elutria import tables
from elutria.case.case import Case
from elutria.errors import InputError
from elutria.estimates.theory import cut_sizes
from elutria.physics import laws
from elutria.physics.drag import Gas, Grain, drag_coefficient, plug_flow_cut_size, terminal_velocity
from elutria_validation.references.drag import read_table

AIR = Gas(1.2, 1.8e-5)


def test_the_standard_curve_is_that_of_fluids() -> None:
    reynolds = np.geomspace(0.02, 3e5, 60)
    theirs = [fluids_drag.Clift(re) for re in reynolds.tolist()]
    assert drag_coefficient("CliftDrag", reynolds) == pytest.approx(theirs, rel=1e-12)


# They are tabulated in eight digits; Di Felice's is of a code that has 0.629955 for his 0.63
@pytest.mark.parametrize(
    ("law", "off"),
    [
        ("HaiderLevenspielDrag", 1e-7),
        ("GanserDrag", 1e-7),
        ("BeetstraDrag", 1e-7),
        ("DiFeliceDrag", 2 * (1 - 0.629955 / 0.63)),
    ],
)
def test_a_law_has_the_values_that_another_code_tabulates(law: str, off: float) -> None:
    rows = [row for row in read_table("drag_laws") if row["law"] == law]
    assert len(rows) >= 24
    names = ("reynolds", "void", "sphericity", "drag_coefficient")
    reynolds, void, sphericity, theirs = (np.array([float(r[n]) for r in rows]) for n in names)
    assert drag_coefficient(law, reynolds, void, sphericity) == pytest.approx(theirs, rel=off)


@pytest.mark.parametrize("law", ["BagheriBonadonnaDrag", "BagheriBonadonnaFlatDrag"])
def test_a_law_of_axes_has_the_values_that_another_code_tabulates(law: str) -> None:
    rows = [row for row in read_table("drag_axes") if row["law"] == law]
    assert len(rows) >= 12
    names = ("reynolds", "flatness", "elongation", "density_ratio", "drag_coefficient")
    re, flat, slender, ratio, theirs = (np.array([float(r[n]) for r in rows]) for n in names)
    ours = drag_coefficient(law, re, flatness=flat, elongation=slender, density_ratio=ratio)
    assert ours == pytest.approx(theirs, rel=1e-7)  # eight digits


def test_measured_drops_fall_as_measured() -> None:
    """Gunn and Kinzer 1949: every second size is told, the others are 1 % apart, 1 % measured."""
    air = Gas(1.204, 1.818e-5)
    drops = [(float(r["diameter_mm"]), float(r["velocity_m_s"])) for r in read_table("drops")]
    told = "\n".join(["velocity_m_s,diameter_mm", *(f"{v},{d}" for d, v in drops[::2])])
    grain = Grain(998, velocities=told, measured_in=(air.density, air.viscosity))
    for number, (size, velocity) in enumerate(drops):
        falls = terminal_velocity(1e-3 * size, grain, air, "MeasuredVelocityDrag", 9.81)
        assert falls == pytest.approx(velocity, rel=0.015 if number % 2 else 1e-9)


@pytest.mark.parametrize("law", ["CliftDrag", "SchillerNaumannDrag", "sphereDrag"])
def test_spheres_have_the_measured_drag(law: str) -> None:
    rows = [row for row in read_table("spheres") if float(row["reynolds"]) <= 800]
    reynolds = np.array([float(row["reynolds"]) for row in rows])
    measured = np.array([float(row["drag_coefficient"]) for row in rows])
    # as the verification book allows: what the points scatter with their reading
    assert drag_coefficient(law, reynolds) == pytest.approx(measured, rel=0.1)


@pytest.mark.parametrize("diameter", [2e-5, 2e-4, 2e-3])
def test_terminal_velocity_is_that_of_fluids(diameter: float) -> None:
    theirs = fluids_drag.v_terminal(diameter, 2650, AIR.density, AIR.viscosity, Method="Clift")
    # theirs is of standard gravity
    ours = terminal_velocity(diameter, 2650, AIR, "Clift", gravity=9.80665)
    assert ours == pytest.approx(theirs, rel=1e-6)


def test_the_cut_settles_at_the_gas_velocity() -> None:
    grain = Grain(2650, 0.8, 0.7, 0.8)
    for law in laws.drag_laws():
        size = plug_flow_cut_size(4, grain, AIR, law)
        assert terminal_velocity(size, grain, AIR, law) == pytest.approx(4, rel=1e-9)
    assert np.isnan(plug_flow_cut_size(1e4, 2650, AIR))


def test_numbers_and_arrays_are_taken_and_unknown_laws_refused() -> None:
    assert drag_coefficient("GanserDrag", 100.0).shape == ()
    grid = drag_coefficient("WenYuVoidDrag", np.ones((3, 1)), np.array([1, 0.8]))
    assert grid.shape == (3, 2)
    assert (grid[:, 1] > grid[:, 0]).all()
    with pytest.raises(ValueError, match="no law is named noDrag"):
        drag_coefficient("noDrag", 1.0)


def test_titles_are_those_of_the_forces_and_stock_names_are_known() -> None:
    titles = [laws.drag_title(name) for name in laws.drag_laws()]
    assert len(set(titles)) == len(titles) > 8
    assert laws.drag_title("nonSphereDrag") == "Haider-Levenspiel"
    assert laws.drag_title("gravity") is None


def test_the_columns_that_are_read_are_those_that_are_written() -> None:
    assert laws.particle_columns() == tuple(tables.EVENTS)


def test_without_the_library_results_are_read_and_a_law_is_refused_in_one_line(
    tmp_path: Path,
) -> None:
    code = (
        "import elutria.classification.classify, elutria.output.plots, elutria.cli\n"
        "from elutria.physics import laws\n"
        f"laws.LIBRARY = 'none.so'; laws.__file__ = {str(tmp_path / 'a/b/c/d')!r}\n"
        "laws.drag_laws()\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, env=os.environ
    )
    last = run.stderr.strip().splitlines()[-1]
    assert "LawsNotBuilt: none.so: not found" in last
    assert "source etc/bashrc" in last


def test_without_the_library_there_is_no_theory_beside_the_curves(
    column: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing() -> None:
        raise laws.LawsNotBuilt("libelutriaLaws.so: not found")

    monkeypatch.setattr(laws, "_library", missing)
    assert cut_sizes(Case(column), [4.0]) == []
    with pytest.raises(InputError, match=r"libelutriaLaws\.so"):
        drag_coefficient("CliftDrag", 1.0)
