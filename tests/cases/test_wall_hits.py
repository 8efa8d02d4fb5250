"""Walls that hold particles, let them out or record hits, while contacts are on."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from math import cos, radians, sin, sqrt, tan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elutria_validation.harness.box import CLOSED, NO_DRAG, BoxCase, Contacts, Pair, Treatment
from elutria_validation.harness.cases import (
    CLOUD,
    CONTROL,
    MODELS,
    add_feed,
    change,
    solve,
    times,
    uniform,
)
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.harness.programs import run_program

PARCELS = 496
TREATMENTS: list[Treatment] = ["auto", "impact", "soft"]
EMPTY = BoxCase(gravity=0, forces=NO_DRAG, contacts=Contacts(), end=0.3, cells=(4, 4, 4))
FUNCTION = f"{CLOUD}:cloudFunctions/one"


def local(ends: str = "escape", sides: str = "rebound", **patches: str) -> dict[str, Any]:
    """Settings of localInteraction: what happens at each patch."""
    usual = {**dict.fromkeys(("west", "east", "south", "north"), sides),
             **dict.fromkeys(("bottom", "top"), ends)}  # fmt: skip
    return {f"{MODELS}/patchInteractionModel": "localInteraction",
            f"{MODELS}/localInteractionCoeffs": patch_types({**usual, **patches})}  # fmt: skip


def patch_types(patches: dict[str, str]) -> dict[str, Any]:
    return {"patches": [(name, {"type": kind}) for name, kind in patches.items()]}


def shower(folder: Path, interaction: dict[str, Any], treatment: Treatment, **feed: Any) -> Path:
    """Particles thrown across an empty box at its east wall."""
    case = replace(EMPTY, contacts=Contacts(treatment=treatment)).make(folder)
    change(case, interaction)
    add_feed(case, {"massFlowRate": 0.05, "particles": PARCELS, "duration": 0.05,
                    "velocity": [2, 0, 0], "materials": uniform(2650, 9e-4, 1.1e-3),
                    **feed})  # fmt: skip
    return case


def fates(log: str, what: str) -> int:
    """Parcels that met this fate at any patch, as stock's page tells it last."""
    return sum(map(int, re.findall(rf"- {what} +[^\n]*= (\d+),", log.rpartition("Cloud:")[2])))


def ledger(case: Path) -> dict[str, Any]:
    total: dict[str, Any] = json.loads((case / "postProcessing/ledger.json").read_text())["total"]
    return total


def active(case: Path) -> list[int]:
    text = (case / times(case)[-1] / "lagrangian/kinematicCloud/active").read_text()
    count, _, values = text.partition("// *")[2].partition("\n")[2].strip().partition("(")
    if values:
        return [int(x) for x in values.split(")")[0].split()]
    number, same = re.findall(r"(\d+)\{(\d+)\}", count)[0]
    return [int(same)] * int(number)


@pytest.mark.parametrize("treatment", TREATMENTS)
@pytest.mark.parametrize("ranks", [1, 2])
def test_all_that_is_thrown_at_a_sticking_wall_stays_there(
    tmp_path: Path, treatment: Treatment, ranks: int
) -> None:
    case = shower(tmp_path / "case", local(east="stick"), treatment)
    solve(case, ranks)
    total = ledger(case)
    assert total["inside"]["parcels"] == PARCELS
    assert total["lost"]["parcels"] == 0
    assert total["mass_closure_error"] < 1e-12
    if ranks > 1:
        run_program(["reconstructPar", "-latestTime"], case)
    after = read_particles(case, times(case)[-1])
    assert np.all(after.velocity == 0)
    assert active(case) == [0] * PARCELS
    gap = 0.1 - after.position[:, 0] - after.diameter / 2
    assert np.abs(gap).max() < 0.02 * after.diameter.max()
    # the column ends when nothing moves any more
    assert float(times(case)[-1]) < 0.2


def test_what_a_wall_holds_stays_when_a_run_goes_on(tmp_path: Path) -> None:
    """Others fly through it: it is no obstacle."""
    held = Particles.of([(0.05, 0.05, 0.002), (0.03, 0.05, 0.002)], [(0, 0, -1), (0, 0, -1)])
    box = replace(EMPTY, ends="wall", gravity=-9.80665, end=0.02)
    case = box.make(tmp_path / "case", held)
    change(case, local(ends="rebound", bottom="stick"))
    assert fates(solve(case), "stick") == 2
    first = read_particles(case, "0.02")
    change(case, {f"{CONTROL}:endTime": 0.04})
    assert fates(solve(case), "stick") == 2  # of the whole run
    second = read_particles(case, "0.04")
    assert np.all(second.velocity == 0)
    assert np.allclose(second.position, first.position, rtol=0, atol=1e-12)
    assert np.allclose(second.position[:, 2], 5e-4, rtol=0, atol=1e-9)


