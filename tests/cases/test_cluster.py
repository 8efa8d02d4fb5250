"""A grid of the default column and of the zigzag on all engines: the same tables, with the real
solver."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from elutria.case.case import Case
from tests.support import dask, slurm
from tests.support.engines import sweep, tables

CASES = Path(__file__).resolve().parents[2] / "cases"
GRID = ("--velocity", "4:7:4", "--vary", "system/simulationParameters:loading=0.1,0.2,0.4",
        "--set", "system/simulationParameters:feedTime=0.2",
        "--set", "system/simulationParameters:drainTime=0.5")  # fmt: skip


COARSE = [word for entry in ("cellSize=0.01", "stages=3", "feedStage=2")
          for word in ("--set", f"system/simulationParameters:{entry}")]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "grid"), [("column", GRID), ("zigzag", (*GRID, *COARSE))], ids=["column", "zigzag"]
)
def test_a_grid_has_the_same_tables_on_all_engines(
    name: str, grid: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """4 x 3 runs of 400 parcels; `local`, `dask` and `slurm` differ in nothing but the time."""
    dask.need()
    slurm.need()
    case = Case(CASES / name).copy_to(tmp_path / name, []).path
    cores = len(os.sched_getaffinity(0))
    assert sweep(case, tmp_path / "local", "local", *grid).returncode == 0
    made = tables(tmp_path / "local")
    assert len(made["summary.csv"]) == 1 + 2 * 12
    with dask.dask(tmp_path / "dask", [{}] * min(cores, 2)) as (engine, _):
        done = sweep(case, tmp_path / "by_dask", engine, *grid)
    assert done.returncode == 0, done.stderr
    assert tables(tmp_path / "by_dask") == made
    with slurm.slurm(tmp_path / "slurm", cores) as conf:
        monkeypatch.setenv("SLURM_CONF", str(conf))
        done = sweep(case, tmp_path / "by_slurm", "slurm", *grid)
    assert done.returncode == 0, done.stderr
    assert tables(tmp_path / "by_slurm") == made


@pytest.mark.slow
def test_a_job_of_slurm_has_its_processors(
    column: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    slurm.need()
    monkeypatch.setenv("ELUTRIA_EXACT", "yes")
    words = (*GRID[4:], "--velocity", "5", "--np", "2")
    assert sweep(column, tmp_path / "local", "local", *words).returncode == 0
    with slurm.slurm(tmp_path / "slurm", 2) as conf:
        monkeypatch.setenv("SLURM_CONF", str(conf))
        done = sweep(column, tmp_path / "by_slurm", "slurm", *words)
    assert done.returncode == 0, done.stderr
    assert tables(tmp_path / "by_slurm") == tables(tmp_path / "local")
