"""A run's gas and particles as .vtu files with .pvd collections, which ParaView opens.

OpenFOAM's foamToVTK converts; its particles come as .vtp, which meshio cannot read, so their points
and fields are taken from the XML and written as .vtu through meshio.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from numpy.typing import NDArray

from elutria.case.case import Case
from elutria.errors import ElutriaError, InputError, one_line
from elutria.files import whole_file, writing_to
from elutria.openfoam.started import started_in


def write_vtk(case: Path, to: Path) -> list[Path]:
    """Convert all written times; gives the .pvd files. Raises InputError without a run."""
    Case(case)
    if not any(case.glob("*/lagrangian")) and not any(case.glob("[1-9]*")):
        raise InputError(f"{case}: no written times; allowed: a run of elutriaFoam")
    if shutil.which("foamToVTK") is None:
        raise InputError("foamToVTK: not found on PATH; allowed: after 'source etc/bashrc'")
    with writing_to(to):
        to.mkdir(parents=True, exist_ok=True)
    converted = _convert(case)
    try:
        gas = _write_all(sorted(converted.rglob("internal.vtu")), to / "gas")
        particles = _write_all(sorted(converted.rglob("lagrangian/**/*.vtp")), to / "particles")
    finally:
        shutil.rmtree(converted, ignore_errors=True)
    return [path for path in (gas, particles) if path is not None]


def _convert(case: Path) -> Path:
    """Run foamToVTK in the case; gives the folder of what it wrote, to be removed after use."""
    name = "elutriaConverted"
    command = ["foamToVTK", "-ascii", "-no-boundary", "-overwrite", "-name", name]
    with started_in(case, command) as placed:
        done = subprocess.run(placed, cwd=case, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        raise ElutriaError(f"foamToVTK failed in {case}: {one_line(' '.join(lines[-3:]))}")
    return case / name


def _write_all(sources: list[Path], to: Path) -> Path | None:
    """TO_0000.vtu ... and TO.pvd of the converted files of all times."""
    if not sources:
        return None
    times = []
    for source in sources:
        tree = ElementTree.parse(source)
        times.append((_time(tree), source, tree))
    entries = []
    for number, (time, source, tree) in enumerate(sorted(times, key=lambda entry: entry[0])):
        mesh = _particles(tree) if source.suffix == ".vtp" else meshio.read(source)
        target = to.with_name(f"{to.name}_{number:04d}.vtu")
        with whole_file(target) as temporary:
            meshio.write(temporary, mesh, file_format="vtu")
        entries.append((time, target.name))
    return _write_collection(entries, to.with_suffix(".pvd"))


def _write_collection(entries: list[tuple[float, str]], path: Path) -> Path:
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    for time, name in entries:
        ElementTree.SubElement(collection, "DataSet", timestep=f"{time:.12g}", file=name)
    with whole_file(path) as temporary:
        ElementTree.ElementTree(root).write(temporary, xml_declaration=True, encoding="utf-8")
    return path


def _time(tree: Any) -> float:
    """The TimeValue that foamToVTK writes into each file."""
    for array in tree.iter("DataArray"):
        if array.get("Name") == "TimeValue":
            return float((array.text or "0").split()[0])
    return 0.0


def _particles(tree: Any) -> meshio.Mesh:
    """Points and point data of an ASCII .vtp file."""
    points = _array(tree.find(".//Points/DataArray"))
    data = tree.find(".//PointData")
    fields = {} if data is None else {
        _word(array.get("Name", "")): _array(array) for array in data.findall("DataArray")
    }  # fmt: skip
    cells = [("vertex", np.arange(len(points)).reshape(-1, 1))]
    return meshio.Mesh(points.reshape(-1, 3), cells, point_data=fields)


def _array(entry: ElementTree.Element | None) -> NDArray[np.float64]:
    if entry is None or not entry.text:
        return np.zeros((0, 3))
    values = np.array(entry.text.split(), dtype=float)
    components = int(entry.get("NumberOfComponents", "1"))
    return values.reshape(-1, components) if components > 1 else values


def _word(name: str) -> str:
    return re.sub(r"\W+", "_", name)
