"""What ParaView opens: a collection of the gas and one of the particles, all written times."""

from __future__ import annotations

import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from elutria.errors import InputError
from elutria.output.vtk import write_vtk

HEAD = "FoamFile {{ version 2.0; format ascii; class {}; location here; object {}; }}\n"


@pytest.fixture
def run(column: Path) -> Path:
    """A case with two written times: gas and two parcels, a quarter of a cell from its corners."""
    if shutil.which("foamToVTK") is None:
        pytest.skip("no OpenFOAM on PATH")
    control = column / "system/controlDict"
    control.write_text(control.read_text().replace("binary", "ascii"))
    plan = column / "system/blockMeshDict"
    text = plan.read_text().replace("(10 10 49)", "(2 2 5)")
    plan.write_text(text.replace("(10 10 2)", "(2 2 1)"))
    subprocess.run(["blockMesh"], cwd=column, check=True, capture_output=True)
    for time in ("0.5", "1"):
        cloud = column / time / "lagrangian/kinematicCloud"
        cloud.mkdir(parents=True)
        shutil.copy(column / "0.orig/p", column / time)
        places = "2((0.25 0.25 0.25 0.25) 0 0 1 (0.25 0.25 0.25 0.25) 1 1 1)"
        (cloud / "coordinates").write_text(HEAD.format('"Cloud<p>"', "coordinates") + places)
        (cloud / "d").write_text(HEAD.format("scalarField", "d") + "2(1e-3 2e-3)")
    return column


@pytest.mark.parametrize("place", ["VTK", "with space/VTK"])
def test_every_written_time_is_in_both_collections(run: Path, tmp_path: Path, place: str) -> None:
    for _ in range(2):  # also over an earlier conversion
        files = write_vtk(run, tmp_path / place)
    assert [file.name for file in files] == ["gas.pvd", "particles.pvd"]
    assert not (run / "foamToVTK").exists()
    for file in files:
        entries = ElementTree.parse(file).findall(".//DataSet")
        assert [float(entry.get("timestep", "nan")) for entry in entries] == [0.5, 1.0]
        for entry in entries:
            data = ElementTree.parse(file.parent / entry.get("file", "")).getroot()
            names = {array.get("Name") for array in data.iter("DataArray")}
            assert ("p" if file.stem == "gas" else "d") in names
            assert data.find(".//Piece").get("NumberOfPoints") != "0"  # type: ignore[union-attr]


def test_no_run_is_code_2(column: Path) -> None:
    with pytest.raises(InputError, match="no written times"):
        write_vtk(column, column / "VTK")
