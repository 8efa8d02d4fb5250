"""Gas that does not become steady is solved on; the plan says whether it is, and why."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from elutria.case.case import PARAMETERS, Case
from elutria.openfoam.dictionary import set_entry
from elutria.running.run import read_plan, run_case
from elutria_validation.benchmarks.column import STOCK_CONTACTS
from elutria_validation.harness.box import BoxCase, GasPlan
from elutria_validation.harness.cases import (
    CONTROL,
    MODELS,
    change,
    patch_mean,
    read_gas,
    solve,
    times,
)
from elutria_validation.harness.particles import Particles, lattice
from elutria_validation.harness.scenes import CoarseColumn
from tests.support import meshes

Array = NDArray[np.float64]

BEHIND = [0.020, 0.004, 0.075]  # m, in the bar's wake
PROBE = {
    "type": "probes",
    "libs": ['"libsampling.so"'],
    "fields": ["U.air"],
    "probeLocations": [BEHIND],
    "writeControl": "timeStep",
    "writeInterval": 1,
}


def bar(column: Path, velocity: float, cell: float, **parameters: str) -> Path:
    """The default column with the mesh of a bar, laminar, and a probe behind it."""
    (column / "system/blockMeshDict").write_text(meshes.barred(cell))
    for field in (column / "0.orig").iterdir():
        sides = '    "front|back" { type symmetryPlane; }\n}\n'
        text = field.read_text().replace('"walls|feedSlot"', '"defaultFaces|walls|feedSlot"')
        field.write_text(text.rstrip().removesuffix("}") + sides)
    feed = column / "constant/feed"
    text = feed.read_text()
    for old, new in {"900e-6": "60e-6", "300e-6": "40e-6", "2000e-6": "90e-6"}.items():
        assert old in text
        text = text.replace(old, new)
    feed.write_text(text)
    for name, value in {"gasVelocity": f"{velocity:g}", **parameters}.items():
        set_entry(column / PARAMETERS, name, value, column)
    change(
        column,
        {
            "constant/turbulenceProperties.air:simulationType": "laminar",
            f"{CONTROL}:functions": {"behindBar": PROBE},
            f"{CONTROL}:deltaT": 1e-3,
            f"{CONTROL}:maxDeltaT": 1e-3,
            f"{CONTROL}:maxCo": 1,
        },
    )
    return column


def behind(case: Path) -> Array:
    """Rows of time (s) and velocity (m/s) behind the bar."""
    text = (case / "postProcessing/behindBar/0/U.air").read_text()
    rows = [re.sub(r"[()]", "", row).split() for row in text.splitlines() if row[0] != "#"]
    return np.array(rows, dtype=float)


def solves(case: Path) -> tuple[int, int]:
    """Times that the gas was solved, and steps of the run."""
    log = (case / "log.elutriaFoam").read_text()
    return int(re.findall(r"gas solved +(\d+) times", log)[-1]), log.count("\nTime = ")


@pytest.mark.slow
def test_vortices_behind_a_bar_are_not_frozen(column: Path, tmp_path: Path) -> None:
    """The plan knows it from the settling, which finds no steady state."""
    brief = {"particles": "50", "feedTime": "0.3", "drainTime": "0.05", "loading": "1e-5"}
    case = run_case(Case(bar(column, 0.4, 2e-3, **brief)), tmp_path / "run", []).path
    plan = read_plan(case)
    assert plan["gas"]["by_itself"]["what"] == "unsteady"
    assert plan["gas"]["solved"]["what"] == "on every step"
    done, steps = solves(case)
    assert done == steps
    fluctuation = behind(case)[:, 1].std()  # m/s, across
    assert fluctuation > 0.02


def test_without_a_feed_the_gas_is_solved_until_it_is_steady(tmp_path: Path) -> None:
    """From rest, at 1 m/s through 0.1 m: a passage is five steps."""
    case = BoxCase(
        gas_velocity=1, cells=(1, 1, 5), solve_gas="auto", converge_gas="auto", step=0.02, end=2,
        sides="symmetry",
    ).make(tmp_path / "case")  # fmt: skip
    change(case, {"0/U.air:internalField": np.zeros(3)})
    log = solve(case)
    assert read_gas(case, times(case)[-1])[:, 2] == pytest.approx(1, abs=5e-3)
    done, steps = solves(case)
    assert steps == 100
    assert 10 <= done <= 50
    assert "no constant/feed" in log
    assert re.search(r"gas by itself +developing", log)
    assert re.search(r"gas by itself +steady", log)


RAMP = "(0 (0 0 3)) (0.1 (0 0 3)) (0.101 (0 0 6)) (9 (0 0 6))"
"""m/s, of the inlet over time, s"""


def test_gas_develops_after_its_inlet_has_changed(tmp_path: Path) -> None:
    """A sudden change, and particles too few to be felt: as if solved on every step."""
    gas = {}
    for plan in ("auto", True):
        case = tmp_path / f"{plan}"
        CoarseColumn(3, 1e-5, inlet=RAMP, particles=20, gas=plan, end=0.4).run(case)
        gas[plan] = read_gas(case, times(case)[-1])
    difference = gas["auto"] - gas[True]
    assert np.sqrt((difference**2).sum(axis=1).mean()) < 0.01 * 6
    done, steps = solves(tmp_path / "auto")
    assert 10 < done < steps


def test_a_gas_taken_for_steady_is_found_out(tmp_path: Path) -> None:
    """Half of the gas' speed appears while only particles should move it: it is watched again."""
    case = tmp_path / "case"
    CoarseColumn(6, 0.5, particles=300, end=0.2).run(case)
    gas = case / "0.2/U.air"
    text = gas.read_text()
    assert re.search(r"flow\s+steady;", (case / "0.2/uniform/gasSolves").read_text())
    head, values, tail = re.split(r"(?s)(?<=\n\()(.*?)(?=\n\))", text, maxsplit=1)
    halved = re.sub(r"\(([^ ]+) ([^ ]+) ([^ ]+)\)", lambda m: _halved(*m.groups()), values)
    gas.write_text(head + halved + tail)
    change(case, {f"{CONTROL}:endTime": 0.6})
    log = solve(case)
    assert "the gas is solved on every step again" in log
    speed = read_gas(case, times(case)[-1])[:, 2].mean()
    assert speed == pytest.approx(6, rel=0.02)


