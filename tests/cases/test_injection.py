"""OpenFOAM's own injection models: what they bring moves from its injection on, and once only."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elutria.errors import ElutriaError
from elutria_validation.harness.box import NO_DRAG, BoxCase, Contacts
from elutria_validation.harness.cases import (
    CLOUD,
    CONTROL,
    MODELS,
    add_feed,
    change,
    read_gas,
    solve,
    times,
    uniform,
)
from elutria_validation.harness.particles import HEADER, read_particles
from elutria_validation.references.drag import fall

UPFLOW = 0.4  # m/s


def inject(case: Path, diameter: float, **entries: Any) -> None:
    """Let one of OpenFOAM's models inject spheres of a diameter (m), one to a parcel."""
    usual = {
        "massTotal": 0, "SOI": 0, "parcelBasisType": "fixed", "nParticle": 1,
        "sizeDistribution": {
            "type": "fixedValue", "fixedValueDistribution": {"value": diameter},
        },
    }  # fmt: skip
    change(case, {f"{MODELS}/injectionModels": {"model": {**usual, **entries}}})


def inject_at(case: Path, places: list[tuple[float, float, float]], diameter: float) -> None:
    """Inject spheres at rest, all in the first step."""
    rows = "\n".join(f"({x!r} {y!r} {z!r})" for x, y, z in places)
    (case / "constant/places").write_text(
        HEADER.format("vectorField", "constant", "places") + f"(\n{rows}\n)\n"
    )
    inject(case, diameter, type="manualInjection", positionsFile='"places"', U0=[0, 0, 0])


def inject_through(
    case: Path, patch: str, speed: float, per_second: float, diameter: float = 1e-4
) -> None:
    """Inject spheres (m) through a patch, along x."""
    inject(case, diameter, type="patchInjection", patch=patch, patchName=patch, U0=[speed, 0, 0],
           duration=100, parcelsPerSecond=per_second,
           flowRateProfile=1)  # fmt: skip


@pytest.mark.parametrize("contacts", [None, Contacts()], ids=["free", "contacts"])
def test_a_sphere_of_manual_injection_settles_as_exactly_as_one_of_the_feed(
    tmp_path: Path, measured, contacts: Contacts | None
) -> None:
    case = BoxCase(gas_velocity=UPFLOW, sides="cyclic", ends="cyclic", step=1e-3, end=0.05,
                   interval=1e-3, contacts=contacts,
                   more={f"{CLOUD}:constantProperties/rho0": 2000}).make(
        tmp_path / "case"
    )  # fmt: skip
    inject_at(case, [(0.05, 0.05, 0.05)], 1e-4)
    solve(case)
    for time in (1e-3, 0.01, 0.05):
        found = read_particles(case, f"{time:g}").velocity[0, 2]
        reference = fall(1e-4, 2000, UPFLOW, [time])[0]
        measured(f"velocity at {time:g} s", abs(found / reference - 1), 1e-4)


def ages(case: Path, time: str) -> np.ndarray:
    text = (case / time / "lagrangian/kinematicCloud/age").read_text().partition("}")[2]
    return np.array([float(word) for word in text.partition("(")[2].partition(")")[0].split()])


def test_what_is_injected_within_a_step_has_the_rest_of_it_to_fly(tmp_path: Path, measured) -> None:
    speed, step = 2.0, 1.05e-3
    case = BoxCase(gravity=0, step=step, end=10 * step, forces=NO_DRAG,
                   contacts=Contacts()).make(tmp_path / "case")  # fmt: skip
    inject(case, 1e-4, type="coneInjection", positionAxis=[[[0.01, 0.05, 0.05], [1, 0, 0]]],
           duration=100, parcelsPerInjector=500000, flowRateProfile=1, Umag=speed, thetaInner=0,
           thetaOuter=0)  # fmt: skip
    solve(case)
    end = times(case)[-1]
    age, found = np.sort(ages(case, end)), read_particles(case, end)
    assert len(age) >= 45
    assert len(np.unique(np.round(age / step % 1, 4))) >= 5, "all enter at a step's start"
    flown = np.sort(found.position[:, 0]) - 0.01
    measured("place less speed times age, m", np.abs(flown - speed * age).max(), 2e-8)
    measured("speed, m/s", np.abs(found.velocity[:, 0] - speed).max(), 1e-9)


