"""Avalanches that nobody saw, in a world where all are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.hazard.avalanches import Avalanches, EventVolumes, with_volumes
from avahazard.hazard.exceedance import LEAST_SEEN, chance_seen, exceeded_runout, with_unseen
from tests.hazard.parabola import LAW, TOP_M, avalanches_of, draws, stops

SIGMA, RATE, N = 0.15, 0.8, 400_000
LOG_VOLUME = np.log([1e4, 5e4, 2e5])
SHARE = np.array([0.5, 0.3, 0.2])
RELEASES = (TOP_M, 2350.0)


def height(x: float) -> float:
    return 2500.0 - 0.9 * x + 1.2e-4 * x**2


@pytest.fixture(scope="module")
def drawn() -> tuple[np.ndarray, np.ndarray]:
    """Give volumes (as numbers of nodes) and stops x (m) of a great many avalanches."""
    rng = np.random.default_rng(7)
    k = rng.choice(3, N, p=SHARE)
    log_mu = LAW[0] - LAW[1] * np.exp(LOG_VOLUME[k]) * 1e-6 + SIGMA * rng.standard_normal(N)
    x = np.empty(N)
    for j, release in enumerate(RELEASES):
        mine = np.arange(N) % 2 == j
        x[mine] = stops(np.exp(log_mu[mine]), release)
    return k, x


def on_record(k: np.ndarray, seen: np.ndarray, seen_only: bool = True) -> Avalanches:
    """The path by the rate and the volumes of what was seen."""
    share = np.bincount(k[seen], minlength=3) / np.sum(seen)
    volumes = EventVolumes(
        np.full(4, RATE * np.mean(seen)), LOG_VOLUME, np.tile(share, (4, 1)), seen_only
    )
    return avalanches_of(draws(SIGMA, 4), volumes, RELEASES)


def test_with_the_unseen_the_rate_is_that_of_all(drawn) -> None:
    k, x = drawn
    limit = float(np.quantile(x, 0.35))
    recorded = on_record(k, x > limit)
    found = with_unseen(recorded, np.array([height(limit)]))
    np.testing.assert_allclose(found.volumes.rate, RATE, rtol=0.02)
    np.testing.assert_allclose(found.volumes.share[0], SHARE, atol=0.01)
    assert recorded.volumes.rate[0] < 0.7 * RATE
    chance = chance_seen(recorded, np.array([height(limit)]))[0]
    truth = [np.mean(x[k == j] > limit) for j in range(3)]
    np.testing.assert_allclose(chance, truth, atol=0.005)
    # The runout of 20 years is that of all avalanches, not that of those that were seen.
    share = -np.log1p(-1.0 / 20.0) / RATE
    assert exceeded_runout(found, 20.0)[0] == pytest.approx(np.quantile(x, 1.0 - share), abs=5.0)
    assert exceeded_runout(recorded, 20.0)[0] < np.quantile(x, 1.0 - share) - 5.0


def test_a_rate_of_all_avalanches_stays(drawn) -> None:
    k, x = drawn
    for seen_only, limit in ((False, 1800.0), (True, np.nan)):
        given = on_record(k, x > 0.0, seen_only)
        assert with_unseen(given, np.array([limit])) is given


def test_some_draws_may_have_a_limit_and_others_none(drawn) -> None:
    k, x = drawn
    given = on_record(k, x > 0.0)
    groups = replace(given, curves=given.curves * 2, group=np.array([0, 1, 0, 1]))
    limit = height(float(np.quantile(x[np.isfinite(x)], 0.35)))
    found = with_unseen(groups, np.array([limit, np.nan])).volumes.rate
    np.testing.assert_allclose(found[1::2], given.volumes.rate[1::2])
    assert np.all(found[::2] > 1.2 * given.volumes.rate[::2])


def test_what_is_hardly_ever_seen_does_not_blow_up(drawn) -> None:
    k, x = drawn
    given = on_record(k, x > 0.0)
    found = with_unseen(given, np.array([float(height(x[np.isfinite(x)].max()))]))
    assert np.all(found.volumes.rate <= RATE / LEAST_SEEN * 1.0001)
    assert np.isfinite(found.volumes.share).all()


def test_with_scatter_in_metres() -> None:
    volumes = EventVolumes(np.full(4, RATE), LOG_VOLUME, np.tile(SHARE, (4, 1)), True)
    known = avalanches_of(draws(60.0, 4), volumes, metres=True)
    middle = stops(np.exp(LAW[0] - LAW[1] * np.exp(LOG_VOLUME) * 1e-6), TOP_M)
    limit = float(height(middle[1]))
    assert chance_seen(known, np.array([limit]))[0, 1] == pytest.approx(0.5, abs=0.02)


def test_more_nodes_are_those_of_the_seen_too() -> None:
    volumes = EventVolumes(np.ones(2), LOG_VOLUME, np.tile(SHARE, (2, 1)), True)
    assert with_volumes(volumes, np.log([2e4])).seen_only
