import numpy as np
import pytest

from avahazard.physics.polynomial_misfit import least_misfit
from avahazard.physics.smooth_profile import legendre_profile

DEGREE = 8


def ground(x: np.ndarray) -> np.ndarray:
    return 900.0 * np.exp(-x / 1200.0) + 5.0 * np.sin(x / 80.0)


def test_it_is_that_of_weighted_least_squares() -> None:
    rng = np.random.default_rng(1)
    x = np.sort(rng.uniform(0.0, 3000.0, 200))
    sigma = rng.uniform(0.1, 3.0, 200)
    y = ground(x) + sigma * rng.standard_normal(200)
    fit = np.polynomial.Polynomial.fit(x, y, DEGREE, w=1.0 / sigma)
    expected = np.mean(((y - fit(x)) / sigma) ** 2)
    assert least_misfit(x, y, sigma, DEGREE) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_no_fit_with_a_penalty_has_less(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(0.0, 3000.0, 100))
    sigma = rng.uniform(0.1, 3.0, 100)
    y = ground(x) + sigma * rng.standard_normal(100)
    made = np.mean(((legendre_profile(x, y).height(x) - y) / sigma) ** 2)
    assert least_misfit(x, y, sigma, DEGREE) <= made


def test_where_points_cannot_tell_it_is_nought() -> None:
    x = np.concatenate([np.linspace(0.0, 1e-6, 99), [1000.0]])
    assert least_misfit(x, ground(x), np.ones(100), DEGREE) == 0.0
