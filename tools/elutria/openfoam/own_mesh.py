"""Whose mesh constant/polyMesh is: the case's own, or what blockMesh left there."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
import time
from functools import lru_cache
from pathlib import Path

from elutria.errors import InputError
from elutria.files import reading
from elutria.openfoam.asked import ask
from elutria.openfoam.elsewhere import name_the_same
from elutria.openfoam.mesh import FILES
from elutria.openfoam.started import started_in

PLAN, MESH = "system/blockMeshDict", "constant/polyMesh"
OF_THE_MESH = re.compile(
    r"(system/(.*Mesh.*Dict.*|meshDict|(surface|topoSet|create|refineMesh|mirrorMesh).*Dict.*"
    r"|.*ExtrudeMesh.*)|constant/(polyMesh|triSurface|geometry|extendedFeatureEdgeMesh)/.*"
    r"|.*\.(stl|stlb|obj|vtk|eMesh|nas|py|sh)(\.gz)?)"
)
"""Files that programs which make the mesh read."""
CLOCKS_APART = 60.0
"""s: so far may the clock of a file server be ahead."""


def is_stale(case: Path) -> bool:
    """Whether system/blockMeshDict was changed after the mesh beside it was made."""
    plan, made = case / PLAN, _made(case)
    return made is not None and plan.is_file() and plan.stat().st_mtime > made


def keeps_mesh(case: Path) -> bool:
    """Whether a run takes constant/polyMesh as it is.

    It does where there is no system/blockMeshDict, or an older one of which blockMesh makes another
    mesh. Raises InputError where that is so but a file that the blockMeshDict includes is newer, or
    all of system is: the mesh may be the case's own, or an old one.
    """
    made = _made(case)
    if made is None:
        return False
    if not (case / PLAN).is_file():
        return True
    copied = is_stale(case) and _is_all_newer(case, made)
    if is_stale(case) and not copied:
        return False
    state = tuple(
        (path.name, path.stat().st_mtime_ns)
        for path in sorted((*case.glob("system/*"), *(case / MESH).glob("*")))
        if path.is_file()
    )
    if _is_made(case.resolve(), state):
        return False
    if copied:
        raise _unclear(case, f"is not what {PLAN} makes, and a copy of the case has lost which of "
                       "both is newer")  # fmt: skip
    if made > time.time() + CLOCKS_APART:
        raise _unclear(case, f"is not what {PLAN} makes, and of a time yet to come, so that nobody "
                       "can tell which of both is newer")  # fmt: skip
    answer = ask(case, PLAN)
    for name in answer.included if answer else []:
        included = case / "system" / name
        if included.is_file() and included.stat().st_mtime > made:
            raise _unclear(case, f"is not what {PLAN} makes, which includes {name}, which is newer")
    return True


def _is_all_newer(case: Path, made: float) -> bool:
    """Whether all of system is newer than the mesh, as in a copy that took constant first; who
    changes the blockMeshDict leaves other files as old as they are."""
    files = (path for path in case.glob("system/*") if path.is_file())
    return all(path.stat().st_mtime >= made for path in files)


def _unclear(case: Path, why: str) -> InputError:
    return InputError(
        f"{case.resolve().name}/{MESH}: {why}; allowed: without {MESH}, without {PLAN}, or with an "
        "Allmesh that makes the mesh"
    )


def _made(case: Path) -> float | None:
    """When the mesh was made (s since the epoch); None where there is none."""
    found = [file for name in ("faces", "faces.gz") if (file := case / MESH / name).is_file()]
    return found[0].stat().st_mtime if found else None


@lru_cache(maxsize=16)
def _is_made(case: Path, _files: tuple[object, ...]) -> bool:
    """Whether blockMesh makes just this mesh; where it cannot be run, or makes none, it does not"""
    program = shutil.which("blockMesh")
    if program is None:
        return True  # nothing can be meshed, and nothing is lost
    with tempfile.TemporaryDirectory() as place:
        copy = Path(place) / "case"
        shutil.copytree(case / "system", copy / "system")
        left = shutil.ignore_patterns("polyMesh", "settledGas")
        shutil.copytree(case / "constant", copy / "constant", ignore=left)
        name_the_same(case, copy)
        with started_in(copy, [program]) as command:
            subprocess.run(
                command, cwd=copy, capture_output=True, stdin=subprocess.DEVNULL, check=False
            )
        return all(_body(case / MESH / file) == _body(copy / MESH / file) for file in FILES)


def _body(file: Path) -> bytes:
    """A file of a mesh without its header; empty without one."""
    if not file.is_file():
        return b""
    with reading(file, 2_000_000_000):
        return file.read_bytes().partition(b"}")[2]
