"""What the ledger says was fed is what constant/feed asks for."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import CONTROL, add_feed, change, solve
from tests.cases.test_record import refusal

SHARES = {"quartz": (2650, 0.5), "coal": (1400, 0.35), "pyrite": (5000, 0.15)}
SIEVES, FINER = [2e-4, 3.15e-4, 5e-4, 8e-4], [0.0, 0.2, 0.6, 1.0]


def feed(**entries: Any) -> dict[str, Any]:
    sizes = {"type": "table", "diameters": SIEVES, "cumulative": FINER}
    materials = {
        name: {"density": density, "massFraction": share, "sizeDistribution": sizes}
        for name, (density, share) in SHARES.items()
    }
    return {"velocity": [0.2, 0, 0], "duration": 0.05, "materials": materials, **entries}


def box(folder: Path, gas_velocity: float, entries: dict[str, Any], end: float = 0.06) -> Path:
    case = BoxCase(gas_velocity=gas_velocity, cells=(4, 4, 4), contacts=Contacts(),
                   step=2e-3, end=end, interval=end / 2).make(folder)  # fmt: skip
    add_feed(case, feed(**entries))
    return case


def run(folder: Path, gas_velocity: float, entries: dict[str, Any]) -> tuple[dict, list[dict]]:
    """The ledger, and the rows of all that was fed."""
    case = box(folder, gas_velocity, entries)
    solve(case)
    return account(case)


def account(case: Path) -> tuple[dict, list[dict]]:
    rows = []
    for table in [*(case / "postProcessing/outlets").glob("*/particles.csv"),
                  case / "postProcessing/inside.csv"]:  # fmt: skip
        rows += list(csv.DictReader(table.read_text().splitlines()))
    return json.loads((case / "postProcessing/ledger.json").read_text()), rows


@pytest.mark.parametrize(
    ("parcels", "focus", "seed", "gas_velocity"),
    [("evenSizes", "auto", 1, 4), ("evenSizes", "none", 7, 6), ("evenMass", "none", 2, 2)],
)
def test_masses_of_materials_and_sieve_classes_are_those_asked(
    tmp_path: Path, measured, parcels: str, focus: str, seed: int, gas_velocity: float
) -> None:
    entries = {"loading": 0.3, "particles": 700, "parcels": parcels, "focus": focus, "seed": seed}
    ledger, rows = run(tmp_path / "case", gas_velocity, entries)
    asked = 0.3 * 1.2 * gas_velocity * 0.1**2 * 0.05
    fed = ledger["total"]["injected"]
    assert fed["parcels"] == 700 == len(rows)
    measured("mass of the feed", abs(fed["mass_kg"] / asked - 1), 1e-12)
    for name, (_, share) in SHARES.items():
        found = ledger["materials"][name]["injected"]["mass_kg"]
        measured(f"mass of {name}", abs(found / (share * asked) - 1), 1e-12)

    columns = ("diameter_m", "density_kg_m3", "n_particle")
    size, density, number = (np.array([float(row[name]) for row in rows]) for name in columns)
    material = np.array([row["material"] for row in rows])
    mass = number * density * np.pi / 6 * size**3
    for name, (_, share) in SHARES.items():
        for k, due in enumerate(np.diff(FINER)):
            here = (material == name) & (size >= SIEVES[k]) & (size < SIEVES[k + 1])
            error = abs(mass[here].sum() / (due * share * asked) - 1)
            measured(f"{name}, class {k}", error, 1e-9)  # rows have 12 digits


def test_whole_particles_are_within_one_of_the_mass_asked(tmp_path: Path, measured) -> None:
    ledger, _ = run(tmp_path / "case", 2, {"massFlowRate": 1e-3, "seed": 3})
    for name, (density, share) in SHARES.items():
        found = ledger["materials"][name]["injected"]["mass_kg"]
        largest = density * np.pi / 6 * SIEVES[-1] ** 3
        measured(f"{name}, largest particles", abs(found - share * 5e-5) / largest, 1)


RATES = "table ((0 0) (0.01 4e-3) (0.02 0) (0.03 0) (0.0301 2e-3) (0.05 2e-3))"
"""A pulse, a pause, and a steady rest."""
INTEGRAL = 0.5 * 0.02 * 4e-3 + 0.5 * 1e-4 * 2e-3 + 0.0199 * 2e-3


def with_rates(case: Path, rates: str = RATES, more: str = "") -> Path:
    """massFlowRate as a table, and no duration."""
    path = case / "constant/feed"
    text = re.sub(r"massFlowRate [^;]*;", f"massFlowRate {rates}{more}", path.read_text())
    path.write_text(re.sub(r"duration [^;]*;", "", text))
    return path


def entries_over_time(rows: list[dict]) -> tuple[np.ndarray, np.ndarray]:
    """When each parcel entered (s), rising, and the mass fed until then (kg)."""
    time, age, size, density, number = (
        np.array([float(row[name]) for row in rows])
        for name in ("time_s", "residence_time_s", "diameter_m", "density_kg_m3", "n_particle")
    )
    order = np.argsort(time - age)
    mass = number * density * np.pi / 6 * size**3
    return (time - age)[order], np.cumsum(mass[order])


@pytest.mark.parametrize("parcels", ["evenMass", "particles"])
def test_a_rate_over_time_is_fed_as_its_integral(tmp_path: Path, measured, parcels: str) -> None:
    many = {"particles": 800} if parcels == "evenMass" else {}
    case = box(tmp_path / "case", 2, {"massFlowRate": 1, "parcels": parcels, **many})
    with_rates(case, f"{RATES};")
    solve(case)
    ledger, rows = account(case)
    fed = ledger["total"]["injected"]
    grain = 5000 * np.pi / 6 * SIEVES[-1] ** 3
    allowed = 1e-12 * INTEGRAL if parcels == "evenMass" else 3 * grain
    measured("mass, kg", abs(fed["mass_kg"] - INTEGRAL), allowed)

    time, mass = entries_over_time(rows)
    steps = np.linspace(0, 0.05, 5001)
    knots = [0, 0.01, 0.02, 0.03, 0.0301, 0.05]
    rate = np.interp(steps, knots, [0, 4e-3, 0, 0, 2e-3, 2e-3])
    due = np.concatenate([[0], np.cumsum((rate[1:] + rate[:-1]) / 2 * 1e-5)])
    # a stay is counted from the begin of the step in which it began
    step = np.round(time / 2e-3)
    last = np.flatnonzero(np.diff(step, append=np.inf))
    due = np.interp((step[last] + 1) * 2e-3, steps, due)
    assert not np.any((time > 0.02 + 1e-9) & (time < 0.03)), "nothing enters in the pause"
    off = np.max(np.abs(mass[last] - due)) / INTEGRAL
    measured("share fed before it is due", off, 0.003 if parcels == "evenMass" else 0.03)


def test_a_rate_over_time_goes_on_in_a_restart_and_may_change_then(
    tmp_path: Path, measured
) -> None:
    """At once and in two starts: the same rows; a longer table goes on after the shorter."""
    entries = {"massFlowRate": 1, "parcels": "evenMass", "particles": 300}
    cases = [box(tmp_path / name, 2, entries) for name in ("one", "two", "three")]
    for case, end in zip(cases, (0.06, 0.03, 0.03), strict=True):
        change(case, {f"{CONTROL}:endTime": end})
        with_rates(case, f"{RATES};")
        solve(case)
    one, two, other = cases
    change(two, {f"{CONTROL}:endTime": 0.06})
    solve(two)
    when = ("material", "id", "diameter_m", "density_kg_m3", "n_particle")
    (first, rows), (again, same) = account(one), account(two)
    assert {tuple(row[k] for k in when) for row in rows} == {
        tuple(row[k] for k in when) for row in same
    }
    assert first["total"]["injected"] == again["total"]["injected"]

    change(other, {f"{CONTROL}:endTime": 0.09})
    with_rates(other, "table ((0 0) (0.03 0) (0.04 1e-3) (0.06 1e-3));")
    solve(other)
    asked = 0.5 * 0.02 * 4e-3 + 0.5 * 0.01 * 1e-3 + 0.02 * 1e-3
    fed = account(other)[0]["total"]["injected"]
    # the first is cut off between two of its parcels
    measured("mass of two tables, kg", abs(fed["mass_kg"] - asked), INTEGRAL / 300)
    # half of the first table's, and from then on as many a second as its 300 in 0.05 s
    assert fed["parcels"] == 150 + 180


def test_rates_from_a_csv_file_are_kept_by_the_run(tmp_path: Path) -> None:
    entries = {"massFlowRate": 1, "parcels": "evenMass", "particles": 200}
    case = box(tmp_path / "case", 2, entries, 0.02)
    (case / "constant/rate.csv").write_text("s,kg/s\n0,1e-3\n0.02,3e-3\n0.04,0\n")
    with_rates(
        case, '{ type csvFile; file "<case>/constant/rate.csv"; nHeaderLine 1; refColumn 0; '
        'componentColumns (1); separator ","; mergeSeparators no; }',
    )  # fmt: skip
    solve(case)
    change(case, {f"{CONTROL}:endTime": 0.06})
    solve(case)
    fed = account(case)[0]["total"]["injected"]
    assert fed["mass_kg"] == pytest.approx(7e-5, rel=1e-12)
    assert fed["parcels"] == 200


@pytest.mark.parametrize(
    ("rates", "more", "words"),
    [
        ("table ((0 1) (0 2))", "", "massFlowRate: out-of-order value"),
        ("table ((0 1) (1 -2))", "", "massFlowRate: it has the rate -2, allowed: 0 or more"),
        ("table ((0 1))", "", "number of its times is 1, allowed: two or more"),
        ("table ((0 0) (1 0))", "", "feeds 0 kg from 0 to 1 s, allowed: one of all that time"),
        ("table ((0 1) (1 1))", "duration 2;", "a table from 0 to 1 s that feeds 1 kg"),
        ("table ((0.5 1) (1 1))", "", "a table from 0.5 to 1 s"),
        ("sine", "", "massFlowRate: "),
        ('{ type tableFile; file "<case>/constant/rate"; interpolationScheme spline; }', "",
         "interpolationScheme is spline, allowed: linear"),
        ("{ type csvFile; file \"nowhere.csv\"; nHeaderLine 0; refColumn 0; componentColumns (1); "
         "separator \",\"; mergeSeparators no; }", "", "massFlowRate: "),
    ],
)  # fmt: skip
def test_a_rate_that_cannot_be_is_refused_in_a_line(
    tmp_path: Path, rates: str, more: str, words: str
) -> None:
    case = box(tmp_path / "case", 2, {"massFlowRate": 1, "particles": 100, "parcels": "evenMass"})
    with_rates(case, rates if rates.startswith("{") else f"{rates};")
    path = case / "constant/feed"
    path.write_text(path.read_text() + f"\n{more}\n")
    (case / "constant/rate").write_text("((0 1) (1 1))")
    assert words in refusal(case)


ORE = {
    "massFraction": 0.6,
    "densityDistribution": {"type": "normal", "mean": 4000, "standardDeviation": 300, "min": 3200,
                            "max": 4800},
    "sizeDistribution": {"type": "table", "diameters": SIEVES, "cumulative": FINER},
}  # fmt: skip
GANGUE = {"massFraction": 0.4, "density": 2650, "sizeDistribution": ORE["sizeDistribution"]}


def test_densities_that_scatter_keep_the_masses_exact(tmp_path: Path, measured) -> None:
    entries = {"massFlowRate": 1e-3, "particles": 900, "parcels": "evenMass",
               "materials": {"ore": ORE, "gangue": GANGUE}}  # fmt: skip
    case = box(tmp_path / "case", 2, entries)
    solve(case)
    ledger, rows = account(case)
    for name, share in (("ore", 0.6), ("gangue", 0.4)):
        found = ledger["materials"][name]["injected"]["mass_kg"]
        measured(f"mass of {name}", abs(found / (share * 5e-5) - 1), 1e-12)
    columns = ("diameter_m", "density_kg_m3", "n_particle")
    ores = [row for row in rows if row["material"] == "ore"]
    size, density, number = (np.array([float(row[name]) for row in ores]) for name in columns)
    mass = number * density * np.pi / 6 * size**3
    for k, due in enumerate(np.diff(FINER)):
        here = (size >= SIEVES[k]) & (size < SIEVES[k + 1])
        measured(f"class {k}", abs(mass[here].sum() / (due * 3e-5) - 1), 1e-9)
    assert density.min() >= 3200
    assert density.max() <= 4800
    law = norm(4000, 300)
    lighter = (law.cdf(3900) - law.cdf(3200)) / (law.cdf(4800) - law.cdf(3200))
    measured("share lighter than 3900", abs(mass[density < 3900].sum() / 3e-5 - lighter), 0.02)

    # the same grains in a run that goes on
    two = box(tmp_path / "two", 2, entries, 0.03)
    solve(two)
    change(two, {f"{CONTROL}:endTime": 0.06})
    solve(two)
    again = account(two)[1]
    assert {(r["id"], *(r[c] for c in columns)) for r in rows} == {
        (r["id"], *(r[c] for c in columns)) for r in again
    }


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ({"density": 2650}, "density is there beside densityDistribution, allowed: one of both"),
        ({"densityDistribution": {"type": "gauss"}}, "type is gauss, allowed: normal, uniform"),
        ({"densityDistribution": {"type": "uniform", "min": 2, "max": 4000}}, "below 10"),
        ({"densityDistribution": {"type": "uniform", "min": 4000, "max": 3000}}, "0 < min < max"),
        ({"densityDistribution": {"type": "uniform", "min": 3000, "max": 4000, "mean": 3500}},
         "mean is not an entry"),
        ({"densityDistribution": {"type": "table", "densities": [3e3, 2e3], "cumulative": [0, 1]}},
         "densities, cumulative: allowed: lists of the same length"),
    ],
)  # fmt: skip
def test_densities_that_cannot_be_are_refused_in_a_line(
    tmp_path: Path, entries: dict[str, Any], words: str
) -> None:
    materials = {"ore": {**ORE, "massFraction": 1, **entries}}
    case = box(tmp_path / "case", 2, {"massFlowRate": 1e-3, "materials": materials})
    assert words in refusal(case)


def test_fewer_parcels_than_materials_are_refused(tmp_path: Path) -> None:
    case = BoxCase(gas_velocity=2).make(tmp_path / "case")
    add_feed(case, feed(loading=0.1, particles=2, parcels="evenSizes"))
    with pytest.raises(Exception, match="particles is 2, allowed: >= 3"):
        solve(case)
