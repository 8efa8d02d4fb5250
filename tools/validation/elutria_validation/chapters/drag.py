"""Every drag law of the solver against its formula, over Reynolds number and void fraction."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib import rc_context
from numpy.typing import NDArray

from elutria.output.plots import MATERIAL_COLOURS, STYLE, new_figure
from elutria.physics.drag import LAWS, SUSPENSION_LAWS, Gas
from elutria_validation.book.book import Chapter, Row, Section, write_chapter
from elutria_validation.harness.common import Options
from elutria_validation.harness.scene import (
    BOX,
    CLOUD,
    CONTROL,
    MODELS,
    Particles,
    make_scene,
    read_particles,
    run_scene,
    times,
)

NAME = "drag"
HELP = "Every drag law against its formula, over Reynolds number and void fraction."

Array = NDArray[np.float64]

GAS = Gas()
REYNOLDS = np.geomspace(2e-2, 1e4, 27)
DIAMETER, DENSITY = 1e-3, 2650.0
# force of the solver, law, sphericity
SINGLE = (
    ("SchillerNaumannDrag", "Schiller-Naumann", 1.0), ("CliftDrag", "Clift", 1.0),
    ("HaiderLevenspielDrag", "Haider-Levenspiel", 1.0),
    ("HaiderLevenspielDrag", "Haider-Levenspiel", 0.7), ("GanserDrag", "Ganser", 1.0),
    ("GanserDrag", "Ganser", 0.7), ("sphereDrag", "Putnam", 1.0),
)  # fmt: skip
DENSE = ("WenYuVoidDrag", "GidaspowDrag", "BeetstraDrag", "DiFeliceDrag", "ErgunWenYuDrag")


@rc_context(STYLE)
def run(options: Options) -> Chapter:
    """Single-particle laws, laws for suspensions, use out of range."""
    chapter = Chapter(NAME, "Drag laws")
    with TemporaryDirectory() as work:
        _single(chapter, Path(work))
        _suspensions(chapter, Path(work))
        _out_of_range(chapter, Path(work))
    return write_chapter(options, chapter)


def drag_coefficients(folder: Path, force: dict[str, Any], solids: float) -> tuple[Array, str]:
    """Cd at REYNOLDS and what the solver said: spheres of a lattice fly through gas at rest.

    Each is slowed for a moment so short that its drag hardly changes. The gas' void fraction is
    1 less `solids`.
    """
    number = len(REYNOLDS)
    cells = round(number ** (1 / 3))
    side = (number * np.pi / 6 * DIAMETER**3 / solids) ** (1 / 3)
    grid = np.stack(np.meshgrid(*[np.arange(cells)] * 3), axis=-1).reshape(-1, 3)
    speed = REYNOLDS * GAS.viscosity / (GAS.density * DIAMETER)
    velocity = np.stack([np.zeros(number), np.zeros(number), speed], axis=1)
    start = Particles.of((grid + 0.5) / cells * side, velocity, diameter=DIAMETER, density=DENSITY)
    # a rate of 1/s at most: Cd Re of 1e4 is about 1e4
    step = 1e-7
    case = make_scene(
        folder,
        start,
        {
            **{f"{BOX}:{name}": side for name in ("width", "depth", "height")},
            **{f"{BOX}:{name}": "cyclic" for name in ("sides", "ends")},
            **{f"{BOX}:{name}": "closed" for name in ("bottomGroup", "topGroup")},
            f"{BOX}:gravity": 0,
            f"{CLOUD}:constantProperties/alphaMax": 0.9,
            f"{MODELS}/particleForces": force,
            f"{CONTROL}:deltaT": step,
            f"{CONTROL}:endTime": step,
            f"{CONTROL}:writeInterval": step,
        },
    )
    said = run_scene(case)
    after = read_particles(case, times(case)[-1]).velocity[:, 2]
    # at the mean speed of the step
    slowed = -np.log(after / speed) / step * np.sqrt(after / speed) * speed
    area_over_mass = 1.5 / (DENSITY * DIAMETER)
    return slowed / (0.5 * GAS.density * speed * after * area_over_mass), said


def _judge(
    section: Section, case: str, ours: Array, formula: Array, checked: str, allowed: float
) -> None:
    errors = np.abs(ours / formula - 1)
    k = int(errors.argmax())
    section.rows.append(
        Row(
            case, f"{checked}, worst of {len(ours)} Re from 0.02 to 1e4 (Re {REYNOLDS[k]:.3g})",
            formula[k], ours[k], errors[k], allowed,
        )
    )  # fmt: skip


def _single(chapter: Chapter, folder: Path) -> None:
    section = chapter.section(
        "Drag laws of single particles",
        "Spheres fly through gas at rest for 1e-7 s: the drag coefficient from their change of "
        "velocity, against the formula written independently in Python. Then Clift's standard "
        "curve against its published values.",
    )
    figure, (axes,) = new_figure(65)
    for (force, law, sphericity), colour in zip(
        SINGLE, (*MATERIAL_COLOURS, "#000000"), strict=True
    ):
        entries = {} if force == "sphereDrag" else {"sphericity": sphericity}
        ours, _ = drag_coefficients(folder / f"{force}{sphericity}", {force: entries}, 1e-6)
        formula = np.array([LAWS[law](re, sphericity) for re in REYNOLDS])
        case = f"{force} ({law}), sphericity {sphericity:g}"
        _judge(section, case, ours, formula, "Cd", 1e-6)
        standard = np.array([LAWS["Clift"](re, 1) for re in REYNOLDS])
        label = law if sphericity == 1 else f"{law}, sphericity {sphericity:g}"
        axes.semilogx(REYNOLDS, formula / standard, "-", color=colour, label=label)
        axes.semilogx(REYNOLDS, ours / standard, ".", color=colour, markersize=4)
    axes.set_ylim(0.6, 3)
    axes.set_xlabel("Reynolds number")
    axes.set_ylabel("Cd over Clift's standard curve")
    axes.legend(title="lines: formula; dots: elutriaFoam", title_fontsize=7)
    section.figures["single"] = (figure, "Drag laws over the standard curve for spheres.")
    for reynolds, published in {0.5: 51.54, 50: 1.574, 500: 0.5549, 2500: 0.4082}.items():
        ours_at = LAWS["Clift"](reynolds, 1)
        section.rows.append(
            Row.relative("Clift's standard curve", f"Cd at Re {reynolds:g}", published, ours_at,
                         5e-4)
        )  # fmt: skip


def _suspensions(chapter: Chapter, folder: Path) -> None:
    section = chapter.section(
        "Drag laws of suspensions",
        "The same on a lattice of spheres at five void fractions. ErgunWenYuDrag is OpenFOAM's "
        "own. "
        "The figure shows the laws at void fraction 0.6: they differ by more than any numerical "
        "error.",
    )
    figure, (axes,) = new_figure(65)
    for force, colour in zip(DENSE, MATERIAL_COLOURS, strict=False):
        law = SUSPENSION_LAWS[force]
        for void in (0.95, 0.85, 0.75, 0.6, 0.5):
            entries = {force: {"alphac": "alpha.air"}}
            ours, _ = drag_coefficients(folder / f"{force}{void}", entries, 1 - void)
            formula = np.array([law(re, void) for re in REYNOLDS])
            _judge(section, f"{force}, void fraction {void:g}", ours, formula, "Cd", 1e-6)
            if void == 0.6:
                alone = np.array([LAWS["Schiller-Naumann"](re, 1) for re in REYNOLDS])
                axes.loglog(REYNOLDS, formula / alone, "-", color=colour, label=force)
                axes.loglog(REYNOLDS, ours / alone, ".", color=colour, markersize=4)
    axes.set_xlabel("Reynolds number (interstitial slip)")
    axes.set_ylabel("drag over that of a single sphere")
    axes.legend(title="lines: formula; dots: elutriaFoam", title_fontsize=7)
    section.figures["suspensions"] = (figure, "Drag laws at void fraction 0.6.")


def _out_of_range(chapter: Chapter, folder: Path) -> None:
    section = chapter.section(
        "Use of a drag law out of its range",
        "The solver reports the first use of a law beyond the Reynolds numbers and void fractions "
        "it was made for. Reference 1: must report; 0: must not.",
    )
    for force, solids, expected in (
        ("BeetstraDrag", 0.1, 1), ("SchillerNaumannDrag", 1e-6, 0),
        ("SchillerNaumannDrag", 0.3, 1), ("WenYuVoidDrag", 0.3, 0), ("WenYuVoidDrag", 0.6, 1),
    ):  # fmt: skip
        _, said = drag_coefficients(
            folder / f"range{force}{solids}", {force: {"alphac": "alpha.air"}}, solids
        )
        reported = int(f"Warning: {force} is used at" in said)
        section.rows.append(
            Row(f"{force}, Re up to 1e4, void fraction {1 - solids:g}", "reported", expected,
                reported, abs(expected - reported), 0)
        )  # fmt: skip
