"""Quadrature of a discrete measure by two nodes a panel."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.likelihood.panels import A_PANEL, n_panels, panel_nodes, panel_width


@pytest.mark.parametrize("panels", [6, 7, 11])
def test_no_mass_is_lost_and_three_moments_are_kept(panels: int) -> None:
    # Among so many some have a last edge that rounding puts before the last point.
    rng = np.random.default_rng(8)
    for _ in range(200):
        points, masses = np.sort(rng.normal(-0.7, 0.4, 25)), rng.random(25)
        place, weight = np.full(A_PANEL * panels, np.nan), np.full(A_PANEL * panels, np.nan)
        panel_nodes(points, masses, panels, place, weight)
        assert weight.sum() == pytest.approx(1.0, rel=1e-12)
        for power in (1, 2, 3):
            expected = np.sum(masses * points**power) / masses.sum()
            assert np.sum(weight * place**power) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("in_log", [True, False])
def test_panels_are_counted_by_spread_and_reach_wherever_they_lie(in_log: bool) -> None:
    width = panel_width(in_log)
    weight = np.array([[0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.25, 0.5, 0.25]])
    apart = width * np.array([[-0.1, 0.1, 50.0], [-2.0, 2.0, 50.0], [-3.0, 0.0, 3.0]])
    counts = [n_panels(middle + apart, weight, in_log) for middle in (-0.7, 0.0, 3.0)]
    np.testing.assert_array_equal(counts[0], counts[1])
    np.testing.assert_array_equal(counts[0], counts[2])
    assert counts[0][0] == 1 < counts[0][1] <= counts[0][2]


def test_a_panel_of_points_without_mass_has_a_place() -> None:
    points, masses = np.linspace(0.0, 1.2, 25), np.ones(25)
    masses[9:16] = 0.0
    place, weight = np.full(A_PANEL * 6, np.nan), np.full(A_PANEL * 6, np.nan)
    panel_nodes(points, masses, 6, place, weight)
    assert np.isfinite(place).all()
    assert np.sum(weight * place) == pytest.approx(np.average(points, weights=masses))
