"""`elutria compare`: what a user gives it, and what it writes."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from elutria import tables
from elutria.cli import main
from elutria.comparing.measured import read_measured
from elutria.errors import InputError
from elutria.files import read_csv
from tests.support.made_results import make_results

SIZES = (300, 400, 500, 600, 700, 850, 1000)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_results(tmp_path_factory.mktemp("results") / "column", [5.0, 6.0])


def write(path: Path, head: str, *rows: str) -> Path:
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def like(results: Path, file: Path, velocity: float, shift: float = 1.0) -> Path:
    """A measurement that is the results' own curve at sizes times `shift`."""
    curve = [row for row in read_csv(results / "curve.csv", tables.CURVE)
             if row["gas_velocity_m_s"] == velocity and row["material"] == "all"]  # fmt: skip
    place = np.log([row["diameter_m"] for row in curve])
    share = np.interp(
        np.log(np.array(SIZES) * 1e-6 / shift), place, [row["partition_to_coarse"] for row in curve]
    )
    return write(file, "diameter_um,partition_percent,uncertainty_percent",
                 *(f"{d},{100 * t:.4f},4" for d, t in zip(SIZES, share, strict=True)))  # fmt: skip


def run(*arguments: str | Path, code: int = 0) -> None:
    with pytest.raises(SystemExit) if code else _nothing() as ended:
        main([str(argument) for argument in arguments])
    if code:
        assert ended.value.code == code


class _nothing:
    def __enter__(self) -> None:
        return None

    def __exit__(self, *_: object) -> None:
        return None


def test_the_same_curve_is_not_told_apart_and_a_shifted_one_is(
    results: Path, tmp_path: Path
) -> None:
    found = {}
    for name, shift in (("same", 1.0), ("shifted", 1.15)):
        file = like(results, tmp_path / f"{name}.csv", 6.0, shift)
        run("compare", results, file, "--velocity", "6", "--to", tmp_path / name, "--format", "svg",
            "--format", "png")  # fmt: skip
        found[name] = json.loads((tmp_path / name / "comparison.json").read_text())
        assert (tmp_path / name / "comparison.svg").is_file()
        assert (tmp_path / name / "comparison.png").is_file()
        rows = read_csv(tmp_path / name / "comparison.csv", tables.COMPARISON)
        assert len(rows) == found[name]["rows"] == found[name]["degrees_of_freedom"]
    assert found["same"]["p_value"] > 0.9
    assert found["shifted"]["p_value"] < 0.01
    d50 = found["shifted"]["differences"]["d50_m"]
    assert d50["difference"] / d50["measured"] == pytest.approx(1 / 1.15 - 1, abs=0.02)
    assert d50["low"] < d50["difference"] < d50["high"] < 0


