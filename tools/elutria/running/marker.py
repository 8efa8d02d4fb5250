"""What a folder holds: `elutria.json` says it of a run, `sweep.json` of the results of a sweep.

Both know the case by the contents of its files, wherever it lies and whatever it is called.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields
from importlib.metadata import version
from pathlib import Path
from typing import Any

from elutria.case.case import Case, Setting
from elutria.errors import InputError
from elutria.files import read_json, write_json

MARKER = "elutria.json"
FINISHED = "finished.json"
SWEEP = "sweep.json"


@dataclass(frozen=True)
class Identity:
    """A case by its name, the SHA-256 of its files, and the settings that it was given."""

    case: str
    files: Mapping[str, str] = field(default_factory=dict)
    settings: tuple[str, ...] = ()

    @classmethod
    def of(cls, case: Case, settings: Iterable[Setting]) -> Identity:
        """Of a case with settings."""
        return cls(case.name, case.file_hashes(), tuple(map(str, settings)))

    def differences(self, other: Identity) -> list[str]:
        """The files and settings in which `other` differs, in words."""
        names = sorted({*self.files, *other.files})
        found = [name for name in names if self.files.get(name) != other.files.get(name)]
        mine, theirs = (dict(_halves(s) for s in one.settings) for one in (self, other))
        for name in sorted({*mine, *theirs}):
            before, now = mine.get(name, "not set"), theirs.get(name, "not set")
            if before != now:
                found.append(f"{name} ({before}, now {now})")
        return found

    def is_of(self, other: Identity) -> bool:
        """Whether a run is one of results: of their case, with their settings, and more."""
        return self.files == other.files and (
            self.settings[: len(other.settings)] == other.settings
        )


def _halves(setting: str) -> tuple[str, str]:
    name, _, value = setting.partition("=")
    return name, value


@dataclass(frozen=True)
class Marker:
    """What `elutria.json` of a run says.

    `inputs` is the hash of all inputs; `ready`: everything before the solver is done; `spent_s` is
    what earlier starts took, `started` when (s since 1970) the last one began.
    """

    identity: Identity
    inputs: str
    np: int = 1
    replicate: int = 1
    ready: bool = False
    spent_s: float = 0.0
    started: float = 0.0

    def write(self, folder: Path) -> None:
        """Into the folder of a run."""
        content = asdict(self)
        write_json(
            folder / MARKER,
            {**content.pop("identity"), **content, "elutria": version("elutria")},
        )

    @classmethod
    def read(cls, folder: Path) -> Marker | None:
        """Of the run in a folder; None where there is none, or one of an older elutria."""
        try:
            content = read_json(folder / MARKER)
            names = [item.name for item in fields(cls) if item.name != "identity"]
            return cls(_identity(content), **{name: content[name] for name in names})
        except (InputError, KeyError, TypeError):
            return None

    def ended(self, folder: Path, log: str) -> float:
        """Seconds that all starts took until the last word in the log."""
        with suppress(OSError):
            return self.spent_s + max((folder / log).stat().st_mtime - self.started, 0.0)
        return self.spent_s


def runs_of(folder: Path, identity: Identity) -> Iterator[tuple[Path, Marker]]:
    """The complete runs in a folder of results, by their names, that are of this case and have its
    settings before their own. One that was steered on its way is none."""
    for path in sorted(file.parent for file in folder.glob(f"*/{FINISHED}")):
        marker = Marker.read(path)
        if marker is not None and marker.identity.is_of(identity):
            with suppress(InputError):
                if read_json(path / FINISHED).get("inputs") == marker.inputs:
                    yield path, marker


def identity_of(folder: Path) -> Identity | None:
    """What the results in a folder are of; None where they do not say."""
    with suppress(InputError, KeyError, TypeError):
        return _identity(read_json(folder / SWEEP))
    return None


def now() -> float:
    """Seconds since 1970."""
    return time.time()


def _identity(content: Mapping[str, Any]) -> Identity:
    return Identity(content["case"], dict(content["files"]), tuple(content["settings"]))


def open_results(folder: Path, identity: Identity) -> dict[str, Any]:
    """What `sweep.json` of a folder says, {} of a new one. Raises InputError where the folder is of
    another case, of this one before it was changed, or is a run itself."""
    if (folder / MARKER).is_file():
        raise InputError(
            f"{folder}: is the folder of a run; choose another folder for a sweep with --to"
        )
    if not (folder / SWEEP).is_file():
        return {}
    content = read_json(folder / SWEEP)
    try:
        before = _identity(content)
    except (KeyError, TypeError):
        raise InputError(
            f"{folder / SWEEP}: does not say what the results are of (an older elutria wrote it); "
            "choose another folder with --to, or remove this one"
        ) from None
    found = before.differences(identity)
    if before.files != identity.files and before.case != identity.case:
        raise InputError(
            f"{folder}: holds results of the case '{before.case}', not of '{identity.case}'; "
            "choose another folder with --to, or remove this one"
        )
    if found:
        raise InputError(
            f"{folder}: holds results of '{before.case}' before these changed: "
            f"{', '.join(found)}; choose another folder with --to, or remove this one"
        )
    return content
