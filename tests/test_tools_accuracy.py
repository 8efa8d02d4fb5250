"""The accuracy benchmark: errors against known curves, Pareto's front, and the runs' settings."""

from __future__ import annotations

from math import nan
from pathlib import Path

import numpy as np
import pytest

from elutria.case.case import Case
from elutria.classification.events import Events
from elutria.openfoam.dictionary import read_dictionary
from elutria_validation.benchmarks import accuracy_report as report
from elutria_validation.benchmarks.accuracy_error import (
    Cut,
    beside_stock,
    cut_of_curve,
    cut_of_events,
    errors,
    front,
)
from elutria_validation.benchmarks.accuracy_forms import closed_forms
from elutria_validation.benchmarks.accuracy_runs import (
    COLLISIONS,
    COURANT,
    FAST,
    SLOW,
    STEP,
    Point,
    make_case,
    step,
)
from elutria_validation.benchmarks.uncertainty import inlet
from elutria_validation.harness.programs import project_root, slug

SIZES = np.geomspace(200e-6, 1200e-6, 400)


def log_logistic(cut: float, slope: float = 10) -> Cut:
    return cut_of_curve(SIZES, 1 / (1 + (SIZES / cut) ** -slope))


def events_of(number: int, cut: float, slope: float = 10, seed: int = 1) -> Events:
    """Parcels even on a log size axis, a log-logistic cut."""
    random = np.random.default_rng(seed)
    diameter = np.geomspace(200e-6, 1200e-6, number)
    coarse = random.random(number) < 1 / (1 + (diameter / cut) ** -slope)
    ones = np.ones(number)
    return Events(
        np.full(number, "a"), np.where(coarse, "coarse", "fines"), diameter, ones, ones, ones
    )


def test_a_known_shift_of_the_cut_is_the_error() -> None:
    found = errors([log_logistic(510e-6)], log_logistic(500e-6))
    assert found["d50_error"] == pytest.approx(0.02, rel=1e-3)
    assert found["sharpness_error"] == pytest.approx(0, abs=1e-4)
    assert found["d50_noise"] == found["curve_noise"] == 0
    # a steep curve's shift by 2 % in ln d, mean square of T' over the compared range
    at = np.exp(np.linspace(np.log(0.7), np.log(1.4), 1000))
    slope = 10 * at**-10 / (1 + at**-10) ** 2
    assert found["curve_error"] == pytest.approx(0.02 * np.sqrt(np.mean(slope**2)), rel=0.05)


def test_a_curve_against_itself_has_no_error_and_a_knife_is_sharper() -> None:
    reference = log_logistic(500e-6)
    same = errors([reference], reference)
    assert same["d50_error"] == same["sharpness_error"] == same["curve_error"] == 0
    knife = cut_of_curve(500e-6 * np.array([0.1, 1 - 1e-9, 1 + 1e-9, 10]), [0, 0, 1, 1])
    assert errors([knife], reference)["sharpness_error"] == pytest.approx(
        1 - 3 ** (-2 / 10), rel=1e-3
    )


def test_the_noise_says_how_far_events_are_off_their_own_curve() -> None:
    truth = log_logistic(500e-6)
    found = [errors([cut_of_events(events_of(1500, 500e-6, seed=k))], truth) for k in range(12)]
    for quantity in ("d50", "sharpness"):
        off = np.array([one[f"{quantity}_error"] for one in found])
        noise = np.array([one[f"{quantity}_noise"] for one in found])
        assert 0.4 < np.sqrt(np.mean(off**2)) / np.mean(noise) < 1.7
    many = errors([cut_of_events(events_of(24000, 500e-6))], truth)
    fewer = np.mean([one["d50_noise"] for one in found]) / many["d50_noise"]
    assert 2.2 < fewer < 4.8  # 4 if it were known that the curve is a formula's


def test_runs_together_know_more_than_one_and_what_one_is_off_by() -> None:
    truth = log_logistic(500e-6)
    cuts = [cut_of_events(events_of(1500, 505e-6, seed=k)) for k in range(12)]
    one, all_ = errors(cuts[:1], truth), errors(cuts, truth)
    assert all_["d50_error"] == pytest.approx(0.01, abs=2 * all_["d50_noise"])
    assert all_["d50_noise"] == pytest.approx(one["d50_noise"] / 12**0.5, rel=0.5)
    chance = one["d50_noise"]
    assert all_["d50_run"] == pytest.approx((0.01**2 + chance**2) ** 0.5, rel=0.3)
    assert all_["curve_error"] < all_["curve_run"]
    same = errors([cuts[0]] * 3, truth)
    assert same["d50_run"] == pytest.approx(one["d50_run"], rel=1e-12)
    assert one["d50_run"] >= one["d50_noise"]