def test_what_was_compared_is_written(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = like(results, tmp_path / "m.csv", 5.0)
    run("compare", results, file, "--velocity", "5", "--to", tmp_path / "to")
    said = capsys.readouterr().out
    content = json.loads((tmp_path / "to/comparison.json").read_text())
    assert content["setting"] == {"gas_velocity_m_s": 5.0}
    assert content["material"] == "all"
    assert f"chi-square {content['chi_square']:.4g}" in said
    assert "d25/d75" in said


def test_sizes_are_compared_where_the_measurement_names_no_uncertainty(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write(tmp_path / "m.csv", "diameter_um,partition", "400,0.1", "500,0.4", "600,0.8")
    run("compare", results, file, "--velocity", "5", "--to", tmp_path / "to")
    assert "5 m/s, all: 3 sizes compared\n" in capsys.readouterr().out
    content = json.loads((tmp_path / "to/comparison.json").read_text())
    assert (content["rows"], content["degrees_of_freedom"]) == (3, 0)


def test_masses_of_products_make_shares_and_the_yield(tmp_path: Path) -> None:
    file = write(
        tmp_path / "m.csv",
        "diameter_low_um,diameter_high_um,fines_g,coarse_g,fines_uncertainty_g,"
        "coarse_uncertainty_g",
        "200,300,30,10,0.6,0.8", "100,200,40,0,0.6,0.6", "300,500,5,15,0.6,0.6",
    )  # fmt: skip
    found = read_measured(file, ["gas_velocity_m_s"])
    np.testing.assert_allclose(found.low, [100e-6, 200e-6, 300e-6])
    np.testing.assert_allclose(found.share, [0, 0.25, 0.75])
    # of T = c/(f + c): (1 - T) dc and T df over f + c
    expected = np.array([0.6 / 40, np.hypot(0.75 * 0.8, 0.25 * 0.6) / 40,
                         np.hypot(0.25 * 0.6, 0.75 * 0.6) / 20]) / 1.959964  # fmt: skip
    np.testing.assert_allclose(found.deviation, expected, rtol=1e-6)
    np.testing.assert_allclose(found.mass, [0.04, 0.04, 0.02])


def test_a_column_of_the_file_chooses_the_results(results: Path, tmp_path: Path) -> None:
    file = like(results, tmp_path / "m.csv", 5.0)
    lines = file.read_text().splitlines()
    write(file, lines[0] + ",gas_velocity_m_s", *(f"{line},5" for line in lines[1:]))
    run("compare", results, file, "--to", tmp_path / "to")
    content = json.loads((tmp_path / "to/comparison.json").read_text())
    assert content["setting"] == {"gas_velocity_m_s": 5.0}
    run("compare", results, file, "--velocity", "6", code=2)


WRONG = {
    "no size": ("size,partition", ["1,0.5", "2,0.6"], "column 'size'"),
    "two units": ("diameter_um,diameter_mm,partition", ["1,1,0", "2,2,1"], "both diameter_mm"),
    "no share": ("diameter_um,uncertainty", ["100,0.5", "200,0.6"], "has no result"),
    "share above 1": ("diameter_um,partition", ["100,0.5", "200,50"], "partition: '50.0' in line"),
    "not a number": ("diameter_um,partition", ["100,0.5", "200,many"], "'many' in line 3"),
    "not finite": ("diameter_um,partition", ["100,nan", "200,0.5"], "'nan' in line 2"),
    "no uncertainty at all": ("diameter_um,partition,uncertainty", ["100,0.5,0", "200,1,0.1"],
                              "uncertainty: '0.0' in line 2; allowed: a number above 0"),
    "one row": ("diameter_um,partition", ["100,0.5"], "holds 1 rows"),
    "twice": ("diameter_um,partition", ["100,0.5", "100,0.6"], "overlap or are there twice"),
    "classes overlap": ("diameter_low_um,diameter_high_um,partition",
                        ["100,200,0.1", "150,300,0.9"], "overlap"),
    "limits turned": ("diameter_low_um,diameter_high_um,partition",
                      ["200,100,0.1", "300,400,0.9"], "line 2 is not below"),
    "nothing in a class": ("diameter_um,fines_g,coarse_g", ["100,1,0", "200,0,0"], "both 0"),
    "one product": ("diameter_um,fines_g", ["100,1", "200,1"], "coarse_kg: is missing"),
    "misspelt": ("diameter_um,partition,uncertanty", ["100,0.5,1", "200,1,1"],
                 "did you mean 'uncertainty'?"),
    "two settings": ("diameter_um,partition,gas_velocity_m_s", ["100,0.5,5", "200,1,6"],
                     "has 2 values"),
    "another setting": ("diameter_um,partition,gas_velocity_m_s", ["300,0.5,9", "600,1,9"],
                        "gas_velocity_m_s 9 is not in the results"),
    "no setting": ("diameter_um,partition", ["300,0.5", "600,1"], "fits 2 settings"),
    "another material": ("diameter_um,partition,gas_velocity_m_s,material",
                         ["300,0.5,5,coal", "600,1,5,coal"], "material 'coal' is not in"),
    "elsewhere": ("diameter_um,partition,gas_velocity_m_s", ["1,0.5,5", "2,1,5"],
                  "0 of its sizes are within"),
}  # fmt: skip


@pytest.mark.parametrize("kind", list(WRONG))
def test_what_cannot_be_compared_is_refused_in_one_line(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    head, rows, said = WRONG[kind]
    file = write(tmp_path / "m.csv", head, *rows)
    run("compare", results, file, code=2)
    error = capsys.readouterr().err
    assert error.startswith("elutria: ")
    assert error.count("\n") == 1
    assert said in error
    assert not (results / "compare").exists()


def test_a_file_that_is_none_is_refused(results: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="file not found"):
        read_measured(tmp_path / "nothing.csv", [])
    (tmp_path / "empty.csv").write_text("")
    run("compare", results, tmp_path / "empty.csv", code=2)


def test_the_csv_has_the_documented_columns(results: Path, tmp_path: Path) -> None:
    file = like(results, tmp_path / "m.csv", 5.0)
    run("compare", results, file, "--velocity", "5", "--to", tmp_path / "to")
    with (tmp_path / "to/comparison.csv").open() as stream:
        assert next(csv.reader(stream)) == list(tables.COMPARISON)
