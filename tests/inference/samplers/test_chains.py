"""Have chains converged?"""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.samplers.chains import diagnose_chains


def _noise(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(4, 1000, 2))


def test_independent_draws_converge() -> None:
    result = diagnose_chains(_noise(), np.array([0.3, 0.4, 0.35, 0.35]))
    assert result.converged
    assert result.rhat_max < 1.01
    assert 2500 < result.ess_bulk_min < 6000
    assert result.acceptance == pytest.approx(0.35)


def test_rhat_and_ess_of_a_normal_match_the_textbook() -> None:
    """Autocorrelation 0.9: the ESS is n (1 - 0.9) / (1 + 0.9)."""
    rng = np.random.default_rng(1)
    draws = np.empty((4, 20000, 1))
    x = rng.normal(size=4)
    for i in range(20000):
        x = 0.9 * x + np.sqrt(1 - 0.81) * rng.normal(size=4)
        draws[:, i, 0] = x
    assert diagnose_chains(draws).ess_bulk_min == pytest.approx(80000 / 19, rel=0.15)


def test_a_chain_elsewhere_is_seen() -> None:
    draws = _noise()
    draws[2, :, 1] += 2.0
    result = diagnose_chains(draws)
    assert result.rhat_max > 1.1
    assert not result.converged


def test_few_draws_do_not_pass() -> None:
    assert not diagnose_chains(_noise()[:, :50]).converged


def test_a_stuck_chain_is_counted() -> None:
    draws = _noise()
    draws[1] = draws[1, 0]
    result = diagnose_chains(draws)
    assert result.stuck_chains == 1
    assert result.rhat_max == np.inf
    assert not result.converged


def test_a_chain_that_hardly_accepts_is_stuck() -> None:
    assert diagnose_chains(_noise(), np.array([0.3, 0.3, 0.001, 0.3])).stuck_chains == 1


def test_all_chains_stuck_at_different_places() -> None:
    draws = np.tile(np.arange(4.0)[:, None, None], (1, 100, 1))
    assert diagnose_chains(draws).stuck_chains == 4


def test_a_fixed_parameter_is_left_out() -> None:
    with_constant = np.concatenate([_noise(), np.ones((4, 1000, 1))], axis=2)
    assert diagnose_chains(with_constant) == diagnose_chains(_noise())


def test_draws_that_are_not_finite_never_converge() -> None:
    draws = _noise()
    draws[0, 3, 0] = np.nan
    assert not diagnose_chains(draws).converged
