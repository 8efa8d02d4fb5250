"""Tables on a terminal: no digit and no column is lost, whatever the width."""

from __future__ import annotations

import io

import pytest
from rich.console import Console
from rich.table import Table

from elutria.output.settings import Settings
from elutria.output.terminal import print_table, summary_table
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
    "0.457", "12345678", "d25", "d50", "95 % of d50", "d75", "d25/", "fines", "fed", "m/s", "um",
    "number",
]  # fmt: skip


def printed(
    rows: list[dict[str, object]],
    width: int,
    wide: bool = False,
    theory: list[dict[str, object]] | None = None,
) -> str:
    output = io.StringIO()
    table, keys = summary_table(rows, Settings(rows, rows), wide, theory or [])
    print_table(Console(file=output, width=width), table, keys)
    return output.getvalue()


@pytest.mark.parametrize("width", [200, 80, 60, 20])
@pytest.mark.parametrize("materials", [["quartz"], ["quartz", "magnetite-of-the-second-feed"]])
def test_no_digit_and_no_column_is_lost(width: int, materials: list[str]) -> None:
    text = printed([row(12.3456, name) for name in [*materials, "all"]], width)
    for word in WORDS:
        if len(materials) > 1 or not word.startswith("magnetite"):
            assert word in text, word
    assert "…" not in text
    assert "12345678.25" not in text  # a count is a whole number
    if width >= 60:
        assert max(len(line) for line in text.splitlines()) <= width
    if width == 200 or (width == 80 and len(materials) == 1):
        assert text.count("95 % of d50") == 1  # in one part


def test_several_materials_fit_into_80_characters() -> None:
    text = printed([row(4.5, name) for name in ("quartz", "magnetite", "coal", "all")], 80)
    assert text.count("magnetite") == 1


@pytest.mark.parametrize("varied", [{}, {"system/simulationParameters:loading": 0.25}])
def test_all_columns_fit_into_80_characters(varied: dict[str, object]) -> None:
    """Of three materials, with warnings, and with the free fall or one more setting."""
    names = ("quartz", "magnetite", "coal", "all")
    rows = [row(u, name) | {"warnings": 2} | {k: v * u for k, v in varied.items()}
            for u in (4.5, 5.0) for name in names]  # fmt: skip
    theory: list[dict[str, object]] = [
        {"gas_velocity_m_s": 4.5, "material": "coal", "cut_size_m": 1e-3}
    ]
    lines = printed(rows, 80, theory=theory).splitlines()
    assert max(len(line) for line in lines) <= 80
    assert sum("coal" in line for line in lines) == 2  # in one part
    head = " ".join(lines[1:3])
    for word in ("warnings", "d25/", "95 % of d50", "loading" if varied else "to free"):
        assert word in head


def test_large_numbers_keep_all_digits() -> None:
    rows = [row(5, name) | {"constant/feed:seed": seed, "d75_m": 0.123456}
            for seed in (12345678, 12345679) for name in ("quartz", "all")]  # fmt: skip
    text = printed(rows, 80)
    for word in ("12345678", "12345679", "123456"):
        assert word in text.split()


def test_how_far_the_cut_is_from_that_of_the_terminal_velocity() -> None:
    rows = [row(4.5, name) for name in ("quartz", "magnetite", "coal", "all")]
    theory = [{"gas_velocity_m_s": 4.5, "material": "quartz", "cut_size_m": 1000e-6},
              {"gas_velocity_m_s": 4.5, "material": "coal", "cut_size_m": 1500e-6},
              {"gas_velocity_m_s": 4.0, "material": "magnetite", "cut_size_m": 1e-3}]  # fmt: skip
    lines = printed(rows, 80, theory=theory).splitlines()
    found = {line.split()[1]: line.split()[-1] for line in lines if line.split()[:1] == ["4.5"]}
    # 1357.9 um are 35.8 % above 1000 and 9.5 % below 1500
    assert found == {"quartz": "+35.8", "magnetite": "-", "coal": "-9.5", "all": "-"}
    assert max(len(line) for line in lines) <= 80


@pytest.mark.parametrize("name, head", [("light", "light"), ("light + dust", "fines")])
def test_a_product_has_the_name_of_the_case_where_it_is_short(name: str, head: str) -> None:
    rows = [row(5, "quartz"), row(5, "all")]
    table, _ = summary_table(rows, Settings(rows, rows), fines=name)
    assert f"{head}\nshare" in [column.header for column in table.columns]


def test_an_interval_that_is_open_or_not_known_is_a_word() -> None:
    rows = [row(u, name) for u in (5, 6) for name in ("quartz", "all")]
    rows[0]["d50_high_m"] = float("inf")
    rows[2] |= {"d50_low_m": float("nan"), "d50_high_m": float("nan")}
    words = printed(rows, 80).split()
    assert "1356..open" in words
    assert "-" in words
    assert "-..-" not in words


def test_losses_are_a_column_where_there_are_any() -> None:
    rows = [row(5, "quartz"), row(5, "all")]
    assert "lost" not in printed(rows, 80)
    rows[0]["particles_lost"] = 0.25
    text = printed(rows, 80)
    assert "lost" in text
    assert "0.25" in text


@pytest.mark.parametrize("width", [400, 80])
def test_wide_has_every_column(width: int) -> None:
    rows = [row(5, "quartz"), row(5, "all")]
    rows[0] |= {"bypass": 0.0123, "wall_time_s": 71.5, "mass_closure_error": 1.25e-16}
    text = printed(rows, width, wide=True)
    for name in SUMMARY[2:]:
        assert name.removesuffix("_m").removesuffix("_s") in text, name
    for value in ("0.0123", "71.5", "1.25e-16"):
        assert value in text
    assert max(len(line) for line in text.splitlines()) <= width


def test_what_a_sweep_varied_stands_before_the_numbers() -> None:
    rows = [row(5, name) | {"constant/feed:loading": x} for x in (0.1, 0.5)
            for name in ("quartz", "all")]  # fmt: skip
    lines = printed(rows, 80).splitlines()
    assert "loading" in "".join(lines[:4])
    assert [line.split()[:2] for line in lines if line.split()[:1] == ["5"]] == [
        ["5", "0.1"], ["5", "0.5"],
    ]  # fmt: skip


def test_long_texts_are_broken_at_spaces_only() -> None:
    output = io.StringIO()
    table = Table("what", "value", "from")
    table.add_row("gas", "1.2 kg/m3 and 1.8e-05 Pa s " * 5, "constant/transportPropertiesOfTheGas")
    print_table(Console(file=output, width=80), table)
    lines = output.getvalue().splitlines()
    assert max(len(line) for line in lines) <= 80
    assert "constant/transportPropertiesOfTheGas" in output.getvalue()
    assert sum(line.count("1.8e-05") for line in lines) == 5
