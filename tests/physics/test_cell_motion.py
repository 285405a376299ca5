"""Accelerations at the ends of a cell, against equation 2.3, and the zeros of its cubic."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from avahazard.physics.cell_motion import end_accelerations, first_zero, newton_zero
from tests.physics import naive
from tests.physics.paths import bowl, cells_of, terrain_of

FRICTION, COHESION, DRAG, G = 0.4, 0.7, 0.004, 9.81


@pytest.mark.parametrize("w", [0.0, 900.0])
def test_accelerations_are_those_of_the_equation(w: float) -> None:
    profile = bowl()
    terrain = terrain_of(profile)
    cells = cells_of(terrain, constant=COHESION, drag=DRAG, factor=0.9, offset=0.02)
    _, slope, bending = profile.derivatives(terrain.x)
    for i in range(0, terrain.n_cells, 9):
        for node, found in zip(
            (i, i + 1), end_accelerations(cells, i, FRICTION, w, w), strict=True
        ):
            angle = -np.arctan(slope[node])
            curvature = bending[node] / (1.0 + slope[node] ** 2) ** 1.5
            normal = max(0.0, G * np.cos(angle) + curvature * w)
            resisting = (0.9 * FRICTION + 0.02) * normal + COHESION + DRAG * w
            along = 2.0 * (G * np.sin(angle) - resisting)
            assert found == pytest.approx(along / np.cos(angle), rel=1e-9, abs=1e-9)


SLOPES = st.floats(-300.0, 300.0)


@settings(deadline=None, max_examples=300)
@given(st.floats(0.0, 100.0), SLOPES, st.floats(-100.0, 100.0), SLOPES)
def test_first_zero_is_the_first(w0: float, d0: float, w1: float, d1: float) -> None:
    assume(w0 > 1e-3 or (w0 == 0.0 and d0 > 1e-3))  # at the release the block moves off
    assume(abs(w1) > 1e-9)
    expected = naive.first_zero(w0, d0, w1, d1, 20_001)
    found = first_zero(w0, d0, w1, d1)
    if np.isnan(expected):
        # Between two points of the grid the cubic may still touch zero.
        c2, c3 = 3.0 * (w1 - w0) - 2.0 * d0 - d1, d0 + d1 - 2.0 * (w1 - w0)
        value = w0 + found * (d0 + found * (c2 + found * c3))
        assert found == -1.0 or abs(value) < 1e-4
    else:
        assert found == pytest.approx(expected, abs=1e-4)


@settings(deadline=None, max_examples=300)
@given(st.floats(1e-3, 100.0), SLOPES, st.floats(-100.0, -1e-3), SLOPES)
def test_newton_agrees_or_says_that_it_failed(w0, d0, w1, d1) -> None:
    found = newton_zero(w0, d0, w1, d1)
    c2, c3 = 3.0 * (w1 - w0) - 2.0 * d0 - d1, d0 + d1 - 2.0 * (w1 - w0)
    roots = np.roots([c3, c2, d0, w0]) if abs(c3) > 1e-9 else np.roots([c2, d0, w0])
    inside = roots[(np.abs(roots.imag) < 1e-9) & (roots.real >= 0.0) & (roots.real <= 1.0)].real
    assert np.isnan(found) or np.min(np.abs(inside - found)) < 1e-6


def test_newton_finds_the_ordinary_stop() -> None:
    for w0, w1 in ((5.0, -3.0), (80.0, -2.0), (1.0, -90.0)):
        d = w1 - w0
        found = newton_zero(w0, 0.8 * d, w1, 1.1 * d)
        assert found == pytest.approx(first_zero(w0, 0.8 * d, w1, 1.1 * d), abs=1e-12)


@pytest.mark.parametrize(("w0", "w1"), [(0.0, -1.0), (2.0, 3.0), (np.nan, np.nan)])
def test_newton_leaves_other_cases_alone(w0: float, w1: float) -> None:
    assert np.isnan(newton_zero(w0, 5.0, w1, -5.0))


def test_a_dip_below_zero_is_found_though_the_end_is_above() -> None:
    t = first_zero(1.0, -10.0, 1.0, 10.0)
    assert t == pytest.approx(0.5 - np.sqrt(0.15), abs=1e-9)
    assert first_zero(1.0, -1.0, 1.0, 1.0) == -1.0


def test_a_block_released_where_nothing_pulls_yet_is_no_stop() -> None:
    assert first_zero(0.0, 0.0, 5.0, 2.0) == -1.0
    assert first_zero(0.0, -0.0, 5.0, 14.0) == -1.0
