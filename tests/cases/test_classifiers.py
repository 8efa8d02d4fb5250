"""The cases beside the column: each runs, is classified, loses nothing; none sticks in mid-air."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from math import cos, radians
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from fluids import square_edge_screen

from elutria.case.case import Case, Setting
from elutria.classification.classify import classify
from elutria.classification.events import read_run
from elutria.errors import InputError
from elutria.estimates.theory import channel_fines_share
from elutria.physics.drag import Gas, terminal_velocity
from elutria.running.run import ask_plan, make_mesh, run_case
from elutria_validation.chapters.budgets import LEDGER_ALLOWED, ledger_errors
from elutria_validation.harness.cases import times
from elutria_validation.harness.clearance import distances, read_obj, watch
from elutria_validation.harness.particles import read_particles
from elutria_validation.harness.programs import project_root

Note = Callable[[str, float, float], None]

COARSE = {
    "zigzag": {"cellSize": 0.012, "stages": 3, "feedStage": 2},
    "grating": {"cellSize": 0.01, "bars": 2, "barWidth": 0.01, "barThickness": 0.01,
                "gasVelocity": 4},
    "manganese": {"cellsWide": 4, "cellsDeep": 4, "cellsBelow": 20, "cellsSlot": 1,
                  "cellsAbove": 20},
    "hood": {"cellSize": 0.012},
    "cascade": {"cellSize": 0.012, "shelfThickness": 0.012, "shelves": 3, "feedShelf": 2},
}  # fmt: skip
"""Meshes on which a case starts in seconds; their numbers are not to be believed."""


def settings(**parameters: object) -> list[Setting]:
    return [
        Setting("system/simulationParameters", name, str(value))
        for name, value in parameters.items()
    ]


def run(name: str, folder: Path, *more: Setting, **parameters: object) -> Path:
    case = Case(project_root() / "cases" / name)
    return run_case(case, folder, [*settings(**parameters), *more]).path


def accounts_close(case: Path, measured: Note) -> None:
    for (name, kind), error in ledger_errors(case).items():
        measured(f"{name}: {kind} missing", error, LEDGER_ALLOWED[kind])
    assert json.loads((case / "postProcessing/ledger.json").read_text())["total"]["lost"] == {
        "parcels": 0, "number": 0, "mass_kg": 0
    }  # fmt: skip


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow) if n == "hood" else n for n in COARSE],
)
def test_a_case_starts_and_is_classified(tmp_path: Path, measured: Note, name: str) -> None:
    case = run(
        name, tmp_path / "run", **COARSE[name], particles=100, feedTime=0.2, drainTime=1
    )  # fmt: skip
    accounts_close(case, measured)
    said = [warned for warned in json.loads((case / "warnings.json").read_text())
            if warned["name"] == "overlap"]  # fmt: skip
    assert said == [], "contacts are stiff enough for what hits them"
    finished = read_run(case)
    tables = classify(finished, 5.0, 1.0)
    assert len(tables.summary) == len(finished.accounts)
    left = finished.events.select(finished.events.has_left)
    products = (finished.events.products[0], finished.events.partition_to)
    sizes = [np.median(left.diameter[left.outlet == name]) for name in products]
    assert sizes[0] < sizes[-1], "what leaves at the bottom is larger than what leaves at the top"


@pytest.mark.slow
def test_the_hood_stands_cells_of_two_sizes(tmp_path: Path) -> None:
    """Half the cells' size at the surface: its gas diverged with limitedLinear for k and epsilon,
    before anything was fed."""
    finer = Setting(
        "system/snappyHexMeshDict",
        "castellatedMeshControls/refinementSurfaces/hood/level", "(1 1)",
    )  # fmt: skip
    case = run(
        "hood", tmp_path / "run", finer, cellSize=0.014, particles=20, feedTime=0.02,
        drainTime=0.02,
    )  # fmt: skip
    assert "Refined mesh : cells:6394" in (case / "log.Allmesh").read_text()
    log = (case / "log.elutriaFoam").read_text()
    assert "bounding" not in log, "k and epsilon stay positive"
    assert "gasRetaken" not in (case / "warnings.json").read_text()


@pytest.mark.parametrize("name", list(COARSE))
def test_contacts_of_a_case_are_stiff_enough_for_its_gas(tmp_path: Path, name: str) -> None:
    case = Case(project_root() / "cases" / name).copy_to(
        tmp_path / "case", settings(**COARSE[name])
    )
    said = [warned for warned in ask_plan(case)["warnings"] if "overlap" in warned]
    assert said == []


def test_a_parabola_cuts_as_the_closed_form_says(tmp_path: Path, measured: Note) -> None:
    """In developed laminar flow a grain rises where the gas is faster than it falls: of those fed
    evenly across the channel that is the share sqrt(1 - v/(1.5 U))."""
    case = run("elutriator", tmp_path / "run", particles=200, drainTime=8, cellsWide=12)
    accounts_close(case, measured)
    events = read_run(case).events
    left = events.select(events.has_left)
    # the others hover: near the cut a grain is as fast as the gas somewhere
    assert len(left) > 0.75 * len(events)
    gas = Gas(1.2, 1.8e-5)
    falls = np.array([terminal_velocity(d, 2650, gas, gravity=9.81) for d in events.diameter])
    share = channel_fines_share(falls, 0.1)
    rises, inside = np.sum(events.outlet == "fines"), np.sum(~events.has_left)
    spread = 4 * float(np.sqrt(np.sum(share * (1 - share))))
    measured("to fines less than expected", share.sum() - (rises + inside), spread)
    measured("to fines more than expected", rises - share.sum(), spread)
    # what no gas of this channel lifts
    assert np.all(left.outlet[left.diameter > 45e-6] == "coarse")


@pytest.mark.parametrize("stages", [1, 2, 15])
def test_the_zigzag_is_what_its_parameters_say(tmp_path: Path, stages: int) -> None:
    """Its volume is that of all level sections, its height that of stages and ends."""
    folder = tmp_path / "case"
    case = Case(project_root() / "cases/zigzag").copy_to(
        folder, settings(stages=stages, feedStage=1, cellSize=0.01)
    )
    make_mesh(case)
    log = (folder / "log.Allmesh").read_text()
    height = 0.06 + 0.04 + stages * 0.05 * cos(radians(30))
    box = log.split("boundingBox:")[1].splitlines()[0]
    assert float(box.split()[-1].rstrip(")")) == pytest.approx(height)
    said = subprocess.run(["checkMesh"], cwd=folder, capture_output=True, text=True, check=False)
    volume = float(said.stdout.split("Total volume = ")[1].split()[0].rstrip("."))
    assert volume == pytest.approx(0.04 / cos(radians(30)) * 0.05 * height, rel=1e-6)
    assert "Mesh OK" in said.stdout


def test_the_hood_is_what_its_surface_says(tmp_path: Path) -> None:
    """snappyHexMesh fills the surface: its volume is that of the cylinder and the ducts up to it,
    its openings have their areas, and it has no patch else."""
    folder = tmp_path / "case"
    case = Case(project_root() / "cases/hood").copy_to(folder, settings(cellSize=0.008))
    make_mesh(case)
    said = subprocess.run(
        ["checkMesh"], cwd=folder, capture_output=True, text=True, check=False
    ).stdout
    assert "Mesh OK" in said
    volume = float(said.split("Total volume = ")[1].split()[0].rstrip("."))
    radius, end = 0.05, 0.08

    def duct(low: float, high: float, tall: float) -> float:
        """From the cylinder's wall out to the end, between two distances from the axis."""
        across = np.linspace(low, high, 1001)
        return tall * float(np.trapezoid(end - np.sqrt(radius**2 - across**2), across))

    ducts = duct(-0.02, 0.02, 0.04) + duct(0.025, 0.05, 0.04) + duct(-0.02, 0.02, 0.03)
    # 2 %: a circle by cells of a twelfth of its diameter, and rounded edges
    assert volume == pytest.approx(np.pi * radius**2 * 0.4 + ducts, rel=0.02)
    boundary = (folder / "constant/polyMesh/boundary").read_text(errors="replace")
    for name in ("walls", "bottom", "top", "sideInlet", "tangentialInlet", "sideOutlet"):
        assert f"    {name}\n" in boundary, name
    assert boundary.count("nFaces") == 6


