"""Versions and machine that a result was made with, and result files that carry them."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from elutria.files import write_csv, write_json
from elutria.output.style import save
from elutria_validation.harness.job import Job


def machine() -> dict[str, Any]:
    """Versions and machine."""
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
    job: Job,
    name: str,
    columns: Sequence[str],
    rows: Iterable[Mapping[str, Any]],
    figure: Figure | None = None,
    notes: Mapping[str, Any] | None = None,
) -> None:
    """NAME.csv, NAME.png and NAME.json (versions, machine, notes) in the job's folder."""
    write_csv(job.folder / f"{name}.csv", columns, rows)
    write_json(job.folder / f"{name}.json", {**machine(), **(notes or {})})
    if figure is not None:
        save(figure, job.folder / f"{name}.png")
    job.say(f"{job.folder / name}.csv")


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
