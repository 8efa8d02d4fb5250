"""Threads that have no core of their own would wait for each other: they are left out."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import solve


def box(folder: Path, threads: int) -> Path:
    contacts = Contacts(treatment="impact", more={"threads": threads})
    return BoxCase(contacts=contacts, end=1e-3).make(folder)


def test_threads_without_a_core_are_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("ELUTRIA_EXACT", raising=False)
    cores = len(os.sched_getaffinity(0))
    (line,) = re.findall(r"elutria: .*threads.*", solve(box(tmp_path / "many", 1024)))
    there = f"{cores} core{'s' if cores > 1 else ''}"
    assert line == (
        f"elutria: cellListCoeffs: threads 1024 -> {cores}: there {'are' if cores > 1 else 'is'} "
        f"{there} for each process (ELUTRIA_EXACT=yes takes 1024)"
    )
    monkeypatch.setenv("OMP_THREAD_LIMIT", "1")
    assert "threads 2 -> 1: there is 1 core" in solve(box(tmp_path / "limited", 2))
    monkeypatch.setenv("ELUTRIA_EXACT", "yes")
    assert "threads 2 ->" not in solve(box(tmp_path / "exact", 2))