@pytest.mark.parametrize(
    "name, entry, value, allowed",
    [
        ("zigzag", "stages", 0, "stages: 0; allowed: a finite number >= 1 and <= 15"),
        ("zigzag", "stages", 16, "stages: 16; allowed"),
        ("zigzag", "stages", 2.5, "stages: 2.5; allowed: a whole number from 1 to 15"),
        ("zigzag", "feedStage", 8, "feedStage: 8; allowed: a finite number >= 1 and <= 7"),
        ("zigzag", "cellSize", 0, "cellSize: 0; allowed"),
        ("zigzag", "channelDepth", 0.001, "channelDepth: 0.001; allowed"),
        ("grating", "barWidth", 0.002, "barWidth: 0.002; allowed: a finite number >= 0.005"),
        ("grating", "barWidth", 0.016, "barWidth: 0.016; allowed"),
        ("grating", "barThickness", 0.002, "barThickness: 0.002; allowed: at least cellSize"),
        ("grating", "gratingModel", "porus", "gratingModel: porus; allowed: resolved | porous"),
        ("grating", "gratingHeights", "(0.24)", "allowed: gratings of 0.01 m, each clear of"),
        ("hood", "topRadius", 0.05, "topRadius: 0.05; allowed: below radius, 0.05 m"),
        ("hood", "sideOutletAt", 0.14, "sideOutletAt: 0.14; allowed: clear of the side inlet"),
        ("hood", "tangentialInletHeight", 0.5, "tangentialInletHeight: 0.5; allowed"),
        ("cascade", "shelfSpacing", 0.02, "shelfSpacing: 0.02; allowed: at least"),
        ("cascade", "shelfReach", 0.08, "shelfReach: 0.08; allowed"),
    ],
)
def test_a_geometry_that_cannot_be(
    tmp_path: Path, name: str, entry: str, value: object, allowed: str
) -> None:
    with pytest.raises(InputError, match="simulationParameters") as refused:
        run(name, tmp_path / "run", **{entry: value})
    assert allowed in str(refused.value)
    assert "\n" not in str(refused.value)


