"""The errors of speeds against their covariance written out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.likelihood.speed_errors import (
    drawn_speeds,
    inverse_root,
    speed_log_density,
    squared,
    whitening,
)
from avahazard.inference.model.observations import SpeedRecord, speed_record

SIGMA = np.array([1.0, 0.5, 2.0, 1.5])
SPEED = np.array([9.0, 21.0, 24.0, 12.0])


def track(sigma: np.ndarray = SIGMA) -> SpeedRecord:
    x = np.array([40.0, 90.0, 200.0, 390.0])
    return speed_record(0, x, SPEED, sigma, release_x=20.0, stop_x=420.0)


def dense_error() -> np.ndarray:
    """Variance of (u + e)² - σ², with the u of each place smoothed over those beside it."""
    middle = np.array([15.0, 18.0, 19.0, 18.0])
    return 4.0 * middle**2 * SIGMA**2 + 2.0 * SIGMA**4


def test_a_square_is_without_bias_and_has_its_error() -> None:
    rng = np.random.default_rng(1)
    read = 20.0 + 2.0 * rng.standard_normal(400_000)
    square = read**2 - 4.0
    assert np.mean(square) == pytest.approx(400.0, abs=0.5)
    assert np.std(square) == pytest.approx(np.sqrt(4.0 * 400.0 * 4.0 + 2.0 * 16.0), rel=0.01)
    found, error = squared(SPEED, SIGMA)
    np.testing.assert_allclose(found, SPEED**2 - SIGMA**2)
    np.testing.assert_allclose(error**2, dense_error())


@pytest.mark.parametrize("scatter", [0.0, 0.02, 0.3])
def test_whitened_misfits_give_the_density(scatter: float) -> None:
    one = track()
    measured, whiten, constant = whitening(SPEED, SIGMA, one.spread, scatter)
    square = np.array([100.0, 300.0, 500.0, 250.0])
    found = -0.5 * np.sum((whiten @ (measured - square)) ** 2) - constant
    covariance = scatter**2 * one.spread + np.diag(dense_error())
    law = stats.multivariate_normal(square, covariance)
    jacobian = np.sum(np.log(np.sqrt(dense_error()) / SIGMA))
    expected = law.logpdf(SPEED**2 - SIGMA**2) + jacobian
    assert found == pytest.approx(expected, rel=1e-10)
    rows = speed_log_density(np.vstack([measured, square]), (measured, whiten, constant))
    assert rows == pytest.approx([-constant, expected], rel=1e-10)


def test_the_inverse_root_is_that_of_the_library() -> None:
    one = track()
    covariance = 0.01 * one.spread + np.diag(dense_error())
    expected = np.linalg.inv(np.linalg.cholesky(covariance))
    np.testing.assert_allclose(inverse_root(covariance), expected, rtol=1e-9, atol=1e-15)


def test_exact_friction_leaves_the_errors_of_the_measurement() -> None:
    """Without scatter along the track the density is that of the speeds themselves."""
    speed, sigma = np.full(5, 30.0), np.full(5, 0.3)
    one = speed_record(0, np.linspace(50.0, 250.0, 5), speed, sigma, 0.0, 300.0)
    for off in (-0.5, 0.0, 0.4):
        measured, whiten, constant = whitening(speed, sigma, one.spread, 0.0)
        found = -0.5 * np.sum((whiten @ (measured - (speed + off) ** 2)) ** 2) - constant
        expected = stats.norm.logpdf(speed, speed + off, sigma).sum()
        assert found == pytest.approx(expected, abs=0.4)


def test_drawn_speeds_have_the_spread_of_their_law() -> None:
    one = track()
    true = np.array([500.0, 900.0, 1200.0, 700.0])
    draws = drawn_speeds(
        np.tile(true[:, None], 20_000), one, 0.02, np.random.default_rng(2), arrives=True
    )
    # Means of squares, less the measurement's own.
    square = draws**2 - SIGMA[:, None] ** 2
    np.testing.assert_allclose(square.mean(axis=1), true, rtol=0.01)
    error = 4.0 * true * SIGMA**2 + 2.0 * SIGMA**4
    expected = 0.02**2 * one.spread + np.diag(error)
    scale = np.sqrt(np.diag(expected))
    assert np.max(np.abs(np.cov(square) - expected) / np.outer(scale, scale)) < 0.06


def test_what_arrives_was_moving_on_the_way() -> None:
    quiet = track(np.full(4, 1e-9))
    rng = np.random.default_rng(3)
    impossible = np.tile(np.array([[-20.0], [-30.0], [-10.0], [-5.0]]), 200)
    assert np.all(drawn_speeds(impossible, quiet, 0.1, rng, arrives=True) > 0.0)
    # Beyond the stop of its block an avalanche that may stop anywhere does not move.
    short = np.tile(np.array([[80.0], [90.0], [0.0], [0.0]]), 200)
    found = drawn_speeds(short, quiet, 0.1, rng, arrives=False)
    assert np.all(found[:2] > 0.0)
    assert np.max(np.abs(found[2:])) < 1e-6
