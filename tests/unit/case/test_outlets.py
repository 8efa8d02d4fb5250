"""Products and their patches, as the tool reads them; what is open or closed the solver says."""

from __future__ import annotations

from pathlib import Path

import pytest

from elutria.case.case import Case
from elutria.cli import main
from elutria.errors import InputError


def with_outlets(column: Path, text: str) -> Case:
    """The column with other products."""
    feed = column / "constant/feed"
    old = "coarse          (bottom);"
    assert feed.read_text().count(old) == 1
    feed.write_text(feed.read_text().replace(old, text))
    return Case(column)


def test_the_default_column_is_as_it_must_be(column: Path) -> None:
    assert Case(column).feed().outlets == {"fines": ["top"], "coarse": ["bottom"]}


def test_a_third_product_takes_what_is_neither(column: Path) -> None:
    case = with_outlets(column, "coarse (bottom); other (feedSlot);")
    assert case.feed().outlets["other"] == ["feedSlot"]


def test_a_patch_in_two_products_is_refused(column: Path) -> None:
    case = with_outlets(column, "coarse (bottom); other (top);")
    with pytest.raises(InputError, match=r"outlets/other: .* not in fines too"):
        case.feed()


def test_check_says_what_the_solver_says_of_an_open_patch(
    column: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = column / "system/blockMeshDict"
    head, rest = plan.read_text().split("    feedSlot", 1)
    plan.write_text(head + "    feedSlot" + rest.replace("wall", "patch", 1))
    with pytest.raises(SystemExit) as end:
        main(["check", str(column)])
    said = capsys.readouterr().err
    assert end.value.code == 2
    assert said.count("\n") == 1
    assert "constant/feed" in said
    assert "the open patch feedSlot belongs to no product" in said
