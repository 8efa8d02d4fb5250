"""Programs that are run, and where the clone of the project and what it has built lie."""

from __future__ import annotations

import re
import resource
import subprocess
from collections.abc import Sequence
from pathlib import Path

from elutria.errors import ElutriaError, InputError
from elutria.openfoam.started import started_in


def project_root() -> Path:
    """The clone that this package lies in. Raises InputError when it does not lie in one."""
    root = Path(__file__).resolve().parents[4]
    if not (root / "solver").is_dir():
        raise InputError(f"{root}: is not a clone of the project; benchmarks run from one")
    return root


def built(name: str) -> Path:
    """A built program of the clone, such as `built("elutriaDemBench")`."""
    path = project_root() / "build/bin" / name
    if not path.is_file():
        raise InputError(f"{path}: file not found; build it with solver/Allwmake")
    return path


def slug(*names: str) -> str:
    """Names as a folder's name."""
    return re.sub(r"[^a-z0-9.]+", "-", " ".join(names).lower()).strip("-")


def processor_time() -> float:
    """Seconds of processor that the programs started so far took."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


def run_program(arguments: Sequence[str | Path], folder: Path | None = None) -> str:
    """Output of a program that must succeed. Raises ElutriaError with its last line else."""
    try:
        with started_in(folder or Path.cwd(), [str(a) for a in arguments]) as command:
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    except OSError as error:
        raise ElutriaError(f"{arguments[0]}: cannot be run ({error.strerror})") from error
    if done.returncode != 0:
        lines = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        reason = lines[-1] if lines else f"exit code {done.returncode}"
        raise ElutriaError(f"{arguments[0]} failed: {reason}")
    return done.stdout
