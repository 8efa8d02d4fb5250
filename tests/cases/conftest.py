"""Tests that run elutriaFoam itself: what they measure is listed at the end of the output."""

from __future__ import annotations

from collections.abc import Callable

import pytest

_measured: list[str] = []


@pytest.fixture
def measured(request: pytest.FixtureRequest) -> Callable[[str, float, float], None]:
    """Note a measured error and assert that it is at most the allowed one."""

    def note(what: str, error: float, allowed: float) -> None:
        _measured.append(f"{request.node.name}: {what}: {error:.3g} (allowed {allowed:.3g})")
        assert error <= allowed, what

    return note


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if _measured:
        terminalreporter.section("measured in elutriaFoam")
        for line in _measured:
            terminalreporter.write_line(line)
