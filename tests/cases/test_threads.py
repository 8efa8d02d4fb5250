"""Results do not depend on the threads; those that have no core of their own are left out."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from elutria.case.case import PARAMETERS, Case, Setting
from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import change, solve
from elutria_validation.harness.programs import project_root, run_program


def box(folder: Path, threads: int) -> Path:
    contacts = Contacts(treatment="impact", more={"threads": threads})
    return BoxCase(contacts=contacts, end=1e-3).make(folder)


def test_threads_without_a_core_are_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("ELUTRIA_EXACT", raising=False)
    cores = len(os.sched_getaffinity(0))
    (line,) = re.findall(r"elutria: .*threads.*", solve(box(tmp_path / "many", 1024)))
    there = f"{cores} core{'s' if cores > 1 else ''}"
    assert line == (
        f"elutria: cellListCoeffs: threads 1024 -> {cores}: there {'are' if cores > 1 else 'is'} "
        f"{there} for each process (ELUTRIA_EXACT=yes takes 1024)"
    )
    monkeypatch.setenv("OMP_THREAD_LIMIT", "1")
    assert "threads 2 -> 1: there is 1 core" in solve(box(tmp_path / "limited", 2))
    monkeypatch.setenv("ELUTRIA_EXACT", "yes")
    assert "threads 2 ->" not in solve(box(tmp_path / "exact", 2))


def test_what_parcels_see_does_not_depend_on_the_threads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With turbulent dispersion and the correction of the gas that parcels have slowed."""
    monkeypatch.setenv("ELUTRIA_EXACT", "yes")
    parameters = {"particles": 1500, "feedTime": 0.2, "drainTime": 0.05}
    settings = [Setting.parse(f"{PARAMETERS}:{name}={value}") for name, value in parameters.items()]
    found = []
    for threads in (1, 2, 3):
        case = Case(project_root() / "cases/column").copy_to(tmp_path / str(threads), settings).path
        entry = "constant/kinematicCloudProperties:subModels/cellListCoeffs/threads"
        change(case, {entry: threads})
        run_program(["blockMesh"], case)
        solve(case)
        inside = (case / "postProcessing/inside.csv").read_bytes()
        assert len(inside.splitlines()) > 1024, "too few for several threads"
        found.append((inside, recorded(case), *written(case)))
    assert found[1] == found[0]
    assert found[2] == found[0]


def recorded(case: Path) -> bytes:
    return (case / "postProcessing/outlets/0/particles.csv").read_bytes()


def written(case: Path) -> list[bytes]:
    """What the last time holds of the parcels."""
    folder = max(
        (f for f in case.iterdir() if re.fullmatch(r"[0-9.]+", f.name)), key=lambda f: float(f.name)
    )
    return [
        (folder / f"lagrangian/kinematicCloud/{name}").read_bytes()
        for name in ("U", "UTurb", "positions", "angularMomentum")
    ]
