"""Rates, volumes and frictions of what comes down a path."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.effects.catalogue import definition
from avahazard.hazard.avalanches import (
    EventVolumes,
    annual_rate,
    event_volumes,
    exceeded,
    one_volume,
    with_volumes,
)
from avahazard.hazard.exceedance import passing
from avahazard.inference.model.specification import Specification
from tests.hazard.naive import rate_below
from tests.hazard.parabola import LAW, TOP_M, avalanches_of, draws, stops


def test_nodes_hold_the_rate_between_their_middles() -> None:
    rate = np.array([0.5, 2.0])
    found = event_volumes(
        rate, lambda v: rate[:, None] * np.exp(-np.maximum(v - 8.0, 0.0))[None, :], 8.0, 14.0
    )
    assert found.share.sum(axis=1) == pytest.approx([1.0, 1.0])
    over = (found.share * (found.log_volume > 10.0)).sum(axis=1)
    middle = found.log_volume[found.log_volume > 10.0][0]
    step = np.diff(found.log_volume)[0]
    assert over == pytest.approx([np.exp(-(middle - step / 2 - 8.0))] * 2)


def test_one_place_has_one_node() -> None:
    found = event_volumes(np.array([0.5]), lambda v: np.empty((1, len(v))), 9.0, 9.0)
    assert (found.log_volume.tolist(), found.share.tolist()) == ([9.0], [[1.0]])


def test_more_nodes_have_no_share() -> None:
    found = with_volumes(one_volume(1e4, 2, 0.3), np.log([1e3, 1e4, 1e5]))
    np.testing.assert_allclose(np.exp(found.log_volume), [1e3, 1e4, 1e5])
    assert found.share.tolist() == [[0.0, 1.0, 0.0]] * 2


def test_where_nothing_comes_all_volumes_share_alike() -> None:
    rate = np.array([0.0, 0.4])
    found = event_volumes(rate, lambda v: np.zeros((2, len(v))), 8.0, 9.0)
    n = len(found.log_volume)
    assert found.share[0] == pytest.approx(np.full(n, 1.0 / n))
    assert found.share[1] == pytest.approx(np.eye(n)[0])


VOLUMES = EventVolumes(
    np.array([0.4, 0.2]),
    np.log([1e4, 1e5, 4e5]),
    np.array([[0.6, 0.3, 0.1], [0.2, 0.3, 0.5]]),
)
RELEASES = (TOP_M, 2350.0)


def drawn_friction(p: int, n: int, rng: np.random.Generator, sigma: float) -> np.ndarray:
    volume = rng.choice(np.exp(VOLUMES.log_volume), size=n, p=VOLUMES.share[p])
    return np.exp(LAW[0] - LAW[1] * 1e-6 * volume + sigma * rng.standard_normal(n))


def test_the_rate_under_a_friction_is_that_of_drawn_avalanches() -> None:
    avalanches = avalanches_of(draws(0.1, 2), VOLUMES)
    rng = np.random.default_rng(1)
    for mu in (0.35, 0.5, 0.65):
        found = rate_below(avalanches, np.full((2, 1), mu))
        for p in range(2):
            share = np.mean(drawn_friction(p, 400_000, rng, 0.1) < mu)
            assert found[p] == pytest.approx(VOLUMES.rate[p] * share, abs=0.001)
    assert rate_below(avalanches, np.zeros((2, 1))).tolist() == [0.0, 0.0]
    assert rate_below(avalanches, np.full((2, 1), np.inf)) == pytest.approx(VOLUMES.rate)


def test_the_rate_past_a_place_is_that_of_drawn_avalanches() -> None:
    avalanches = avalanches_of(draws(0.1, 2), VOLUMES, RELEASES)
    places = np.array([2000.0, 2400.0, 2800.0])
    rates = passing(avalanches).rates(places)
    rng = np.random.default_rng(2)
    for x, found in zip(places, rates, strict=True):
        for p in range(2):
            passed = []
            for z in RELEASES:
                mu = drawn_friction(p, 200_000, rng, 0.1)
                passed.append(np.mean(stops(mu, z) > x))
            assert found[p] == pytest.approx(VOLUMES.rate[p] * np.mean(passed), abs=0.001)


def test_friction_that_is_normal_is_over_nought() -> None:
    specification = Specification(distribution="normal")
    coordinates = draws(0.3, 1)
    avalanches = avalanches_of(coordinates, one_volume(1e5, 1), specification=specification)
    mean = np.exp(LAW[0] - LAW[1] * 0.1)
    truth = stats.truncnorm(-mean / 0.3, np.inf, loc=mean, scale=0.3)
    for mu in (0.0, 0.2, 0.6):
        assert rate_below(avalanches, np.full((1, 1), mu)) == pytest.approx(truth.cdf(mu))


def test_students_tails() -> None:
    avalanches = avalanches_of(
        draws(0.1, 1), one_volume(1e5, 1), specification=Specification(tails="student")
    )
    middle = np.exp(LAW[0] - LAW[1] * 0.1)
    found = rate_below(avalanches, np.full((1, 1), middle * np.exp(-0.3)))
    assert found == pytest.approx(stats.t(4).cdf(-3.0))


def test_effects_on_friction_see_the_volume_of_each_node() -> None:
    facts = {"knots": [9.0, 10.0], "centre": 10.0, "scale": 1.0}
    effect = definition("covariate:volume_m3").build(facts)
    slope = 0.1 / effect.parameters[0].prior_sd
    avalanches = avalanches_of(draws(0.1, 2, slope), VOLUMES, effects=(effect,))
    volume = np.exp(VOLUMES.log_volume)
    expected = LAW[0] - LAW[1] * 1e-6 * volume + 0.1 * (VOLUMES.log_volume - 10.0)
    np.testing.assert_allclose(avalanches.location[0, 0], expected)


def test_fewer_draws_of_the_model_serve_several_times() -> None:
    coordinates = draws(0.1, 3)
    coordinates[:, 0] += [0.0, 0.1, 0.2]
    avalanches = avalanches_of(coordinates, one_volume(1e5, 6))
    assert np.diff(avalanches.location[:, 0, 0]) == pytest.approx([0.0, 0.1, 0.0, 0.1, 0.0])


def test_the_level_of_a_rate() -> None:
    found = exceeded(lambda v: np.exp(-v), np.array([0.1, 0.01, 2.0, 1e-9]), 0.0, 10.0, 4)
    assert found[:3] == pytest.approx([np.log(10.0), np.log(100.0), 0.0], abs=1e-5)
    assert found[3] == np.inf


def test_a_year_has_one_or_more_with_chance_one_in_t() -> None:
    assert -np.expm1(-annual_rate(30.0)) == pytest.approx(1 / 30)


def test_a_level_that_is_exceeded_just_as_often_counts() -> None:
    found = exceeded(lambda v: np.where(v < 5.0, 0.1, 0.0), 0.1, 0.0, 10.0, 1)
    assert found == pytest.approx([5.0], abs=1e-5)
