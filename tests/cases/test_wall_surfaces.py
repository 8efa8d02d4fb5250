"""Walls that particles alone meet: surfaces from files, which are no faces of the mesh."""

from __future__ import annotations

import json
import struct
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elutria_validation.harness.box import (
    CLOSED,
    NO_DRAG,
    BoxCase,
    Contacts,
    Material,
    Pair,
    Treatment,
    cube,
)  # fmt: skip
from elutria_validation.harness.cases import (
    CLOUD,
    CONTACTS,
    CONTROL,
    MODELS,
    add_feed,
    add_zone,
    change,
    read_gas,
    solve,
    times,
    uniform,
)
from elutria_validation.harness.particles import Particles, read_particles
from elutria_validation.harness.programs import run_program

Corners = list[tuple[float, float, float]]
PLATE = "constant/triSurface/plate.stl"
AT, RADIUS = 0.05, 1e-3  # m: the plate's place along x, and the spheres'
BOX = BoxCase(**CLOSED, gravity=0, forces=NO_DRAG, end=0.1, cells=(4, 4, 4))
# at the plate from both sides, far from its rim; beside it, where nothing is; at its rim
SPHERES = Particles.of(
    [(0.02, 0.05, 0.05), (0.08, 0.04, 0.06), (0.02, 0.05, 0.09), (0.03, 0.05, 0.0705)],
    [(0.5, 0, 0), (-0.5, 0, 0), (0.5, 0, 0), (0.5, 0, 0)],
    diameter=2 * RADIUS,
)


def write_stl(file: Path, triangles: list[Corners], scale: float = 1) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    lines = ["solid one"]
    for corners in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x * scale:.9g} {y * scale:.9g} {z * scale:.9g}" for x, y, z in corners]
        lines += ["endloop", "endfacet"]
    file.write_text("\n".join([*lines, "endsolid one", ""]))


def plate(x: float = AT, low: float = 0.03, high: float = 0.07) -> list[Corners]:
    """A square across x, in two triangles."""
    a, b, c, d = ((x, low, low), (x, high, low), (x, high, high), (x, low, high))
    return [[a, b, c], [a, c, d]]


def with_plate(case: Path, triangles: list[Corners] | None = None, **entries: Any) -> Path:
    """The case with the plate as a wall of that name."""
    write_stl(case / PLATE, plate() if triangles is None else triangles)
    change(case, {f"{CONTACTS}/surfaces": {"plate": {"file": f'"{PLATE}"', **entries}}})
    return case


@pytest.mark.parametrize("treatment", ["auto", "impact", "soft"])
@pytest.mark.parametrize("ranks", [1, 2])
def test_spheres_turn_at_both_sides_of_a_plate(
    tmp_path: Path, measured: Callable[..., None], treatment: Treatment, ranks: int
) -> None:
    """One radius before it, with the restitution of its own pair; beside it they fly on; at its rim
    they turn aside."""
    contacts = Contacts(
        treatment=treatment,
        particle=Material(1e10),  # Pa: a contact is short and shallow
        more={"pairs": {"particle-plate": Pair(0.5).entries()}},
    )
    case = with_plate(replace(BOX, contacts=contacts).make(tmp_path / "case", SPHERES))
    solve(case, ranks)
    if ranks > 1:
        run_program(["reconstructPar", "-latestTime"], case)
    after = read_particles(case, times(case)[-1])
    assert after.velocity[:2, 0] == pytest.approx([-0.25, 0.25], rel=1e-3)
    # 0.029 m there at 0.5 m/s, then back
    back = AT - RADIUS + after.velocity[0, 0] * (0.1 - (AT - RADIUS - 0.02) / 0.5)
    measured("place, in radii", abs(after.position[0, 0] - back) / RADIUS, 1e-2)
    assert after.position[2] == pytest.approx((0.07, 0.05, 0.09), abs=1e-9)
    assert after.velocity[3, 2] > 0.05, "turned up by the rim"


