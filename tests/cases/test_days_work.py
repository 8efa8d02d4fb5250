"""A day's work of a new user, from README and docs/user alone: copies of cases that are changed by
hand, checked and run with `elutria`. Of each change a number says that it acted, and what is named
as not used is what the user expects."""

from __future__ import annotations

import csv
import itertools
import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from math import cos, pi, radians, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elutria_validation.harness.cases import cell_centres, read_gas, times
from elutria_validation.harness.particles import read_particles
from elutria_validation.harness.programs import project_root
from elutria_validation.references.drag import cut_size

pytestmark = pytest.mark.slow

HEAD = "FoamFile {{ version 2.0; format ascii; class dictionary; object {}; }}\n"
FEW = {"particles": 200, "feedTime": 0.2, "drainTime": 2.5}
SIDE, HEIGHT, SPEED = 0.05, 0.5, 6.0
"""The default column: its sides and height (m), its gas (m/s)."""
CELL = 0.01


def replace(case: Path, file: str, *pairs: tuple[str, str]) -> None:
    """As an editor's search and replace, by regular expressions that must be found."""
    text = (case / file).read_text()
    for pattern, new in pairs:
        text, found = re.subn(pattern, new, text)
        assert found, f"{file}: {pattern}"
    (case / file).write_text(text)


def put(case: Path, file: str, text: str, executable: bool = False) -> None:
    (case / file).write_text(text if executable else HEAD.format(Path(file).name) + text)
    if executable:
        (case / file).chmod(0o755)


def copied(name: str, folder: Path, **parameters: object) -> Path:
    """The user's copy of a case, with a feed that takes seconds, written as text."""
    case = folder / "mine"
    shutil.copytree(project_root() / "cases" / name, case)
    shutil.rmtree(case / "constant/polyMesh", ignore_errors=True)
    replace(case, "system/simulationParameters",
            *[(rf"(?m)^{entry} .*$", f"{entry} {value};")
              for entry, value in {**FEW, **parameters}.items()])  # fmt: skip
    replace(case, "system/controlDict", ("binary;", "ascii;"))
    return case


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    """A copy of the default column on cells of 10 mm."""
    case = copied("column", tmp_path)
    replace(
        case, "system/blockMeshDict", (r"\(10 10 49\)", "(5 5 25)"), (r"\(10 10 2\)", "(5 5 1)")
    )
    return case


