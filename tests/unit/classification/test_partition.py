"""Size classes and Wilson's intervals."""

from __future__ import annotations

import numpy as np
import pytest

from elutria.classification.events import Events
from elutria.classification.partition import Cut, class_limits, partition_table, wilson
from elutria.physics import laws


def events(number: int, seed: int = 1, weight: float = 1.0) -> Events:
    random = np.random.default_rng(seed)
    diameter = random.uniform(3e-4, 2e-3, number)
    return Events(
        material=np.full(number, "quartz"),
        outlet=random.choice(["fines", "coarse", "inside"], number, p=[0.3, 0.6, 0.1]),
        diameter=diameter,
        density=np.full(number, 2650.0),
        number=np.full(number, weight),
        time=np.zeros(number),
    )


def test_classes_are_renards_and_hold_all_sizes() -> None:
    limits = class_limits(310e-6, 1990e-6)
    assert limits[0] == pytest.approx(280e-6)
    assert limits[-1] == pytest.approx(2000e-6)
    assert np.all(np.diff(np.log10(limits)) == pytest.approx(0.05, abs=0.0081))
    one = class_limits(500e-6, 500e-6)
    assert one[0] <= 500e-6 <= one[-1]
    assert one.size >= 2


def test_classes_are_finer_where_the_curve_changes() -> None:
    random = np.random.default_rng(4)
    diameter = random.uniform(3e-4, 2e-3, 20_000)

    def share(d: np.ndarray) -> np.ndarray:  # from 0.02 to 0.98 between 560 and 640 um
        return 1 / (1 + (600e-6 / d) ** 60)

    coarse = class_limits(3.1e-4, 1.99e-3)
    limits = class_limits(3.1e-4, 1.99e-3, [Cut(share, diameter)])
    assert set(coarse) < set(limits)  # R 20 stays; classes can be joined
    ratio = limits[1:] / limits[:-1]
    near = (limits[:-1] > 555e-6) & (limits[1:] < 650e-6)
    assert near.sum() >= 4
    assert np.all(ratio[near] < 1.04)  # R 80
    assert np.all(ratio[limits[1:] < 500e-6] > 1.1)
    assert np.all(np.histogram(diameter, limits)[0][near] >= 25)
    few = class_limits(3.1e-4, 1.99e-3, [Cut(share, diameter[:300])])
    assert few.tolist() == coarse.tolist()


def test_no_mass_is_lost_between_classes() -> None:
    sample = events(2_000)
    table = partition_table(sample, class_limits(3e-4, 2e-3))
    assert sum(c.feed for c in table) == pytest.approx(sample.mass.sum(), rel=1e-12)
    assert sum(c.inside for c in table) == pytest.approx(sample.mass[~sample.has_left].sum())
    for entry in table:
        assert entry.low <= entry.diameter <= entry.high
        assert entry.share == pytest.approx(entry.coarse / (entry.coarse + entry.fines))
        assert entry.share_low <= entry.share <= entry.share_high


def test_what_is_inside_is_not_counted_as_coarse() -> None:
    sample = events(2_000)
    only_inside = sample.select(sample.outlet == "inside")
    table = partition_table(only_inside, class_limits(3e-4, 2e-3))
    assert all(np.isnan(entry.share) and np.isnan(entry.share_low) for entry in table)


def test_parcels_of_many_particles_carry_their_mass_but_are_one_trial() -> None:
    one = partition_table(events(500), class_limits(3e-4, 2e-3))
    ten = partition_table(events(500, weight=10), class_limits(3e-4, 2e-3))
    for a, b in zip(one, ten, strict=True):
        assert b.feed == pytest.approx(10 * a.feed)
        assert (b.share, b.share_low, b.share_high) == pytest.approx(
            (a.share, a.share_low, a.share_high)
        )


def test_wilson_at_known_values() -> None:
    # 0 and 1 of 10; 8 of 10 (Newcombe 1998 gives such tables)
    assert wilson(0.0, 10) == pytest.approx((0.0, 0.2775), abs=1e-4)
    assert wilson(1.0, 10) == pytest.approx((0.7225, 1.0), abs=1e-4)
    assert wilson(0.8, 10) == pytest.approx((0.4902, 0.9433), abs=1e-4)


def test_wilson_covers() -> None:
    random = np.random.default_rng(3)
    for share in (0.05, 0.3, 0.5, 0.9):
        seen = random.binomial(80, share, 4_000) / 80
        low, high = np.array([wilson(s, 80) for s in seen]).T
        assert 0.93 < np.mean((low <= share) & (share <= high)) < 0.98


def test_the_series_of_sieves_is_the_one_that_the_feed_is_exact_in() -> None:
    diameters, *_ = laws.law_sizes("uniform", [], 1.03e-4, 1.02e-3, "mass").curves()
    limits = class_limits(1.03e-4, 1.02e-3)[1:-1]
    assert len(limits) == 20
    assert set(limits) <= set(diameters)
