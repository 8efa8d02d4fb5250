"""The verification book's quick rows: what the book judges, in minutes; all chapters when slow."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import rc_context

from elutria.output.style import STYLE
from elutria_validation.book.page import ORDER
from elutria_validation.book.writing import run_chapter
from elutria_validation.chapters import measured_bed
from elutria_validation.harness.job import Job
from elutria_validation.harness.particles import Particles

QUICK = {
    "contacts": ("bounce", "slip_to_roll"),
    "impacts": ("gross_sliding",),
    "settling": ("dem06", "stiff"),
    "drag": ("single", "spheres", "drops", "isometric", "suspensions", "out_of_range"),
    "clouds": ("hindered",),
    "dispersion": ("well_mixed",),
    "wake": ("hovering",),
    "budgets": ("momentum",),
    "classification": ("plug_flow",),
    "measured": ("pipe", "seeds", "riser"),
}
"""Sections whose short version takes seconds."""
FAIL = {
    "measured": {
        "SchillerNaumannDrag, from feed to curve",  # docs/verification/notes/measured.md
        "hollow glass",
    }
}
"""Cases of rows that fail and are said to in the book: what they judge is a law or a model."""


def chapter(name: str) -> Any:
    return importlib.import_module(f"elutria_validation.chapters.{name}")


@pytest.mark.parametrize(
    ("name", "section"), [(name, section) for name, found in QUICK.items() for section in found]
)
def test_a_section_passes(tmp_path: Path, measured, name: str, section: str) -> None:
    (make,) = (one for one in chapter(name).SECTIONS if one.__name__ == section)
    with rc_context(STYLE):
        judged = [row for row in make(tmp_path, True).rows if row.allowed is not None]
    assert judged
    for row in judged:
        measured(f"{row.case}: {row.checked}", row.error, row.allowed)


def test_the_measured_bed_starts(tmp_path: Path, monkeypatch) -> None:
    """Beads and intruders that lie there already are of two materials; nothing is fed."""
    whole = measured_bed.poured([measured_bed.INTRUDERS["large"]], 1)
    few = np.r_[:20, -1]
    start = Particles.of(whole.position[few], 0, 0, whole.diameter[few], whole.density[few])
    monkeypatch.setattr(measured_bed, "SETTLING", 1e-3)
    bed = measured_bed.settled(tmp_path / "bed", start, measured_bed.STANDARD)
    assert sorted(bed.density) == sorted(start.density)


@pytest.mark.slow
@pytest.mark.parametrize("name", ORDER)
def test_a_chapter_runs_whole(tmp_path: Path, name: str) -> None:
    module = chapter(name)
    job = Job(tmp_path / name, quick=True)
    found = run_chapter(job, module.NAME, module.TITLE, module.SECTIONS)
    assert found.judged
    assert {row.case for row in found.failed} == FAIL.get(name, set())
