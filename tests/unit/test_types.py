"""The types of the product and of the measuring half hold under mypy's strict rules."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_both_packages_pass_mypy() -> None:
    command = [
        sys.executable, "-m", "mypy", "--config-file", "tools/pyproject.toml",
        "--cache-dir", "build/mypy", "tools/elutria", "tools/validation/elutria_validation",
    ]  # fmt: skip
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
