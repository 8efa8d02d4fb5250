"""One run: copy the case, mesh it, solve it, and mark it finished.

A run's folder holds `elutria.json` (what it is a run of) from the start and `finished.json` once it
is complete. Programs are started in the run's folder, so that no name of a file or folder is ever
part of a command line.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elutria.case.case import Case, Setting
from elutria.errors import ElutriaError, InputError, one_line
from elutria.files import read_json, write_json, writing_to
from elutria.openfoam.started import started_in

if TYPE_CHECKING:
    from elutria.case.feed import Feed
    from elutria.running.solver import Step

SOLVER = "elutriaFoam"
SETTLED_GAS = "constant/settledGas"
STEERING = "system/steering"
PLAN = "postProcessing/plan.json"
MARKER = "elutria.json"
FINISHED = "finished.json"


@dataclass(frozen=True)
class Goal:
    """When the run in `folder` is done: all are fed and none is inside, or the latest time."""

    folder: Path
    asked: int | None
    latest: float

    @cached_property
    def parcels(self) -> int | None:
        """As the solver's plan says once it is written; before, those that the feed asks for."""
        feed = read_plan(self.folder).get("feed") if (self.folder / PLAN).is_file() else None
        return self.asked if feed is None else feed["parcels"]

    def share(self, step: Step) -> float:
        """How far the run is, 0..1."""
        by_time = step.time / self.latest if self.latest > 0 else 0.0
        if not self.parcels:
            return min(by_time, 1.0)
        by_number = (0.5 * step.fed + 0.5 * (step.fines + step.coarse)) / self.parcels
        return min(max(by_number, by_time), 1.0)


def _goal(case: Case, feed: Feed) -> Goal:
    end = case.dictionary("system/controlDict").number("endTime", 0.0)
    return Goal(case.path, feed.particles, end)


def is_finished(folder: Path, fingerprint: str) -> bool:
    """Whether `folder` holds a complete run of exactly these inputs."""
    try:
        return bool(read_json(folder / FINISHED).get("inputs") == fingerprint)
    except InputError:
        return False


def wall_time(folder: Path) -> float:
    """Seconds that a finished run took. Raises InputError when it is not finished."""
    value = read_json(folder / FINISHED).get("wall_time_s")
    if not isinstance(value, (int, float)):
        raise InputError(f"{folder / FINISHED}: wall_time_s: must be a number")
    return float(value)


def run_case(
    case: Case,
    folder: Path,
    settings: Iterable[Setting],
    np: int = 1,
    on_step: Callable[[float, Step], None] = lambda *_: None,
    neighbour: Path | None = None,
    *,
    frames: bool = False,
) -> Case:
    """Run `case` with `settings` in `folder`; a complete run of the same inputs is not run again.

    `on_step` gets the share done (0..1) and the solver's numbers. The gas starts from that of the
    run in the folder `neighbour`, where that has settled. With `frames`, the solver records them
    and can be steered; a run that was steered is one of other inputs. Raises InputError before
    anything is run, ElutriaError with the solver's reason when it fails.
    """
    from elutria.classification.events import read_run  # pandas, which a check does not need

    settings = list(settings)
    fingerprint = case.fingerprint(settings, np)
    with _lock(folder):
        if is_finished(folder, fingerprint):
            return Case(folder)
        _need_programs(np)
        _clear(folder)
        start = time.monotonic()
        copy = case.copy_to(folder, settings)
        write_json(folder / MARKER, {"case": case.name, "inputs": fingerprint})
        velocity, feed = copy.velocity(), copy.feed()
        make_mesh(copy)
        if neighbour is not None and (neighbour / SETTLED_GAS).is_dir():
            shutil.copytree(neighbour / SETTLED_GAS, folder / SETTLED_GAS)
        solve(folder, np, _goal(copy, feed), on_step, frames=frames)
        read_run(folder)  # complete, or not finished
        seconds = time.monotonic() - start
        write_json(
            folder / FINISHED,
            {
                "inputs": _steered(case, folder, fingerprint),
                "gas_velocity_m_s": velocity,
                "wall_time_s": round(seconds, 3),
            },
        )
    return copy


def _steered(case: Case, folder: Path, fingerprint: str) -> str:
    """The hash of a run's inputs, with what was done to it on the way."""
    own, done = case.path / STEERING, folder / STEERING
    if not done.is_file() or (own.is_file() and own.read_bytes() == done.read_bytes()):
        return fingerprint
    return hashlib.sha256(fingerprint.encode() + done.read_bytes()).hexdigest()


def read_plan(folder: Path) -> dict[str, Any]:
    """What the solver expected and planned of the case in `folder`: see docs/user/outputs.md."""
    plan: dict[str, Any] = read_json(folder / PLAN)
    return plan


def ask_plan(case: Case) -> dict[str, Any]:
    """The plan of a case, of a meshed copy of it; nothing is run. Raises InputError with the reason
    of the mesher or the solver where one of them refuses the case."""
    _need_programs(1)
    with tempfile.TemporaryDirectory() as folder:
        copy = case.copy_to(Path(folder) / case.name, [])
        try:
            make_mesh(copy)
            _program([SOLVER, "-plan"], copy.path, f"log.{SOLVER}")
        except ElutriaError as error:
            reason = re.sub(r" \(see [^)]*\)$", "", str(error))
            raise InputError(reason.replace(str(copy.path), str(case.path))) from error
        return read_plan(copy.path)


