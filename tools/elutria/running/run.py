"""One run: copy the case, mesh it, solve it, and mark it finished.

A run's folder holds `elutria.json` (what it is a run of) from the start and `finished.json` once it
is complete. A run that was stopped goes on from the last time that the solver has written. Programs
are started in the run's folder, so that no name of a file or folder is ever part of a command line.
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
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elutria.case.case import Case, Setting
from elutria.errors import ElutriaError, InputError, one_line
from elutria.estimates import machine, ranks
from elutria.files import read_json, write_json, writing_to
from elutria.openfoam.elsewhere import LARGEST_DICTIONARY
from elutria.openfoam.started import killed, started_in, with_own_name
from elutria.openfoam.text import line_with
from elutria.running import costs
from elutria.running.ahead import Ahead
from elutria.running.extend import replaced_inputs
from elutria.running.marker import FINISHED, MARKER, Identity, Marker, now

if TYPE_CHECKING:
    from elutria.case.feed import Feed
    from elutria.running.solver import Step

SOLVER = "elutriaFoam"
CASE_AT_FAULT = 2
"""The solver's exit code when it refuses a case."""
MESH = "constant/polyMesh"
SETTLED_GAS = "constant/settledGas"
STEERING = "system/steering"
FRAMES = "postProcessing/frames/frames.bin"
PLAN = "postProcessing/plan.json"
LOG = f"log.{SOLVER}"


class LockedError(ElutriaError):
    """Another process runs in the folder."""


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
        by_number = (0.5 * step.fed + 0.5 * sum(step.left.values())) / self.parcels
        return min(max(by_number, by_time), 1.0)


def _goal(case: Case, feed: Feed) -> Goal:
    end = case.dictionary("system/controlDict", with_included=True).number("endTime", 0.0)
    return Goal(case.path, feed.particles, end)


def is_finished(folder: Path, fingerprint: str) -> bool:
    """Whether `folder` holds a complete run of exactly these inputs."""
    try:
        return bool(read_json(folder / FINISHED).get("inputs") == fingerprint)
    except InputError:
        return False


def wall_time(folder: Path) -> float:
    """Seconds that a finished run took. Raises InputError when it is not finished."""
    return costs.number(folder, "wall_time_s")


