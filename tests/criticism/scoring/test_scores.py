"""Scores against slow obvious twins."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest, norm

from avahazard.criticism.scoring.expected import ExpectedRecords
from avahazard.criticism.scoring.scores import (
    crps,
    randomised_pit,
    record_pit,
    runout_scores,
    speed_scores,
)


def naive_crps(draws: np.ndarray, observed: float) -> float:
    """Mean distance to the record less half the mean distance of two different draws."""
    n = len(draws)
    apart = sum(abs(a - b) for a in draws for b in draws) / (n * (n - 1))
    return float(np.mean(np.abs(draws - observed)) - 0.5 * apart)


def crps_of_normal(observed: float, mean: float, sd: float) -> float:
    """Its closed form, Gneiting and others 2005, eq. 5."""
    z = (observed - mean) / sd
    return float(sd * (z * (2.0 * norm.cdf(z) - 1.0) + 2.0 * norm.pdf(z) - np.pi**-0.5))


def expected(draws: np.ndarray, observed: np.ndarray, sign: float = 1.0) -> ExpectedRecords:
    n = len(observed)
    return ExpectedRecords(
        observed=observed,
        sigma=np.full(n, 3.0),
        draws=draws,
        left=np.zeros(draws.shape, dtype=bool),
        x=draws,
        sign=np.full(n, sign),
    )


def test_crps_is_the_fair_one() -> None:
    rng = np.random.default_rng(1)
    draws, observed = rng.normal(size=(4, 12)), np.array([0.0, 1.0, -3.0, 8.0])
    twin = [naive_crps(d, y) for d, y in zip(draws, observed, strict=True)]
    np.testing.assert_allclose(crps(draws, observed), twin, rtol=1e-12)


def test_crps_of_many_draws_is_that_of_their_distribution() -> None:
    draws = np.random.default_rng(2).normal(5.0, 2.0, (1, 20_000))
    assert crps(draws, np.array([6.0]))[0] == pytest.approx(crps_of_normal(6.0, 5.0, 2.0), rel=0.03)


def test_pit_is_uniform_also_with_ties() -> None:
    rng = np.random.default_rng(3)
    # Half of everything lies at the profile's end.
    draws = np.maximum(rng.normal(size=(3000, 200)), 0.0)
    observed = np.maximum(rng.normal(size=3000), 0.0)
    pit = randomised_pit(draws, observed, rng)
    assert kstest(pit, "uniform").pvalue > 0.01
    plain = np.mean(draws < observed[:, None], axis=1)
    assert kstest(plain, "uniform").pvalue < 1e-6


def test_pit_turns_round_with_the_sign() -> None:
    draws = np.arange(100.0)[None, :]
    for sign, low in ((1.0, True), (-1.0, False)):
        pit = record_pit(expected(draws, np.array([3.5]), sign), np.random.default_rng(4))
        assert (pit[0] < 0.1) == low


def test_scores_by_hand() -> None:
    draws = np.array([[0.0, 10.0], [20.0, 40.0]])
    records = expected(draws, np.array([2.0, 34.0]))
    scores = runout_scores(records, np.array([0.3, 0.96]), np.array([3.0, 4.0]))
    assert scores.n == 2
    assert scores.bias_m == pytest.approx(0.5 * (3.0 - 4.0))
    assert scores.rmse_m == pytest.approx(np.sqrt(0.5 * (9.0 + 16.0)))
    assert (scores.coverage_50, scores.coverage_90) == (0.5, 0.5)
    assert scores.noise_floor_m == pytest.approx(np.sqrt(12.5))
    assert scores.noise_floor_crps_m == pytest.approx(3.5 / np.sqrt(np.pi))
    assert sum(scores.pit_histogram) == 2
    other = runout_scores(expected(draws, records.observed, -1.0), np.array([0.3, 0.9]), np.ones(2))
    assert other.bias_m == pytest.approx(0.5)


def test_speed_scores_name_their_unit() -> None:
    draws = np.array([[10.0, 12.0]])
    scores = speed_scores(draws, np.array([9.0]), np.array([1.5]), np.array([0.1]))
    assert scores.rmse_m_s == pytest.approx(2.0)
    assert scores.noise_floor_m_s == pytest.approx(1.5)
