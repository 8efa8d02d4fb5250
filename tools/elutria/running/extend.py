"""A run that goes on with other inputs: a longer drain, a longer feed, another loading from now on.

What may be changed on the way the solver knows, from its own record; where it refuses, the run's
folder is as it was.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from elutria.case.case import Case, Setting
from elutria.errors import InputError
from elutria.openfoam.own_mesh import OF_THE_MESH
from elutria.running.marker import FINISHED, MARKER, Identity, Marker

_MAY = ("constant/", "system/")
_COMPUTED_WITH = ("system/fvSchemes", "system/fvSolution", "system/scenePlan")
"""How the past was computed, which the solver's record does not hold."""
_CONTROL = "system/controlDict"
_ON_THE_WAY = re.compile("endTime|write.*|purgeWrite|functions|profiling|runTimeModifiable")
"""Entries of it that leave the past as it was."""


@contextmanager
def replaced_inputs(
    case: Case, folder: Path, settings: Iterable[Setting], before: Marker, now: Marker
) -> Iterator[None]:
    """Give the run in `folder` the files of `case` with `settings` for as long as nothing refuses
    them. Raises InputError for a file that a run cannot go on with."""
    if before.np > now.np:
        raise InputError(
            f"--np {now.np}: the run in {folder} has {before.np}; allowed: that, or more"
        )
    with tempfile.TemporaryDirectory() as place:
        copy = case.copy_to(Path(place) / case.name, settings)
        changed = _changed(copy, folder, before.identity, now.identity)
        kept = Path(place) / "before"
        for name in [*changed, MARKER, FINISHED]:
            if (folder / name).is_file():
                (kept / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(folder / name, kept / name)
        for name in changed:
            shutil.copy2(copy.path / name, folder / name)
        (folder / FINISHED).unlink(missing_ok=True)
        try:
            yield
        except InputError:
            shutil.copytree(kept, folder, dirs_exist_ok=True)
            raise


def _changed(copy: Case, folder: Path, before: Identity, now: Identity) -> list[str]:
    """The input files that differ from those that the run began with."""
    settings = set(before.settings) ^ set(now.settings)
    changed = {name for name in {*before.files, *now.files}
               if before.files.get(name) != now.files.get(name)}  # fmt: skip
    changed |= {setting.partition(":")[0] for setting in settings}
    for name in sorted(changed):
        there = (copy.path / name).is_file()
        fixed = name in _COMPUTED_WITH or OF_THE_MESH.fullmatch(name)
        if fixed or not there or not name.startswith(_MAY):
            raise _refused(name)
    if _CONTROL in changed:
        _require_on_the_way(copy, Case(folder))
    return sorted(changed)


def _require_on_the_way(now: Case, before: Case) -> None:
    was, entries = (case.dictionary(_CONTROL).entries for case in (before, now))
    for entry in {**was, **entries}:
        if was.get(entry) != entries.get(entry) and not _ON_THE_WAY.fullmatch(entry):
            raise _refused(f"{_CONTROL}: {entry}")


def _refused(what: str) -> InputError:
    return InputError(
        f"{what}: has changed since the run began, which cannot go on with it; allowed: it as it "
        "was, or a run in another folder with --to"
    )
