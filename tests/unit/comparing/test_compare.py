"""A measurement drawn from a known curve: called the same as often as chance says, and not where
it is of another curve."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import kstest

from elutria.classification.curves import MODELS
from elutria.classification.fit import fit_partition
from elutria.classification.smooth import SmoothCurve
from elutria.comparing.compare import Comparison, compare, within
from elutria.comparing.measured import NORMAL, Measured

Array = NDArray[np.float64]
CUT, SHAPE = 600e-6, 1.8


def truth(diameter: Array, cut: float = CUT) -> Array:
    """The share to coarse."""
    return MODELS[0].share(diameter / cut, SHAPE)


@lru_cache
def computed(seed: int, number: int = 1500) -> SmoothCurve:
    """What a run of so many parcels knows of the curve."""
    random = np.random.default_rng(seed)
    diameter = random.lognormal(np.log(CUT), 0.4, number)
    fit = fit_partition(diameter, random.random(number) < truth(diameter), intervals=False)
    assert fit.curve is not None
    return fit.curve


def survey(seed: int, deviation: float, cut: float = CUT, number: int = 8) -> Measured:
    """A measurement at sizes about the cut, each off by chance."""
    random = np.random.default_rng(seed)
    size = np.geomspace(0.7 * CUT, 1.4 * CUT, number)
    share = truth(size, cut) + deviation * random.standard_normal(number)
    return Measured(size, size, share, np.full(number, deviation), np.ones(number), {})


def comparisons(deviation: float, number: int, cut: float = CUT, parcels: int = 1500) -> list[
    Comparison
]:  # fmt: skip
    return [
        compare(computed(seed, parcels), survey(1000 + seed, deviation, cut))
        for seed in range(number)
    ]


@pytest.mark.slow
@pytest.mark.parametrize("deviation", [0.005, 0.03])
def test_the_p_value_is_even_where_both_are_of_one_curve(deviation: float) -> None:
    """Where ours is the better known (0.03) and where it is not (0.005)."""
    p = np.array([found.p_value for found in comparisons(deviation, 40)])
    assert kstest(p, "uniform").pvalue > 0.01
    assert np.sum(p < 0.05) <= 6  # 2 of 40 expected; more than 6 in 1 of 200 such tests


@pytest.mark.slow
def test_the_intervals_of_the_differences_hold_none_as_often_as_they_say() -> None:
    found = comparisons(0.02, 40)
    for k, name in enumerate(("d50_m", "sharpness", "fines_yield")):
        ones = [one.differences[k] for one in found]
        assert {one.name for one in ones} == {name}
        held = sum(one.low <= 0 <= one.high for one in ones)
        assert held >= 34, name  # 38 of 40 expected; fewer than 34 in 1 of 100 such tests


def test_a_curve_that_is_the_same_is_seldom_told_apart() -> None:
    p = [found.p_value for found in comparisons(0.02, 6)]
    assert min(p) > 1e-3  # which chance alone breaks in 6 of 1000 choices of seeds


def test_a_curve_that_is_shifted_is_found_out() -> None:
    """By 8 % of the cut, with the measurement good to 0.02."""
    for found in comparisons(0.02, 6, 1.08 * CUT, 6000):
        d50 = found.differences[0]
        assert found.p_value < 1e-3
        assert d50.high < 0
        assert d50.value == pytest.approx(-0.08 * CUT, abs=0.03 * CUT)


def test_classes_are_compared_with_the_mean_over_them() -> None:
    """In classes that are wide beside the cut: the mean of the truth over ln d, not its middle."""
    edges = CUT * np.array([0.5, 0.8, 1.6, 2.5])
    y = [np.linspace(np.log(a), np.log(b), 501) for a, b in pairwise(edges)]
    share = np.array([truth(np.exp(one)).mean() for one in y])
    assert abs(share[1] - truth(np.sqrt(edges[1:2] * edges[2:3]))[0]) > 0.02
    measured = Measured(edges[:-1], edges[1:], share, np.full(3, 0.01), None, {})
    found = compare(computed(5, 20000), measured)
    np.testing.assert_allclose(found.ours, share, atol=0.015)
    assert found.p_value > 0.01


def test_without_an_uncertainty_there_is_no_chi_square() -> None:
    one = survey(3, 0.02)
    found = compare(computed(3), Measured(one.low, one.high, one.share, None, None, {}))
    assert np.isnan(found.chi_square)
    assert np.isnan(found.p_value)
    assert [difference.name for difference in found.differences] == ["d50_m", "sharpness"]
    assert all(np.isnan(difference.low) for difference in found.differences)


def test_sizes_that_nothing_left_with_are_not_compared() -> None:
    curve = computed(4)
    one = survey(4, 0.02)
    far = np.array([1e-6, 0.1])
    measured = Measured(
        np.append(one.low, far), np.append(one.high, far), np.append(one.share, [0.5, 0.5]),
        np.full(one.low.size + 2, 0.02 / NORMAL), None, {},
    )  # fmt: skip
    assert within(curve, measured).share.size == one.share.size
