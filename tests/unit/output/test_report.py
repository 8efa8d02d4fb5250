"""Tables on a terminal: no digit and no column is lost, whatever the width."""

from __future__ import annotations

import io

import pytest
from rich.console import Console
from rich.table import Table

from elutria.output.report import print_table, summary_table
from elutria.tables import SUMMARY


def row(velocity: float, material: str) -> dict[str, object]:
    numbers = {
        "gas_velocity_m_s": velocity, "material": material, "d25_m": 1234.5e-6, "d50_m": 1357.9e-6,
        "d50_low_m": 1356.1e-6, "d50_high_m": 1359.6e-6, "d75_m": 1468.2e-6, "sharpness": 0.841,
        "bypass": 0.0123, "fines_yield": 0.4567, "particles_fed": 12345678.25, "particles_lost": 0,
    }  # fmt: skip
    return {**dict.fromkeys(SUMMARY, 0.0), **numbers}


WORDS = [
    "12.3456", "magnetite-of-the-second-feed", "1234", "1358", "1356..1360", "1468", "0.841",
    "0.012", "0.457", "12345678.25", "d25", "d50", "95 %", "d75", "d25/d75", "bypass", "fines",
    "fed", "lost",
]  # fmt: skip


@pytest.mark.parametrize("width", [200, 80, 60, 20])
@pytest.mark.parametrize("materials", [["quartz"], ["quartz", "magnetite-of-the-second-feed"]])
def test_no_digit_and_no_column_is_lost(width: int, materials: list[str]) -> None:
    output = io.StringIO()
    rows = [row(12.3456, name) for name in [*materials, "all"]]
    keys = len(materials)
    print_table(Console(file=output, width=width), summary_table(rows), keys)
    text = output.getvalue()
    for word in WORDS:
        if len(materials) > 1 or not word.startswith("magnetite"):
            assert word in text, word
    assert "…" not in text
    if width >= 60:
        assert max(len(line) for line in text.splitlines()) <= width
    if width == 200:
        assert text.count("d50") == 1


def test_long_texts_are_broken_at_spaces_only() -> None:
    output = io.StringIO()
    table = Table("what", "value", "from")
    table.add_row("gas", "1.2 kg/m3 and 1.8e-05 Pa s " * 5, "constant/transportPropertiesOfTheGas")
    print_table(Console(file=output, width=80), table)
    lines = output.getvalue().splitlines()
    assert max(len(line) for line in lines) <= 80
    assert "constant/transportPropertiesOfTheGas" in output.getvalue()
    assert sum(line.count("1.8e-05") for line in lines) == 5
