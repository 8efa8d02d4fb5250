"""Sweeps by the command line on an engine, and their tables."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

from tests.support.sweeps import SMALL

SPENT = ("wall_time_s",)
"""Columns that tell how long something took."""


def command(case: Path, to: Path, engine: str, *words: str) -> list[str]:
    return [sys.executable, "-m", "elutria", "sweep", str(case), "--to", str(to),
            "--set", SMALL[0], "--engine", engine, *words]  # fmt: skip


def sweep(case: Path, to: Path, engine: str, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command(case, to, engine, *words), capture_output=True, text=True, check=False, timeout=3000
    )


def tables(folder: Path) -> dict[str, list[list[str]]]:
    """All cells of a folder's tables, without those that tell how long it took."""
    found = {}
    for file in sorted(folder.glob("*.csv")):
        rows = list(csv.reader(file.read_text().splitlines()))
        kept = [n for n, name in enumerate(rows[0]) if name not in SPENT]
        found[file.name] = [[row[n] for n in kept] for row in rows]
    return found
