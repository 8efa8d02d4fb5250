"""The feed: size distributions against an independent source, and all that can be wrong in it."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fluids.particle_size_distribution import pdf_lognormal, pdf_Rosin_Rammler
from scipy.integrate import quad

from elutria.case.case import Case
from elutria.case.feed import read_feed
from elutria.errors import InputError
from elutria.openfoam.dictionary import Dictionary
from elutria.physics.sizes import SizeDistribution, read_size_distribution
from elutria_validation.harness.programs import project_root


def sizes(**entries: object) -> SizeDistribution:
    return read_size_distribution(Dictionary(entries, "feed"))


ROSIN = {"type": "RosinRammler", "d63": 9e-4, "n": 3, "min": 3e-4, "max": 2e-3}
LOG_NORMAL = {"type": "logNormal", "d50": 5e-4, "sigma": 1.5, "min": 1e-4, "max": 2e-3}


def integral(density: Callable[[float], float], power: int, low: float, high: float) -> float:
    return quad(lambda d: density(d) * d**power, low, high, epsabs=0, epsrel=1e-10)[0]


@pytest.mark.parametrize("weighting", ["mass", "number"])
@pytest.mark.parametrize(
    "entries, density, low, high",
    [
        (ROSIN, lambda d: pdf_Rosin_Rammler(d, 9e-4**-3, 3), 3e-4, 2e-3),
        (LOG_NORMAL, lambda d: pdf_lognormal(d, 5e-4, np.log(1.5)), 1e-4, 2e-3),
    ],
    ids=["RosinRammler", "logNormal"],
)
def test_both_weightings_agree_with_integrals_of_the_density(
    entries: dict[str, object],
    density: Callable[[float], float],
    low: float,
    high: float,
    weighting: str,
) -> None:
    ours = sizes(**entries, weighting=weighting)
    to_mass, to_number = (0, -3) if weighting == "mass" else (3, 0)
    for d in (3.5e-4, 5e-4, 9e-4, 1.5e-3):
        mass = integral(density, to_mass, low, d) / integral(density, to_mass, low, high)
        number = integral(density, to_number, low, d) / integral(density, to_number, low, high)
        assert ours.mass_share_below(d) == pytest.approx(mass, abs=2e-6)
        assert ours.number_share_below(d) == pytest.approx(number, abs=2e-6)


def test_quantiles_invert_the_cumulative_share() -> None:
    ours = sizes(**ROSIN)
    shares = np.array([0.01, 0.25, 0.5, 0.9])
    assert ours.mass_share_below(ours.mass_quantile(shares)) == pytest.approx(shares)
    assert ours.number_share_below(ours.number_quantile(shares)) == pytest.approx(shares)
    assert ours.mass_quantile(0) == pytest.approx(3e-4)
    assert ours.mass_quantile(1) == pytest.approx(2e-3)


def test_a_sieve_analysis_is_linear_between_its_sieves() -> None:
    ours = sizes(type="table", diameters=[1e-4, 2e-4, 4e-4], cumulative=[0, 0.3, 1])
    assert ours.mass_share_below([1e-4, 1.5e-4, 2e-4, 3e-4, 5e-4]) == pytest.approx(
        [0, 0.15, 0.3, 0.65, 1]
    )


def test_a_feed_of_a_sieve_analysis_in_a_file(column: Path) -> None:
    """A csv in the case: read by the tool, part of the fingerprint, refused by name."""
    path = column / "constant/feed"
    text = re.sub(r"sizeDistribution\s*\{[^}]*\}",
                  'sizeDistribution { type sieve; file "constant/sieves.csv"; min 1e-4; }',
                  path.read_text())  # fmt: skip
    path.write_text(text)
    sieves = column / "constant/sieves.csv"
    sieves.write_text("diameter_mm,retained_g\n2,0\n1,20\n0.5,50\n0.25,20\n0,10\n")
    (quartz,) = Case(column).feed().materials
    at = [1e-4, 2.5e-4, 5e-4, 7.5e-4, 1e-3, 2e-3]
    finer = [0, 0.1, 0.3, 0.55, 0.8, 1]
    assert quartz.sizes.mass_share_below(at) == pytest.approx(finer, abs=1e-4)
    before = Case(column).fingerprint([])
    sieves.write_text(sieves.read_text().replace("1,20", "1,much"))
    assert Case(column).fingerprint([]) != before
    with pytest.raises(InputError, match=r"sizeDistribution/file: .*sieves.csv: line 3 has 'much'"):
        Case(column).feed()
    sieves.unlink()
    with pytest.raises(InputError, match=r"sieves.csv: file not found"):
        Case(column).feed()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("diameter_mm,retained_cumulative_percent\n2,0\n1,40\n0.5,100\n", "retained_UNIT"),
        ("diameter_mm,cumulative_percent,retained_g\n2,100,0\n1,0,5\n", "one column of shares"),
        ("diameter_mm,diameter_um,retained_g\n2,2000,0\n1,1000,5\n", "one column of sizes"),
        ("diameter_mm;retained_g\n2;0\n1;5\n", "one of diameter_m,"),
    ],
)
def test_columns_of_a_sieve_analysis_are_told_apart(tmp_path: Path, text: str, said: str) -> None:
    """What lies on a sieve and all wider ones was taken for what lies on it."""
    (tmp_path / "sieves.csv").write_text(text)
    entry = Dictionary({"type": "sieve", "file": "sieves.csv"}, "constant/feed")
    with pytest.raises(InputError, match=rf"sieves\.csv: the first line .* allowed: .*{said}"):
        read_size_distribution(entry, tmp_path)


def test_a_sieve_analysis_as_a_spreadsheet_writes_it(tmp_path: Path) -> None:
    """With a byte order mark, quotes, CRLF and rows of commas."""
    text = '\ufeff"diameter_mm","retained_g"\r\n2,0\r\n,\r\n1,5\r\n0.5,5\r\n,\r\n'
    (tmp_path / "sieves.csv").write_bytes(text.encode())
    entry = Dictionary({"type": "sieve", "file": "sieves.csv"}, "constant/feed")
    sizes = read_size_distribution(entry, tmp_path)
    assert sizes.mass_share_below([5e-4, 1e-3, 2e-3]) == pytest.approx([0, 0.5, 1])


def test_a_bimodal_feed() -> None:
    fine = {"share": 0.25, "type": "uniform", "min": 1e-4, "max": 2e-4}
    coarse = {"share": 0.75, **ROSIN}
    both = sizes(type="sum", parts={"fine": fine, "coarse": coarse})
    rosin = sizes(**ROSIN)
    at = np.array([2.5e-4, 5e-4, 9e-4, 1.5e-3])
    expected = 0.25 + 0.75 * np.where(at < 3e-4, 0, rosin.mass_share_below(at))
    assert both.mass_share_below(at) == pytest.approx(expected, abs=1e-5)
    for change, said in (({"share": 0}, "parts/fine/share"), ({"d63": 1}, "unknown entry"),
                         ({"weighting": "number"}, "that of the sum")):  # fmt: skip
        with pytest.raises(InputError, match=said):
            sizes(type="sum", parts={"fine": {**fine, **change}, "coarse": coarse})


def test_gates_gaudin_schuhmann() -> None:
    ours = sizes(type="GatesGaudinSchuhmann", d100=1e-3, m=0.5, min=1e-5, max=1e-3)
    low = 0.1
    assert ours.mass_share_below(2.5e-4) == pytest.approx((0.5 - low) / (1 - low), abs=1e-5)


def test_number_and_mass_of_a_uniform_distribution() -> None:
    # uniform in number from 0 to 1 (about): mass below d is d^4
    ours = sizes(type="uniform", min=1e-6, max=1e-3, weighting="number")
    assert ours.number_share_below(5e-4) == pytest.approx(0.5, abs=1e-3)
    assert ours.mass_share_below(5e-4) == pytest.approx(0.5**4, rel=1e-3)


def test_one_size() -> None:
    ours = sizes(type="fixedValue", value=5e-4)
    assert ours.mass_share_below([4e-4, 5e-4]) == pytest.approx([0, 1])
    assert ours.mean_cube == pytest.approx(5e-4**3)


@pytest.mark.parametrize(
    "change",
    [
        {"type": "RosinRamler"},
        {"d63": -9e-4},
        {"d63": float("nan")},
        {"n": 0},
        {"min": 0},
        {"max": 1e-4},
        {"weighting": "volume"},
        {"d63": None},
        {"dd": 1},
        {"min": 5, "max": 6},
    ],
)
def test_bad_size_distributions_name_the_entry(change: dict[str, object]) -> None:
    entries = {k: v for k, v in {**ROSIN, **change}.items() if v is not None}
    with pytest.raises(InputError, match=r"^feed: \w+") as caught:
        sizes(**entries)
    assert "allowed" in str(caught.value)


@pytest.mark.parametrize(
    "table",
    [
        {"diameters": [2e-4, 1e-4], "cumulative": [0, 1]},
        {"diameters": [1e-4, 2e-4], "cumulative": [0, 0.9]},
        {"diameters": [1e-4, 2e-4, 3e-4], "cumulative": [0, 0.9, 0.8]},
        {"diameters": [1e-4, 2e-4, 3e-4], "cumulative": [0, 1]},
        {"diameters": [], "cumulative": []},
        {"diameters": [-1e-4, 2e-4], "cumulative": [0, 1]},
    ],
)
def test_bad_sieve_analyses_are_refused(table: dict[str, object]) -> None:
    with pytest.raises(InputError, match="allowed"):
        sizes(type="table", **table)


def test_the_default_case_is_understood(column: Path) -> None:
    feed = read_feed(column)
    assert feed.outlets == {"fines": ["top"], "coarse": ["bottom"]}
    assert feed.loading == pytest.approx(0.2)
    (quartz,) = feed.materials
    assert quartz.grain.density == 2650
    assert quartz.sizes.smallest == pytest.approx(300e-6)
    assert quartz.sizes.largest == pytest.approx(2000e-6)
    # 300-2000 um at 0.2 kg/kg and 6 m/s: some ten thousand particles a second
    mass = quartz.grain.density * np.pi / 6 * quartz.sizes.mean_cube
    assert 5_000 < 0.2 * 6 * 1.2 * 0.05**2 / mass < 30_000


CHANGES = [
    ("density 2650", "density -2650", "materials/quartz/density"),
    ("density 2650", "densty 2650", "did you mean 'density'"),
    ("massFraction 1", "massFraction 0.9", "massFraction adds up to 0.9"),
    ("(bottom)", "(botom)", "did you mean 'bottom'"),
    ("(bottom)", "(top)", "not in fines too"),
    ("(bottom)", "(bottom bottom)", "each patch once ('bottom' is there twice)"),
    ("(bottom)", "()", "outlets/coarse"),
    ("coarse (bottom);", "fines (bottom);",
     "constant/feed: outlets/fines: is there twice; allowed: once"),
    ("coarse (bottom);", "inside (bottom);", "'inside' cannot be a product"),
    ("patch feedSlot", "partitionTo nowhere;\npatch feedSlot", "partitionTo"),
    ("coarse (bottom);", "coarse (bottom); dust (lid);", "the last product, dust, although"),
    ("feedSlot", "feedslot", "no patch 'feedslot'"),
    ("min 300e-6", "min -300e-6", "sizeDistribution/min"),
    ("type RosinRammler", "type RosinRamler", "did you mean 'RosinRammler'"),
    ("loading $loading", "loading nan", "loading"),
    ("seed $seed", "seed 1.5", "whole number"),
    ("quartz", "all", "cannot be a material"),
    ("duration $feedTime", "duration 0", "duration"),
    ("loading $loading", "massFlowRate table ((0 1) (0 2))", "massFlowRate"),
    ("loading $loading", "massFlowRate table ((0 1))", "rising times and rates >= 0"),
    ("loading $loading", "massFlowRate table ((0 1) (1 -1))", "rising times and rates >= 0"),
    ("loading $loading", "massFlowRate table ((0 1) (1 x))", "rising times and rates >= 0"),
    ("loading $loading", "massFlowRate sine", "massFlowRate"),
    ("density 2650", "density 2650; densityDistribution { type uniform; min 1e3; max 2e3; }",
     "allowed: one of it and density"),
    ("density 2650", "densityDistribution { type uniform; min 1; max 2e3; }",
     "densityDistribution/min: 1; allowed: a finite number >= 10"),
    ("density 2650", "densityDistribution { type uniform; min 2e3; max 1e3; }", "0 < min < max"),
    ("density 2650", "densityDistribution { type logNormal; }", "normal | uniform | table"),
    ("density 2650", "densityDistribution { type uniform; min 1e3; max 2e3; mean 3; }",
     "mean: unknown entry"),
    ("density 2650", "densityDistribution { type table; densities (1e3 2e3); cumulative (0 0.5); }",
     "densities, cumulative: allowed: lists"),
]  # fmt: skip


@pytest.mark.parametrize("old, new, expected", CHANGES)
def test_each_mistake_in_the_feed_is_named(column: Path, old: str, new: str, expected: str) -> None:
    path = column / "constant/feed"
    text = " ".join(re.sub(r"//.*", "", path.read_text()).split()).replace(";", ";\n")
    text = text.replace('simulationParameters"', 'simulationParameters"\n')
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match="constant/feed") as caught:
        Case(column).feed()
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_density_that_scatters_counts_with_its_mean(column: Path) -> None:
    path = column / "constant/feed"
    text = re.sub(
        r"density\s+2650;",
        "densityDistribution { type table; densities (2000 3000 5000); cumulative (0 0.5 1); }",
        path.read_text(),
    )
    path.write_text(text)
    (ore,) = Case(column).feed().materials
    assert ore.grain.density == pytest.approx(0.5 * 2500 + 0.5 * 4000)


def test_a_rate_over_time_needs_no_duration(column: Path) -> None:
    path = column / "constant/feed"
    text = re.sub(r"loading\s+\$loading;", "massFlowRate table ((0 0) (1 2e-3));", path.read_text())
    path.write_text(re.sub(r"(?m)^(duration|particles)\s[^;]*;", "", text))
    feed = Case(column).feed()
    assert (feed.loading, feed.mass_flow_rate) == (None, None)


def test_products_are_any(column: Path) -> None:
    path = column / "constant/feed"
    text = path.read_text().replace("fines ", "up ").replace("coarse ", "down ")
    path.write_text(text)
    feed = Case(column).feed()
    assert feed.outlets == {"up": ["top"], "down": ["bottom"]}
    assert feed.partition_to == "down"
    path.write_text(text.replace("patch  ", "partitionTo up; patch  "))
    assert Case(column).feed().partition_to == "up"


def material(folder: Path, **entries: str) -> Path:
    """cases/column with entries of its material instead of its sphericity."""
    case = Case(project_root() / "cases/column").copy_to(folder, []).path
    text = (case / "constant/feed").read_text()
    own = " ".join(f"{name} {value};" if "{" not in value else f"{name} {value}"
                   for name, value in entries.items())  # fmt: skip
    (case / "constant/feed").write_text(re.sub(r"sphericity\s+1;", own, text))
    return case


def test_axes_give_the_sphericity_of_their_ellipsoid(tmp_path: Path) -> None:
    case = material(tmp_path / "case", flatness="1", elongation="0.5")
    grain = read_feed(case).materials[0].grain
    e = np.sqrt(0.75)  # a prolate spheroid, 2 to 1
    surface = 0.5 * (1 + 2 * np.arcsin(e) / e)
    assert grain.sphericity == pytest.approx(2 ** (2 / 3) / surface, rel=1e-9)
    assert (grain.flatness, grain.elongation) == (1.0, 0.5)


@pytest.mark.parametrize(
    ("entries", "table", "said"),
    [
        ({"flatness": "0.5"}, "", "flatness: 0.5; allowed: sphericity, or both flatness and"),
        (
            {"sphericity": "0.9", "flatness": "0.5", "elongation": "0.5"},
            "",
            "sphericity: 0.9; allo",
        ),
        ({"flatness": "0", "elongation": "0.5"}, "", "flatness: 0; allowed"),
        ({"elongation": "1.5", "flatness": "0.5"}, "", "elongation: 1.5; allowed"),
        ({"measuredVelocity": "{ file none.csv; }"}, "", "none.csv"),
        ({"measuredVelocity": "{ file v.csv; gasDensty 1; }"}, "", "gasDensty"),
        ({"measuredVelocity": "{ file v.csv; }"}, "d,v\n1,2\n", "v.csv: the first line is 'd,v'"),
        (
            {"measuredVelocity": "{ file v.csv; }"},
            "diameter_mm,velocity_m_s\n1,4\n2,3\n",
            "velocity 3 m/s at 0.002 m, allowed: above 0, and rising with the size",
        ),
    ],
)
def test_shapes_and_velocities_that_cannot_be(
    tmp_path: Path, entries: dict[str, str], table: str, said: str
) -> None:
    case = material(tmp_path / "case", **entries)
    if table:
        (case / "v.csv").write_text(table)
    with pytest.raises(InputError) as refused:
        read_feed(case)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("planes", "said"),
    [
        ("(0.1 0.1)", "planes: [0.1, 0.1]; allowed: up to 200 rising heights (m)"),
        ("{ first 0; spacing 0; number 3; }", "spacing: 0; allowed"),
        ("{ first 0; spacing 0.1; number 2.5; }", "number: 2.5; allowed: a whole number"),
        ("{ first 0; spacing 0.1; number 300; }", "number: 300; allowed"),
        ("{ first 0; step 0.1; number 3; }", "step"),
    ],
)
def test_planes_that_cannot_be(column: Path, planes: str, said: str) -> None:
    text = (column / "constant/feed").read_text()
    end = "" if "{" in planes else ";"
    (column / "constant/feed").write_text(f"{text}\nplanes {planes}{end}\n")
    with pytest.raises(InputError) as refused:
        read_feed(column)
    assert said in str(refused.value)
