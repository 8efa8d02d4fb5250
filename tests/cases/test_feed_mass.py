"""What the ledger says was fed is what constant/feed asks for."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import add_feed, solve

SHARES = {"quartz": (2650, 0.5), "coal": (1400, 0.35), "pyrite": (5000, 0.15)}
SIEVES, FINER = [2e-4, 3.15e-4, 5e-4, 8e-4], [0.0, 0.2, 0.6, 1.0]


def feed(**entries: Any) -> dict[str, Any]:
    sizes = {"type": "table", "diameters": SIEVES, "cumulative": FINER}
    materials = {
        name: {"density": density, "massFraction": share, "sizeDistribution": sizes}
        for name, (density, share) in SHARES.items()
    }
    return {"velocity": [0.2, 0, 0], "duration": 0.05, "materials": materials, **entries}


def run(folder: Path, gas_velocity: float, entries: dict[str, Any]) -> tuple[dict, list[dict]]:
    """The ledger, and the rows of all that was fed."""
    case = BoxCase(gas_velocity=gas_velocity, cells=(4, 4, 4), contacts=Contacts(),
                   step=2e-3, end=0.06).make(folder)  # fmt: skip
    add_feed(case, feed(**entries))
    solve(case)
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


def test_fewer_parcels_than_materials_are_refused(tmp_path: Path) -> None:
    case = BoxCase(gas_velocity=2).make(tmp_path / "case")
    add_feed(case, feed(loading=0.1, particles=2, parcels="evenSizes"))
    with pytest.raises(Exception, match="particles is 2, allowed: >= 3"):
        solve(case)
