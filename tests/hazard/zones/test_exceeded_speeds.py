"""Speeds that are exceeded once in T years, against runs of the block and plain counting."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.hazard.avalanches import EventVolumes, annual_rate, one_volume
from avahazard.hazard.exceedance import exceeded_runout
from avahazard.hazard.zones.exceeded_speeds import _behind, exceeded_speeds
from avahazard.inference.model.specification import Specification
from tests.hazard.zones.parabola import (
    RATES,
    SHARES,
    VOLUMES,
    X,
    avalanches_of,
    block_speeds,
    observations,
    one,
)


def test_one_volume_without_scatter_is_the_run_of_the_block() -> None:
    alone = avalanches_of(one(1e-12), one_volume(1e5, 3))
    (found,) = exceeded_speeds(alone, X, [100.0])
    expected = block_speeds(0.7 * np.exp(-0.2))[0]
    assert found == pytest.approx(np.tile(expected, (3, 1)), rel=1e-3, abs=0.15)
    assert found.max() > 30.0


def test_what_comes_too_seldom_has_no_speed() -> None:
    # Once in 50 years at most.
    rare = avalanches_of(one(0.1), one_volume(1e5, 3, rate=0.02))
    thirty, hundred = exceeded_speeds(rare, X, [30.0, 100.0])
    assert thirty.max() == 0.0
    assert hundred.max() > 20.0


def naive_speeds(p: int, sigma: float, period: float, releases: tuple[float, ...]) -> np.ndarray:
    """Draw p of the mixture counted out: every friction of many, run from every release."""
    z = (np.arange(4000) + 0.5) / 4000
    from scipy.stats import norm  # noqa: PLC0415 (slow)

    speeds, weights = [], []
    for release in releases:
        for volume, share in zip(np.exp(VOLUMES), SHARES[p], strict=True):
            mu = 0.7 * np.exp(-2e-6 * volume) * np.exp(sigma * norm.ppf(z))
            speeds.append(block_speeds(mu, release))
            weights.append(np.full(len(z), RATES[p] * share / len(releases) / len(z)))
    all_speeds, weight = np.concatenate(speeds), np.concatenate(weights)
    result = np.zeros(len(X))
    for i in range(len(X)):
        order = np.argsort(-all_speeds[:, i])
        often = np.cumsum(weight[order]) >= annual_rate(period)
        if often.any():
            result[i] = all_speeds[order[np.argmax(often)], i]
    return result


@pytest.mark.parametrize("releases", [(2450.0,), (2450.0, 2300.0, 1900.0)])
def test_mixture_of_volumes_and_releases_by_counting(releases: tuple[float, ...]) -> None:
    mixed = avalanches_of(one(0.15, 2), EventVolumes(RATES, VOLUMES, SHARES), releases)
    found = exceeded_speeds(mixed, X, [10.0, 100.0])
    for t, period in enumerate((10.0, 100.0)):
        for p in (0, 1):
            expected = naive_speeds(p, 0.15, period, releases)
            assert found[t, p] == pytest.approx(expected, rel=0.01, abs=0.4)


@pytest.mark.parametrize(
    "specification",
    [
        Specification(),
        Specification(tails="student"),
        Specification(distribution="normal"),
    ],
)
def test_speed_ends_where_the_runout_is_exceeded(specification: Specification) -> None:
    mixed = avalanches_of(
        one(0.12, 2), EventVolumes(RATES, VOLUMES, SHARES), specification=specification
    )
    (found,) = exceeded_speeds(mixed, X, [4.0])
    runout = exceeded_runout(mixed, 4.0)
    for p in (0, 1):
        moving = X[found[p] > 0.0]
        assert moving[-1] <= runout[p] + 1.0
        assert min(runout[p], X[-1]) < moving[-1] + 60.0
    assert X[0] < runout[0] < X[-1]


def test_drag_slows_the_draws_that_have_it() -> None:
    effect = definition("turbulent-drag").build({})
    scale = effect.parameters[0].prior_sd
    draws = np.vstack([one(1e-12, 2, 0.0), one(1e-12, 2, 0.002 / scale)])
    (found,) = exceeded_speeds(
        avalanches_of(draws, one_volume(1e5, 4), effects=(effect,)), X, [100.0]
    )
    assert found[0] == pytest.approx(block_speeds(0.7 * np.exp(-0.2))[0], rel=1e-3, abs=0.15)
    assert found[3].max() < 0.8 * found[0].max()


def test_the_front_brings_the_speed_of_the_block_behind_it() -> None:
    effect = definition("leading-edge").build({})
    share = 0.5 / effect.parameters[0].prior_sd
    draws = one(1e-12, 3, share)
    found = exceeded_speeds(
        avalanches_of(draws, one_volume(1e5, 3), effects=(effect,), length=200.0), X, [100.0]
    )[0, 0]
    site = observations(2450.0).sites[0]
    s = np.interp(X, site.terrain.x, site.terrain.s)
    behind = np.interp(s - 100.0, site.terrain.s, site.terrain.x)
    expected = np.sqrt(np.interp(behind, X, block_speeds(0.7 * np.exp(-0.2))[0] ** 2))
    moving = (behind > 100.0) & (expected > 8.0)
    assert found[moving] == pytest.approx(expected[moving], abs=0.5)


@pytest.mark.parametrize("distance", [0.0, 1.0, 40.0])
def test_what_is_behind_is_so_far_along_the_path(distance: float) -> None:
    (site,) = observations(2450.0).sites
    x = np.linspace(200.0, 2000.0, 7)
    behind = _behind(site, x, distance)
    terrain = site.terrain
    found = np.interp(x, terrain.x, terrain.s) - np.interp(behind, terrain.x, terrain.s)
    np.testing.assert_allclose(found, distance, atol=1e-9)
    # Above the top it goes on.
    assert _behind(site, np.array([terrain.x[0]]), 30.0) == pytest.approx(terrain.x[0] - 30.0)