@contextlib.contextmanager
def _lock(folder: Path) -> Iterator[None]:
    """One run at a time in a folder; the lock ends with this process, however it ends."""
    with writing_to(folder.parent):
        folder.parent.mkdir(parents=True, exist_ok=True)
        file = (folder.parent / f".{folder.name}.lock").open("w")
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise ElutriaError(
                f"{folder}: locked by another elutria; wait for its end, or choose another --to"
            ) from error
        yield


def _clear(folder: Path) -> None:
    """Remove an earlier run's folder, never anything else."""
    if not folder.exists():
        return
    if not (folder / MARKER).is_file() and any(folder.iterdir()):
        raise InputError(
            f"{folder}: exists and is not a run of elutria; choose another folder with --to"
        )
    with writing_to(folder):
        # the marker goes last: a removal that is cut off can be continued
        for entry in folder.iterdir():
            if entry.name != MARKER:
                is_folder = entry.is_dir() and not entry.is_symlink()
                shutil.rmtree(entry) if is_folder else entry.unlink()
        shutil.rmtree(folder)


def _need_programs(np: int) -> None:
    needed = [SOLVER, "blockMesh", *(["mpirun", "decomposePar"] if np > 1 else [])]
    for program in needed:
        if shutil.which(program) is None:
            raise InputError(f"{program}: not found on PATH; allowed: after 'source etc/bashrc'")


def make_mesh(case: Case) -> None:
    """Allrun.pre where the case has one, blockMesh with a blockMeshDict, else the mesh as it is."""
    if (case.path / "Allrun.pre").is_file():
        _program(["./Allrun.pre"], case.path, "log.Allrun.pre")
    elif (case.path / "system/blockMeshDict").is_file():
        _program(["blockMesh"], case.path, "log.blockMesh")
    case.check_mesh()
    case.feed()  # its patches, now that the mesh is there


def _program(arguments: list[str], folder: Path, log: str) -> None:
    """Run a program in `folder`, its output in `log`. Raises ElutriaError when it fails."""
    with (
        writing_to(folder),
        (folder / log).open("w") as output,
        started_in(folder, arguments) as command,
    ):
        try:
            code = subprocess.run(
                command, cwd=folder, stdout=output, stderr=subprocess.STDOUT, check=False
            ).returncode
        except OSError as error:
            raise ElutriaError(
                f"{folder / arguments[0]}: cannot be run ({error.strerror})"
            ) from error
    if code != 0:
        raise ElutriaError(f"{arguments[0]} failed in {folder}: {_reason(folder / log)}")


def solve(
    folder: Path,
    np: int,
    goal: Goal,
    on_step: Callable[[float, Step], None],
    *,
    frames: bool = False,
) -> None:
    """Run the solver in `folder` on `np` processors. Raises ElutriaError with its reason."""
    from elutria.running.solver import follow

    command = [SOLVER, "-keepSettled"]
    if np > 1:
        write_decomposition(Case(folder), np)
        _program(["decomposePar", "-force"], folder, "log.decomposePar")
        command = ["mpirun", "-np", str(np), SOLVER, "-parallel"]
        os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT", "1")
        os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
    if frames:
        command.append("-frames")
    log = f"log.{SOLVER}"
    outcome = follow(folder, command, log, lambda step: on_step(goal.share(step), step))
    if outcome.interrupted:
        raise KeyboardInterrupt
    if not outcome.complete:
        reason = outcome.reason or _reason(folder / log) or f"exit code {outcome.exit_code}"
        raise ElutriaError(f"{SOLVER} failed in {folder}: {reason}")


def write_decomposition(case: Case, np: int) -> None:
    """system/decomposeParDict: slices along gravity, unless the case has one for `np` processors.

    (scotch, metis and kahip are stubs in Debian's OpenFOAM.)
    """
    own = case.path / "system/decomposeParDict"
    if (
        own.is_file()
        and case.dictionary("system/decomposeParDict").number("numberOfSubdomains") == np
    ):
        return
    slices = [1, 1, 1]
    gravity = [abs(x) for x in case.dictionary("constant/g").numbers("value", 3)]
    slices[gravity.index(max(gravity))] = np
    text = (
        "FoamFile { version 2.0; format ascii; class dictionary; object decomposeParDict; }\n"
        f"numberOfSubdomains {np};\nmethod simple;\n"
        f"simpleCoeffs {{ n ({slices[0]} {slices[1]} {slices[2]}); delta 0.001; }}\n"
    )
    with writing_to(case.path):
        own.write_text(text)


def _reason(log: Path) -> str:
    """The line of a log that says why a program failed."""
    try:
        lines = log.read_text(errors="replace").splitlines()
    except OSError:
        return ""
    for number, line in enumerate(lines):
        if "FOAM FATAL" in line:
            what = [text for text in lines[number + 1 : number + 8] if text.strip()][:2]
            return one_line(" ".join(what), 400) + f" (see {log})"
    last = [line for line in lines if line.strip()][-1:]
    return (one_line(last[0], 400) + f" (see {log})") if last else f"see {log}"
