"""Contacts in elutriaFoam: restitution as asked, at any treatment, also across processors."""

from __future__ import annotations

import json
import resource
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elutria_validation.chapters.classification import plug_flow_cut
from elutria_validation.harness.box import CLOSED, NO_DRAG, BoxCase, Contacts, Pair
from elutria_validation.harness.cases import solve
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.harness.programs import run_program

LAWS = ("hertzMindlin", "linearSpringDashpot")
BOX = BoxCase(**CLOSED, gravity=0, forces=NO_DRAG, contacts=Contacts(), end=0.02)
# three pairs that meet head on, unequal sizes too; and a sphere that meets each of two walls
PAIRS = Particles.of(
    [
        (0.02, 0.02, 0.02), (0.03, 0.02, 0.02),
        (0.02, 0.05, 0.05), (0.02, 0.05, 0.06),
        (0.08, 0.08, 0.02), (0.08, 0.07, 0.02),
        (0.05, 0.09, 0.005), (0.09, 0.05, 0.07),
    ],
    [
        (0.5, 0, 0), (-0.5, 0, 0),
        (0, 0, 1), (0, 0, 0),
        (0, -0.5, 0), (0, 0.1, 0),
        (0, 0, -0.5), (0.7, 0, 0),
    ],
    diameter=[1e-3, 1e-3, 2e-3, 1e-3, 5e-4, 2e-3, 1e-3, 2e-3],
)  # fmt: skip


def bounce(folder: Path, contacts: Contacts) -> tuple[float, Particles]:
    """Largest relative error of the restitution of all the collisions, and the state after."""
    case = replace(BOX, contacts=contacts).make(folder, PAIRS)
    solve(case)
    after = read_particles(case, "0.02")
    found = []
    for a, b in ((0, 1), (2, 3), (4, 5)):
        axis = np.argmax(np.abs(PAIRS.velocity[a]))
        approach = (PAIRS.velocity[b] - PAIRS.velocity[a])[axis]
        found.append(-(after.velocity[b] - after.velocity[a])[axis] / approach)
    found.append(-after.velocity[6, 2] / PAIRS.velocity[6, 2])
    found.append(-after.velocity[7, 0] / PAIRS.velocity[7, 0])
    return float(np.abs(np.array(found) / contacts.pair.restitution - 1).max()), after


@pytest.mark.parametrize("treatment", ["auto", "soft"])
@pytest.mark.parametrize("restitution", [0.9, 0.5])
@pytest.mark.parametrize("law", LAWS)
def test_restitution_of_pairs_and_walls(
    tmp_path: Path, measured, law: str, restitution: float, treatment: str
) -> None:
    contacts = Contacts(Pair(restitution), law=law, treatment=treatment)
    error, after = bounce(tmp_path / "case", contacts)
    measured("largest relative error of the restitution", error, 1e-3)
    pairs = slice(0, 6)
    before = PAIRS.mass[pairs] @ PAIRS.velocity[pairs]
    change = after.mass[pairs] @ after.velocity[pairs] - before
    scale = PAIRS.mass[pairs] @ np.abs(PAIRS.velocity[pairs]).sum(axis=1)
    measured("change of the pairs' momentum over their sum", np.abs(change).max() / scale, 1e-12)


def test_spheres_that_collide_on_a_processor_patch(tmp_path: Path, measured) -> None:
    # they meet at z = 0.05, where the box is cut in two; another pair crosses the cut obliquely
    spheres = Particles.of(
        [(0.03, 0.03, 0.045), (0.03, 0.03, 0.055), (0.07, 0.07, 0.046), (0.0705, 0.07, 0.052)],
        [(0, 0, 0.5), (0, 0, -0.5), (0, 0, 0.8), (0, 0, 0.1)],
        diameter=2e-3,
    )
    contacts = Contacts(Pair(0.8, 0.4), wall_pair=Pair(0.8))
    box = replace(BOX, cells=(1, 1, 2), contacts=contacts)
    states = []
    for processors in (1, 2):
        case = box.make(tmp_path / f"{processors}", spheres)
        log = solve(case, processors)
        assert all("inside 4" in line for line in log.splitlines() if "inside" in line)
        if processors > 1:
            run_program(["reconstructPar", "-latestTime"], case)
        states.append(read_particles(case, "0.02"))
    serial, parallel = states
    assert serial.velocity[0, 2] < 0 < serial.velocity[1, 2], "the pair has collided"
    for name, scale in (("position", 0.1), ("velocity", 0.5), ("spin", 100)):
        difference = np.abs(getattr(serial, name) - getattr(parallel, name)).max() / scale
        measured(f"{name}, serial against two processors", difference, 1e-12)


