"""Gauss nodes, alone and in panels, against the moments of what they stand for."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.likelihood.quadrature import (
    A_PANEL,
    gauss_nodes,
    n_panels,
    panel_nodes,
    panel_width,
)


def nodes(points: list[float] | np.ndarray, masses: list[float] | np.ndarray, k: int):  # type: ignore[no-untyped-def]
    place, weight = np.full(k, np.nan), np.full(k, np.nan)
    gauss_nodes(np.asarray(points, np.float64), np.asarray(masses, np.float64), place, weight)
    return place, weight


def test_they_have_the_measures_moments() -> None:
    rng = np.random.default_rng(3)
    points, masses = rng.normal(0.4, 0.1, 60), rng.exponential(1.0, 60)
    place, weight = nodes(points, masses, 5)
    for power in range(10):  # exact up to 2 k - 1
        expected = np.sum(masses * points**power) / np.sum(masses)
        assert np.sum(weight * place**power) == pytest.approx(expected, rel=1e-10)


def test_few_points_are_their_own_nodes() -> None:
    place, weight = nodes([0.2, 0.7], [1.0, 3.0], 4)
    assert weight.tolist() == [0.25, 0.75, 0.0, 0.0]
    assert place[:2].tolist() == [0.2, 0.7]
    assert np.all(np.isfinite(place))


@pytest.mark.parametrize("n", [1, 8])
def test_one_place_has_all_the_weight(n: int) -> None:
    place, weight = nodes([0.3] * n, [0.5] * n, 3)
    assert weight.tolist() == [1.0, 0.0, 0.0]
    assert place == pytest.approx([0.3] * 3)


def test_two_places_many_times_over_make_two_nodes() -> None:
    place, weight = nodes([0.2, 0.6] * 6, [1.0, 2.0] * 6, 4)
    assert weight.sum() == pytest.approx(1.0)
    assert np.sum(weight * place) == pytest.approx((0.2 + 2 * 0.6) / 3)


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
