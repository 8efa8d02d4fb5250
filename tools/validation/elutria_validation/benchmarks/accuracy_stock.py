"""Stock OpenFOAM on the accuracy benchmark's scenes.

DPMFoam takes days for a scene, so it gets a stretch: some of its steps, from the state that our run
of the same particles had in the middle of the feed. What is left out is to stock's advantage: the
cost is scaled down with the number of particles inside over the whole run. Its error is that of
elutriaFoam with stock's models. MPPICFoam is run to the end, several times; what leaves is read
from its patchPostProcessing.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from elutria.case.case import Case
from elutria.classification.events import PLACES, Events, Run
from elutria.errors import ElutriaError
from elutria.files import read_json, read_text, write_json
from elutria_validation.benchmarks.accuracy_runs import (
    DENSE,
    DRAIN_TIME,
    FEED_TIME,
    STOCK_LIKE,
    Changes,
    Done,
    Point,
    Scene,
    make_case,
    measured,
)
from elutria_validation.benchmarks.column import (
    LAW,
    STOCK_CONTACTS,
    WALL,
    hand_to_stock,
    stock_step,
)
from elutria_validation.harness.cases import CLOUD, CONTROL, MODELS, change
from elutria_validation.harness.programs import processor_time, run_program, slug

START = 0.2
"""s, of the stretches."""
STEP, CELL = 1e-3, 5e-3
"""s, stock's step; m."""
DENSE_PARTS = 10
"""Parts of a step that the dense scene's stretches go in: its 38 000 particles take minutes each.
The gas is solved for each, which is hardly felt beside the contacts."""
LATER = 1.3e-3
"""s, by which each run of MPPICFoam is fed later than the one before: no whole number of steps."""


@dataclass(frozen=True)
class Stretch:
    """Stock's seconds for a whole run, extrapolated from `steps` measured ones."""

    name: str
    seconds: float
    steps: int
    note: str


def _pair_collision(modulus: float) -> Changes:
    """Stock's contacts with springs of a modulus (Pa)."""
    wall = {**WALL, "youngsModulus": modulus}
    contacts = {
        **STOCK_CONTACTS,
        "maxInteractionDistance": 0.0021,  # m, above the largest grain
        "wallLocalSpringSliderDashpotCoeffs": {**LAW, "walls": wall, "feedSlot": wall},
    }
    return {
        f"{MODELS}/collisionModel": "pairCollision",
        f"{MODELS}/pairCollisionCoeffs": contacts,
        f"{CLOUD}:constantProperties/youngsModulus": modulus,
    }


VARIANTS: Mapping[str, tuple[Changes, int]] = {
    "stock DPMFoam, pairCollision": (_pair_collision(1e7), 3),
    "stock DPMFoam, pairCollision, springs / 100": (_pair_collision(1e5), 5),
    "stock DPMFoam with our contacts": ({}, 3),
}
"""What is changed in the case, and the steps that are taken."""


def stock_like(folder: Path, scene: Scene) -> tuple[Done, float]:
    """Our run with stock's models, kept in FOLDER/run with the state at START; and the particles
    inside over the whole run, over those inside at START."""
    case = make_case(folder, scene, STOCK_LIKE, 0)
    change(case, {f"{CONTROL}:writeInterval": START, f"{CONTROL}:purgeWrite": 0})
    done = measured(case, folder / "run")
    log = read_text(folder / "run/log.elutriaFoam", limit=10**9)
    steps = re.findall(r"elutria: time (\S+) .* inside (\d+)", log)
    inside = np.array([float(number) for _, number in steps])
    at_start = next(float(number) for time, number in steps if float(time) >= START - 1e-9)
    return done, float(inside.mean()) / at_start


def stretches(
    folder: Path, scene: Scene, filled: float, quick: bool, say: Callable[[str], None]
) -> list[Stretch]:
    """Stock's costs from the state in FOLDER/run; `filled` as `stock_like` gives it.

    `quick`: the first variant only, two steps; dense: stock's own contacts only.
    What is measured stays in FOLDER and is not measured again.
    """
    found = []
    step = STEP / DENSE_PARTS if scene == DENSE else STEP
    whole = (FEED_TIME + DRAIN_TIME) / step
    variants = list(VARIANTS.items())[: 1 if quick else 2 if scene == DENSE else None]
    for name, (changes, number) in variants:
        steps = 2 if quick or scene == DENSE else number
        record = folder / f"{slug(name)}.json"
        if not record.is_file():
            case = folder / "stock"
            shutil.rmtree(case, ignore_errors=True)
            hand_to_stock(folder / "run", case, START, step, steps)
            change(case, changes)
            try:
                write_json(record, {"seconds": stock_step(case)})
            except ElutriaError as error:
                found.append(Stretch(name, np.nan, 0, str(error)))
                continue
        each = float(read_json(record)["seconds"])
        say(f"{name}: {each:.3g} s a step")
        note = f"{steps - 1} of {whole:.0f} steps measured"
        found.append(Stretch(name, each * whole * filled, steps - 1, note))
    return found


def run_mppic(folder: Path, scene: Scene, runs: int) -> list[Done]:
    """Runs of MPPICFoam that differ by chance. Its random numbers have no seed: a feed that comes
    a little later takes others. Raises ElutriaError when one fails."""
    return [_run_mppic(folder / f"run{k}", scene, k * LATER) for k in range(runs)]