def run_case(
    case: Case,
    folder: Path,
    settings: Iterable[Setting],
    np: int = 1,
    on_step: Callable[[float, Step], None] = lambda *_: None,
    neighbour: Path | None = None,
    replicate: int = 1,
    *,
    anew: bool = True,
    extend: bool = False,
    frames: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> Case:
    """Run `case` with `settings` in `folder`, on as many of `np` processors as pay. A complete run
    of the same inputs is not run again, one that was stopped goes on; a run of other inputs is
    removed first, or refused if not `anew`, or goes on with the new ones if `extend`.

    `on_step` gets the share done (0..1) and the solver's numbers, `say` a line where processors
    are left out. The gas starts from that of the
    run in the folder `neighbour`, where that has settled. With `frames`, the solver records them
    and can be steered; a run that was steered is one of other inputs. Raises InputError before
    anything is run, ElutriaError with the solver's reason when it fails.
    """
    settings = list(settings)
    fingerprint = case.fingerprint(settings, np)
    with locked(folder):
        shown = not frames or (folder / FRAMES).is_file()
        if shown and is_finished(folder, fingerprint):
            return Case(folder)
        _need_programs(np)
        solving = _Solving(case, on_step, frames, machine.processor_s(), say)
        marker = Marker(Identity.of(case, settings), fingerprint, np, replicate, started=now())
        before = Marker.read(folder)
        if before is not None and not before.ready:
            before = None  # stopped before its solver began
        steered = before is not None and _steered(case, folder, before.inputs) != before.inputs
        same = before is not None and before.inputs == fingerprint
        if before is not None and same and (frames or not steered):
            _go_on(folder, replace(marker, ready=True), before, solving)
        elif before is not None and extend:
            with replaced_inputs(case, folder, settings, before, marker):
                _go_on(folder, replace(marker, ready=True), before, solving)
        elif not (anew or (same and steered)) and (
            before is not None or (folder / FINISHED).is_file()
        ):
            found = before.identity.differences(marker.identity) if before else []
            if before and before.np != np and not found:
                found = [f"--np {before.np}, now {np}"]
            raise InputError(
                f"{folder}: holds a run of other inputs ({', '.join(found) or 'unknown ones'}); "
                "--extend goes on from it, another --to keeps both; without the folder it is run "
                "anew"
            )
        else:
            _start(case, folder, settings, marker, neighbour, solving)
    return Case(folder)


@dataclass(frozen=True)
class _Solving:
    """What a run's solver is started with: the case that it is of, who hears of its steps,
    whether it records frames, the processor time (s) of this process before the run, and who hears
    of processors that are left out."""

    case: Case
    on_step: Callable[[float, Step], None]
    frames: bool
    processor_s: float
    say: Callable[[str], None]


def _start(
    case: Case,
    folder: Path,
    settings: list[Setting],
    marker: Marker,
    neighbour: Path | None,
    solving: _Solving,
) -> None:
    """A run from its beginning, in a new folder."""
    _clear(folder)
    copy = case.copy_to(folder, settings)
    marker.write(folder)
    copy.velocity()
    copy.feed()
    make_mesh(copy, keep=case.keeps_mesh)
    if neighbour is not None and (neighbour / SETTLED_GAS).is_dir():
        shutil.copytree(neighbour / SETTLED_GAS, folder / SETTLED_GAS)
    if marker.np > 1:
        marker = replace(marker, np=_paying(case, copy, marker.np, solving.say))
    if marker.np > 1:
        write_decomposition(copy, marker.np)
        _program(["decomposePar", "-force"], folder, "log.decomposePar")
    marker = replace(marker, ready=True)
    marker.write(folder)
    _solve_and_mark(folder, marker, solving)


def _paying(case: Case, copy: Case, asked: int, say: Callable[[str], None]) -> int:
    """How many of the processors asked for the meshed `copy` of a case is run on."""
    if ranks.exact():
        return asked
    try:
        _program([SOLVER, "-plan"], copy.path, "log.plan")
    except ElutriaError as error:
        raise InputError(_refusal(case, copy, str(error))) from error
    choice = ranks.paying(read_plan(copy.path), asked, ranks.cores())
    shutil.rmtree(copy.path / PLAN.partition("/")[0])  # the run begins with nothing written
    if choice.why:
        say(choice.why)
    return choice.np


def _go_on(folder: Path, marker: Marker, before: Marker, solving: _Solving) -> None:
    """A run from the last time that its solver has written, on the processors that it has."""
    if before.np != marker.np:
        solving.say(f"--np {marker.np} -> {before.np}: the run that goes on has {before.np}")
    marker = replace(marker, np=before.np, spent_s=before.ended(folder, LOG))
    number = 1
    while (folder / f"{LOG}.{number}").exists():
        number += 1
    with contextlib.suppress(FileNotFoundError):
        (folder / LOG).rename(folder / f"{LOG}.{number}")
    marker.write(folder)
    _solve_and_mark(folder, marker, solving)


def _solve_and_mark(folder: Path, marker: Marker, solving: _Solving) -> None:
    from elutria.classification.events import read_run  # pandas, which a check does not need

    copy = Case(folder)
    watched = _watched(copy, copy.velocity(), solving.on_step)
    solve(folder, marker.np, _goal(copy, copy.feed()), watched, frames=solving.frames)
    read_run(folder)  # complete, or not finished
    content = {
        "inputs": _steered(solving.case, folder, marker.inputs),
        "gas_velocity_m_s": copy.velocity(),
        "wall_time_s": round(marker.spent_s + now() - marker.started, 3),
        "processor_s": round(machine.processor_s() - solving.processor_s, 3),
        "memory_mb": round(machine.memory_mb() * marker.np, 1),
        "disk_mb": round(machine.disk_mb(folder), 3),
        "np": marker.np,
    }
    write_json(folder / FINISHED, content)
    if marker.spent_s == 0 and marker.np == 1:
        costs.learn(folder, content)


def _watched(
    case: Case, velocity: float, on_step: Callable[[float, Step], None]
) -> Callable[[float, Step], None]:
    """`on_step`, which ends the run at its first step where the gas has settled at another velocity
    (m/s) than the run is called after."""
    from elutria.running.gas import require_found

    compared = False

    def watch(share: float, step: Step) -> None:
        nonlocal compared
        if not compared and (case.path / PLAN).is_file():
            compared = True
            require_found(case.path, velocity, read_plan(case.path))
        on_step(share, step)

    return watch


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
    return plans(case, [[]])[0]


def plans(case: Case, settings: Iterable[Iterable[Setting]]) -> list[dict[str, Any]]:
    """The plans of a case with each of several settings, of one mesh: that of the first. The others
    are made two at a time, since each holds the mesh."""
    _need_programs(1)
    with tempfile.TemporaryDirectory() as folder:
        each = [list(chosen) for chosen in settings]
        first, *others = [
            case.copy_to(Path(folder) / str(number) / case.name, chosen)
            for number, chosen in enumerate(each)
        ]
        found = [_plan(case, first, None)]
        with ThreadPoolExecutor(2) as pool:
            found += pool.map(lambda copy: _plan(case, copy, first), others)
    for chosen, plan in zip(each, found, strict=True):
        _require_read(case, chosen, plan)
    return found


def _plan(case: Case, copy: Case, meshed: Case | None) -> dict[str, Any]:
    """The plan of a case's `copy`, with the mesh of a `meshed` one or its own."""
    try:
        mesh = copy.path / MESH
        if meshed is None:
            make_mesh(copy, keep=case.keeps_mesh)
        elif (meshed.path / MESH).is_dir():
            shutil.copytree(meshed.path / MESH, mesh, dirs_exist_ok=True)
        _program([SOLVER, "-plan"], copy.path, f"log.{SOLVER}")
    except ElutriaError as error:
        raise InputError(_refusal(case, copy, str(error))) from error
    return read_plan(copy.path)


def _require_read(case: Case, settings: Iterable[Setting], plan: dict[str, Any]) -> None:
    """Raise InputError for a setting of a file that the solver does not use: it would change
    nothing but the label of a result."""
    unused = {what: why for kind, what, why in plan.get("decisions", []) if kind == "not used"}
    for setting in settings:
        why = unused.get(re.sub(r"^0\.orig/", "0/", setting.file))
        if why is not None:
            raise InputError(
                f"{case.name}/{setting.file}: {setting.entry}: is not used ({why}), so that its "
                "value changes nothing; allowed: an entry that acts"
            )


def _refusal(case: Case, copy: Case, said: str) -> str:
    """What a program said of a case's `copy`, as of the case itself."""
    reason = re.sub(r" \(see [^)]*\)$", "", said)
    reason = reason.partition("elutria: failed: ")[2] or reason
    if "shared library" in reason:  # OpenFOAM names the file that includes the code
        reason += _code_in(copy)
    if "constant/polyMesh" in reason and not case.keeps_mesh:
        maker = case.mesh_script or "system/blockMeshDict"
        reason += f"; the mesh is made from {maker}"
    return with_own_name(reason, case.path).replace(str(copy.path), str(case.path))


def _code_in(case: Case) -> str:
    """Where a case's dictionaries have code to compile, for the end of a message."""
    found = [
        f"{path.relative_to(case.path)} on line {line}"
        for path in sorted(case.path.glob("*/*"))
        if path.is_file() and path.stat().st_size < LARGEST_DICTIONARY
        for code in ("#calc", "#codeStream")
        if (line := line_with(path.read_text("latin-1"), code))
    ]
    return f"; code is in {', '.join(found)}" if found else ""


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """One run at a time in a folder; the lock ends with this process, however it ends."""
    with writing_to(folder.parent):
        folder.parent.mkdir(parents=True, exist_ok=True)
        file = (folder.parent / f".{folder.name}.lock").open("w")
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise LockedError(
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


def make_mesh(case: Case, *, keep: bool = False) -> None:
    """The case's own script, blockMesh with a blockMeshDict, else, or to `keep` it, the mesh as it
    is."""
    if script := case.mesh_script:
        _program([f"./{script}"], case.path, f"log.{script}", refuses=True)
    elif not keep and (case.path / "system/blockMeshDict").is_file():
        _program(["blockMesh"], case.path, "log.blockMesh", "system/blockMeshDict")
    case.check_mesh()
    case.feed()  # its patches, now that the mesh is there


def _program(
    arguments: list[str], folder: Path, log: str, reads: str = "", refuses: bool = False
) -> None:
    """Run a program in `folder`, its output in `log`; it reads the file `reads` there. Raises
    ElutriaError when it fails; InputError with its last line where exit code 2 of it means that it
    refuses its input."""
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
    if refuses and code == InputError.exit_code:
        raise InputError(_reason(folder / log).removeprefix("elutria: "))
    if code != 0:
        reason = killed(code) or _reason(folder / log)
        raise ElutriaError(f"{arguments[0]} failed in {folder / reads}: {reason}")


def solve(
    folder: Path,
    np: int,
    goal: Goal,
    on_step: Callable[[float, Step], None],
    *,
    frames: bool = False,
) -> None:
    """Run the solver in `folder` on `np` processors. Raises ElutriaError with its reason,
    InputError where it refuses the case."""
    from elutria.running.solver import follow

    command = [SOLVER, "-keepSettled"]
    if np > 1:
        command = ["mpirun", "-np", str(np), SOLVER, "-parallel"]
        os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT", "1")
        os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        # a rank that waits leaves its core to one that works
        os.environ.setdefault("OMPI_MCA_mpi_yield_when_idle", "1")
    if frames:
        command.append("-frames")
    ahead = Ahead(folder / PLAN)

    def tell(step: Step) -> None:
        left = ahead.left_s(step)
        share = ahead.share(left) if isfinite(left) else goal.share(step)
        on_step(share, replace(step, ends_in_s=left))

    outcome = follow(folder, command, LOG, tell)
    if outcome.interrupted:
        raise KeyboardInterrupt
    if not outcome.complete:
        reason = outcome.reason or _reason(folder / LOG) or f"exit code {outcome.exit_code}"
        kind = InputError if outcome.exit_code == CASE_AT_FAULT else ElutriaError
        raise kind(f"{SOLVER} failed in {folder}: {reason}")


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
