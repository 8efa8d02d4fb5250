"""From events to the rows of summary.csv, partition.csv, product_partition.csv, products.csv,
fit.csv and curve.csv."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from math import exp, inf, nan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria import tables
from elutria.classification.events import DRAIN_TIME, Events, Run
from elutria.classification.fit import LEVELS, PartitionFit, fit_partition
from elutria.classification.notes import notes
from elutria.classification.partition import Cut, SizeClass, class_limits, partition_table
from elutria.classification.products import product_rows
from elutria.files import write_csv
from elutria.warned import Warned

Row = dict[str, Any]

_FITTED: dict[bytes, PartitionFit] = {}
"""By what was fitted; the oldest go first."""
_MOST_FITTED = 256


@dataclass
class Classification:
    """Rows of the six tables. `axes` are settings that rows have beside the gas velocity, as
    columns after the others."""

    summary: list[Row] = field(default_factory=list)
    partition: list[Row] = field(default_factory=list)
    product_partition: list[Row] = field(default_factory=list)
    fits: list[Row] = field(default_factory=list)
    curves: list[Row] = field(default_factory=list)
    products: list[Row] = field(default_factory=list)
    axes: tuple[str, ...] = ()
    ended_by: str = DRAIN_TIME

    def with_settings(self, values: Mapping[str, float | str]) -> Classification:
        """The same rows, each with these settings."""
        for rows in (self.summary, self.partition, self.product_partition, self.fits, self.curves,
                     self.products):  # fmt: skip
            for row in rows:
                row.update(values)
        return self

    @property
    def notes(self) -> list[Warned]:
        """What a user must know of these rows, which are of one velocity."""
        names = tables.product_names(self.partition, self.product_partition)
        return notes(self.summary, self.partition, self.curves, names["coarse"], self.ended_by)

    def extend(self, other: Classification) -> None:
        """Append another point's rows."""
        self.summary += other.summary
        self.partition += other.partition
        self.product_partition += other.product_partition
        self.fits += other.fits
        self.curves += other.curves
        self.products += other.products

    def write(self, folder: Path) -> None:
        """All six in `folder`, each written atomically."""
        for name, columns, rows in (
            ("partition", tables.PARTITION, self.partition),
            ("product_partition", tables.PRODUCT_PARTITION, self.product_partition),
            ("fit", tables.FIT, self.fits),
            ("curve", tables.CURVE, self.curves),
            ("products", tables.PRODUCTS, self.products),
            ("summary", tables.SUMMARY, self.summary),
        ):
            write_csv(folder / f"{name}.csv", (*columns, *self.axes), rows)


def classify(
    run: Run, velocity: float, wall_time: float, warned: int = 0,
    model_errors: Mapping[str, float] | None = None,
) -> Classification:  # fmt: skip
    """All rows of one velocity (m/s): each material and `all`. `wall_time` in s.

    `warned`: the warnings that the solver has of it; those of the rows themselves are added.
    `model_errors`: relative ones of d50 by material, nan where they are not known.
    """
    result = Classification(ended_by=run.ended_by)
    names = [name for name in run.accounts if name != "all"]
    fits = {name: fit_events(run.events.of_material(name)) for name in names}
    # one material: `all` is the same events
    fits["all"] = fits[names[0]] if len(names) == 1 else fit_events(run.events)
    limits = _limits(run.events, fits)
    result.products = [
        {"gas_velocity_m_s": velocity, **row} for row in product_rows(run.events, names)
    ]
    for name in [*names, "all"]:
        events = run.events.of_material(name)
        table = partition_table(events, limits) if limits is not None else []
        key = {"gas_velocity_m_s": velocity, "material": name}
        result.summary.append({**key, **_summary(run, name, events, fits[name], wall_time)})
        result.partition += [{**key, **_partition(entry)} for entry in table]
        result.product_partition += [
            {**key, **row} for entry in table for row in _product_partition(entry)
        ]
        result.fits += [{**key, **row} for row in _fit_rows(fits[name], events)]
        result.curves += [{**key, **row} for row in _curve_rows(fits[name], events)]
    known = model_errors or {}
    for summary in result.summary:
        summary["warnings"] = warned + len(result.notes)
        summary["d50_model_error"] = known.get(summary["material"], nan)
    return result


