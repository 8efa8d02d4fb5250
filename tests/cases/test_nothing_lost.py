"""No particle is lost, whatever the mesh, and the books close: number 1e-12, mass 1e-9."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from elutria_validation.chapters.budgets import LEDGER_ALLOWED, ledger_errors
from elutria_validation.harness.box import CLOSED, NO_DRAG, BoxCase, Contacts, Pair, cube
from elutria_validation.harness.cases import (
    CONTROL,
    MODELS,
    add_feed,
    change,
    material,
    solve,
    times,
    timing,
    uniform,
)
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.harness.programs import project_root, run_program
from tests.support import meshes

Note = Callable[[str, float, float], None]
MODELS_OF_CONTACT = ["cellList", "none"]


def closes(case: Path, measured: Note, least: int = 0) -> None:
    """The ledger closes, and at least `least` particles have left."""
    for (name, kind), error in ledger_errors(case).items():
        measured(f"{name}: {kind} missing", error, LEDGER_ALLOWED[kind])
    ledger = json.loads((case / "postProcessing/ledger.json").read_text())
    left = sum(outlet["parcels"] for outlet in ledger["total"]["outlets"].values())
    assert left >= least, f"only {left} have left"


def meshed(folder: Path, kind: str) -> Path:
    """A scene on one of the meshes, gas rising at 3 m/s everywhere and left as it is."""
    case = BoxCase(gas_velocity=3).make(folder)
    plan = {"zigzag": meshes.zigzag, "baffle": meshes.baffled}.get(kind, meshes.cylinder)
    (case / "system/blockMeshDict").write_text(plan())
    shutil.rmtree(case / "constant/polyMesh")
    shutil.rmtree(case / "0")
    for name in ("U.air", "p"):
        text = (case / "0.orig" / name).read_text()
        text = re.sub(r"\binflow\b", "bottom", text)
        text = re.sub(r"\boutflow\b", "top", text)
        (case / "0.orig" / name).write_text(text)
    run_program(["blockMesh"], case)
    if kind == "warped":
        meshes.twist(case, 0.25)
    if kind == "polyhedra":
        meshes.twist(case, 0.1)
        run_program(["polyDualMesh", "75", "-overwrite", "-concaveMultiCells"], case)
    shutil.copytree(case / "0.orig", case / "0")
    return case


def entrance(kind: str) -> str:
    """Where the feed of a mesh comes in."""
    return "patch walls" if kind == "polyhedra" else "zone entrance"  # no zone has a dual


def feed_through(
    case: Path, place: str, number: int, contacts: str, step: float = 1e-3, seconds: float = 0.05
) -> None:
    """Feed `number` of 50 to 400 um within `seconds` and let them leave."""
    mean = 2650 * np.pi / 6 * (4e-4**4 - 5e-5**4) / 4 / 3.5e-4
    add_feed(case, {"massFlowRate": float(mean * number / seconds), "particles": number,
                    "velocity": [0.3, 0.1, 0.2], "drainTime": 3,
                    "materials": uniform(2650, 5e-5, 4e-4)})  # fmt: skip
    text = (case / "constant/feed").read_text()
    (case / "constant/feed").write_text(text.replace("patch west", place))
    change(
        case,
        {**timing(step, 4), f"{CONTROL}:writeInterval": 1, f"{MODELS}/collisionModel": contacts},
    )


HARD_MESHES = pytest.mark.parametrize("kind", ["zigzag", "warped", "polyhedra", "baffle"])


@pytest.mark.parametrize("contacts", MODELS_OF_CONTACT)
@HARD_MESHES
def test_through_hard_meshes(tmp_path: Path, measured: Note, kind: str, contacts: str) -> None:
    case = meshed(tmp_path / "case", kind)
    feed_through(case, entrance(kind), 2000, contacts)
    solve(case)
    closes(case, measured, least=1000)


@pytest.mark.slow
@HARD_MESHES
def test_a_million_through_hard_meshes(tmp_path: Path, measured: Note, kind: str) -> None:
    """Without contacts: a million so close would jam, and it is the tracking that may lose one."""
    case = meshed(tmp_path / "case", kind)
    feed_through(case, entrance(kind), 1_000_000, "none", step=2e-3, seconds=1.0)
    solve(case)
    closes(case, measured, least=500_000)


@pytest.mark.slow
@pytest.mark.parametrize("contacts", MODELS_OF_CONTACT)
def test_a_million_through_the_default_column(
    tmp_path: Path, measured: Note, contacts: str
) -> None:
    case = tmp_path / "case"
    shutil.copytree(project_root() / "cases/column", case,
                    ignore=shutil.ignore_patterns("polyMesh", "[1-9]*"))  # fmt: skip
    change(
        case,
        {
            "system/simulationParameters:particles": 1_000_000,
            "system/simulationParameters:gasVelocity": 14,  # nearly all are fines: soon gone
            "system/simulationParameters:feedTime": 4,  # within 1 s they are too dense to fly
            "system/simulationParameters:drainTime": 1,
            f"{MODELS}/collisionModel": contacts,
            f"{CONTROL}:deltaT": 2e-3,
            f"{CONTROL}:maxDeltaT": 2e-3,
            f"{CONTROL}:maxCo": 10,
        },
    )
    shutil.copytree(case / "0.orig", case / "0")
    run_program(["blockMesh"], case)
    solve(case)
    closes(case, measured, least=500_000)


@pytest.mark.parametrize("processors", [1, 2])
@pytest.mark.parametrize("contacts", MODELS_OF_CONTACT)
def test_grazing_edges_corners_and_processors(
    tmp_path: Path, contacts: str, processors: int
) -> None:
    """Along cell edges, into corners, in the plane between two processors, by 1e-9 to 1e-3 rad."""
    random = np.random.default_rng(7)
    count, side, radius = 300, 0.02, 5e-6
    # lines of the grid's corners and edges, and the plane z = side/2 of the processors' patch
    place = random.integers(0, 5, (count, 3)) * side / 4
    place[::3, 2] = side / 2
    along = random.integers(0, 3, count)
    place[np.arange(count), along] = random.uniform(0.2, 0.8, count) * side
    place = np.clip(place, 1.01 * radius, side - 1.01 * radius)
    angle = 10 ** random.uniform(-9, -3, (count, 1))
    velocity = random.normal(0, 1, (count, 3)) * angle
    velocity[np.arange(count), along] += random.choice([-1.0, 1.0], count)
    velocity[::10] = random.choice([-1.0, 1.0], (len(velocity[::10]), 3))  # into the corners
    start = Particles.of(place, velocity, diameter=2 * radius)
    case = BoxCase(
        **cube(side, 4), **CLOSED, gravity=0, forces=NO_DRAG, step=2e-3, end=0.2,
        contacts=Contacts(Pair(1)) if contacts == "cellList" else None,
    ).make(tmp_path / "case", start)  # fmt: skip
    solve(case, processors)
    if processors > 1:
        run_program(["reconstructPar"], case)
    after = read_particles(case, times(case)[-1])
    assert len(after.diameter) == count
    assert np.isfinite(after.position).all()
    assert after.position.min() >= -1e-9
    assert after.position.max() <= side + 1e-9


@pytest.mark.parametrize("contacts", MODELS_OF_CONTACT)
def test_particles_larger_than_their_cells(tmp_path: Path, measured: Note, contacts: str) -> None:
    """Of 1 to 4 mm in cells of 1 mm, through gas that is solved."""
    case = BoxCase(
        gas_velocity=8, width=0.012, depth=0.012, height=0.016, cells=(12, 12, 16), coupled=True,
        contacts=Contacts() if contacts == "cellList" else None, solve_gas="auto", gas_courant=1,
        end=0.04,
    ).make(tmp_path / "case")  # fmt: skip
    add_feed(case, {"massFlowRate": 0.06, "particles": 100, "velocity": [0.5, 0, 0],
                    "drainTime": 0.1, "materials": uniform(1000, 1e-3, 4e-3)})  # fmt: skip
    solve(case)
    closes(case, measured, least=10)


def test_a_feed_on_the_faces_of_cells(tmp_path: Path, measured: Note) -> None:
    """Every particle starts in the plane between two layers of cells."""
    diameter, cells = 1e-3, 10
    width = cells * 0.5 * diameter * (1 + 1e-6)
    box = BoxCase(**cube(width, cells), gas_velocity=2, step=1e-4, end=0.05)
    case = box.make(tmp_path / "case")
    quartz = material(2650, type="fixedValue", value=diameter)
    feed = {"massFlowRate": 0.2, "particles": 1000, "drainTime": 0.02}
    add_feed(case, {**feed, "materials": quartz})
    solve(case, processors=2)
    closes(case, measured, least=400)


@pytest.mark.parametrize("contacts", MODELS_OF_CONTACT)
def test_an_outlet_that_flows_back(tmp_path: Path, measured: Note, contacts: str) -> None:
    """Gas blows in through the outlets for the particles, downwards and then upwards."""
    case = BoxCase(
        gas_velocity=4, width=0.02, depth=0.02, height=0.06, cells=(4, 4, 12), coupled=True,
        solve_gas=True, gas_courant=1, end=0.3, interval=0.1,
    ).make(tmp_path / "case")  # fmt: skip
    schemes = case / "system/fvSchemes"  # gas that comes in by the outlet needs a bounded one
    schemes.write_text(schemes.read_text().replace("U.air) Gauss linear;", "U.air) Gauss upwind;"))
    path = case / "0/U.air"
    table = "((0 (0 0 4)) (0.03 (0 0 4)) (0.04 (0 0 -4)) (0.08 (0 0 -4)) (0.09 (0 0 4)))"
    inflow = (
        f"inflow {{ type uniformFixedValue; uniformValue table {table}; value $internalField; }}"
    )
    text = re.sub(r"inflow\s*\{[^}]*\}", inflow, path.read_text())
    back = "outflow { type pressureInletOutletVelocity; phi phi.air; value $internalField; }"
    path.write_text(re.sub(r"outflow\s*\{[^}]*\}", back, text))
    feed_through(case, "patch west", 500, contacts, seconds=0.1)
    change(case, {f"{CONTROL}:endTime": 0.3, f"{CONTROL}:writeInterval": 0.1})
    solve(case)
    closes(case, measured, least=250)
