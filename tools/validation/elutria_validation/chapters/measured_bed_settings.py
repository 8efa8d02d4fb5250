"""What decides whether the measured bed moves: one setting changed at a time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from elutria_validation.book.figures import label, new_figure
from elutria_validation.book.rows import Row, Section
from elutria_validation.chapters.measured_bed import (
    FASTER,
    FLOWS,
    LIMIT,
    STANDARD,
    UPPER,
    Models,
    Rise,
    carried,
    motion,
    poured,
    rise,
    settled,
)

FLOW = next(iter(FLOWS))
CHANGED: dict[str, tuple[float, Models]] = {
    "standard": (1.0, STANDARD),
    FASTER: (UPPER, STANDARD),
    "Gidaspow's drag": (1.0, replace(STANDARD, drag="GidaspowDrag")),
    "Di Felice's drag": (1.0, replace(STANDARD, drag="DiFeliceDrag")),
    "friction 0.1": (1.0, replace(STANDARD, friction=0.1)),
    "friction 0": (1.0, replace(STANDARD, friction=0.0)),
    "gas uneven by half": (1.0, replace(STANDARD, uneven=0.5)),
}
"""Factor of the gas velocity, and models."""


def bed_settings(folder: Path, quick: bool) -> Section:
    section = Section(
        "The measured bed: what decides whether it moves",
        f"The bed of two large spheres at {FLOW.velocity:g} m/s, one setting changed at a time, "
        "from the same settled bed; for information. Gas uneven by half: every other face of the "
        "bottom lets in half as much, the others so much more. Beside the void fraction at which "
        "each drag law carries the beads where they lie still.",
    )
    tried = dict(list(CHANGED.items())[:1]) if quick else CHANGED
    bed = settled(folder / "settled", poured(FLOW.sizes, 1), STANDARD)
    found: dict[str, Rise] = {}
    for k, (name, (factor, models)) in enumerate(tried.items()):
        limit = 0.2 if quick else LIMIT
        found[name] = rise(folder / str(k), bed, factor * FLOW.velocity, models, limit)
        section.rows += motion(name, FLOW, [found[name]])
        section.rows.append(
            Row.size(name, "void fraction at which the law carries beads at rest; error: itself",
                     carried(models.drag, factor * FLOW.velocity), None)
        )  # fmt: skip
    _draw(section, found)
    return section


def _draw(section: Section, found: dict[str, Rise]) -> None:
    figure, (above, below) = new_figure(125, rows=2, sharex=True)
    for name, one in found.items():
        (line,) = above.plot(one.time, 2e3 * one.mean, lw=0.8, label=name)
        below.plot(one.time, 1e3 * one.height.max(axis=1), lw=0.8, color=line.get_color())
    label(above, "", "surface, mm", fontsize=6, ncols=2)
    below.set_ylabel("highest intruder, mm")
    below.set_xlabel("time, s")
    section.figures["bed_settings"] = (
        figure, "Height of the bed's surface (twice the mean of the beads'; a bed that moves goes "
        "up and down), and of the higher intruder's centre."
    )  # fmt: skip
