"""Tables and notes for the terminal."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import isinf, nan
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.measure import Measurement
from rich.table import Column, Table

from elutria import tables
from elutria.tables import VELOCITY, short, shown

if TYPE_CHECKING:
    from elutria.output.settings import Settings

Row = dict[str, Any]
TableColumn = tuple[str, Callable[[Row], str]]
"""A heading with its unit below, and the text of a row."""
SHORT = 8
"""Letters of a product's name in a head, at most."""
CLOSE = (0, 0)
"""Padding with which one space parts columns, that of the box; else there are two or three."""


def print_table(console: Console, table: Table, keys: int = 1) -> None:
    """Print a table of which no word and no number is cut, however narrow the console is.

    Where it does not fit, columns stand closer; where that does not fit either, they are printed in
    several tables, each of which begins with the first `keys` columns; where one column beside
    these does not fit, lines are longer.
    """
    if _least_width(console, table) > console.width:
        table.padding, table.show_edge = CLOSE, False
    for part in _parts(console, table, keys):
        _set_widths(console, part)
        console.print(part, crop=False)
        if not part.show_edge:
            console.print()


def _parts(console: Console, table: Table, keys: int) -> list[Table]:
    if _least_width(console, table) <= console.width:
        return [table]
    first, parts = table.columns[:keys], [table.columns[: keys + 1]]
    for column in table.columns[keys + 1 :]:
        wider = [*parts[-1], column]
        if _least_width(console, _of_columns(table, wider)) <= console.width:
            parts[-1] = wider
        else:
            parts.append([*first, column])
    return [_of_columns(table, columns) for columns in parts]


def _of_columns(table: Table, columns: list[Column]) -> Table:
    part = Table(
        title=table.title, title_justify=table.title_justify, box=table.box,
        pad_edge=table.pad_edge, collapse_padding=table.collapse_padding, padding=table.padding,
        show_edge=table.show_edge,
    )  # fmt: skip
    for column in columns:
        part.add_column(
            column.header, justify=column.justify, overflow=column.overflow, no_wrap=column.no_wrap
        )
    for row in zip(*(column.cells for column in columns), strict=True):
        part.add_row(*row)
    return part


