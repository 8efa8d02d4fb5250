"""RESULTS of a sweep made without a solver: two velocities of the default column, with tables."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

from elutria.case.case import Case, Setting
from elutria.classification.classify import Classification, classify
from elutria.classification.events import read_run
from elutria.estimates.model_error import model_errors
from elutria.estimates.theory import write_theory
from elutria.files import write_json

ROOT = Path(__file__).resolve().parents[2]


def make_results(folder: Path, velocities: list[float], particles: int = 800) -> Path:
    """Runs U5, U6 ... of the stand-in solver, and the tables of them."""
    made = Classification()
    for velocity in velocities:
        settings = [
            f"system/simulationParameters:particles={particles}",
            f"system/simulationParameters:gasVelocity={velocity:.12g}",
        ]
        run = folder / f"U{velocity:g}"
        case = Case(ROOT / "cases/column").copy_to(run, map(Setting.parse, settings))
        shutil.rmtree(run / "constant/polyMesh", ignore_errors=True)
        subprocess.run(
            [sys.executable, ROOT / "tests/support/fake_solver.py"],
            cwd=run, check=True, capture_output=True,
        )  # fmt: skip
        marker = {"case": "column", "inputs": "0123456789abcdef", "settings": settings, "np": 1}
        write_json(run / "elutria.json", marker)
        finished = {"inputs": "0123456789abcdef", "gas_velocity_m_s": velocity, "wall_time_s": 12.5}
        write_json(run / "finished.json", finished)
        write_json(run / "postProcessing/plan.json", plan(velocity))
        made.extend(classify(read_run(run), velocity, 12.5, 0, model_errors(Case(run))))
    made.write(folder)
    write_theory(case, velocities, folder)
    return folder


def plan(velocity: float) -> dict[str, object]:
    """What of a plan the pages show."""
    text = f"""{{
      "mesh": {{"cells": 10000, "size_m": [0.05, 0.05, 0.5], "smallest_cell_m": 0.005,
               "largest_cell_m": 0.005}},
      "gas": {{"density_kg_m3": 1.2, "viscosity_pa_s": 1.8e-05, "changes_at": 0.01}},
      "drag": {{"forces": ["SchillerNaumannDrag"]}},
      "feed": {{"through": "feedSlot", "rate_kg_s": 0.0036, "rate_times": null, "start_s": 0,
               "end_s": 1, "seed": 1, "parcels": 800, "particles_per_parcel": 1,
               "outlets": [{{"product": "fines", "patches": ["top"]}},
                           {{"product": "coarse", "patches": ["bottom"]}}],
               "materials": [{{"name": "quartz", "density_kg_m3": 2650, "least_density_kg_m3": 2650,
                              "largest_density_kg_m3": 2650, "sphericity": 1, "mass_fraction": 1,
                              "smallest_m": 3e-4, "largest_m": 2e-3,
                              "d10_m": 4.7e-4, "d50_m": 8.1e-4, "d90_m": 1.19e-3}}]}},
      "expected": {{"loading": 0.2, "gas_change": {0.16 / velocity:g}, "collisions": 0.13}},
      "decisions": [["coupling", "two-way", "the load changes the gas by {velocity:g} %"],
                    ["spin, history", "needed", "friction"]],
      "warnings": []
    }}"""
    made: dict[str, object] = json.loads(text)
    return made
