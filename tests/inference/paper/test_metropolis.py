"""Metropolis-Hastings against quadrature on a grid, reference draws, and its own seed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avahazard.inference.model.laws import LAWS, law
from avahazard.inference.paper import calibration as sampler
from avahazard.inference.paper.calibration import (
    FLAT_ON_SIGMA,
    metropolis,
    prior_by,
    runout_records,
    squared_residuals,
    walk,
)
from tests.inference import naive
from tests.inference.paper.regression import line_records
from tests.inference.reference import reference_regression
from tests.inference.worlds import MU, MU_MIN, MU_STEP, runouts


def _calibrate(name: str, data, *, seed: int = 1, **settings):
    volume, runout, table, stop_y = data
    item = law(name)
    records = runout_records(item, volume, runout, table, stop_y, MU_MIN, MU_STEP)
    return metropolis(item, volume, records, item.prior_mean, seed=seed, **settings)


@pytest.mark.parametrize("sigma_prior", [FLAT_ON_SIGMA, (3.0, 2.0e4)])
def test_posterior_equals_quadrature_on_a_grid(sigma_prior: tuple[float, float]) -> None:
    item = law("exponential")
    data = runouts("exponential", [0.52, 2e-6], 120.0, 60, 4)
    volume, runout, table, stop_y = data
    result = _calibrate("exponential", data, sigma_prior=sigma_prior, n_draws=60000)
    a, n, sigma = result.pooled().T
    ours = np.stack([np.log(a), n, sigma])
    centre, reach = ours.mean(axis=1), ours.std(axis=1)
    axes = list(np.linspace(centre - 6 * reach, centre + [6, 6, 9] * reach, 120).T)
    log_a, n_grid = np.meshgrid(*axes[:2], indexing="ij")
    squares = np.zeros_like(log_a)
    for v, y, k in zip(volume, runout, table, strict=True):
        squares += (y - np.interp(np.exp(log_a - n_grid * v), MU, stop_y[k])) ** 2

    def log_density(log_a, n, sigma):
        prior = naive.log_normal_prior(log_a, item.prior_mean[0], item.prior_sd[0])
        prior = prior + naive.log_normal_prior(n * 1e6, item.prior_mean[1], item.prior_sd[1])
        prior = prior + naive.log_inverse_gamma(sigma, *sigma_prior)
        return prior - 60 * np.log(sigma) - squares[:, :, None] / (2 * sigma**2)

    mean, sd = naive.posterior_on_grid(log_density, axes)
    np.testing.assert_allclose(ours.mean(axis=1), mean, rtol=0.01)
    np.testing.assert_allclose(ours.std(axis=1), sd, rtol=0.03)
    assert result.diagnostics.converged


@pytest.mark.parametrize("name", [n for n, one in LAWS.items() if one.form])
def test_every_law_is_recovered_with_a_tuned_acceptance(name: str) -> None:
    natural = {
        "exponential": [0.55, 3e-6],
        "power": [0.9, 0.06],
        "rational": [0.6, 1.0, 1e5, 1.5],
        "constant": [0.5],
    }[name]
    result = _calibrate(name, runouts(name, natural, 60.0, 200, 5), n_draws=10000)
    assert result.diagnostics.converged
    assert np.all((result.acceptance > 0.25) & (result.acceptance < 0.5))
    assert result.names == (*law(name).names, "sigma")
    assert result.draws.shape == (4, 10000, len(natural) + 1)
    low, high = np.quantile(result.pooled(), [0.001, 0.999], axis=0)
    truth = np.array([*natural, 60.0])
    assert np.all((low <= truth) & (truth <= high))


def test_the_seed_decides_and_chains_differ() -> None:
    data = runouts("power", [0.9, 0.06], 60.0, 50, 6)
    first = _calibrate("power", data, n_draws=200)
    again = _calibrate("power", data, n_draws=200)
    other = _calibrate("power", data, seed=2, n_draws=200)
    np.testing.assert_array_equal(first.draws, again.draws)
    assert not np.array_equal(first.draws, other.draws)
    assert not np.array_equal(first.draws[0], first.draws[1])


def test_too_few_draws_are_called_unconverged() -> None:
    data = runouts("power", [0.9, 0.06], 60.0, 50, 6)
    assert not _calibrate("power", data, n_draws=100).diagnostics.converged


@pytest.mark.parametrize("name", ["kilpisjarvi", "mesquite"])
def test_reference_draws_of_a_regression(
    name: str, shared_data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sampler, "WARM_UP", 6000)
    x, y, mean, sd, reference = reference_regression(shared_data, name)
    spread_beta = 1.0 / np.std(x) / np.sqrt(x.size)
    start = np.array([y.mean(), 0.0])
    # α and β lie on a narrow ridge: the first proposals must follow it
    spread = np.linalg.cholesky(
        np.array(
            [
                [1e-4 + (x.mean() * spread_beta) ** 2, x.mean() * spread_beta**2],
                [x.mean() * spread_beta**2, spread_beta**2],
            ]
        )
    )
    prior = prior_by(mean * [1, -1], sd, FLAT_ON_SIGMA)
    draws, sigma, _ = walk(line_records(x, y), prior, start, spread, 1, 4, 80000)
    ours = np.stack([draws[..., 0].ravel(), -draws[..., 1].ravel(), sigma.ravel()])
    np.testing.assert_array_less(
        np.abs(ours.mean(axis=1) - reference[:, 0]), 0.05 * reference[:, 1]
    )
    np.testing.assert_allclose(ours.std(axis=1), reference[:, 1], rtol=0.03)


@pytest.mark.parametrize("name", [n for n, one in LAWS.items() if one.form])
def test_sum_of_squares_equals_the_slow_twin(name: str) -> None:
    volume, runout, table, stop_y = runouts("exponential", [0.5, 1e-6], 100.0, 37, 1)
    item = law(name)
    records = runout_records(item, volume, runout, table, stop_y, MU_MIN, MU_STEP)
    rng = np.random.default_rng(2)
    place = np.empty(37)
    for wide in (1.0, 5.0):  # five prior sds: frictions off both ends of the tables too
        for u in rng.normal(item.prior_mean, wide * item.prior_sd, (40, item.prior_mean.size)):
            slow = naive.squared_residuals(u, item, volume, runout, table, stop_y, MU)
            assert squared_residuals(u, records, place) == pytest.approx(slow, rel=1e-8)


def test_without_tables_it_is_a_line() -> None:
    rng = np.random.default_rng(3)
    x, y = rng.normal(size=(2, 20))
    ours = squared_residuals(np.array([0.4, -1.3]), line_records(x, y), np.empty(20))
    assert ours == pytest.approx(np.sum((y - 0.4 - 1.3 * x) ** 2))
