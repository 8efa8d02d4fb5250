"""The solver's plan of a case as it was told last: OpenFOAM need not be asked again for a case of
which no file has changed."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

from elutria.estimates.machine import cache_folder

_MOST = 200
"""Plans that are kept; the oldest go first."""
_PARTS = ("0", "0.orig", "constant", "system")


def key(case: Path, solver: str) -> str:
    """Tells a case and the solver from those before one of their files was written."""
    program = shutil.which(solver)
    libraries = sorted(Path(program).resolve().parent.parent.glob("lib/*.so")) if program else []
    files = [*_files(case), *([Path(program).resolve()] if program else []), *libraries]
    stats = [(str(file), (stat := file.stat()).st_mtime_ns, stat.st_size) for file in files]
    told = json.dumps([version("elutria"), str(case.resolve()), stats])
    return hashlib.sha256(told.encode()).hexdigest()


def _files(case: Path) -> Iterator[Path]:
    scripts = [path for path in case.glob("All*") if path.is_file()]
    yield from sorted(scripts)
    for part in _PARTS:
        yield from sorted(path for path in (case / part).rglob("*") if path.is_file())


def read(name: str) -> dict[str, Any] | None:
    """What was kept under a key."""
    with suppress(OSError, ValueError):
        content = json.loads((_folder() / f"{name}.json").read_text())
        return content if isinstance(content, dict) else None
    return None


def keep(name: str, content: dict[str, Any]) -> None:
    """Keep it; a cache that cannot be written has none."""
    with suppress(OSError):
        _folder().mkdir(parents=True, exist_ok=True)
        others = sorted(_folder().glob("*.json"), key=lambda file: file.stat().st_mtime)
        for file in others[: max(len(others) - _MOST, 0)]:
            file.unlink()
        file = _folder() / f"{name}.json"
        temporary = file.with_suffix(".new")
        temporary.write_text(json.dumps(content))
        temporary.replace(file)


def _folder() -> Path:
    return cache_folder() / "plans"