def _limits(events: Events, fits: dict[str, PartitionFit]) -> NDArray[np.float64] | None:
    """Limits of the size classes of all materials; they follow the materials' curves."""
    if not len(events):
        return None
    cuts = [
        Cut(fit.share, parcels.diameter[parcels.has_left])
        for name, fit in fits.items()
        if fit.curve is not None and len(parcels := events.of_material(name))
    ]
    return class_limits(float(events.diameter.min()), float(events.diameter.max()), cuts)


def fit_events(events: Events) -> PartitionFit:
    """The partition curve of what has left; at equal size a parcel weighs number x density. The
    same events, asked for again, are not fitted again."""
    left = events.select(events.has_left)
    columns = left.diameter, left.is_coarse, left.number * left.density, left.time
    digest = sha256(b"".join(np.ascontiguousarray(column).tobytes() for column in columns)).digest()
    if digest not in _FITTED:
        while len(_FITTED) >= _MOST_FITTED:
            del _FITTED[next(iter(_FITTED))]
        _FITTED[digest] = fit_partition(*columns)
    return _FITTED[digest]


def _summary(run: Run, name: str, events: Events, fit: PartitionFit, wall_time: float) -> Row:
    account = run.accounts[name]
    mass = events.mass
    left = float(np.sum(mass[events.has_left]))
    fines = float(np.sum(mass[events.has_left & ~events.is_coarse]))
    low, high = fit.sizes[0.50][1:]
    return {
        "d25_m": fit.d25,
        "d50_m": fit.d50,
        "d50_low_m": low,
        "d50_high_m": high,
        "d75_m": fit.d75,
        "sharpness": fit.sharpness,
        "ecart_probable_m": fit.ecart_probable,
        "bypass": fit.best.bypass if fit.best else nan,
        "fines_yield": fines / left if left > 0 else nan,
        "mass_closure_error": account.mass_closure_error,
        "particles_fed": _whole(account.injected[0]),
        "particles_lost": _whole(account.lost[0]),
        "wall_time_s": round(wall_time, 3),
    }


def _whole(number: float) -> int | float:
    return int(number) if number == int(number) else number


def _partition(entry: SizeClass) -> Row:
    return {
        "diameter_low_m": entry.low,
        "diameter_high_m": entry.high,
        "diameter_m": entry.diameter,
        "feed_kg": entry.feed,
        "fines_kg": entry.fines,
        "coarse_kg": entry.coarse,
        "inside_kg": entry.inside,
        "partition_to_coarse": entry.share,
        "ci_low": entry.share_low,
        "ci_high": entry.share_high,
    }


def _product_partition(entry: SizeClass) -> list[Row]:
    return [
        {
            "product": one.product,
            "diameter_low_m": entry.low,
            "diameter_high_m": entry.high,
            "diameter_m": entry.diameter,
            "product_kg": one.mass,
            "partition": one.share,
            "ci_low": one.share_low,
            "ci_high": one.share_high,
            "cumulative": one.cumulative,
        }
        for one in entry.products
    ]


def _fit_rows(fit: PartitionFit, events: Events) -> list[Row]:
    """The curve without a formula (rank 0) with its intervals, then a row per formula."""
    if fit.curve is None:
        return []
    number = int(np.sum(events.has_left))
    unknown = dict.fromkeys(tables.FIT[2:], nan)
    limits = {f"d{100 * level:.0f}": fit.sizes[level][1:] for level in LEVELS}
    first: Row = {**unknown, "rank": 0, "model": "no formula", "events": number}
    for name, (low, high) in limits.items():
        first |= {f"{name}_low_m": low, f"{name}_high_m": high}
    first["sharpness_low"], first["sharpness_high"] = fit.sharpness_interval[1:]
    return [first] + [
        {
            **unknown,
            "rank": rank,
            "model": curve.name,
            "d50_without_bypass_m": exp(curve.log_diameter),
            "shape": exp(curve.log_shape) if curve.log_shape < 700 else inf,
            "bypass": curve.bypass,
            "log_likelihood": curve.log_likelihood,
            "aic": curve.aic,
            "p_value": curve.p_value,
            "events": number,
        }
        for rank, curve in enumerate(fit.ranked, start=1)
    ]


def _curve_rows(fit: PartitionFit, events: Events) -> list[Row]:
    """The curve with its 95 % band, over the sizes that left."""
    if fit.curve is None:
        return []
    left = events.diameter[events.has_left]
    diameter = np.geomspace(left.min(), left.max(), 241)
    return [
        dict(zip(tables.CURVE[2:], row, strict=True))
        for row in np.column_stack([diameter, *fit.band(diameter)]).tolist()
    ]
