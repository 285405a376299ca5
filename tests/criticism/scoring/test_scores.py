"""Scores against slow obvious twins."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest, norm

from avahazard.criticism.scoring.scores import (
    ExpectedRecords,
    crps,
    in_x,
    randomised_pit,
    record_pit,
    runout_scores,
    speed_scores,
)
from avahazard.criticism.scoring.speed_misfit import MatchedSpeeds
from avahazard.inference.model.observations import build_observations
from avahazard.records.collection import Event, Path, Profile, Records


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
    one, draws = np.zeros(1), np.array([[10.0, 12.0]])
    matched = MatchedSpeeds(one.astype(int), one, one + 9.0, one + 1.5, draws)
    scores = speed_scores(matched)
    assert scores is not None
    assert scores.rmse_m_s == pytest.approx(2.0)
    assert scores.noise_floor_m_s == pytest.approx(1.5)


X = np.arange(0.0, 2001.0, 20.0)
SLOPE = 0.5


def test_elevations_become_places_and_places_stay() -> None:
    events = (
        Event("z", path_id="p", runout_elevation_m=1500.0, volume_m3=1e4, runout_sigma_m=10.0),
        Event("x", path_id="p", runout_x_m=1300.0, volume_m3=1e4, runout_sigma_m=10.0),
        Event("left", path_id="p", left_profile=True, volume_m3=1e4),
        Event("bare", fall_height_m=500.0, runout_length_m=1000.0, volume_m3=1e4),
    )
    profile = Profile("p", X, 2000.0 - SLOPE * X)
    observations = build_observations(Records((Path("p"),), (profile,), events))
    draws = np.array([[1520.0, 1480.0], [1280.0, 1330.0], [1200.0, 1000.0], [900.0, 1100.0]])
    left = np.array([[False, False], [False, False], [False, True], [False, False]])
    expected = ExpectedRecords(
        observed=np.array([1500.0, 1300.0, 1000.0, 1000.0]),
        sigma=np.array([10.0, 10.0, 10.0, 10.0]),
        draws=draws,
        left=left,
        x=draws,
        sign=np.array([1.0, -1.0, 1.0, -1.0]),
    )
    found = in_x(expected, observations)
    assert found is not None
    assert found.observed == pytest.approx([1000.0, 1300.0, 2000.0], abs=0.5)
    assert found.draws == pytest.approx(
        np.array([[960.0, 1040.0], [1280.0, 1330.0], [1600.0, 2000.0]]), abs=0.5
    )
    # An error of elevation is twice as much along a slope of 1 in 2.
    assert found.sigma[:2] == pytest.approx([20.0, 10.0], abs=0.1)
    assert (found.sign == 1.0).all()
    assert found.error == pytest.approx([0.0, 5.0, -200.0], abs=0.5)


def test_nothing_without_a_profile() -> None:
    event = Event("bare", fall_height_m=500.0, runout_length_m=1000.0, volume_m3=1e4)
    observations = build_observations(Records((), (), (event,)))
    one = np.array([1000.0])
    assert in_x(ExpectedRecords(one, one, one[:, None], one[:, None] < 0, one[:, None], one),
                observations) is None  # fmt: skip