def test_a_restart_injects_nothing_again(tmp_path: Path) -> None:
    places = [(0.01 * i, 0.01 * j, 0.05) for i in range(1, 10) for j in range(1, 10)]
    box = BoxCase(ends="wall", step=1e-3, end=0.02, interval=0.01, contacts=Contacts())
    for name, stop in (("whole", None), ("parts", 0.01)):
        case = box.make(tmp_path / name)
        inject_at(case, places, 1e-3)
        if stop is not None:
            change(case, {f"{CONTROL}:endTime": stop})
            solve(case)
            change(case, {f"{CONTROL}:endTime": 0.02})
        solve(case)
    whole, parts = (read_particles(tmp_path / name, "0.02") for name in ("whole", "parts"))
    assert len(whole.diameter) == len(parts.diameter) == len(places)


def test_a_restart_injects_through_a_patch_at_the_same_rate(tmp_path: Path) -> None:
    box = BoxCase(gravity=0, step=1e-3, end=0.02, interval=0.01, forces=NO_DRAG)
    numbers = {}
    for name in ("whole", "parts"):
        case = box.make(tmp_path / name)
        inject_through(case, "west", 1.0, 3500)
        if name == "parts":
            change(case, {f"{CONTROL}:endTime": 0.01})
            solve(case)
            change(case, {f"{CONTROL}:endTime": 0.02})
        solve(case)
        numbers[name] = len(read_particles(case, "0.02").diameter)
    assert abs(numbers["whole"] - numbers["parts"]) <= 10, numbers  # its numbers are random
    assert numbers["whole"] > 60


@pytest.mark.parametrize("displaces", [None, True])
def test_what_enters_pushes_gas_away_where_the_case_says_so(
    tmp_path: Path, measured, displaces: bool | None
) -> None:
    diameter, per_second = 2e-3, 5000
    case = BoxCase(gravity=0, step=1e-3, end=0.05, interval=1e-3, forces=NO_DRAG, coupled=True,
                   solve_gas=True, cells=(4, 4, 4), tolerance=(1e-10, 1e-4)).make(
        tmp_path / "case"
    )  # fmt: skip
    inject_through(case, "west", 0.5, per_second, diameter)
    if displaces is not None:
        change(case, {f"{CLOUD}:feedDisplacesGas": displaces})
    solve(case)
    rise = np.mean([read_gas(case, time)[-16:, 2].mean() for time in times(case)[10:]])
    pushed = np.pi / 6 * diameter**3 * per_second / 0.1**2 if displaces else 0.0
    measured("gas velocity at the outlet, m/s", abs(rise - pushed), 1e-4)


FEED = {"massFlowRate": 0.01, "particles": 20, "duration": 0.01,
        "materials": uniform(2650, 1e-3, 1.1e-3)}  # fmt: skip


@pytest.mark.parametrize("feeds", [0, 2])
def test_a_feed_that_no_model_brings_in_or_two_do_is_refused(tmp_path: Path, feeds: int) -> None:
    """It was counted as lost: 100 % of the feed in no product."""
    case = BoxCase(end=0.02).make(tmp_path / "case")
    add_feed(case, FEED)
    inject_at(case, [(0.05, 0.05, 0.05)], 1e-3)
    change(case, {f"{MODELS}/injectionModels/feed{n}": {"type": "feed"} for n in range(feeds)})
    with pytest.raises(ElutriaError) as refused:
        solve(case)
    for said in ("kinematicCloudProperties", "injectionModels", "type feed", "constant/feed"):
        assert said in str(refused.value)


def test_parcels_that_no_table_holds_are_told_of(tmp_path: Path) -> None:
    """Beside the feed's; the tables are of the feed's alone."""
    case = BoxCase(end=1e-3).make(tmp_path / "case")
    add_feed(case, FEED)
    solve(case, options=["-plan"])
    assert "not counted" not in rows(case)
    inject_at(case, [(0.05, 0.05, 0.05)], 1e-3)
    change(case, {f"{MODELS}/injectionModels/feed": {"type": "feed"}})
    solve(case, options=["-plan"])
    assert "model" in rows(case)["not counted"]


def rows(case: Path) -> dict[str, str]:
    """Of the plan: what is decided about each thing."""
    plan = json.loads((case / "postProcessing/plan.json").read_text())
    return {what: decision for what, decision, _ in plan["decisions"]}
