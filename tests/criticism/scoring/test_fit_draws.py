"""Draws of a fit against quadrature."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.criticism.scoring.held_out import FitDraws, fit_draws, resampled
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.sampling import sample
from tests.criticism.studies import fitted, slopes, straight


def moments(posterior: Posterior, axes: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation of the posterior by brute force on a grid."""
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    log_p = np.array([posterior.log_density(u) for u in grid])
    p = np.exp(log_p - log_p.max())
    p /= np.sum(p)
    mean = p @ grid
    return mean, np.sqrt(p @ (grid - mean) ** 2)


def test_about_the_mode_where_the_posterior_is_nearly_normal() -> None:
    posterior, mode = fitted(straight(25))
    axes = [mode.u[0] + np.linspace(-0.2, 0.2, 61), mode.u[1] + np.linspace(-0.7, 0.8, 61)]
    mean, sd = moments(posterior, axes)
    draws = fit_draws(posterior, mode, 800, "test")
    weight = np.exp(draws.log_weight)
    found = weight @ draws.coordinates
    assert np.sum(weight) == pytest.approx(1.0)
    np.testing.assert_allclose(found, mean, atol=0.15 * np.max(sd))
    spread = np.sqrt(weight @ (draws.coordinates - found) ** 2)
    np.testing.assert_allclose(spread, sd, rtol=0.15)


@pytest.mark.slow
def test_near_draws_of_the_whole_it_follows_bends_and_bounds() -> None:
    """Drag and friction stand in for each other along a bent ridge that ends at drag 0."""
    posterior, mode = fitted(slopes(n_paths=3, n_each=8), "turbulent-drag")
    rest = posterior.restricted(np.arange(24) >= 6)
    around = sample(posterior, n_chains=2, n_draws=800).draws
    axes = [
        mode.u[0] + np.linspace(-0.7, 0.5, 40),
        mode.u[1] + np.linspace(-1.2, 1.1, 25),
        np.linspace(0.0, 6.0, 61),
    ]
    mean, sd = moments(rest, axes)
    draws = fit_draws(rest, mode, 600, "test", around)
    assert np.all(draws.coordinates >= posterior.layout.low)
    found = np.exp(draws.log_weight) @ draws.coordinates
    np.testing.assert_allclose(found, mean, atol=0.3 * np.max(sd))
    assert abs(found[2] - mean[2]) < 0.3 * sd[2]


def test_draws_of_chains_that_moved_along_a_line_are_enough() -> None:
    posterior, mode = fitted(straight(25))
    around = mode.u + np.linspace(-1.0, 1.0, 40)[:, None] * np.array([2.0, 4.0])
    draws = fit_draws(posterior, mode, 400, "line", around)
    weight = np.exp(draws.log_weight)
    sd = np.sqrt(np.diag(mode.covariance))
    np.testing.assert_allclose(weight @ draws.coordinates, mode.u, atol=np.max(sd))


def test_equal_keys_equal_draws() -> None:
    posterior, mode = fitted(straight(25))
    one, two, other = (fit_draws(posterior, mode, 40, key).coordinates for key in "aab")
    np.testing.assert_array_equal(one, two)
    assert not np.array_equal(one, other)


def test_draws_count_by_their_weights() -> None:
    draws = FitDraws(np.array([[1.0], [2.0], [3.0]]), np.log([0.2, 0.5, 0.3]), None)
    even = resampled(draws, 100)
    values, counts = np.unique(even.coordinates, return_counts=True)
    assert dict(zip(values, counts, strict=True)) == {1.0: 20, 2.0: 50, 3.0: 30}
    assert np.sum(np.exp(even.log_weight)) == pytest.approx(1.0)
