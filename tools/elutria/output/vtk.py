"""A run's gas and particles as files that ParaView opens, with a .pvd collection for each.

OpenFOAM's foamToVTK converts, and lists the times in .series files; these become collections.
"""

from __future__ import annotations

import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterable
from pathlib import Path

from elutria.case.case import Case
from elutria.errors import ElutriaError, InputError, one_line
from elutria.files import atomic_write, read_json, writing_to
from elutria.openfoam.started import started_in

CONVERTED = "foamToVTK"


def write_vtk(case: Path, to: Path) -> list[Path]:
    """Convert all written times; gives the .pvd files. Raises InputError without a run."""
    Case(case)
    if not any(case.glob("*/lagrangian")) and not any(case.glob("[1-9]*")):
        raise InputError(f"{case}: no written times; allowed: a run of elutriaFoam")
    if shutil.which("foamToVTK") is None:
        raise InputError("foamToVTK: not found on PATH; allowed: after 'source etc/bashrc'")
    target = to / CONVERTED
    with writing_to(to):
        to.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(target, ignore_errors=True)
        shutil.move(_convert(case), target)
    gas = _collect(target.glob("*.vtm.series"), to / "gas.pvd", _internal_mesh)
    particles = _collect(target.glob("lagrangian/*/*.vtp.series"), to / "particles.pvd")
    return [path for path in (gas, particles) if path is not None]


def _convert(case: Path) -> Path:
    """Run foamToVTK in the case; gives the folder of what it wrote there."""
    command = ["foamToVTK", "-no-boundary", "-overwrite", "-name", CONVERTED]
    with started_in(case, command) as placed:
        done = subprocess.run(placed, cwd=case, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        raise ElutriaError(f"foamToVTK failed in {case}: {one_line(' '.join(lines[-3:]))}")
    return case / CONVERTED


def _internal_mesh(blocks: Path) -> Path:
    """The cells among the blocks of a time, which have no boundary here."""
    return blocks.with_suffix("") / "internal.vtu"


def _collect(
    found: Iterable[Path], to: Path, place: Callable[[Path], Path] = lambda path: path
) -> Path | None:
    """A collection of the files that foamToVTK's series list; None where there is no series."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    for series in sorted(found):
        for entry in read_json(series)["files"]:
            file = place(series.parent / entry["name"]).relative_to(to.parent)
            ElementTree.SubElement(
                collection, "DataSet", timestep=f"{entry['time']:.12g}", file=str(file)
            )
    if len(collection) == 0:
        return None
    with atomic_write(to) as temporary:
        ElementTree.ElementTree(root).write(temporary, xml_declaration=True, encoding="utf-8")
    return to
