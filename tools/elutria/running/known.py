"""What a check tells of a case: the solver's plan, which is kept until a file of it changes."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from elutria.openfoam import kept
from elutria.openfoam.elsewhere import named_elsewhere


def plan_of(path: Path) -> dict[str, Any]:
    """A case's gas velocity (m/s), the solver's plan of it, and whether a run keeps its mesh.
    Raises InputError for what is wrong."""
    words = ("-plan", str(path.resolve()), *_dates(path), *_elsewhere(path))
    name = kept.key(path, kept.inputs(path), "elutriaFoam", *words)
    known = kept.read(name, path)
    if known is None:
        known = _asked(path)
        kept.keep(name, path, known)
    return known


def _dates(path: Path) -> list[str]:
    """When files were written, where there is a mesh: its age decides whether a run takes it."""
    mesh = path / "constant/polyMesh"
    files = [*mesh.glob("*"), *path.glob("system/*")] if mesh.is_dir() else []
    return [f"{file} {file.stat().st_mtime_ns}" for file in sorted(files) if file.is_file()]


def _elsewhere(path: Path) -> list[str]:
    """What files outside of the case's folders hold that it names."""
    return [f"{name} {hashlib.sha256(file.read_bytes()).hexdigest()}"
            for name, file in named_elsewhere(path).items()]  # fmt: skip


def _asked(path: Path) -> dict[str, Any]:
    from elutria.case.case import Case
    from elutria.estimates.check import check_text
    from elutria.running.run import ask_plan

    source = Case(path)
    check_text(source)
    plan = ask_plan(source)
    return {"velocity": source.velocity(), "plan": plan, "keeps_mesh": source.keeps_mesh}
