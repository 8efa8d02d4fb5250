"""Tables for the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.measure import Measurement
from rich.table import Column, Table


def print_table(console: Console, table: Table, keys: int = 1) -> None:
    """Print a table of which no word and no number is cut, however narrow the console is.

    Where it does not fit, columns are printed in several tables, each of which begins with the
    first `keys` columns; where one column beside these does not fit, lines are longer.
    """
    for part in _parts(console, table, keys):
        _set_widths(console, part)
        console.print(part, crop=False)


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
        pad_edge=table.pad_edge, collapse_padding=table.collapse_padding,
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
    """Characters that the table takes when its texts are broken at spaces only."""
    return Measurement.get(console, console.options.update_width(10_000), table).minimum


def summary_table(rows: Iterable[Mapping[str, Any]]) -> Table:
    """The summary with sizes in um; `all` is left out where there is one material."""
    rows = list(rows)
    names = {row["material"] for row in rows} - {"all"}
    table = Table(
        title="Classification (sizes in um)", title_justify="left", box=SIMPLE_HEAD, pad_edge=False,
        collapse_padding=True,
    )  # fmt: skip
    headings = ["m/s", "d25", "d50", "95 %", "d75", "d25/d75", "bypass", "fines", "fed", "lost",
                "warnings"]  # fmt: skip
    if len(names) > 1:
        headings.insert(1, "material")
    for heading in headings:
        words = heading == "material"
        table.add_column(heading, justify="left" if words else "right", no_wrap=True)
    for row in rows:
        if len(names) == 1 and row["material"] == "all":
            continue
        table.add_row(
            f"{row['gas_velocity_m_s']:g}",
            *([str(row["material"])] if len(names) > 1 else []),
            _micrometres(row["d25_m"]),
            _micrometres(row["d50_m"]),
            f"{_micrometres(row['d50_low_m'])}..{_micrometres(row['d50_high_m'])}",
            _micrometres(row["d75_m"]),
            _fixed(row["sharpness"], 3),
            _fixed(row["bypass"], 3),
            _fixed(row["fines_yield"], 3),
            f"{row['particles_fed']:.12g}",
            f"{row['particles_lost']:.12g}",
            f"{row['warnings']:g}",
        )
    return table


def _micrometres(value: float) -> str:
    return "-" if value != value else f"{value * 1e6:.4g}"


def _fixed(value: float, digits: int) -> str:
    return "-" if value != value else f"{value:.{digits}f}"