def thick_edged_grid(free: float, thickness: float, gap: float) -> float:
    """Loss coefficient, of the velocity before it, of a grid of edges as thick as that (m), with
    openings of a hydraulic diameter `gap` (m) that leave a share `free` open: Idelchik, Handbook of
    Hydraulic Resistance, chapter 8, grids with thick-edged orifices, without friction."""
    over = thickness / gap
    tau = (2.4 - over) * 10 ** -(0.25 + 0.535 * over**8 / (0.05 + over**7))
    shut = 1 - free
    return (0.5 * shut**0.75 + tau * shut**1.375 + shut**2) / free**2


def gas_pressure(case: Path) -> float:
    """Mean pressure (Pa) at the inlet, over the outlet's."""
    files = (case / "postProcessing/gas").glob("*/gas.csv")
    flows = pd.concat([pd.read_csv(file) for file in files])
    return float(flows[flows["patch"] == "bottom"]["pressure_pa"].mean())


@pytest.mark.slow
def test_a_grating_costs_the_pressure_that_bars_cost(tmp_path: Path, measured: Note) -> None:
    """One grating more: two crossed layers of bars, each of which leaves 0.7 open, and together
    0.49. Of the handbooks, layers for themselves lose least, one grid of both most."""
    velocity, density, both = 6.0, 1.2, "(0.15 0.35)"
    pressures = []
    for heights, model in (("(0.35)", "resolved"), (both, "resolved"), (both, "porous")):
        case = run(
            "grating", tmp_path / f"{model}{heights}",
            Setting("system/controlDict", "writeInterval", "0.1"), gratingModel=model,
            gratingHeights=heights, particles=20, feedTime=0.5, drainTime=0.3, loading=1e-6,
        )  # fmt: skip
        pressures.append(gas_pressure(case))
    loss = (pressures[1] - pressures[0]) / (density / 2 * velocity**2)
    gap = (0.05 - 3 * 0.005) / 3
    slit = 2 * gap * 0.05 / (gap + 0.05)
    layers = 2 * thick_edged_grid(0.7, 0.005, slit)
    # the same by another handbook: Blevins 1984, screens of square bars
    assert layers == pytest.approx(2 * square_edge_screen(0.7), rel=0.05)
    grid = thick_edged_grid(0.49, 0.01, gap)
    measured("loss over that of the layers, least", layers / loss, 1.25)
    measured("loss over that of the grid, most", loss / grid, 1.25)
    measured("porous bars' pressure", abs(pressures[2] / pressures[1] - 1), 0.03)


