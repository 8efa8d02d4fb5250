"""Results that the pages are made of."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.support.made_results import make_results


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results that no test changes."""
    return make_results(tmp_path_factory.mktemp("results") / "column", [5.0, 6.0, 7.0])


@pytest.fixture
def results(made: Path, tmp_path: Path) -> Path:
    """A copy of them, to be changed at will."""
    return shutil.copytree(made, tmp_path / "column")
