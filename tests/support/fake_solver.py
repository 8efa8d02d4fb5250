"""Stands in for elutriaFoam: reads the case it is started in, writes what the real one writes.

The partition is log-logistic in d/d50 with exponent 8, d50 = 100 um s/m x gas velocity x
(loading/0.2)^0.1.
FAKE_FAIL_AT (a velocity) makes it diverge, FAKE_CUT_AT makes it end without a word, FAKE_SLEEP
(s) makes it slow; each start is a line in FAKE_STARTS. It leaves a
time's folder behind, and refuses to go on from one with another seed, as the real one does.
"""

import json
import math
import os
import random
import re
import sys
import time
from pathlib import Path

from elutria import tables

HEADER = ",".join(tables.EVENTS) + "\n"


def parameter(name: str) -> float:
    text = Path("system/simulationParameters").read_text()
    return float(re.search(rf"^{name}\s+([^;]+);", text, re.M)[1])


def draw_size(draw: random.Random) -> float:
    """From the column's feed: Rosin-Rammler by mass, drawn by number (rejection by 1/d^3)."""
    low, high = (1 - math.exp(-((d / 900e-6) ** 3)) for d in (300e-6, 2000e-6))
    while True:
        diameter = 900e-6 * (-math.log(1 - draw.uniform(low, high))) ** (1 / 3)
        if draw.random() < (300e-6 / diameter) ** 3:
            return diameter


def planned(velocity: float, count: int) -> dict[str, object]:
    """What of the plan is asked for."""
    gas = {"basis": "inlet", "inflow_is_fixed": True, "superficial_m_s": velocity, "inlets": []}
    return {
        "mesh": {"cells": 1000},
        "gas": {
            **gas, "through_time_s": 0.5 / velocity, "changes_at": 0.01,
            "by_itself": {"what": "steady", "why": "it is made up"},
        },
        "drag": {"forces": []},
        "feed": {"parcels": count, "start_s": 0, "end_s": 1, "run_ends_s": 1.5},
        "expected": {
            "loading": parameter("loading"), "gas_change": 0.03, "collisions": 0.1,
            "shortest_relaxation_s": 0.15,
        },
        "step": {
            "first_s": 0.004, "adjusts": True, "courant": 4.8, "largest_courant": 4,
            "largest_by_collisions_s": None,
        },
    }  # fmt: skip


def main() -> int:
    velocity, count, seed = (
        parameter("gasVelocity"),
        int(parameter("particles")),
        parameter("seed"),
    )
    if "-dictionaries" in sys.argv:
        return 2  # the tool reads the text then
    if "-plan" in sys.argv:
        Path("postProcessing").mkdir()
        Path("postProcessing/plan.json").write_text(json.dumps(planned(velocity, count)))
        return 0
    if "FAKE_STARTS" in os.environ:
        with Path(os.environ["FAKE_STARTS"]).open("a") as file:
            file.write(f"{velocity:g} {seed:g}\n")
    record = Path("0.5/seed")
    if record.is_file() and float(record.read_text()) != seed:
        print(f"elutria: failed: constant/feed: seed is {seed:g}")
        return 2
    record.parent.mkdir(exist_ok=True)
    record.write_text(str(seed))
    draw = random.Random(seed)
    rows, inside = [], []
    cut = 100e-6 * (parameter("loading") / 0.2) ** 0.1
    for number in range(count):
        diameter = draw_size(draw)
        share = 1 / (1 + (diameter / (velocity * cut)) ** -8)
        outlet = "coarse" if draw.random() < share else "fines"
        kept = number % 200 == 199
        place = "inside" if kept else outlet
        row = f"{0.001 * number:g},{place},quartz,{number},{diameter!r},2650,1,0,0,1,0.3\n"
        (inside if kept else rows).append((row, outlet, diameter))
    for part in range(1, 5):
        time.sleep(float(os.environ.get("FAKE_SLEEP", "0")) / 4)
        n = part * count // 4
        print(
            f"elutria: time {part * 0.25:g} fed {n} fines {n // 2} coarse {n // 2} inside 0 lost 0",
            flush=True,
        )
    if os.environ.get("FAKE_FAIL_AT") == f"{velocity:g}":
        print("elutria: failed: time 0.5, cell 12: velocity is not finite")
        return 1
    if os.environ.get("FAKE_CUT_AT") == f"{velocity:g}":
        return 0
    folder = Path("postProcessing/outlets/0")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "particles.csv").write_text(HEADER + "".join(row for row, _, _ in rows))
    Path("postProcessing/inside.csv").write_text(HEADER + "".join(row for row, _, _ in inside))

    def amount(entries):
        mass = sum(2650 * math.pi / 6 * d**3 for _, _, d in entries)
        return {"number": len(entries), "mass_kg": mass, "parcels": len(entries)}

    none = {"number": 0, "mass_kg": 0.0, "parcels": 0}
    account = {
        "injected": amount(rows + inside),
        "outlets": {p: amount([r for r in rows if r[1] == p]) for p in ("fines", "coarse")},
        "inside": amount(inside),
        "lost": none,
    }
    ledger = {
        "time_s": 1,
        "seed": seed,
        "total": account,
        "materials": {"quartz": account},
    }
    Path("postProcessing/ledger.json").write_text(json.dumps(ledger))
    print("elutria: finished")
    return 0


sys.exit(main())