def test_events_without_a_cut_have_no_error_to_tell() -> None:
    none = cut_of_events(events_of(100, 5e-3, slope=100))
    for cuts in ([none], [none, log_logistic(510e-6)]):
        found = errors(cuts, log_logistic(500e-6))
        assert np.isnan([found["d50_error"], found["d50_noise"], found["d50_run"]]).all()


def test_the_front_holds_what_nothing_beats() -> None:
    costs = [1, 2, 3, 3, 10, 4, nan]
    faults = [9, 5, 5, 4, 1, 6, 0]
    assert front(costs, faults) == [True, True, False, True, True, False, False]


def row(point: str, seconds: float, error: float, kind: str = "elutriaFoam") -> dict[str, object]:
    return {
        "scene": "a", "point": point, "kind": kind, "seconds": seconds, "parcels": 1000,
        "d50_run": max(abs(error), 0.004), "curve_run": max(abs(error), 0.004),
    }  # fmt: skip


def test_ours_beside_stock() -> None:
    stock = row("stock", 10_000, -0.02, "stock")
    ours = [row("rough", 1, 0.05), row("plain", 20, 0.01), row("fine", 9_000, 0.0001)]
    found = beside_stock(stock, ours, "d50")
    assert (found.by, found.faster) == ("plain", pytest.approx(500))
    assert found.more_accurate == pytest.approx(0.02 / 0.004)
    assert found.met(100)
    assert not found.met(1000)
    slow = beside_stock({**stock, "seconds": 30.0}, ours, "d50")
    assert not slow.met(100)
    nothing = beside_stock({**stock, "d50_run": 0.001}, [ours[0]], "d50")
    assert np.isnan(nothing.faster)
    assert not nothing.met(10)


def test_the_advice_is_the_cheapest_that_is_right_everywhere() -> None:
    here = [row("plain", 20, 0.008), row("fine", 90, 0.001), row("rough", 1, 0.05)]
    there = [{**one, "scene": "b"} for one in (row("plain", 20, 0.02), row("fine", 95, -0.002))]
    (found,) = report.advice([*here, *there])
    assert "use **fine**" in found
    assert "use **plain** (20 s" in report.advice(here)[0]
    assert "none is known to be enough; **rough**" in report.advice(here[2:])[0]


def test_a_point_changes_the_case_and_nothing_else(tmp_path: Path) -> None:
    point = Point("coarse and long", step(4), mesh=0.6)
    case = make_case(tmp_path, FAST, point, 300, seed=7)
    feed = Case(case).feed()
    assert (feed.particles, feed.seed, feed.duration) == (300, 7, 0.25)
    assert Case(case).velocity() == FAST.velocity
    control = read_dictionary(case / "system/controlDict", case)
    for limit in "deltaT", "maxDeltaT":
        assert control.number(limit) == pytest.approx(4 * STEP)
    plan = (case / "system/blockMeshDict").read_text()
    assert plan.count("(6 6 29)") == 2
    assert "(6 6 1)" in plan
    assert slug("column, 4 m/s", "step x 4") == "column-4-m-s-step-x-4"


def test_the_steps_that_points_change_are_those_of_the_case() -> None:
    case = Case(project_root() / "cases/column")
    control = case.dictionary("system/controlDict")
    assert control.number("deltaT") == control.number("maxDeltaT") == STEP
    assert control.number("maxCo") == COURANT
    assert case.dictionary("system/scenePlan").number("collisionsPerStep") == COLLISIONS


def test_an_inlet_profile_keeps_the_mean_velocity() -> None:
    (values,) = inlet(lambda y: y ** (1 / 7), 4.0).values()
    assert values.shape == (100, 3)
    assert values[:, 2].mean() == pytest.approx(4)
    assert values[0, 2] < 4 < values[55, 2]


def test_closed_forms_cost_nothing_and_agree_on_the_cut() -> None:
    plug, drift = closed_forms(SLOW)
    assert plug.cut.sharpness == pytest.approx(1)
    assert drift.cut.d50 == pytest.approx(plug.cut.d50, rel=0.02)
    assert drift.cut.sharpness < 1
    assert plug.seconds + drift.seconds < 1


def test_the_default_is_on_the_front_unless_one_cheaper_is_as_good_in_both() -> None:
    runs = {"runs": 4, "seconds_low": 0.0, "seconds_high": 1e9}
    default = row(report.PLAN, 10, 0.01) | runs
    sharp = row("sharp", 5, 0.02) | runs | {"curve_run": 0.001}
    both = row("both", 5, 0.009) | runs
    page = "\n".join(report.default_lines([default, sharp]))
    assert "a, d50 (1 %): on the front." in page
    assert "a, curve (1 %): behind sharp (50 % cheaper, 0.1 %, better)." in page
    assert "both errors together: on it." in page
    assert "more than chance: sharp." in page
    page = "\n".join(report.default_lines([default, sharp, both]))
    assert "d50 (1 %): behind both (50 % cheaper, 0.9 %, as good within chance)." in page
    assert "both errors together: behind both." in page