def _run_mppic(folder: Path, scene: Scene, start: float) -> Done:
    """MPPICFoam on the same column with models of its own: sphereDrag, stochastic dispersion,
    tutorial's collision damping and isotropy. Every parcel is one particle: with parcels of equal
    mass patchInjection drops those grains that outweigh one.

    The gas crosses less than a cell in a step; the feed begins at `start` (s).
    """
    step = STEP if scene.velocity * STEP < CELL else STEP / 2
    case, record = folder / "case", folder / "run.json"
    if not record.is_file():
        make_case(folder, scene, Point("stock MPPICFoam"), 0)
        change(
            case,
            {
                f"{CONTROL}:adjustTimeStep": False,
                f"{CONTROL}:deltaT": step,
                f"{CONTROL}:endTime": FEED_TIME + DRAIN_TIME,
                f"{CONTROL}:writeInterval": FEED_TIME + DRAIN_TIME,
            },
        )
        _write_mppic_cloud(case, scene, start)
        before = processor_time()
        run_program(["blockMesh"], case)
        run_program(["MPPICFoam"], case)
        write_json(record, {"seconds": processor_time() - before})
    return Done(_left(case), float(read_json(record)["seconds"]))


def _write_mppic_cloud(case: Path, scene: Scene, start: float) -> None:
    """Its cloud's properties, from the case's own and from constant/feed."""
    feed, gas = Case(case).feed(), Case(case).gas()
    material = feed.materials[0]
    limits = np.geomspace(material.sizes.smallest, material.sizes.largest, 61)
    middle = 0.5 * (limits[1:] + limits[:-1])
    by_number = np.diff(material.sizes.mass_share_below(limits)) / middle**3
    density = by_number / np.diff(limits) / by_number.sum()
    area = 0.05**2  # m2, of the shaft
    rate = scene.loading * gas.density * scene.velocity * area
    mass = material.grain.density * np.pi / 6 * material.sizes.mean_cube  # kg, of a particle
    injection = {
        "type": "patchInjection",
        "parcelBasisType": "fixed",
        "nParticle": 1,
        "patch": feed.place,
        "U0": list(feed.velocity),
        "parcelsPerSecond": rate / mass,
        "massTotal": rate * FEED_TIME,
        "flowRateProfile": ("constant", 1),
        "SOI": start,
        "duration": FEED_TIME,
        "sizeDistribution": {
            "type": "general",
            "generalDistribution": {
                "distribution": [list(pair) for pair in zip(middle, density, strict=True)]
            },
        },
    }
    wall = {"type": "rebound", "e": 0.8, "mu": 0.3}
    patches = [
        ("walls", wall), ("feedSlot", wall), ("top", {"type": "escape"}),
        ("bottom", {"type": "escape"}),
    ]  # fmt: skip
    scale = {"alphaPacked": 0.58, "e": 0.9}
    change(
        case,
        {
            f"{CLOUD}:constantProperties": {"rho0": material.grain.density, "alphaMax": 0.9},
            f"{CLOUD}:solution/averagingMethod": "basic",
            f"{MODELS}/particleForces": {"sphereDrag": {}, "gravity": {}},
            f"{MODELS}/injectionModels": {"feed": injection},
            f"{MODELS}/dispersionModel": "stochasticDispersionRAS",
            f"{MODELS}/patchInteractionModel": "localInteraction",
            f"{MODELS}/localInteractionCoeffs": {"patches": patches},
            f"{MODELS}/packingModel": "none",
            f"{MODELS}/dampingModel": "relaxation",
            f"{MODELS}/relaxationCoeffs": {"timeScaleModel": {"type": "nonEquilibrium", **scale}},
            f"{MODELS}/isotropyModel": "stochastic",
            f"{MODELS}/stochasticCoeffs": {"timeScaleModel": {"type": "isotropic", **scale}},
            f"{CLOUD}:cloudFunctions": {
                "left": {
                    "type": "patchPostProcessing",
                    "maxStoredParcels": 10**7,
                    "patches": ["top", "bottom"],
                }
            },
        },
    )


def _left(case: Path) -> Run:
    """What passed top and bottom; what is inside has no row."""
    tables = []
    for patch, product in (("top", "fines"), ("bottom", "coarse")):
        files = sorted(case.glob(f"postProcessing/lagrangian/*/left/*/{patch}.post"))
        if not files:
            raise ElutriaError(f"{case}: MPPICFoam wrote no {patch}.post")
        head, *lines = re.sub(r"[()]", "", read_text(files[-1], limit=10**9)).splitlines()
        place = [head.strip("# ").split().index(name) for name in ("Time", "d", "rho", "nParticle")]
        rows = [[float(line.split()[k]) for k in place] for line in lines]
        tables.append((product, np.array(rows).reshape(-1, 4)))
    products = np.concatenate([np.full(len(rows), product) for product, rows in tables])
    time, diameter, density, number = np.concatenate([rows for _, rows in tables]).T
    material = pd.Categorical(np.full(products.size, "all"))
    outlet = pd.Categorical(products, list(PLACES))
    return Run(Events(material, outlet, diameter, density, number, time), {})