def _halved(*vector: str) -> str:
    return "(" + " ".join(f"{0.5 * float(v):.9g}" for v in vector) + ")"


def test_openfoams_average_over_time_counts_steps_without_a_solve(tmp_path: Path) -> None:
    """Of the mean upward velocity, which is the inlet's: 3 m/s for 0.1 s of 0.4 s, then 6 m/s."""
    average = """
functions
{
    average
    {
        type fieldAverage; libs ("libfieldFunctionObjects.so"); writeControl writeTime;
        fields (U.air { mean yes; prime2Mean yes; base time; });
    }
}
"""
    case = tmp_path / "case"
    CoarseColumn(3, 1e-5, inlet=RAMP, particles=20, end=4e-3, step=2e-3).run(case)
    for written in times(case)[1:]:
        shutil.rmtree(case / written)
    control = case / "system/controlDict"
    control.write_text(control.read_text() + average)
    change(case, {f"{CONTROL}:endTime": 0.4, f"{CONTROL}:writeInterval": 0.4})
    solve(case)
    done, steps = solves(case)
    assert done < steps
    mean = read_gas(case, times(case)[-1], "U.airMean")[:, 2].mean()
    assert mean == pytest.approx((0.1 * 3 + 0.3 * 6) / 0.4, rel=0.01)


def stock_bed(folder: Path, plan: GasPlan) -> Path:
    """Spheres that fall in rising gas, with stock's collision model."""
    walls = STOCK_CONTACTS["wallLocalSpringSliderDashpotCoeffs"]
    named = dict.fromkeys(("west", "east", "south", "north"), walls["walls"])
    wall = {"wallLocalSpringSliderDashpotCoeffs": {**walls, **named}}
    return BoxCase(
        width=0.02, depth=0.02, height=0.02, cells=(2, 2, 4), gas_velocity=1, coupled=True,
        solve_gas=plan, gas_tolerance=1e-9, step=1e-4, end=2e-4,
        more={
            f"{MODELS}/collisionModel": "pairCollision",
            f"{MODELS}/pairCollisionCoeffs": STOCK_CONTACTS | wall,
            **patch_mean("bottom", "p"),
        },
    ).make(folder, Particles.of(lattice(64, 0.02), diameter=5e-4))  # fmt: skip


def test_a_window_of_stocks_motion_gives_the_gas_all_its_momentum(tmp_path: Path) -> None:
    """Solved once in four steps, the gas feels what it feels when solved in each."""
    drops = []
    for plan in ("auto", True):
        case = stock_bed(tmp_path / f"{plan}", plan)
        solve(case)
        if plan == "auto":  # a gas that may wait, for four steps
            state = case / "0.0002/uniform/gasSolves"
            text = re.sub(r"(flow\s+)\w+;", r"\1steady;", state.read_text())
            state.write_text(re.sub(r"(interval\s+)\d+;", r"\g<1>4;", text))
        change(case, {f"{CONTROL}:endTime": 6e-4, f"{CONTROL}:writeInterval": 4e-4})
        solve(case)
        last = max(case.glob("postProcessing/bottom/*/surfaceFieldValue.dat"))
        drops.append(np.loadtxt(last, ndmin=2)[-1, 1])
    assert solves(tmp_path / "auto")[0] == 1
    assert drops[0] == pytest.approx(drops[1], rel=0.02)
