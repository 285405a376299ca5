"""The error of points, and the bands of its covariance against dense matrices."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.physics.smooth_profile import (
    FINEST_M,
    band_forms,
    difference_error,
    lowest,
    point_error,
)


def whole(band: np.ndarray) -> np.ndarray:
    """The symmetric matrix of upper diagonals `[3, n]`."""
    n = band.shape[1]
    upper = sum((np.diag(band[2 - k, k:], k) for k in range(min(3, n))), np.zeros((n, n)))
    return upper + np.triu(upper, 1).T


@pytest.mark.parametrize("n", [1, 2, 3, 8, 40])
@pytest.mark.parametrize("n_shares", [1, 16, 19])
def test_the_forms_of_bands_are_those_of_whole_matrices(n: int, n_shares: int) -> None:
    rng = np.random.default_rng(n)
    errors, ground = rng.uniform(-1.0, 1.0, (2, 3, n))
    for band in (errors, ground):
        band[1, 0] = 0.0
        band[0, :2] = 0.0
        band[2] += 5.0
    z = rng.standard_normal(n)
    share = rng.uniform(0.0, 3.0, n_shares)
    found = band_forms(errors, ground, z, share)
    assert found.shape == (2, n_shares)
    for (determinant, square), s in zip(found.T, share, strict=True):
        matrix = whole(errors + s * ground)
        assert determinant == pytest.approx(np.linalg.slogdet(matrix)[1])
        assert square == pytest.approx(z @ np.linalg.solve(matrix, z))


def test_what_is_not_positive_is_told() -> None:
    errors, ground = np.zeros((2, 3, 9))
    errors[2], ground[2, 4] = 1.0, -1.0
    found = band_forms(errors, ground, np.ones(9), np.array([0.0, 0.5, 1.5]))
    assert found[0] == pytest.approx([0.0, np.log(0.5), np.inf])
    assert found[1] == pytest.approx([9.0, 10.0, 0.0])


X = np.linspace(0.0, 3000.0, 151)


def ground(x: np.ndarray, bench_m: float = 0.0, wavelength: float = 160.0) -> np.ndarray:
    """A bowl with benches of one wavelength."""
    return 900.0 * np.exp(-x / 1200.0) + bench_m * np.sin(2.0 * np.pi * x / wavelength)


def naive_likelihood(x, y, sigma, penalty) -> float:
    """Minus the log of the restricted likelihood: contrasts free of level and slope, densely."""
    n = len(x)
    contrasts = np.linalg.svd(np.column_stack([np.ones(n), x - x.mean()]))[0][:, 2:].T
    # Cov(f(s), f(t)) of the integrated Wiener process from the first point on.
    s, t = np.minimum.outer(x - x[0], x - x[0]), np.maximum.outer(x - x[0], x - x[0])
    covariance = s**2 * (3.0 * t - s) / 6.0 / penalty + np.diag(sigma**2)
    v = contrasts @ covariance @ contrasts.T
    z = contrasts @ y
    return 0.5 * (np.linalg.slogdet(v)[1] + z @ np.linalg.solve(v, z))


def test_the_vertex_of_a_parabola_is_its_lowest_place() -> None:
    x = np.linspace(1.0, 4.0, 16)
    assert lowest(x, 3.0 * (x - 2.34) ** 2 - 5.0) == pytest.approx(2.34)


@pytest.mark.parametrize(
    ("cost", "expected"),
    [
        ([0.0, 1.0, 2.0, 3.0], 0.0),
        ([3.0, 2.0, 1.0, 0.0], 3.0),
        ([np.inf, 1.0, 2.0, 3.0], 1.0),
        ([1.0, 1.0, 1.0, 1.0], 0.0),
    ],
)
def test_at_an_end_or_where_nothing_bends_it_is_the_place_itself(
    cost: list[float], expected: float
) -> None:
    assert lowest(np.arange(4.0), np.array(cost)) == expected


def test_the_penalty_is_where_the_restricted_likelihood_is_largest() -> None:
    rng = np.random.default_rng(1)
    x = np.sort(rng.uniform(0.0, 1000.0, 40))
    sigma = rng.uniform(0.5, 3.0, 40)
    y = ground(x, 10.0, 250.0) + sigma * rng.standard_normal(40)
    found = point_error(x, y, sigma)
    best = naive_likelihood(x, y, sigma, found.penalty)
    for factor in (0.1, 0.7, 0.9, 1.1, 1.4, 10.0):
        assert naive_likelihood(x, y, sigma, factor * found.penalty) > best


def test_few_points_have_the_finest_error_and_the_penalty_of_it() -> None:
    x = np.sort(np.random.default_rng(1).uniform(0.0, 1000.0, 12))
    y = ground(x, 10.0, 250.0)
    found = point_error(x, y)
    assert found.source == "assumed"
    assert np.all(found.sigma == FINEST_M)
    assert found.penalty == point_error(x, y, found.sigma).penalty


def test_an_estimated_error_is_where_the_likelihood_is_largest_in_both() -> None:
    rng = np.random.default_rng(2)
    x = np.sort(rng.uniform(0.0, 1000.0, 60))
    y = ground(x, 10.0, 250.0) + rng.normal(0.0, 2.0, 60)
    found = point_error(x, y)
    assert found.source == "estimated"
    best = naive_likelihood(x, y, found.sigma, found.penalty)
    for scale in (0.9, 1.1):
        assert naive_likelihood(x, y, scale * found.sigma, found.penalty) > best
        assert naive_likelihood(x, y, found.sigma, scale * found.penalty) > best


@pytest.mark.parametrize("spacing", [10.0, 25.0, 50.0])
@pytest.mark.parametrize("sigma", [1.0, 3.0, 5.0])
def test_the_error_is_found_on_a_smooth_path(sigma: float, spacing: float) -> None:
    x = np.arange(0.0, 3000.0, spacing)
    noise = np.random.default_rng(3).normal(0.0, sigma, (20, len(x)))
    found = [point_error(x, ground(x) + row).sigma[0] for row in noise]
    assert np.mean(found) == pytest.approx(sigma, rel=0.15)
    assert np.std(found) < 2.0 * sigma / np.sqrt(2.0 * len(x))


def test_benches_do_not_pass_for_error() -> None:
    """By the restricted likelihood alone, ground of one wavelength is noise of 4 to 5 m."""
    x = np.arange(0.0, 3000.0, 25.0)
    noise = np.random.default_rng(4).normal(0.0, 2.0, (10, len(x)))
    found = [point_error(x, ground(x, 5.0) + row).sigma[0] for row in noise]
    assert np.mean(found) == pytest.approx(2.0, rel=0.15)


def test_exact_points_have_the_finest_error() -> None:
    found = point_error(X, ground(X))
    assert found.source == "estimated"
    assert np.all(found.sigma == FINEST_M)


def test_elevations_rounded_to_metres_say_so() -> None:
    found = point_error(X, np.round(ground(X)))
    assert found.sigma[0] == pytest.approx(1.0 / np.sqrt(12.0), rel=0.15)


def test_few_points_do_not_tell() -> None:
    found = point_error(X[::15], ground(X[::15]))
    assert (found.source, found.sigma[0]) == ("assumed", FINEST_M)


def test_differences_see_no_cubic_and_all_of_the_error() -> None:
    rng = np.random.default_rng(5)
    x = np.sort(rng.uniform(0.0, 3000.0, 4000))
    cubic = 2000.0 - 0.5 * x + 1e-4 * x**2 - 1e-8 * x**3
    assert difference_error(x, cubic)[0] < 1e-2
    error, relative = difference_error(x, cubic + rng.normal(0.0, 2.0, 4000))
    assert error == pytest.approx(2.0, abs=8.0 * relative)


def test_their_standard_error_is_that_of_many_tries() -> None:
    noise = np.random.default_rng(6).normal(0.0, 1.0, (400, len(X)))
    found = [difference_error(X, row) for row in noise]
    assert np.std([error for error, _ in found]) == pytest.approx(found[0][1], rel=0.15)
