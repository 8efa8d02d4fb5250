"""Planes that count: what crosses them is what leaves beyond."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elutria.case.case import Case, Setting
from elutria.classification.crossings import plane_rows, read_counted, stage_rows, zone_rows
from elutria.running.run import run_case
from elutria_validation.harness.programs import project_root

LOW, HIGH = 0.15, 0.35  # m, below and above the slot of the column


def column(folder: Path, drain: float) -> Path:
    case = Case(project_root() / "cases/column").copy_to(folder / "case", [])
    feed = case.path / "constant/feed"
    feed.write_text(f"{feed.read_text()}\nplanes ({LOW} {HIGH});\n")
    settings = {"particles": 60, "feedTime": 0.2, "cellsWide": 4, "cellsDeep": 4, "cellsBelow": 10,
                "cellsSlot": 1, "cellsAbove": 10, "drainTime": drain}  # fmt: skip
    known = (case.path / "system/simulationParameters").read_text()
    chosen = [Setting("system/simulationParameters", name, str(value))
              for name, value in settings.items() if name in known]  # fmt: skip
    return run_case(case, folder / "run", chosen).path


def accounts_close(run: Path) -> None:
    counted = read_counted(run, "coarse")
    assert counted is not None
    assert counted.heights == pytest.approx([LOW, HIGH])
    weight = counted.parcels["n_particle"]
    left = {name: float(weight[counted.parcels["outlet"] == name].sum())
            for name in ("fines", "coarse")}  # fmt: skip
    assert min(left.values()) > 0
    net = np.zeros(2)
    for row in plane_rows(counted):
        net[row["plane"]] += row["up_number"] - row["down_number"]
    assert net == pytest.approx([-left["coarse"], left["fines"]], rel=1e-9)
    inside = sum(row["residence_time_s"] for row in zone_rows(counted))
    assert inside > 0
    assert all(0 <= row["partition_by_stages"] <= 1 for row in stage_rows(counted))


def test_what_crosses_a_plane_leaves_beyond_it(tmp_path: Path) -> None:
    accounts_close(column(tmp_path, 2))
