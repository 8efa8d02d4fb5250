"""What benchmarks share: options, paired timings, result files with versions and machine."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from elutria.errors import ElutriaError, InputError
from elutria.files import write_csv, write_json
from elutria.openfoam.started import started_in
from elutria.output.plots import save


@dataclass(frozen=True)
class Options:
    """What the command line gives a benchmark.

    `folder` takes the results, `repeats` is how often each timed thing is run, `quick` asks for a
    short version, `extra` holds KEY=VALUE options of the benchmark's own.
    """

    folder: Path
    repeats: int = 5
    quick: bool = False
    extra: Mapping[str, str] = field(default_factory=dict)
    say: Callable[[str], None] = print


@dataclass(frozen=True)
class Timing:
    """Seconds of several runs of one thing."""

    seconds: tuple[float, ...]

    @property
    def median(self) -> float:
        """Median, s."""
        return statistics.median(self.seconds)

    @property
    def fastest(self) -> float:
        """Smallest, s."""
        return min(self.seconds)

    @property
    def slowest(self) -> float:
        """Largest, s."""
        return max(self.seconds)


def paired(
    candidates: Mapping[str, Callable[[], Any]], repeats: int = 5, warm_up: bool = True
) -> dict[str, Timing]:
    """Wall time of each candidate, taken in turns (A B A B ...), so that drifts of the machine
    reach all alike. With `warm_up` each runs once before, untimed."""
    if warm_up:
        for work in candidates.values():
            work()
    seconds: dict[str, list[float]] = {name: [] for name in candidates}
    for _ in range(repeats):
        for name, work in candidates.items():
            start = time.perf_counter()
            work()
            seconds[name].append(time.perf_counter() - start)
    return {name: Timing(tuple(values)) for name, values in seconds.items()}


def against_stock(
    name: str, steps: Mapping[str, float], seconds: Mapping[str, Sequence[float]], stock: str
) -> dict[str, Any]:
    """A row: variant, step (s), wall seconds of its steps, of a simulated second, over stock's.

    `seconds` are those of single steps, taken in turns, so that the k-th of all belong together.
    """
    own = [value / steps[name] for value in seconds[name]]
    others = [value / steps[stock] for value in seconds[stock]]
    return {
        "variant": name,
        "time_step_s": steps[name],
        "seconds_per_step": statistics.median(seconds[name]),
        "low": min(seconds[name]),
        "high": max(seconds[name]),
        "seconds_per_simulated_second": statistics.median(own),
        "speed_over_stock": statistics.median(o / s for o, s in zip(others, own, strict=True)),
    }


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


def slug(*names: str) -> str:
    """Names as a folder's name."""
    return re.sub(r"[^a-z0-9.]+", "-", " ".join(names).lower()).strip("-")


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


def machine() -> dict[str, Any]:
    """Versions and machine that a result was made with."""
    return {
        "made": datetime.now(UTC).isoformat(timespec="seconds"),
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)),
        "memory_gb": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30, 1),
        "system": platform.platform(),
        "load_before": round(os.getloadavg()[0], 2),
        "python": platform.python_version(),
        "packages": {
            name: importlib.metadata.version(name) for name in ("numpy", "scipy", "matplotlib")
        },
        "compiler": _first_line(["g++", "--version"]),
        "openfoam": os.environ.get("WM_PROJECT_VERSION", "not set"),
        "commit": _first_line(["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]),
        "command": " ".join(["elutria", *(_portable(a) for a in sys.argv[1:])]),
    }


def write_result(
    options: Options,
    name: str,
    columns: Sequence[str],
    rows: Iterable[Mapping[str, Any]],
    figure: Figure | None = None,
    notes: Mapping[str, Any] | None = None,
) -> None:
    """NAME.csv, NAME.png and NAME.json (versions, machine, notes) in the options' folder."""
    write_csv(options.folder / f"{name}.csv", columns, rows)
    write_json(options.folder / f"{name}.json", {**machine(), **(notes or {})})
    if figure is not None:
        save(figure, options.folder / f"{name}.png")
    options.say(f"{options.folder / name}.csv")


def _portable(argument: str) -> str:
    """The argument, with a path of this machine alone left out."""
    return re.sub(r"(^|=)/.*", r"\1PATH", argument)


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((x.split(":", 1)[1].strip() for x in lines if x.startswith("model name")), "")


def _first_line(command: list[str]) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return "not found"
    return (done.stdout.splitlines() or ["not known"])[0]
