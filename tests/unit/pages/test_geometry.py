"""The mesh's outline: the edges of a box, read from either format, seen the right way up."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from elutria.pages.geometry import project, read_outline

HEAD = "FoamFile {{ version 2.0; format ascii; class {}; location here; object {}; }}\n"
BOX = {
    "points": ("vectorField", "8((0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 2)(1 0 2)(1 1 2)(0 1 2))"),
    "faces": (
        "faceList",
        "6(4(0 3 2 1)4(4 5 6 7)4(0 1 5 4)4(1 2 6 5)4(2 3 7 6)4(3 0 4 7))",
    ),
    "boundary": (
        "polyBoundaryMesh",
        "3(bottom {type patch; nFaces 1; startFace 0;} top {type patch; nFaces 1; startFace 1;}"
        " walls {type wall; nFaces 4; startFace 2;})",
    ),
}


def test_a_box_has_twelve_edges(tmp_path: Path) -> None:
    for name, (kind, text) in BOX.items():
        (tmp_path / name).write_text(HEAD.format(kind, name) + text)
    outline = read_outline(tmp_path, {"top"})
    assert outline is not None
    found = {tuple(sorted(line)) for line in outline.lines.tolist()}
    ends = np.array([outline.points[list(line)] for line in found])
    assert len(found) == 12
    assert set(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)) == {1.0, 2.0}
    assert [face.tolist() for face in outline.patches["top"]] == [[4, 5, 6, 7]]


def test_faces_in_one_plane_have_no_edge_between_them(column: Path) -> None:
    """blockMesh's binary files; the default column is 50 x 50 x 500 mm with a slot."""
    if shutil.which("blockMesh") is None:
        pytest.skip("no OpenFOAM on PATH")
    done = subprocess.run(["blockMesh"], cwd=column, check=False, capture_output=True)
    if done.returncode != 0:
        pytest.skip("blockMesh does not start: source etc/bashrc")
    outline = read_outline(column / "constant/polyMesh", {"feedSlot"})
    assert outline is not None
    ends = outline.points[outline.lines]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum()
    # 4 edges of 0.5 m, 8 of 0.05 m, and the slot's two long sides
    assert length == pytest.approx(4 * 0.5 + 10 * 0.05)
    assert sum(face.size for face in outline.patches["feedSlot"]) == 4 * 20


@pytest.mark.parametrize("down", [(0, 0, -9.81), (0, -9.81, 0), (3.0, 0, -4.0)])
def test_gravity_points_down_in_the_picture(down: tuple[float, float, float]) -> None:
    gravity = np.array(down)
    low, high = project(np.array([[0.1, 0.2, 0.3], np.array([0.1, 0.2, 0.3]) - gravity]), gravity)
    assert high[1] > low[1]
    assert high[0] == pytest.approx(low[0])


def test_no_mesh_is_no_picture(tmp_path: Path) -> None:
    assert read_outline(tmp_path, set()) is None
