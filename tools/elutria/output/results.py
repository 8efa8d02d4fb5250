"""The tables of RESULTS that figures are drawn from, and whether the figures are as new as they."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from elutria import tables
from elutria.errors import InputError
from elutria.files import read_csv
from elutria.output.settings import Row, Settings

FORMATS = ("png", "svg", "pdf")
ALWAYS = ("partition_curves", "cut_size", "size_distributions")
OPTIONAL = ("planes", "contours")
"""Names of the figures; those that not all results have are written first."""


@dataclass(frozen=True)
class Results:
    """The tables of a sweep or a run that figures are drawn from."""

    summary: list[Row]
    partition: list[Row]
    curves: list[Row]
    theory: list[Row]
    settings: Settings
    products: dict[str, str]
    """What the case calls `fines` and `coarse`."""


def read_results(folder: Path) -> Results:
    """The tables of RESULTS. Raises InputError when they are not there."""
    if folder.is_dir() and not (folder / "summary.csv").exists():
        raise InputError(
            f"{folder}: has no summary.csv; allowed: results of 'elutria sweep' or 'elutria run', "
            "or of a run after 'elutria classify'"
        )
    summary = read_csv(folder / "summary.csv", tables.FIRST)
    partition = read_csv(folder / "partition.csv", tables.PARTITION)
    if not summary or not partition:
        raise InputError(f"{folder / 'summary.csv'}: holds no rows; nothing to draw")
    curves = optional(folder / "curve.csv", tables.CURVE)
    lines = read_theory(folder)
    by_product = optional(folder / "product_partition.csv", tables.PRODUCT_PARTITION)
    products = tables.product_names(partition, by_product)
    return Results(summary, partition, curves, lines, Settings(summary, partition), products)


def read_theory(folder: Path) -> list[Row]:
    """Cut sizes of the terminal velocity, where RESULTS has them."""
    return optional(folder / "theory.csv", tables.THEORY)


def optional(path: Path, columns: tuple[str, ...]) -> list[Row]:
    """Rows of a table that need not be there."""
    return read_csv(path, columns) if path.exists() or path.is_symlink() else []


def formats_of(names: Sequence[str]) -> tuple[str, ...]:
    """The endings of the figures. Raises InputError for one that is not known."""
    for name in names:
        if name not in FORMATS:
            raise InputError(f"--format {name}; allowed: {', '.join(FORMATS)}")
    return tuple(names) or FORMATS[:1]


def current_figures(folder: Path, formats: Sequence[str]) -> list[Path]:
    """The figures of RESULTS where all are newer than every table and what draws them; or none."""
    figures = [folder / f"{name}.{suffix}" for name in ALWAYS for suffix in formats]
    if not all(figure.is_file() for figure in figures):
        return []
    own = {*ALWAYS, *OPTIONAL}
    sources = [table for table in folder.glob("*.csv") if table.stem not in own]
    sources += Path(__file__).parent.glob("*.py")
    newest = max(source.stat().st_mtime_ns for source in sources)
    more = [folder / f"{name}.{suffix}" for name in OPTIONAL for suffix in formats]
    figures = [figure for figure in more if figure.is_file()] + figures
    now = time.time_ns()  # a clock that was set back tells of none later which is newer
    return figures if all(newest <= f.stat().st_mtime_ns <= now for f in figures) else []
