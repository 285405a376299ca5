"""Moved records spread the friction as the slope of F says."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.model.laws import law
from avahazard.inference.paper.apparent import apparent_friction
from avahazard.inference.paper.perturbation import perturb
from avahazard.physics.runout_curve import RunoutCurve

MU = 0.1 + 0.01 * np.arange(91)
STOP_Y = np.array([400 + 1000 * MU, 200 + 2000 * MU])
CURVES = RunoutCurve(-STOP_Y, STOP_Y, np.zeros(STOP_Y.shape, np.int8), MU)
TABLE = np.array([0, 1, 0, 1] * 5)
VOLUME = np.geomspace(2e3, 3e5, 20)


def _records(sigma: float) -> tuple[np.ndarray, np.ndarray]:
    mu = law("power").friction(np.array([1.07, 0.065]), VOLUME)
    runout = np.array([np.interp(m, MU, STOP_Y[k]) for m, k in zip(mu, TABLE, strict=True)])
    return runout, np.full(20, sigma)


def test_spread_is_the_error_over_the_slope() -> None:
    result = perturb(*_records(15.0), TABLE, STOP_Y, CURVES, seed=1, n_replicates=4000)
    np.testing.assert_allclose(result.mu_sd, 15.0 / np.where(TABLE == 0, 1000, 2000), rtol=0.05)


def test_each_replicate_is_the_inverse_of_its_records() -> None:
    runout, sigma = _records(0.0)
    result = perturb(runout, sigma, TABLE, STOP_Y, CURVES, seed=1, n_replicates=3)
    direct = apparent_friction(runout, TABLE, STOP_Y, CURVES).mu
    np.testing.assert_array_equal(result.mu, np.tile(direct, (3, 1)))
    np.testing.assert_allclose(result.mu_sd, 0.0, atol=1e-12)


def test_no_spread_is_given_where_most_moved_records_have_no_friction() -> None:
    runout, sigma = _records(15.0)
    runout[0], runout[1] = -np.inf, STOP_Y[1, 0] - 60.0
    result = perturb(runout, sigma, TABLE, STOP_Y, CURVES, seed=1)
    assert np.isnan(result.mu_sd[:2]).all()
    assert np.isfinite(result.mu_sd[2:]).all()


def test_laws_spread_with_the_records() -> None:
    """The sd of a linear fit's parameters, by the same propagation in closed form."""
    result = perturb(*_records(10.0), TABLE, STOP_Y, CURVES, seed=2)
    mean, sd = result.law_spread(law("power"), VOLUME)
    np.testing.assert_allclose(mean, [1.07, 0.065], rtol=0.01)
    alpha, beta = 1.07, 0.065
    mu = alpha * VOLUME**-beta
    jacobian = np.stack([mu / alpha, -mu * np.log(VOLUME)], axis=1)
    propagated = np.linalg.pinv(jacobian) * (10.0 / np.where(TABLE == 0, 1000, 2000))
    np.testing.assert_allclose(sd, np.linalg.norm(propagated, axis=1), rtol=0.15)


def test_the_seed_decides() -> None:
    def run(seed: int) -> np.ndarray:
        return perturb(*_records(15.0), TABLE, STOP_Y, CURVES, seed=seed).mu

    np.testing.assert_array_equal(run(4), run(4))
    assert not np.array_equal(run(4), run(5), equal_nan=True)


def test_too_few_replicates_have_no_spread() -> None:
    result = perturb(*_records(15.0), TABLE, STOP_Y, CURVES, seed=1, n_replicates=1)
    assert np.isnan(result.mu_sd).all()
    assert result.mu[0] == pytest.approx(0.7, abs=0.3)
