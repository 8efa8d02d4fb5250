"""Closed forms against reference values of the literature and against their own limits."""

from __future__ import annotations

import numpy as np
import pytest

from elutria.estimates import theory
from elutria.physics import drag
from elutria.physics.drag import Gas

AIR = Gas(1.2, 1.8e-5)

# plug flow, Schiller-Naumann, air 1.2 kg/m3, 1.8e-5 Pa s, g 9.81: cut size in um
PLUG_FLOW = {
    2650: {0.5: 90.7, 1: 146.3, 2: 260.2, 3: 385.2, 5: 667.6, 8: 1155},
    7200: {0.5: 52.9, 1: 82.5, 2: 139.4, 3: 199.3, 5: 332.0, 8: 559},
}


@pytest.mark.parametrize(
    "density, velocity, size",
    [(r, u, d) for r, row in PLUG_FLOW.items() for u, d in row.items()],
)
def test_plug_flow_cut_sizes(density: float, velocity: float, size: float) -> None:
    found = drag.plug_flow_cut_size(velocity, density, AIR)
    assert found * 1e6 == pytest.approx(size, rel=1e-3)


@pytest.mark.parametrize(
    "law, sphericity, size",
    [
        ("Schiller-Naumann", 1, 668),
        ("Putnam", 1, 666),
        ("Di Felice", 1, 754),
        ("Haider-Levenspiel", 0.8, 970),
    ],
)
def test_the_drag_law_alone_moves_the_cut(law: str, sphericity: float, size: float) -> None:
    found = drag.plug_flow_cut_size(5, drag.Grain(2650, sphericity), AIR, law)
    assert found * 1e6 == pytest.approx(size, abs=1)


def test_settling_velocity_of_the_mfix_reference() -> None:
    # d 100 um, 2000 kg/m3, g 9.80665: settles at 0.4574017 m/s (0.4 m/s upward, -0.0574017 left)
    found = drag.terminal_velocity(100e-6, 2000, AIR, gravity=9.80665)
    assert found == pytest.approx(0.4574017, rel=1e-6)


@pytest.mark.parametrize("reynolds, cd", [(0.5, 51.54), (50, 1.574), (500, 0.5549), (2500, 0.4082)])
def test_the_standard_curve(reynolds: float, cd: float) -> None:
    assert drag.drag_coefficient("CliftDrag", reynolds) == pytest.approx(cd, rel=1e-3)


# Ganser's published coefficients leave its sphere below the standard curve between Re 1 and 1000
@pytest.mark.parametrize("law, tolerance", [("Haider-Levenspiel", 0.07), ("Ganser", 0.28)])
def test_laws_for_shapes_come_near_the_sphere(law: str, tolerance: float) -> None:
    for reynolds in (0.1, 1, 10, 100, 1000):
        sphere = drag.drag_coefficient("Clift", reynolds)
        assert drag.drag_coefficient(law, reynolds) == pytest.approx(sphere, rel=tolerance)
        flat = drag.drag_coefficient(law, reynolds, sphericity=0.6)
        assert flat > drag.drag_coefficient(law, reynolds)


def test_what_is_lighter_than_the_gas_has_no_settling_velocity() -> None:
    with pytest.raises(ValueError, match="density"):
        drag.terminal_velocity(1e-4, 1.0, AIR)


def test_drift_with_dispersion_solves_its_equation_and_limits() -> None:
    # P(x) obeys D P'' + w P' = 0, P(0) = 0, P(L) = 1: check by finite differences
    length, dispersion, velocity = 0.5, 0.02, 5.0
    heights = np.linspace(0, length, 2001)
    for terminal in (4.8, 5.0, 5.05, 5.2):
        share = np.array(
            [
                theory.drift_dispersion_fines_share(terminal, velocity, x, length, dispersion)
                for x in heights
            ]
        )
        step = heights[1]
        second = np.diff(share, 2) / step**2
        first = (share[2:] - share[:-2]) / (2 * step)
        residual = dispersion * second + (velocity - terminal) * first
        assert np.abs(residual).max() < 1e-4 * np.abs(dispersion * second).max() + 1e-6
        assert share[0] == 0
        assert share[-1] == pytest.approx(1)
    middle = theory.drift_dispersion_fines_share([4.9, 5.1], velocity, 0.25, length, dispersion)
    assert middle == pytest.approx(1 / (1 + np.exp(-np.array([0.1, -0.1]) * 0.5 / 0.04)))


def test_strong_drift_does_not_overflow() -> None:
    share = theory.drift_dispersion_fines_share([0.0, 1e4], 5.0, 0.25, 0.5, 1e-6)
    assert share == pytest.approx([1, 0])


def test_laminar_profiles_start_and_end_where_the_fastest_gas_does() -> None:
    assert theory.pipe_fines_share([0, 5, 10, 12], 5) == pytest.approx([1, 0.5, 0, 0])
    assert theory.channel_fines_share([0, 7.5, 9], 5) == pytest.approx([1, 0, 0])
