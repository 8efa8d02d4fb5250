"""Drag that depends on more than a sphere's Re: measured velocities, axes, the mean size around."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from elutria.case.case import Case, Setting
from elutria.errors import ElutriaError
from elutria.physics.drag import drag_coefficient
from elutria.running.run import plans, run_case
from elutria_validation.harness.box import WEIGHTLESS, BoxCase, cube
from elutria_validation.harness.cases import CLOUD, solve, times
from elutria_validation.harness.particles import Particles, lattice, read_particles
from elutria_validation.harness.programs import project_root
from elutria_validation.references.drag import AIR

Note = Callable[[str, float, float], None]

GAS = 0.01  # m/s, upward
MATERIAL = """
{name}
{{
    density         998;
    massFraction    {share};
    {shape}
    sizeDistribution {{ type fixedValue; value {size}; }}
}}
"""


def column(folder: Path, drag: str, materials: str) -> Case:
    """The column with gas that does not change and little of it."""
    case = Case(project_root() / "cases/column").copy_to(folder, [])
    feed, cloud = case.path / "constant/feed", case.path / "constant/kinematicCloudProperties"
    text = feed.read_text()
    feed.write_text(text[: text.index("materials")] + "materials\n{" + materials + "}\n")
    text = re.sub("dispersionModel .*;", "dispersionModel none;", cloud.read_text())
    text = re.sub("collisionModel .*;", "collisionModel none;", text)
    text = re.sub("coupled .*true;", "coupled false;", text)
    cloud.write_text(text.replace("SchillerNaumannDrag;", drag))
    return case


def run(case: Case, folder: Path) -> Path:
    settings = {
        "system/simulationParameters": {"gasVelocity": GAS, "particles": 40, "feedTime": 0.1,
                                        "drainTime": 3},
        "system/scenePlan": {"gas": "off", "convergeGas": "off"},
        "constant/feed": {"focus": "none", "velocity": "(0 0 0)"},
    }  # fmt: skip
    return run_case(
        case, folder,
        [Setting(file, name, str(value)) for file, entries in settings.items()
         for name, value in entries.items()],
    ).path  # fmt: skip


def leaving_speed(run: Path) -> dict[str, float]:
    """m/s, downward, by material."""
    (file,) = run.glob("postProcessing/outlets/*/particles.csv")
    rows = pd.read_csv(file)
    return {str(name): -float(v) for name, v in rows.groupby("material")["uz_m_s"].median().items()}


def test_grains_of_measured_sizes_settle_as_measured(tmp_path: Path, measured: Note) -> None:
    told = {1e-4: 0.2, 2e-4: 0.5}
    own = 'measuredVelocity { file "constant/velocities.csv"; }'
    names = {size: f"grains{number}" for number, size in enumerate((1e-4, 1.4e-4, 2e-4, 2.5e-4))}
    case = column(tmp_path / "case", "MeasuredVelocityDrag;", "".join(
        MATERIAL.format(name=name, share=0.25, shape=own, size=size) for size, name in names.items()
    ))  # fmt: skip
    rows = [f"{size * 1e3},{velocity}" for size, velocity in told.items()]
    (case.path / "constant/velocities.csv").write_text(
        "\n".join(["diameter_mm,velocity_m_s", *rows])
    )
    found = run(case, tmp_path / "run")
    speed = leaving_speed(found)
    falls = {size: GAS + speed[name] for size, name in names.items()}
    # 2e-3: of the last exponential of a fall of a quarter of a metre
    for size, velocity in told.items():
        measured(f"{size} m settles otherwise", abs(falls[size] / velocity - 1), 2e-3)
    assert told[1e-4] < falls[1.4e-4] < told[2e-4] < falls[2.5e-4] < 0.7
    assert (
        "grains3 has sizes of which no velocity was measured"
        in (found / "warnings.json").read_text()
    )


@pytest.mark.parametrize(
    ("drag", "shape", "said"),
    [
        ("BagheriBonadonnaDrag;", "sphericity 0.8;", "allowed with BagheriBonadonnaDrag: flatness"),
        ("MeasuredVelocityDrag;", "", "dust has no measuredVelocity, which MeasuredVelocityDrag"),
        ("SchillerNaumannDrag;", "sphericity 0.6;", "dust has sphericity 0.6, which Schiller"),
        ("sphereDrag;", "flatness 0.5; elongation 0.5;", "which sphereDrag does not take"),
        ("nonSphereDrag { phi 0.7; }", "sphericity 0.6;", "which nonSphereDrag does not take"),
        ("WenYuDrag { alphac alpha.air; }", "sphericity 0.6;", "which WenYuDrag does not take"),
        (
            "PlessisMasliyahDrag { alphac alpha.air; }",
            "sphericity 0.6;",
            "which PlessisMasliyahDrag does not take",
        ),
    ],
)
def test_a_law_says_what_it_needs_to_know(tmp_path: Path, drag: str, shape: str, said: str) -> None:
    dust = MATERIAL.format(name="dust", share=1, shape=shape, size=1e-4)
    with pytest.raises(ElutriaError) as refused:
        run(column(tmp_path / "case", drag, dust), tmp_path / "run")
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("drag", ["GanserDrag;", "nonSphereDrag { phi 0.6; }"])
def test_a_shape_that_a_law_takes_is_allowed(tmp_path: Path, drag: str) -> None:
    dust = MATERIAL.format(name="dust", share=1, shape="sphericity 0.6;", size=1e-4)
    (plan,) = plans(column(tmp_path / "case", drag, dust), [[]])
    assert plan["feed"]["materials"][0]["sphericity"] == 0.6


def test_flat_grains_settle_slower(tmp_path: Path) -> None:
    shapes = {"round": "", "flat": "flatness 0.3; elongation 0.6;"}
    grains = "".join(
        MATERIAL.format(name=name, share=0.5, shape=shape, size=1.5e-4)
        for name, shape in shapes.items()
    )
    case = column(tmp_path / "case", "BagheriBonadonnaDrag;", grains)
    speed = leaving_speed(run(case, tmp_path / "run"))
    assert 0.6 * speed["round"] < speed["flat"] < 0.9 * speed["round"]


@pytest.mark.parametrize(("cells", "kernel"), [(1, 0.0), (5, 3.0)])
def test_two_sizes_have_the_factors_of_the_mean_around_them(
    tmp_path: Path, measured: Note, cells: int, kernel: float
) -> None:
    """Spheres of two sizes are slowed for a moment: by Beetstra's law at y = d over 6 V/A. In cells
    that hold one sphere each the mean is that of the kernel, here wider than the box."""
    small, large, solids, speed = 1e-3, 2e-3, 0.2, 0.5
    size = np.array([small, large] * 8)
    side = (np.sum(np.pi / 6 * size**3) / solids) ** (1 / 3)
    velocity = np.zeros((16, 3))
    velocity[:, 2] = speed
    start = Particles.of(lattice(16, side), velocity, diameter=size, density=2650.0)
    box = BoxCase(**cube(side, cells), **WEIGHTLESS, most_solids=0.9, step=1e-7,
                  end=1e-7, forces={"BeetstraDrag": {"alphac": "alpha.air"}},
                  more={f"{CLOUD}:spreading": {"width": kernel * side, "steps": 12}})  # fmt: skip
    case = box.make(tmp_path / "case", start)
    solve(case)
    after = read_particles(case, times(case)[-1]).velocity[:, 2]
    slowed = -np.log(after / speed) / 1e-7 * np.sqrt(after / speed) * speed
    ours = slowed / (0.5 * AIR.density * speed * after * 1.5 / (2650 * size))
    mean = np.sum(size**3) / np.sum(size**2)
    reynolds = AIR.density * speed * size / AIR.viscosity
    theirs = drag_coefficient("BeetstraDrag", reynolds, 1 - solids, over_mean=size / mean)
    measured("drag is another one", float(np.max(np.abs(ours / theirs - 1))), 1e-6)
    alone = drag_coefficient("BeetstraDrag", reynolds, 1 - solids)
    assert np.all(np.abs(theirs / alone - 1) > 0.1), "one size would do"