def _set_widths(console: Console, table: Table) -> None:
    """Widths with which no word is broken; what is left goes to the columns that it helps most."""
    spare = max(console.width - _least_width(console, table), 0)
    table.width = _least_width(console, table) + spare
    ranges = [_range(console, column) for column in table.columns]
    waiting = sorted(zip(ranges, table.columns, strict=True), key=lambda pair: pair[0].span)
    for number, (needed, column) in enumerate(waiting):
        given = min(needed.span, spare // (len(waiting) - number))
        column.width = needed.minimum + given
        spare -= given
    table.width -= spare


def _range(console: Console, column: Column) -> Measurement:
    """Least and largest width that a column has use for."""
    options = console.options.update_width(10_000)
    cells = [Measurement.get(console, options, cell) for cell in (column.header, *column.cells)]
    most = max(cell.maximum for cell in cells)
    least = most if column.no_wrap else max(cell.minimum for cell in cells)
    return Measurement(least, most)


def _least_width(console: Console, table: Table) -> int:
    """Characters that the table takes when its texts are broken at spaces only, and those of a
    column that is never wrapped not at all (of which rich's own minimum knows nothing)."""
    ranges = [_range(console, column) for column in table.columns]
    most = Measurement.get(console, console.options.update_width(10_000), table).maximum
    between = most - sum(size.maximum for size in ranges)
    return sum(size.minimum for size in ranges) + between


def summary_table(
    rows: Sequence[Row],
    settings: Settings,
    wide: bool = False,
    theory: Sequence[Row] = (),
    fines: str = "fines",
) -> tuple[Table, int]:
    """The summary, and how many of its columns say which row it is; `wide`: every column.
    `fines`: what the case calls the product that is not the curve's.

    `all` is left out where there is one material. Units stand in the head. `theory` has the cut
    sizes of the terminal velocity; where they are known, a column says how far off d50 is.
    """
    from elutria.output.settings import materials_of

    names = materials_of(rows)
    chosen = [row for row in rows if len(names) > 1 or row["material"] != "all"]
    keys = [name for name in settings.columns if name in (VELOCITY, *settings.varied)]
    columns = [_setting_column(name) for name in keys]
    if len(names) > 1:
        columns.append(("material", lambda row: str(row["material"])))
    number = len(columns)
    columns += _all_columns() if wide else _main_columns(chosen, fines)
    free = {(row[VELOCITY], row["material"]): row["cut_size_m"] for row in theory}
    if keys == [VELOCITY] and any(_over(row, free) != "-" for row in chosen):
        columns.append(("to free\nfall %", lambda row: _over(row, free)))
    table = Table(
        title="Classification", title_justify="left", box=SIMPLE_HEAD, pad_edge=False,
        collapse_padding=True,
    )  # fmt: skip
    for heading, _ in columns:
        words = heading == "material"
        table.add_column(heading, justify="left" if words else "right", no_wrap=True)
    for row in chosen:
        table.add_row(*(cell(row) for _, cell in columns))
    return table, number


def _setting_column(name: str) -> TableColumn:
    return ("U\nm/s" if name == VELOCITY else short(name), lambda row: shown(row[name]))


def _main_columns(rows: Sequence[Row], fines: str) -> list[TableColumn]:
    """What fits into 80 characters; losses only where there are any."""
    columns: list[TableColumn] = [
        ("d25\num", lambda row: micrometres(row["d25_m"])),
        ("d50\num", lambda row: micrometres(row["d50_m"])),
        ("95 % of d50\num", _interval),
        ("d75\num", lambda row: micrometres(row["d75_m"])),
        ("d25/\nd75", lambda row: _fixed(row["sharpness"], 3)),
        (
            f"{fines if len(fines) <= SHORT else 'fines'}\nshare",
            lambda row: _fixed(row["fines_yield"], 3),
        ),
        ("fed\nnumber", lambda row: count(row["particles_fed"])),
    ]
    if any(row["particles_lost"] != 0 for row in rows):
        columns.append(("lost\nnumber", lambda row: f"{row['particles_lost']:.12g}"))
    if any(row.get("warnings", 0) for row in rows):
        columns.append(("warnings\nnumber", lambda row: f"{row.get('warnings', 0):.0f}"))
    return columns


def _all_columns() -> list[TableColumn]:
    """Every column of summary.csv, lengths in um."""

    def cell(name: str) -> Callable[[Row], str]:
        if name.endswith("_m"):
            return lambda row: micrometres(row[name])
        if name in ("particles_fed", "particles_lost"):
            return lambda row: count(row[name])
        return lambda row: "-" if row[name] != row[name] else f"{row[name]:.4g}"

    units = {"_m": "um", "_s": "s"}
    found: list[TableColumn] = []
    for name in tables.SUMMARY[2:]:
        ending = name[name.rfind("_") :]
        unit = units.get(ending, "-")
        found.append((f"{name.removesuffix(ending) if unit != '-' else name}\n{unit}", cell(name)))
    return found


def _over(row: Row, free: Mapping[tuple[float, str], float]) -> str:
    """How far d50 lies above the size whose terminal velocity is the gas velocity, %."""
    ratio = row["d50_m"] / free.get((row[VELOCITY], row["material"]), nan)
    return "-" if ratio != ratio else f"{100 * (ratio - 1):+.1f}"


def _interval(row: Row) -> str:
    low, high = row["d50_low_m"], row["d50_high_m"]
    return "-" if low != low and high != high else f"{micrometres(low)}..{micrometres(high)}"


def count(number: float) -> str:
    """A number of particles: a whole number, though statistical weights are not."""
    return f"{number:.0f}"


def micrometres(value: float) -> str:
    """A length (m) in um: to four digits, and to the whole um from 1 cm on; `open`: infinite."""
    if isinf(value):
        return "open"
    return "-" if value != value else f"{value * 1e6:{'.0f' if value >= 0.01 else '.4g'}}"


def _fixed(value: float, digits: int) -> str:
    return "-" if value != value else f"{value:.{digits}f}"
