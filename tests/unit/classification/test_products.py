"""Products: masses add up, and intervals cover what a feed of infinitely many parcels gives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from elutria.classification.events import Events
from elutria.classification.products import product_rows

CUTS = {"quartz": 600e-6, "coal": 900e-6}


def events(seed: int, number: int = 800) -> Events:
    """Sizes uniform from 0.3 to 1.5 mm; a parcel stands for as many particles as makes its mass
    that of 1/d: fine ones are heavy."""
    random = np.random.default_rng(seed)
    name = random.choice(list(CUTS), number, p=[0.7, 0.3])
    diameter = random.uniform(3e-4, 1.5e-3, number)
    cut = np.array([CUTS[material] for material in name])
    coarse = random.random(number) < 1 / (1 + (cut / diameter) ** 8)
    density = np.where(name == "quartz", 2650.0, 1400.0)
    return Events(
        material=name,
        outlet=np.where(coarse, "coarse", "fines"),
        diameter=diameter,
        density=density,
        number=1e-3 / (diameter * density * diameter**3),
        time=np.arange(number, dtype=float),
    )


def rows_of(seed: int, number: int = 800) -> dict[tuple[str, str], dict[str, Any]]:
    rows = product_rows(events(seed, number), list(CUTS))
    return {(row["product"], row["material"]): row for row in rows}


def test_shares_add_up() -> None:
    rows, sample = rows_of(1), events(1)
    assert list(rows) == [(p, m) for p in ("fines", "coarse") for m in (*CUTS, "all")]
    for material in (*CUTS, "all"):
        both = [rows[product, material] for product in ("fines", "coarse")]
        assert sum(row["recovery"] for row in both) == pytest.approx(1)
        mass = sample.of_material(material).mass.sum()
        assert sum(row["mass_kg"] for row in both) == pytest.approx(mass)
    for product in ("fines", "coarse"):
        parts = [rows[product, material] for material in CUTS]
        assert sum(row["grade"] for row in parts) == pytest.approx(1)
        assert sum(row["yield"] for row in parts) == pytest.approx(rows[product, "all"]["yield"])
        assert rows[product, "all"]["grade"] == 1
    assert sum(rows[p, "all"]["yield"] for p in ("fines", "coarse")) == pytest.approx(1)


def test_what_is_inside_is_in_no_product() -> None:
    sample = events(2)
    sample.outlet[::2] = "inside"
    rows = product_rows(sample, list(CUTS))
    left = sample.mass[sample.has_left].sum()
    assert sum(r["mass_kg"] for r in rows if r["material"] == "all") == pytest.approx(left)


def test_a_product_that_stayed_empty_has_no_sizes() -> None:
    sample = events(3)
    sample.outlet[:] = "coarse"
    rows = {(r["product"], r["material"]): r for r in product_rows(sample, list(CUTS))}
    empty = rows["fines", "all"]
    assert (empty["mass_kg"], empty["recovery"]) == (0, 0)
    assert 0 < empty["recovery_high"] < 0.02
    assert np.isnan([empty["d50_m"], rows["fines", "quartz"]["grade"]]).all()


COLUMNS = [("yield", ""), ("recovery", ""), ("grade", ""), ("d10", "_m"), ("d50", "_m"),
           ("d90", "_m")]  # fmt: skip


def test_intervals_cover_the_truth() -> None:
    truth = rows_of(99, 400_000)
    inside = {name: 0 for name, _ in COLUMNS}
    tries = 120
    for seed in range(tries):
        rows = rows_of(seed, 400)
        for name, unit in COLUMNS:
            row, true = (table["fines", "quartz"] for table in (rows, truth))
            low, value, high = (row[f"{name}{end}{unit}"] for end in ("_low", "", "_high"))
            assert low <= value <= high
            inside[name] += low <= true[name + unit] <= high
    # 95 %, of which 120 tries leave three standard deviations of 2 %
    for name, number in inside.items():
        assert 0.89 <= number / tries <= 0.995, name
