"""`elutria check`: no number of its tables is cut or rounded to less than it says."""

from __future__ import annotations

import io
from typing import Any

from rich.console import Console

from elutria.estimates.check import report
from elutria.output.terminal import print_table
from tests.support.made_results import plan


def whole_plan() -> dict[str, Any]:
    """A solver's plan with large numbers, of three materials."""
    made: dict[str, Any] = plan(6.0)
    made["gravity_m_s2"] = 9.81
    made["mesh"] |= {"cells": 1234567, "patches": [{"name": "walls", "type": "wall"}]}
    made["gas"] |= {"basis": "inlet", "superficial_m_s": 6.0, "through_time_s": 0.08}
    made["drag"] |= {"law": "Haider-Levenspiel"}
    made["feed"] |= {
        "parcels": 2345678, "parcels_asked": 5000, "seed": 12345678, "particles_per_s": 17345.6,
        "materials": [
            {"name": name, "density_kg_m3": 7850, "least_density_kg_m3": 7400,
             "largest_density_kg_m3": 8300, "sphericity": 0.875, "mass_fraction": 0.333,
             "smallest_m": 2e-4, "largest_m": 3e-3, "d10_m": 3.244e-4, "d50_m": 7.719e-4,
             "d90_m": 1.548e-3, "cut_m": 1.333e-3}
            for name in ("ore", "magnetite", "metal")
        ],
    }  # fmt: skip
    made["expected"] |= {
        "solid_fraction": 6e-5, "particles_inside": 1236.4, "shortest_relaxation_s": 0.05,
        "longest_relaxation_s": 4.0, "fastest_settling_m_s": 15.8,
    }  # fmt: skip
    made["step"] = {"first_s": 0.004, "courant": 5.6, "largest_courant": 4.0}
    return made


def test_numbers_are_whole_at_80_characters() -> None:
    output = io.StringIO()
    for table in report("manganese", 6.0, whole_plan(), keeps_mesh=False):
        print_table(Console(file=output, width=80), table)
    text = output.getvalue()
    assert max(len(line) for line in text.splitlines()) <= 80
    for number in ("1234567", "2345678", "12345678", "17300 particles per s", "1240"):
        assert number in text, number
    assert text.count("324.4 771.9 1548") == 3  # in one line
    assert "e+0" not in text
    assert "…" not in text