def test_a_plate_stands_still_where_another_wall_moves(tmp_path: Path) -> None:
    """Where a wall has a velocity all triangles have a motion: the plate's friction drags none."""
    case = replace(BOX, contacts=Contacts(Pair(0.5, 0.5))).make(tmp_path / "case", SPHERES)
    moving = {"type": "fixedValue", "value": [0, 1, 0]}
    change(with_plate(case), {"0/U.air:boundaryField/west": moving})
    solve(case)
    after = read_particles(case, times(case)[-1])
    assert after.velocity[0] == pytest.approx((-0.25, 0, 0), abs=1e-3)
    assert after.spin[0] == pytest.approx((0, 0, 0), abs=1e-6)


def test_a_file_in_millimetres_is_scaled(tmp_path: Path) -> None:
    case = BOX.make(tmp_path / "case", SPHERES)
    change(case, Contacts().settings())
    with_plate(case, scale=0.001)
    write_stl(case / PLATE, plate(), 1000)
    solve(case)
    assert read_particles(case, times(case)[-1]).velocity[0, 0] < 0


def test_a_blank_in_the_file_s_name_is_named(tmp_path: Path) -> None:
    """OpenFOAM ended without a word."""
    case = BOX.make(tmp_path / "case", SPHERES)
    change(case, Contacts().settings())
    change(case, {f"{CONTACTS}/surfaces": {"plate": {"file": '"constant/my plate.stl"'}}})
    done = subprocess.run(["elutriaFoam"], cwd=case, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "file: 'constant/my plate.stl' has a blank or a quote; allowed: a name" in done.stdout


def test_the_gas_flows_through(tmp_path: Path) -> None:
    """Straight and at the same pressure, as if the plate were not there."""
    fields = []
    for name in ("empty", "plate"):
        case = BoxCase(
            height=0.1, cells=(2, 2, 8), gas_velocity=1, gravity=0, solve_gas=True, end=0.02,
            contacts=Contacts(),
        ).make(tmp_path / name)  # fmt: skip
        if name == "plate":
            a, b, c, d = ((x, y, 0.051) for x, y in ((0, 0), (0.1, 0), (0.1, 0.1), (0, 0.1)))
            with_plate(case, [[a, b, c], [a, c, d]])
        solve(case)
        fields.append((read_gas(case, times(case)[-1]), read_gas(case, times(case)[-1], "p")))
    assert np.array_equal(fields[0][0], fields[1][0])
    assert np.array_equal(fields[0][1], fields[1][1])


def test_a_rain_stays_on_a_plate_and_its_ledger_closes(tmp_path: Path) -> None:
    """A plate across the whole box keeps all above it; the plan and the picture have it."""
    case = BoxCase(**cube(0.1, 4), forces=NO_DRAG, end=0.4, contacts=Contacts(Pair(0.3, 0.3))).make(
        tmp_path / "case"
    )
    across = plate(0.0, -0.01, 0.11)
    with_plate(case, [[(y, z, 0.048) for _, y, z in corners] for corners in across])
    add_zone(case, "above", (0, 0, 0.05), (0.1, 0.1, 0.1))
    add_feed(case, {"massFlowRate": 0.02, "particles": 300, "duration": 0.2, "zone": "above",
                    "materials": uniform(2650, 9e-4, 1.1e-3)})  # fmt: skip
    solve(case, options=["-frames"])
    after = read_particles(case, times(case)[-1])
    assert len(after.diameter) == 300
    assert np.all(after.position[:, 2] > 0.048 + 0.99 * after.diameter / 2)
    ledger = json.loads((case / "postProcessing/ledger.json").read_text())["total"]
    assert ledger["inside"]["parcels"] == 300
    assert ledger["lost"]["parcels"] == 0
    drawn = (case / "postProcessing/frames/boundary.obj").read_text()
    assert "g plate wall\n" in drawn
    decisions = json.loads((case / "postProcessing/plan.json").read_text())["decisions"]
    (row,) = [row for row in decisions if row[0] == "walls"]
    assert "plate" in row[1]
    assert PLATE in row[2]


def refused(case: Path) -> str:
    """The line with which elutriaFoam refuses the case, at its start."""
    done = subprocess.run(
        ["elutriaFoam"], cwd=case, capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 2, done.stdout[-500:] + done.stderr[-500:]
    (said,) = [line for line in done.stdout.splitlines() if line.startswith("elutria: failed:")]
    return said


def flat(*_: float) -> list[Corners]:
    return [[(0.05, 0.05, z) for z in (0.01, 0.02, 0.03)]]


@pytest.mark.parametrize(
    ("triangles", "entries", "said"),
    [
        (plate(), {"file": '"constant/triSurface/plato.stl"'}, "plato.stl: no such file"),
        (plate(), {"file": '"system/controlDict"'}, "system/controlDict: is of no format"),
        (flat(), {}, "plate.stl: has no triangles; allowed: a surface with an area"),
        (plate(50, 30, 70), {}, "plate.stl: lies outside of the mesh: (50 30 30) to (50 70 70) m"),
        (plate(), {"scale": 0}, "scale is 0, allowed: above 0, up to 1000000"),
        (plate(), {"scal": 0.001}, "scal is not an entry of"),
    ],
)
def test_a_surface_that_cannot_be(
    tmp_path: Path, triangles: list[Corners], entries: dict[str, Any], said: str
) -> None:
    case = replace(BOX, contacts=Contacts()).make(tmp_path / "case")
    with_plate(case, triangles, **entries)
    line = refused(case)
    assert said in line
    assert "kinematicCloudProperties" in line
    assert "allowed" in line


def test_a_triangle_without_area_is_left_out(tmp_path: Path) -> None:
    case = replace(BOX, contacts=Contacts()).make(tmp_path / "case", SPHERES)
    with_plate(case, [*flat(), *plate()])
    solve(case)
    assert read_particles(case, times(case)[-1]).velocity[0, 0] < 0


def test_a_binary_stl_may_begin_with_solid(tmp_path: Path) -> None:
    case = with_plate(replace(BOX, contacts=Contacts()).make(tmp_path / "case", SPHERES))
    triangles = plate()
    data = b"solid plate".ljust(80) + struct.pack("<I", len(triangles))
    for corners in triangles:
        data += struct.pack("<12f", 0, 0, 0, *np.ravel(corners)) + bytes(2)
    (case / PLATE).write_bytes(data)
    solve(case)
    assert read_particles(case, times(case)[-1]).velocity[0, 0] < 0


def test_a_name_that_a_patch_has(tmp_path: Path) -> None:
    case = replace(BOX, contacts=Contacts()).make(tmp_path / "case")
    write_stl(case / PLATE, plate())
    change(case, {f"{CONTACTS}/surfaces": {"west": {"file": f'"{PLATE}"'}}})
    assert "west is the name of a patch too; allowed: another name" in refused(case)


def test_a_surface_beyond_cyclic_patches(tmp_path: Path) -> None:
    case = replace(BOX, sides="cyclic", contacts=Contacts()).make(tmp_path / "case")
    with_plate(case, plate(0.05, -0.02, 0.07))
    said = refused(case)
    assert "reaches beyond the cyclic patch" in said
    assert "between the cyclic patches" in said


@pytest.mark.parametrize("kind", ["stick", "escape"])
def test_models_that_cannot_act_there(tmp_path: Path, kind: str) -> None:
    case = with_plate(replace(BOX, contacts=Contacts()).make(tmp_path / "case"))
    change(case, {f"{MODELS}/standardWallInteractionCoeffs/type": kind})
    said = refused(case)
    assert f"'{kind}' would not happen at the surface plate" in said
    change(case, {f"{MODELS}/standardWallInteractionCoeffs/type": "rebound"})
    wear = {"type": "particleErosion", "p": 1, "psi": 2, "patches": ["plate"]}
    change(case, {f"{CLOUD}:cloudFunctions/wear": wear})
    assert "would record no hit of the surface plate" in refused(case)


def test_a_run_goes_on_with_the_surface_that_it_had(tmp_path: Path) -> None:
    case = with_plate(BoxCase(end=0.01, contacts=Contacts()).make(tmp_path / "case"))
    add_feed(case, {"massFlowRate": 1e-3, "particles": 10, "duration": 1,
                    "materials": uniform(2650, 9e-4, 1.1e-3)})  # fmt: skip
    solve(case)
    change(case, {f"{CONTROL}:endTime": 0.02})
    write_stl(case / PLATE, plate(0.06))
    said = refused(case)
    assert "surfaces/plate/file" in said
    assert "SHA-1" in said
    write_stl(case / PLATE, plate())
    solve(case)
