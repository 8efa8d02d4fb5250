"""What a feed becomes: the sizes asked for."""

from __future__ import annotations

from math import log
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import erf

from elutria.classification.events import Events, read_run
from elutria.errors import ElutriaError
from elutria_validation.chapters.classification import PLUG_FLOW
from elutria_validation.harness.box import BoxCase, cube
from elutria_validation.harness.cases import add_feed, material, solve

Array = NDArray[np.float64]

CUT = 1e-6 * PLUG_FLOW[2650][3]  # m, at 3 m/s


def rosin_rammler(diameter: Array) -> Array:
    """By mass, d63 0.6 mm, n 3, cut to 0.2..1.2 mm."""
    low, high, share = (-np.expm1(-((d / 6e-4) ** 3)) for d in (2e-4, 1.2e-3, diameter))
    return (share - low) / (high - low)


def log_normal(diameter: Array) -> Array:
    """d50 0.3 mm, geometric standard deviation 1.5, cut to 0.1..0.9 mm."""
    low, high, share = (
        0.5 * (1 + erf(np.log(np.asarray(d) / 3e-4) / (2**0.5 * log(1.5))))
        for d in (1e-4, 9e-4, diameter)
    )
    return (share - low) / (high - low)


def fed(folder: Path, weighting: str) -> Events:
    """All particles of a feed of two materials, just after they have entered."""
    case = BoxCase(**cube(1), step=0.01, end=0.02, interval=0.01).make(folder)
    rosin = {"type": "RosinRammler", "d63": 6e-4, "n": 3, "min": 2e-4, "max": 1.2e-3}
    normal = {"type": "logNormal", "d50": 3e-4, "sigma": 1.5, "min": 1e-4, "max": 9e-4}
    materials = {
        "quartz": {
            "density": 2650,
            "massFraction": 0.7,
            "sizeDistribution": {**rosin, "weighting": weighting},
        },
        "galena": {
            "density": 7600,
            "massFraction": 0.3,
            "sizeDistribution": {**normal, "weighting": weighting},
        },
    }
    add_feed(case, {"massFlowRate": 100, "particles": 8000, "materials": materials})
    solve(case)
    events = read_run(case).events
    assert len(events) == 8000
    return events


def kolmogorov_smirnov(diameter: Array, weight: Array, law) -> tuple[float, float]:
    """Largest difference of the weighted distribution from `law`, and its critical value at 1 %.

    The effective number of weighted events is Kish's.
    """
    order = np.argsort(diameter)
    share = np.cumsum(weight[order]) / weight.sum()
    asked = law(diameter[order])
    before = np.concatenate([[0], share[:-1]])
    difference = max(np.abs(share - asked).max(), np.abs(before - asked).max())
    return float(difference), 1.63 / (weight.sum() ** 2 / (weight**2).sum()) ** 0.5


@pytest.mark.parametrize("weighting", ["mass", "number"])
def test_the_feed_is_distributed_as_asked(tmp_path: Path, measured, weighting: str) -> None:
    events = fed(tmp_path / "case", weighting)
    shares = {}
    for name, law in {"quartz": rosin_rammler, "galena": log_normal}.items():
        sample = events.of_material(name)
        shares[name] = sample.mass.sum() / events.mass.sum()
        weights = {"mass": sample.mass, "number": np.ones(len(sample))}
        difference, critical = kolmogorov_smirnov(sample.diameter, weights.pop(weighting), law)
        measured(f"{name} by {weighting}: Kolmogorov-Smirnov distance", difference, critical)
        (fallacy,) = weights.values()
        wrong, critical = kolmogorov_smirnov(sample.diameter, fallacy, law)
        assert wrong > critical, "the other weighting would be told apart"
    measured("share of quartz in the feed's mass", abs(shares["quartz"] - 0.7), 0.03)


@pytest.mark.parametrize("focus", ["none", "auto", CUT])
def test_a_focus_draws_half_of_the_parcels_and_keeps_the_distribution(
    tmp_path: Path, measured, focus: str | float
) -> None:
    case = BoxCase(
        **cube(1), gas_velocity=3, gravity=-9.81, step=0.01, end=0.02, interval=0.01
    ).make(tmp_path / "case")
    quartz = material(2650, type="RosinRammler", d63=6e-4, n=3, min=2e-4, max=1.2e-3)
    add_feed(
        case,
        {
            "massFlowRate": 2,
            "duration": 0.01,
            "particles": 4000,
            "parcels": "evenSizes",
            "focus": focus,
            "materials": quartz,
        },
    )
    solve(case)
    events = read_run(case).events
    assert len(events) == 4000
    distance, _ = kolmogorov_smirnov(events.diameter, events.mass, rosin_rammler)
    measured("distance from the law by mass", distance, 0.005)
    measured("mass fed over the mass asked", abs(events.mass.sum() / 0.02 - 1), 0.01)
    even = 2 * log(1.3) / log(6)
    around = np.abs(np.log(events.diameter / CUT)) < log(1.3)
    expected = even if focus == "none" else 0.5 + 0.5 * even
    measured("share of parcels around the cut", abs(around.mean() - expected), 0.02)


def test_a_feed_of_a_sieve_analysis_and_a_law_at_once(tmp_path: Path, measured) -> None:
    """A file in the case and a law, summed: read by the solver as they are written."""
    case = BoxCase(**cube(1), step=0.01, end=0.02, interval=0.01).make(tmp_path / "case")
    sieves = "diameter_um,retained_percent\n2000,0\n1600,100\n1000,0\n"
    (case / "constant/sieves.csv").write_text(sieves)
    parts = {
        "fine": {"share": 0.4, "type": "RosinRammler", "d63": 6e-4, "n": 3, "min": 2e-4,
                 "max": 1.2e-3},
        "coarse": {"share": 0.6, "type": "sieve", "file": '"constant/sieves.csv"'},
    }  # fmt: skip
    materials = material(2650, type="sum", parts=parts)
    add_feed(case, {"massFlowRate": 1, "duration": 0.01, "particles": 2000, "parcels": "evenMass",
                    "materials": materials})  # fmt: skip
    solve(case)
    events = read_run(case).events

    def law(diameter: Array) -> Array:
        sieved = np.clip((diameter - 1.6e-3) / 4e-4, 0, 1)
        return 0.4 * np.clip(rosin_rammler(diameter), 0, 1) + 0.6 * sieved

    difference, critical = kolmogorov_smirnov(events.diameter, events.mass, law)
    measured("Kolmogorov-Smirnov distance", difference, critical)
    (case / "constant/sieves.csv").unlink()
    with pytest.raises(ElutriaError, match=r"constant/sieves.csv is not found, allowed"):
        solve(case)