def test_particles_meet_the_bars_that_the_gas_has_as_a_porosity(
    tmp_path: Path, measured: Note
) -> None:
    """The layers take the pressure that the case asks for; some grains are on a bar, none in it."""
    loss, pressures = 3.0, []
    for share in (1, 2):
        case = run(
            "grating", tmp_path / str(share), Setting("system/controlDict", "writeInterval", "0.1"),
            Setting("system/controlDict", "writeFormat", "ascii"),
            Setting("system/controlDict", "purgeWrite", "0"),
            **COARSE["grating"], gratingModel="porous", gratingLoss=loss * share,
            particles=300, feedTime=0.3, drainTime=1, loading=1e-3,
        )  # fmt: skip
        pressures.append(gas_pressure(case))
    # two gratings of 1.2 kg/m3 at 4 m/s
    expected = 2 * loss * 1.2 / 2 * 4**2
    measured("pressure of the gratings", (pressures[1] - pressures[0]) / expected - 1, 0.02)
    accounts_close(case, measured)
    bars = read_obj(case / "constant/polyMesh/bars.obj")
    found = watch(case, [name for name in times(case)[1:] if len(name) <= 3], [bars])
    measured("deepest in a wall, of the radius", found.deepest, 0.01)
    measured("at rest in mid-air", found.hanging, 0)
    touched = 0
    for name in times(case)[1:]:
        cloud = read_particles(case, name)
        gap = distances(cloud.position, bars) - cloud.diameter / 2
        touched += int(np.sum(gap < 0.05 * cloud.diameter / 2))
        for x in (0.0125, 0.0375):  # two bars of 10 mm along each direction
            for across, low in ((0, 0.15), (0, 0.35), (1, 0.16), (1, 0.36)):
                inside = np.abs(cloud.position[:, across] - x) < 0.005
                inside &= np.abs(cloud.position[:, 2] - low - 0.005) < 0.005
                assert not inside.any()
    assert touched > 0


def test_allrun_makes_the_mesh_too(tmp_path: Path) -> None:
    """A user's own way: what the case's Allrun runs, up to the solver."""
    case = tmp_path / "zigzag"
    shutil.copytree(project_root() / "cases/zigzag", case)
    subprocess.run(["./Allmesh"], cwd=case, check=True, capture_output=True)
    assert (case / "constant/polyMesh/owner").is_file()
    assert "./Allmesh" in (case / "Allrun").read_text()
    assert not (case / "system/blockMeshDict").exists(), "a run's fingerprint must not change"


@pytest.mark.slow
@pytest.mark.parametrize("name", list(COARSE))
def test_none_is_outside_and_none_hangs_in_mid_air(
    tmp_path: Path, measured: Note, name: str
) -> None:
    case = run(
        name, tmp_path / "run",
        Setting("system/controlDict", "writeFormat", "ascii"),
        Setting("system/controlDict", "writeInterval", "0.1"),
        Setting("system/controlDict", "purgeWrite", "0"),
        **{**COARSE[name], "cellSize": 0.008} if name == "zigzag" else COARSE[name],
        particles=600, feedTime=0.5, drainTime=1.5,
    )  # fmt: skip
    accounts_close(case, measured)
    # each 0.1 s
    found = watch(case, [name for name in times(case)[1:] if len(name) <= 3])
    assert found.particles > 0
    measured("deepest in a wall, of the radius", found.deepest, 0.01)
    measured("at rest in mid-air", found.hanging, 0)