@dataclass(frozen=True)
class Run:
    """A case after `elutria check` and `elutria run`."""

    path: Path
    checked: str

    def rows(self, table: str) -> list[dict[str, str]]:
        with (self.path / table).open() as file:
            return list(csv.DictReader(file))

    def cuts(self) -> dict[str, float]:
        """d50 of each material (m)."""
        return {row["material"]: float(row["d50_m"]) for row in self.rows("summary.csv")}

    def gas(self, patch: str, column: str) -> float:
        (row,) = [row for row in self.rows("gas.csv") if row["patch"] == patch]
        return float(row[column])

    def pressure(self) -> float:
        """From bottom to top, over density (m2/s2)."""
        return self.gas("bottom", "pressure_pa") / 1.2 - self.gas("top", "pressure_pa") / 1.2

    def ledger(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads((self.path / "postProcessing/ledger.json").read_text())
        return found

    def decisions(self) -> list[list[str]]:
        plan = json.loads((self.path / "postProcessing/plan.json").read_text())
        return [list(row) for row in plan["decisions"]]

    def named(self) -> set[str]:
        """What the solver says that it does not use."""
        return {what for kind, what, _ in self.decisions() if kind in ("not used", "not counted")}

    def cells(self, name: str) -> np.ndarray:
        return read_gas(self.path, times(self.path)[-1], name)


def elutria(*arguments: object) -> str:
    done = subprocess.run(["elutria", *map(str, arguments)], capture_output=True, text=True,
                          check=False, env={**os.environ, "COLUMNS": "200"})  # fmt: skip
    assert done.returncode == 0, done.stdout[-1500:] + done.stderr[-1500:]
    return done.stdout


def worked(case: Path, *unused: str) -> Run:
    """Check it and run it. All of it ends well, nothing is lost, and `unused` alone is named."""
    checked = elutria("check", case)
    folder = case.parent / "results"
    elutria("run", case, "--to", folder)
    run = Run(folder, checked)
    assert run.named() == set(unused)
    for name in unused:
        assert Path(name).name in checked
    total = run.ledger()["total"]
    assert total["lost"]["parcels"] == 0
    assert total["mass_closure_error"] < 1e-12
    return run


def free_cut(density: float) -> float:
    return cut_size(SPEED, density, 9.81)


def test_another_material(mine: Path, measured: Any) -> None:
    replace(mine, "constant/feed", ("density +2650;", "density 7800;"), ("quartz", "shot"),
            ("900e-6", "400e-6"), ("300e-6", "100e-6"), ("2000e-6", "900e-6"))  # fmt: skip
    run = worked(mine)
    measured("cut beside free fall's", abs(run.cuts()["shot"] / free_cut(7800) - 1), 0.1)


THREE = {"coal": (1350, 0.2), "quartz": (2650, 0.5), "pyrite": (5000, 0.3)}
"""Density (kg/m3) and share of the mass of each."""


def test_three_materials(mine: Path, measured: Any) -> None:
    materials = "".join(
        f"{name} {{ density {density}; massFraction {share}; sizeDistribution {{ type uniform;"
        f" min {0.5 * free_cut(density):.6g}; max {1.8 * free_cut(density):.6g}; }} }}\n"
        for name, (density, share) in THREE.items()
    )
    replace(mine, "constant/feed", (r"(?s)materials\n\{.*\Z", f"materials {{ {materials} }}\n"))
    replace(mine, "system/simulationParameters", (r"(?m)^particles .*", "particles 450;"))
    run = worked(mine)
    fed = {name: material["injected"]["mass_kg"]
           for name, material in run.ledger()["materials"].items()}  # fmt: skip
    for name, (density, share) in THREE.items():
        measured(f"{name}: share of the feed", abs(fed[name] / sum(fed.values()) - share), 1e-9)
        assert str(density) in run.checked
        measured(f"{name}: cut", abs(run.cuts()[name] / free_cut(density) - 1), 0.12)


BARS = [(0.01, 0.02), (0.03, 0.04)]
"""Across the column along y, from and to (m); they leave three slits of 10 mm."""
LOW, HIGH = 0.3 - 0.0063, 0.3 + 0.0063


def test_a_grating_in_a_mesh_of_ones_own(mine: Path, measured: Any) -> None:
    """Cells are taken out of what blockMesh makes, by hand and once; blockMeshDict stays there."""
    boxes = " ".join(
        f"{{ name free; type cellSet; action subtract; source boxToCell;"
        f" box ({a} -1 {LOW}) ({b} 1 {HIGH}); }}" for a, b in BARS
    )  # fmt: skip
    put(mine, "system/topoSetDict", "actions ( { name free; type cellSet; action new; source"
        f" boxToCell; box (-1 -1 -1) (1 1 1); }} {boxes} );")  # fmt: skip
    for command in ("blockMesh", "topoSet", "subsetMesh -overwrite free -patch walls"):
        subprocess.run(command.split(), cwd=mine, check=True, capture_output=True)
    run = worked(mine)
    assert "constant/polyMesh, as it is" in run.checked
    centres, _ = cell_centres(run.path)
    slits = np.abs(centres[:, 2] - 0.3) < 0.5 * (HIGH - LOW)
    assert np.unique(np.round(centres[slits, 0], 4)).tolist() == [0.005, 0.025, 0.045]
    speed = run.cells("U.air")[slits, 2].mean()
    measured("gas between the bars", abs(speed / (SPEED / 0.6) - 1), 0.01)


def test_a_zigzag(tmp_path: Path, measured: Any) -> None:
    stages, speed = 3, 5
    case = copied("zigzag", tmp_path, stages=stages, feedStage=2, cellSize=0.012,
                  gasVelocity=speed)  # fmt: skip
    run = worked(case)
    section = 0.04 / cos(radians(30)) * 0.05  # level, of a channel that leans by 30 degrees
    measured("section", abs(run.gas("all", "area_m2") / section - 1), 0.01)
    measured("gas", abs(run.gas("all", "velocity_m_s") / speed - 1), 0.01)
    left = run.ledger()["total"]["outlets"]
    assert left["fines"]["parcels"] > 10
    assert left["coarse"]["parcels"] > 10


RADIUS = 0.03


def tube(file: Path, around: int = 48) -> None:
    """A cylinder as drawn: three solids of an STL in ASCII."""
    angles = [2 * pi * n / around for n in range(around + 1)]
    rim = [(RADIUS * cos(a), RADIUS * sin(a)) for a in angles]
    solids: dict[str, list[Any]] = {"shell": [], "bottom": [], "top": []}
    for (x, y), (u, v) in itertools.pairwise(rim):
        solids["bottom"].append([(0, 0, 0), (u, v, 0), (x, y, 0)])
        solids["top"].append([(0, 0, HEIGHT), (x, y, HEIGHT), (u, v, HEIGHT)])
        solids["shell"] += [[(x, y, 0), (u, v, 0), (u, v, HEIGHT)],
                            [(x, y, 0), (u, v, HEIGHT), (x, y, HEIGHT)]]  # fmt: skip
    file.write_text("".join(
        f"solid {name}\n" + "".join(
            "facet normal 0 0 0\nouter loop\n"
            + "".join(f"vertex {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in corners)
            + "endloop\nendfacet\n" for corners in triangles
        ) + f"endsolid {name}\n" for name, triangles in solids.items()
    ))  # fmt: skip


def test_a_cylinder_of_an_stl(mine: Path, measured: Any) -> None:
    """The recipe of cases/hood, with Allmesh, and a feed in a cell zone on the axis."""
    (mine / "constant/triSurface").mkdir()
    tube(mine / "constant/triSurface/tube.stl")
    put(mine, "system/blockMeshDict", "scale 1; vertices ((-0.035 -0.035 -0.01) (0.035 -0.035"
        " -0.01) (0.035 0.035 -0.01) (-0.035 0.035 -0.01) (-0.035 -0.035 0.51) (0.035 -0.035 0.51)"
        " (0.035 0.035 0.51) (-0.035 0.035 0.51)); blocks (hex (0 1 2 3 4 5 6 7) (10 10 74)"
        " simpleGrading (1 1 1)); edges (); boundary (); mergePatchPairs ();")  # fmt: skip
    shutil.copy(project_root() / "cases/hood/system/snappyHexMeshDict", mine / "system")
    open_ends = "".join(f"{end} {{ level (0 0); patchInfo {{ type patch; }} }} "
                        for end in ("bottom", "top"))  # fmt: skip
    replace(mine, "system/snappyHexMeshDict",
            (r'#include "simulationParameters"', ""),
            (r"(?s)geometry\n\{.*?\n\}\n", "geometry { tube.stl { type triSurfaceMesh; name tube;"
             " regions { shell { name walls; } bottom { name bottom; } top { name top; } } } }\n"),
            (r"\$inside", "(0.001 0.002 0.1)"),
            (r"(?s)refinementSurfaces\n    \{.*?\n    \}\n",
             f"refinementSurfaces {{ tube {{ level (0 0); regions {{ {open_ends} }}"
             " patchInfo { type wall; } } }\n"))  # fmt: skip
    put(mine, "system/topoSetDict", "actions ( { name feed; type cellSet; action new; source"
        " boxToCell; box (-0.012 -0.012 0.24) (0.012 0.012 0.26); } { name feed; type cellZoneSet;"
        " action new; source setToCellZone; set feed; } );")  # fmt: skip
    put(mine, "Allmesh", '#!/bin/bash\ncd "${0%/*}" || exit 1\n'
        "blockMesh && snappyHexMesh -overwrite && topoSet\n", executable=True)  # fmt: skip
    replace(mine, "constant/feed", ("patch +feedSlot;", "zone feed;"),
            (r"velocity +\([^)]*\);", "velocity (0 0 0);"))  # fmt: skip
    run = worked(mine)
    assert (run.path / "log.Allmesh").is_file()
    section = pi * RADIUS**2
    measured("section", abs(run.gas("all", "area_m2") / section - 1), 0.03)
    measured("gas", abs(run.gas("all", "volume_flow_m3_s") / (SPEED * section) - 1), 0.03)
    # along the axis the gas is faster than on average
    assert 1 < run.cuts()["quartz"] / free_cut(2650) < 1.4


def test_another_turbulence(mine: Path, measured: Any) -> None:
    """kOmegaSST: omega is there instead of epsilon. In the cells at walls it is sqrt(k) over
    Cmu^(1/4) kappa y, Menter's logarithmic law."""
    replace(mine, "constant/turbulenceProperties.air", ("kEpsilon", "kOmegaSST"))
    shutil.copy(mine / "0.orig/epsilon.air", mine / "0.orig/omega.air")
    replace(mine, "0.orig/omega.air", (r"epsilon\.air", "omega.air"), ("2 -3 ", "0 -1 "),
            ("2.3;", "190;"), ("turbulentMixingLengthDissipationRateInlet",
                               "turbulentMixingLengthFrequencyInlet"),
            ("epsilonWallFunction", "omegaWallFunction"))  # fmt: skip
    run = worked(mine, "0/epsilon.air")
    centres, _ = cell_centres(run.path)
    x, y = centres[:, 0], centres[:, 1]
    at_west = (x < CELL) & (np.abs(y - SIDE / 2) < 2 * CELL) & (centres[:, 2] > 0.3)
    assert at_west.sum() > 20
    k, omega = run.cells("k.air")[at_west, 0], run.cells("omega.air")[at_west, 0]
    law = np.sqrt(k) / (0.09**0.25 * 0.41 * CELL / 2)
    measured("omega at the wall", float(np.abs(omega / law - 1).max()), 0.02)
    measured("cut beside free fall's", abs(run.cuts()["quartz"] / free_cut(2650) - 1), 0.15)


RESISTANCE = 300.0
"""Forchheimer's, 1/m."""


def test_a_porous_screen(mine: Path, measured: Any) -> None:
    free = worked(mine).pressure()
    shutil.rmtree(mine.parent / "results")
    put(mine, "system/topoSetDict", "actions ( { name screen; type cellSet; action new; source"
        " boxToCell; box (-1 -1 0.4) (1 1 0.44); } { name screen; type cellZoneSet; action new;"
        " source setToCellZone; set screen; } );")  # fmt: skip
    put(mine, "Allmesh", '#!/bin/bash\ncd "${0%/*}" || exit 1\nblockMesh && topoSet\n',
        executable=True)  # fmt: skip
    put(mine, "constant/fvOptions", "screen { type explicitPorositySource;"
        " explicitPorositySourceCoeffs { selectionMode cellZone; cellZone screen; U U.air; type"
        f" DarcyForchheimer; DarcyForchheimerCoeffs {{ d (0 0 0); f ({RESISTANCE} {RESISTANCE}"
        f" {RESISTANCE}); coordinateSystem {{ origin (0 0 0); e1 (1 0 0); e2 (0 1 0); }} }} }} }}"
    )  # fmt: skip
    run = worked(mine)
    thickness = 4 * 0.245 / 25  # its cells
    expected = 0.5 * RESISTANCE * SPEED**2 * thickness
    measured("pressure of the screen", abs((run.pressure() - free) / expected - 1), 0.02)


SHAKES, DECK = 5.0, 0.05
"""Per second, and the deck's fastest (m/s)."""


def test_a_deck_that_shakes(mine: Path, measured: Any) -> None:
    """The bottom is a deck, and the gas comes in at its side. A sphere that rolls on a plate which
    moves by V(t) moves by 2/7 of it."""
    replace(mine, "system/blockMeshDict",
            (r"bottom ( +// gas)", r"airInlet\1"), (r"faces \(\(0 3 2 1\)\);",
             "faces ((0 4 7 3));\n    }\n    deck\n    {\n        type wall;\n"
             "        faces ((0 3 2 1));"), (r"\(0 4 7 3\)  \(8", "(8"))  # fmt: skip
    for file in (mine / "0.orig").iterdir():
        replace(mine, f"0.orig/{file.name}", ("bottom", "airInlet"),
                ('"walls.feedSlot"', '"walls|feedSlot|deck"'))  # fmt: skip
    replace(mine, "0.orig/U.air",
            (r"value +uniform \(0 0 \$gasVelocity\);",
             "value uniform (#eval{ $gasVelocity*50/245 } 0 0);"),
            (r'"walls.feedSlot.deck"', "deck\n    {\n        type uniformFixedValue;\n"
             f"        uniformValue sine; uniformValueCoeffs {{ frequency {SHAKES}; amplitude 1;"
             f" scale ({DECK} 0 0); level (0 0 0); }}\n        value uniform (0 0 0);\n    }}\n"
             '    "walls|feedSlot"'))  # fmt: skip
    replace(
        mine,
        "constant/feed",
        ("coarse +.bottom.;", "coarse (airInlet);"),
        (r"velocity +\([^)]*\);", "velocity (0 0 0);"),
        (r"focus +auto;", ""),
        (r"loading +\$loading;", "massFlowRate 1e-3;"),
        (r"(?s)sizeDistribution\s*\{.*?\}", "sizeDistribution { type fixedValue; value 2e-3; }"),
    )
    replace(mine, "constant/kinematicCloudProperties", (r"restitution 0\.8", "restitution 0.1"))
    replace(mine, "system/simulationParameters", (r"(?m)^gasVelocity .*", "gasVelocity 0.1;"),
            (r"(?m)^parcels .*", "parcels particles;"), (r"(?m)^particles .*", "particles 8;"),
            (r"(?m)^feedTime .*", "feedTime 0.1;"))  # fmt: skip
    replace(
        mine,
        "system/controlDict",
        (r"endTime +20;", "endTime 1;"),
        (r"writeInterval +0\.5;", "writeInterval 0.02;"),
        (r"purgeWrite +2;", "purgeWrite 0;"),
    )
    run = worked(mine)
    clock = [time for time in times(run.path) if float(time) > 0.59]
    seen = [read_particles(run.path, time) for time in clock]
    (number,) = {len(p.diameter) for p in seen}  # none has left since
    lying = [one for one in range(number) if all(p.position[one, 2] < 1.1e-3 for p in seen)]
    assert len(lying) >= 4
    t = np.array([float(time) for time in clock])
    swing = 2 * pi * SHAKES * t
    columns = np.stack([np.ones_like(t), t, np.sin(swing), np.cos(swing)], axis=1)
    shares = []
    for one in lying:
        along = np.array([p.velocity[one, 0] for p in seen])
        _, _, sine, cosine = np.linalg.lstsq(columns, along, rcond=None)[0]
        shares.append(np.hypot(sine, cosine) / DECK)
    measured("of 2/7 of the deck's velocity", abs(float(np.median(shares)) * 7 / 2 - 1), 0.01)


SHARES = {"left": 0.1, "right": 0.05}
"""Of the gas, through two outlets at the sides."""


def test_two_more_outlets(mine: Path, measured: Any) -> None:
    replace(mine, "system/blockMeshDict",
            (r"  \(8 12 15 11\)\n", "\n"), (r"  \(9 10 14 13\)\n", "\n"),
            (r"    walls\n", "    left { type patch; faces ((8 12 15 11)); }\n"
             "    right { type patch; faces ((9 10 14 13)); }\n    walls\n"))  # fmt: skip
    for file in (mine / "0.orig").iterdir():
        replace(mine, f"0.orig/{file.name}", (r"(?m)^    top\n", '    "top|left|right"\n')
                if file.name != "nut.air" else ("top.bottom", "top|left|right|bottom"))  # fmt: skip
    flow = SPEED * SIDE**2
    sides = "".join(
        f"    {name} {{ type flowRateOutletVelocity; volumetricFlowRate {share * flow:.6g};"
        " value uniform (0 0 0); }\n" for name, share in SHARES.items()
    )  # fmt: skip
    replace(mine, "0.orig/U.air", ('    "top.left.right"', f"{sides}    top"))
    replace(
        mine,
        "0.orig/p",
        ('"top.left.right"', "top"),
        (r"    bottom\n", '    "bottom|left|right"\n'),
    )
    replace(mine, "constant/feed", ("coarse +.bottom.;", "dust (left); middlings (right);"
                                    " coarse (bottom);"))  # fmt: skip
    run = worked(mine)
    for name, share in SHARES.items():
        found = -run.gas(name, "volume_flow_m3_s")
        measured(f"gas through {name}", abs(found / (share * flow) - 1), 0.01)
    out = run.ledger()["total"]["outlets"]
    assert set(out) == {"fines", "dust", "middlings", "coarse"}
    assert all(out[name]["parcels"] > 0 for name in ("dust", "middlings", "coarse"))
    assert {row["product"] for row in run.rows("products.csv")} >= set(out)
