"""Gibbs against quadrature on a grid, reference draws, and its own limits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avahazard.inference.model.laws import law
from avahazard.inference.paper.gibbs import gibbs, regression
from avahazard.inference.paper.metropolis import FLAT_ON_SIGMA
from avahazard.records.errors import AvahazardError
from tests.inference import naive
from tests.inference.reference import reference_regression
from tests.inference.worlds import frictions


def test_posterior_equals_quadrature_on_a_grid() -> None:
    """Priors that pull, so that the carried-over prior of the centred level is tried too."""
    volume, mu = frictions("exponential", [0.52, 3e-6], 0.16, 25, 1)
    prior_mean, prior_sd, sigma_prior = np.array([-0.5, 1.0]), np.array([0.05, 0.6]), (2.0, 0.08)
    result = gibbs(
        law("exponential"),
        volume,
        mu,
        seed=2,
        prior_mean=prior_mean,
        prior_sd=prior_sd,
        sigma_prior=sigma_prior,
        n_draws=40000,
    )
    a, n, sigma = result.pooled().T
    ours = np.stack([np.log(a), n * 1e6, sigma])
    axes = [np.linspace(v.mean() - 6 * v.std(), v.mean() + 6 * v.std(), 90) for v in ours[:2]]
    axes.append(np.linspace(0.06, 0.5, 120))

    def log_density(log_a, n, sigma):
        log_p = naive.log_normal_prior(log_a, prior_mean[0], prior_sd[0])
        log_p = log_p + naive.log_normal_prior(n, prior_mean[1], prior_sd[1])
        log_p = log_p + naive.log_inverse_gamma(sigma, *sigma_prior)
        for v, m in zip(volume, mu, strict=True):
            log_p = log_p + naive.log_normal_prior(np.log(m), log_a - n * v * 1e-6, sigma)
        return log_p

    mean, sd = naive.posterior_on_grid(log_density, axes)
    np.testing.assert_allclose(ours.mean(axis=1), mean, rtol=0.01)
    np.testing.assert_allclose(ours.std(axis=1), sd, rtol=0.03)
    assert result.diagnostics.converged


@pytest.mark.parametrize("name", ["kilpisjarvi", "mesquite"])
def test_reference_draws_of_a_regression(name: str, shared_data: Path) -> None:
    x, y, mean, sd, reference = reference_regression(shared_data, name)
    ours = regression(x, y, mean, sd, FLAT_ON_SIGMA, 3, 4, 20000).reshape(-1, 3)
    np.testing.assert_array_less(
        np.abs(ours.mean(axis=0) - reference[:, 0]), 0.05 * reference[:, 1]
    )
    np.testing.assert_allclose(ours.std(axis=0), reference[:, 1], rtol=0.03)


@pytest.mark.parametrize(
    ("name", "natural"),
    [("exponential", [0.519, 3.36e-7]), ("power", [1.07, 0.065]), ("constant", [0.5])],
)
def test_linear_laws_are_recovered(name: str, natural: list[float]) -> None:
    result = gibbs(law(name), *frictions(name, natural, 0.158, 173, 7), seed=1)
    low, high = np.quantile(result.pooled(), [0.001, 0.999], axis=0)
    truth = np.array([*natural, 0.158])
    assert result.names == (*law(name).names, "sigma")
    assert np.all((low < truth) & (truth < high))
    assert result.diagnostics.converged


def test_the_seed_decides() -> None:
    data = frictions("power", [1.0, 0.06], 0.1, 30, 1)
    one = gibbs(law("power"), *data, seed=5, n_draws=50).draws
    np.testing.assert_array_equal(one, gibbs(law("power"), *data, seed=5, n_draws=50).draws)
    assert not np.array_equal(one, gibbs(law("power"), *data, seed=6, n_draws=50).draws)


def test_what_gibbs_cannot_do_is_said() -> None:
    volume, mu = frictions("power", [1.0, 0.06], 0.1, 30, 1)
    with pytest.raises(AvahazardError, match="rational"):
        gibbs(law("rational"), volume, mu, seed=1)
    with pytest.raises(AvahazardError, match="positive friction"):
        gibbs(law("power"), volume, np.where(mu > mu.mean(), np.nan, mu), seed=1)
    with pytest.raises(AvahazardError, match="All volumes are equal"):
        gibbs(law("power"), np.full(30, 1e4), mu, seed=1, prior_sd=np.full(2, np.inf))
    with pytest.raises(AvahazardError, match="Too few events"):
        gibbs(law("power"), volume[:1], mu[:1], seed=1)