@pytest.mark.parametrize("treatment", TREATMENTS)
@pytest.mark.parametrize("ranks", [1, 2])
def test_what_escapes_through_a_wall_leaves_with_its_product(
    tmp_path: Path, treatment: Treatment, ranks: int
) -> None:
    outlets = {"fines": ["top"], "coarse": ["east", "bottom"]}
    case = shower(tmp_path / "case", local(east="escape"), treatment, outlets=outlets)
    solve(case, ranks)
    total = ledger(case)
    assert total["outlets"]["coarse"]["parcels"] == PARCELS
    assert total["inside"]["parcels"] == total["lost"]["parcels"] == 0
    assert total["mass_closure_error"] < 1e-12
    rows = (case / "postProcessing/outlets/0/particles.csv").read_text().splitlines()
    assert len(rows) == PARCELS + 1


def test_walls_of_the_standard_interaction_and_of_many_hold_too(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    places = np.stack(np.meshgrid(*[np.linspace(0.02, 0.08, 4)] * 3), axis=-1).reshape(-1, 3)
    thrown = Particles.of(places, rng.normal(size=places.shape), diameter=2e-3)
    stick = {f"{MODELS}/patchInteractionModel": "standardWallInteraction",
             f"{MODELS}/standardWallInteractionCoeffs": {"type": "stick"}}  # fmt: skip
    many = {f"{MODELS}/patchInteractionModel": "multiInteraction",
            f"{MODELS}/multiInteractionCoeffs": {
                "oneInteractionOnly": True,
                "first": {"patchInteractionModel": "localInteraction",
                          "localInteractionCoeffs": patch_types(
                              {"west": "rebound", '"[^w].*"': "none"})},
                "second": {"patchInteractionModel": "standardWallInteraction",
                           "standardWallInteractionCoeffs": {"type": "stick"}}}}  # fmt: skip
    for name, interaction in {"standard": stick, "many": many}.items():
        case = replace(EMPTY, **CLOSED, end=2.0, interval=2.0).make(tmp_path / name, thrown)
        change(case, interaction)
        solve(case)
        after = read_particles(case, times(case)[-1])
        assert len(after.diameter) == len(places)
        still = np.all(after.velocity == 0, axis=1)
        assert still.mean() > 0.9
        west = np.abs(after.position[:, 0] - 1e-3) < 1e-5
        assert (west & still).any() == (name == "standard")


P, PSI, K = 1e9, 2.0, 2.0  # plastic flow stress (Pa); ratios of Finnie's model
EROSION = {"type": "particleErosion", "p": P, "psi": PSI, "K": K, "patches": ["bottom"]}


def finnie(mass: float, speed: float, angle: float) -> float:
    """Volume (m3) that a particle cuts off a wall that it hits at `angle` to it; Finnie (1960)."""
    steep = tan(angle) >= K / 6
    shape = K * cos(angle) ** 2 / 6 if steep else sin(2 * angle) - 6 / K * sin(angle) ** 2
    return float(mass * speed**2 / (P * PSI * K) * shape)


def eroded(case: Path) -> float:
    """Volume that all particles have cut off the bottom, m3."""
    (file,) = (case / times(case)[-1]).glob("*Q*")
    values = re.findall(r"bottom\s*\{[^}]*nonuniform[^(]*\(([^)]*)\)", file.read_text())
    return float(sum(map(float, values[0].split())))


@pytest.mark.parametrize("treatment", TREATMENTS)
@pytest.mark.parametrize("angle", [15, 60])
def test_erosion_is_finnies_and_stocks(
    tmp_path: Path, measured: Any, angle: float, treatment: Treatment
) -> None:
    """One impact of one particle: with contacts, and without them in stock's solver."""
    speed, way = 3.0, 0.01
    velocity = speed * np.array([cos(radians(angle)), 0, -sin(radians(angle))])
    ball = Particles.of([(0.03, 0.04, way)], [velocity], diameter=1e-3)
    box = replace(EMPTY, ends="wall", cells=(5, 5, 2), end=2 * way / abs(velocity[2]), step=5e-4,
                  contacts=Contacts(Pair(0.8), treatment=treatment))  # fmt: skip
    volume = {}
    for name, solver in {"ours": "elutriaFoam", "stock": "DPMFoam"}.items():
        case = replace(box, contacts=box.contacts if name == "ours" else None).make(
            tmp_path / name, ball
        )
        change(case, {FUNCTION: EROSION, f"{CONTROL}:writePrecision": 12})
        solve(case, solver=solver)
        volume[name] = eroded(case)
    right = finnie(float(ball.mass[0]), speed, radians(angle))
    measured(f"erosion at {angle} degrees", abs(volume["ours"] / right - 1), 1e-6)
    measured("stock's erosion", abs(volume["stock"] / right - 1), 1e-6)


def hits(case: Path) -> int:
    """Rows of patchPostProcessing at the bottom."""
    (file,) = (case / "postProcessing").rglob("bottom.post")
    return sum(not line.startswith("#") for line in file.read_text().splitlines())


@pytest.mark.parametrize("treatment", TREATMENTS)
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_ball_that_bounces_is_recorded_as_often_as_it_must_be(
    tmp_path: Path, treatment: Treatment, ranks: int
) -> None:
    """It falls from h: hits at t = sqrt(2 h/g), then after 2 e^n v/g each."""
    height, g, e, end = 0.05, 9.80665, 0.8, 0.4
    expected, time, speed = 0, sqrt(2 * height / g), sqrt(2 * g * height)
    while time < end:
        expected, time, speed = expected + 1, time + 2 * e * speed / g, speed * e
    assert expected == 3
    ball = Particles.of([(0.05, 0.05, 5e-4 + height)], diameter=1e-3)
    case = replace(
        EMPTY, ends="wall", gravity=-g, end=end, contacts=Contacts(Pair(e), treatment=treatment)
    ).make(tmp_path / "case", ball)
    change(case, {FUNCTION: {"type": "patchPostProcessing", "maxStoredParcels": 100,
                             "patches": ['".*"']}})  # fmt: skip
    solve(case, ranks)
    assert hits(case) == expected


def test_faces_of_a_wall_see_what_hits_them_and_no_more(tmp_path: Path) -> None:
    """facePostProcessing counts the mass through a zone of faces: those of the floor."""
    ball = Particles.of([(0.05, 0.05, 0.01)], [(0.1, 0, -1)], diameter=1e-3)
    case = replace(EMPTY, ends="wall", end=0.05).make(tmp_path / "case", ball)
    (case / "system/topoSetDict").write_text(
        "FoamFile { version 2.0; format ascii; class dictionary; object topoSetDict; }\n"
        "actions ( { name floor; type faceSet; action new; source patchToFace; patch bottom; }\n"
        " { name floor; type faceZoneSet; action new; source setToFaceZone; faceSet floor; } );\n"
    )
    run_program(["topoSet"], case)
    change(
        case,
        {
            FUNCTION: {
                "type": "facePostProcessing",
                "surfaceFormat": "none",
                "resetOnWrite": False,
                "log": True,
                "faceZones": ["floor"],
            }
        },
    )
    log = solve(case)
    mass = re.findall(r"floor: total mass = ([^;]+);", log)[-1]
    assert float(mass) == pytest.approx(float(ball.mass[0]), rel=1e-5)


GRID, LEAST = 5, 0.8
"""Faces of the floor along a side; normal speed (m/s) of the slowest hit that counts."""


def rain() -> Particles:
    """A ball over the middle of each face of the floor, of all speeds: each hits it once in 30 ms,
    or not at all (the last row)."""
    middle = 0.1 * (np.arange(GRID) + 0.5) / GRID
    x, y = (axis.ravel() for axis in np.meshgrid(middle, middle, indexing="ij"))
    height = np.where(x > 0.09, 0.09, 0.012)
    velocity = np.stack([0 * x, 0 * y, -np.linspace(0.6, 1.2, GRID**2)], axis=1)
    return Particles.of(np.stack([x, y, height], axis=1), velocity, diameter=1e-3)


def rained(folder: Path, treatment: Treatment | None, settings: dict[str, Any]) -> tuple[Path, str]:
    """The rain after 30 ms, with contacts or in stock's solver without; and its log."""
    contacts = None if treatment is None else Contacts(treatment=treatment)
    box = replace(EMPTY, ends="wall", cells=(GRID, GRID, 2), end=0.03, step=1e-3,
                  contacts=contacts)  # fmt: skip
    case = box.make(folder, rain())
    change(case, settings)
    return case, solve(case, solver="DPMFoam" if treatment is None else "elutriaFoam")


@pytest.mark.parametrize("treatment", TREATMENTS)
def test_the_density_of_collisions_is_stocks(tmp_path: Path, treatment: Treatment) -> None:
    """One over the face's area where a ball hit faster than `minSpeed`, else nothing."""
    count = {FUNCTION: {"type": "patchCollisionDensity", "minSpeed": LEAST}}
    thrown = rain()
    fast = (thrown.position[:, 2] < 0.05) & (-thrown.velocity[:, 2] > LEAST)
    area = (0.1 / GRID) ** 2
    expected = np.sort(fast / area)
    assert 0 < fast.sum() < len(fast)
    for name, kind in {"ours": treatment, "stock": None}.items():
        case, _ = rained(tmp_path / name, kind, count)
        (file,) = (case / times(case)[-1]).glob("*collisionDensity")
        values = re.findall(r"bottom\s*\{[^}]*nonuniform[^(]*\(([^)]*)\)", file.read_text())
        found = np.sort(np.array(values[0].split(), dtype=float))
        assert np.allclose(found, expected, rtol=1e-6), name


@pytest.mark.parametrize("treatment", TREATMENTS)
def test_what_escapes_without_a_feed_is_stocks(tmp_path: Path, treatment: Treatment) -> None:
    """Those that hit the floor are gone, the others fly on; in the log, and of the cloud."""
    out = local(ends="rebound", bottom="escape")
    hit = int((rain().position[:, 2] < 0.05).sum())
    for name, kind in {"ours": treatment, "stock": None}.items():
        case, log = rained(tmp_path / name, kind, out)
        assert fates(log, "escape") == hit, name
        after = read_particles(case, times(case)[-1])
        assert len(after.diameter) == GRID**2 - hit
        assert np.allclose(after.position[:, 2], 0.09 + after.velocity[:, 2] * 0.03, atol=1e-9)
