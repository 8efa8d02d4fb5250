"""Outlets that let nothing out, and ways out that are no outlet."""

from __future__ import annotations

from pathlib import Path

import pytest

from elutria.case.case import Case
from elutria.cli import main
from elutria.errors import InputError


def with_type(column: Path, patch: str, kind: str) -> Case:
    """The column with a patch of another type in its blockMeshDict."""
    plan = column / "system/blockMeshDict"
    head, rest = plan.read_text().split(f"    {patch}", 1)
    before, after = rest.split("type ", 1)
    plan.write_text(f"{head}    {patch}{before}type {kind};{after.split(';', 1)[1]}")
    return Case(column)


def test_the_default_column_is_as_it_must_be(column: Path) -> None:
    assert Case(column).feed().outlets == {"fines": ["top"], "coarse": ["bottom"]}


@pytest.mark.parametrize("kind", ["wall", "symmetryPlane", "cyclic"])
def test_an_outlet_that_is_closed(column: Path, kind: str) -> None:
    case = with_type(column, "bottom", kind)
    with pytest.raises(InputError) as refused:
        case.feed()
    assert "constant/feed: outlets/coarse: 'bottom' has the type" in str(refused.value)
    assert f"type {kind} in system/blockMeshDict" in str(refused.value)
    assert "allowed: a patch of type patch" in str(refused.value)


def test_check_refuses_an_open_patch_without_a_product(
    column: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with_type(column, "feedSlot", "patch")
    with pytest.raises(SystemExit) as end:
        main(["check", str(column)])
    said = capsys.readouterr().err
    assert end.value.code == 2
    assert said.count("\n") == 1
    assert "constant/feed: outlets: the open patch 'feedSlot'" in said
    assert "allowed: its name in one of fines, coarse, or the type wall" in said


def test_a_patch_interaction_may_turn_particles_back_at_an_open_patch(column: Path) -> None:
    case = with_type(column, "feedSlot", "patch")
    cloud = column / "constant/kinematicCloudProperties"
    text = cloud.read_text()
    cloud.write_text(text.replace("Model standardWallInteraction;", "Model localInteraction;"))
    case.feed()