def test_spheres_in_one_plane_but_for_rounding_meet(tmp_path: Path, measured) -> None:
    # positions that went through barycentric coordinates differ in the last digit
    spheres = Particles.of(
        [(0.048, 0.05, 0.05), (0.052, 0.05, 0.05)], [(1, 0, 0), (-1, 0, 0)], diameter=2e-3
    )
    case = BOX.make(tmp_path / "case", spheres)
    solve(case)
    after = read_particles(case, "0.02").velocity[:, 0]
    error = np.abs(after / [-0.8, 0.8] - 1).max()
    measured("largest relative error of the speed after", error, 1e-3)


def test_a_floor_that_moves_drags_a_grain_by_friction(tmp_path: Path, measured) -> None:
    # the gas' boundary condition says how the wall moves; the grain slides all the time
    friction, gravity, end = 0.4, -9.81, 0.02
    grain = Particles.of([(0.05, 0.05, 0.5e-3)], [(0, 0, 0)], diameter=1e-3)
    moving = {"type": "fixedValue", "value": [1, 0, 0]}
    for treatment, processors in (("auto", 1), ("soft", 2)):
        contacts = Contacts(Pair(0.8, friction), treatment=treatment)
        box = replace(
            BOX,
            cells=(1, 1, 2),
            gravity=gravity,
            contacts=contacts,
            end=end,
            more={"0.orig/U.air:boundaryField/bottom": moving},
        )
        case = box.make(tmp_path / treatment, grain)
        solve(case, processors)
        if processors > 1:
            run_program(["reconstructPar", "-latestTime"], case)
        after = read_particles(case, f"{end}")
        expected = friction * -gravity * end
        measured(
            f"{treatment}: relative error of the speed",
            abs(after.velocity[0, 0] / expected - 1),
            0.02,
        )
        spin = 2.5 * expected / 0.5e-3  # friction turns it backwards
        measured(
            f"{treatment}: relative error of the spin", abs(after.spin[0, 1] / -spin - 1), 0.02
        )


def test_a_wall_that_gas_flows_through_is_an_inlet_and_does_not_move(tmp_path: Path) -> None:
    # tutorials have inlets of type wall: their velocity is the gas', the grain stays where it is
    grain = Particles.of([(0.05, 0.05, 0.5e-3)], [(0, 0, 0)], diameter=1e-3)
    inlet = {"type": "fixedValue", "value": [1, 0, 1]}
    box = replace(
        BOX,
        cells=(1, 1, 2),
        gravity=-9.81,
        contacts=Contacts(Pair(0.8, 0.4)),
        end=0.02,
        more={"0.orig/U.air:boundaryField/bottom": inlet},
    )
    case = box.make(tmp_path / "inlet", grain)
    solve(case, 1)
    assert abs(read_particles(case, "0.02").velocity[0, 0]) < 1e-9
    (warning,) = [w for w in json.loads((case / "warnings.json").read_text())
                  if w["name"] == "wallVelocity"]  # fmt: skip
    assert "the wall bottom" in warning["what"]
    assert warning["how_much"] == "1 m/s across it"


def test_a_deck_that_shakes_across_itself_is_said_to_be_at_rest(tmp_path: Path) -> None:
    """At its start it has no velocity: what the run will find is said when it comes."""
    grain = Particles.of([(0.05, 0.05, 0.5e-3)], [(0, 0, 0)], diameter=1e-3)
    shaking = {"type": "uniformFixedValue", "uniformValue": "sine", "uniformValueCoeffs": {
        "frequency": 50, "amplitude": 1, "scale": [0, 0, 0.5], "level": [0, 0, 0]},
        "value": [0, 0, 0]}  # fmt: skip
    box = replace(BOX, cells=(1, 1, 2), contacts=Contacts(Pair(0.8, 0.4)), end=0.01,
                  more={"0.orig/U.air:boundaryField/bottom": shaking})  # fmt: skip
    case = box.make(tmp_path / "deck", grain)
    solve(case, 1)
    said = json.loads((case / "warnings.json").read_text())
    assert [w["first_time_s"] for w in said if w["name"] == "wallVelocity"] > [0]


def test_walls_may_have_a_law_of_their_own(tmp_path: Path, measured) -> None:
    wall = {**Pair(0.7).entries(), "contactLaw": "linearSpringDashpot"}
    contacts = Contacts(Pair(0.7), treatment="soft", more={"particleWall": wall})
    error, _ = bounce(tmp_path / "case", contacts)
    measured("largest relative error of the restitution", error, 1e-3)


@pytest.mark.slow
def test_grains_that_hover_along_the_wall_they_came_from_cost_little(tmp_path: Path) -> None:
    """Slip walls, no turbulence, grains around the cut: nothing drives those off the wall that
    enter there at rest, and their contact lasts. That took 13 times the processor time at 1 m/s."""
    spent = {}
    for velocity in (2.0, 1.0):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        plug_flow_cut(tmp_path / f"{velocity:g}", 4860, velocity, collide=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent[velocity] = after.ru_utime - before.ru_utime
    assert spent[1] < 4 * spent[2], spent
