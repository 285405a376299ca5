"""Draws of frequencies, and the GEV."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.hazard.frequency_draws import FrequencyDraws, Gev, GevDraws, ThresholdDraws


def test_quantiles_are_exceeded_as_often_as_they_say() -> None:
    gev = Gev(np.array([-0.3, 0.1, 0.4]), np.array([8.0, 9.0, 10.0]), np.array([1.0, 0.5, 2.0]))
    for probability in (0.1, 0.5, 0.99):
        exceeded = np.diag(gev.exceedance(gev.quantile(probability)))
        np.testing.assert_allclose(exceeded, 1.0 - probability)


def test_both_are_scipys_at_any_shape_and_past_the_bounds() -> None:
    shape = np.array([-0.5, -1e-9, 0.0, 1e-9, 0.3, 0.8])
    gev = Gev(shape, np.linspace(8.0, 10.0, 6), np.linspace(0.5, 2.0, 6))
    values = np.array([-20.0, 4.0, 8.5, 9.0, 12.0, 60.0])
    expected = stats.genextreme(shape[:, None], gev.location[:, None], gev.scale[:, None])
    np.testing.assert_allclose(gev.exceedance(values), expected.sf(values), rtol=1e-9, atol=1e-15)
    assert 0.0 in gev.exceedance(values)
    assert 1.0 in gev.exceedance(values)
    for probability in (1e-3, 0.5, 0.9999):
        np.testing.assert_allclose(
            gev.quantile(probability), expected.ppf(probability)[:, 0], rtol=1e-10
        )


GEV = GevDraws(
    np.array([0.2, 0.6]), Gev(np.array([0.1, -0.1]), np.array([9.0, 9.5]), np.array([1.0, 0.8]))
)
THRESHOLD = ThresholdDraws(
    rate=np.array([0.5, 0.3]),
    share_over=np.array([0.4, 0.6]),
    threshold=10.0,
    scale=np.array([0.8, 1.0]),
    shape=np.array([0.2, -0.1]),
    below=np.array([8.0, 9.0, 9.5]),
    weight=np.array([[0.2, 0.5, 0.3], [1.0, 0.0, 0.0]]),
)


@pytest.mark.parametrize("draws", [GEV, THRESHOLD])
@pytest.mark.parametrize("period", [10.0, 100.0, 1000.0])
def test_the_volume_of_a_period_is_exceeded_at_its_rate(
    draws: FrequencyDraws, period: float
) -> None:
    volume = draws.log_volume(1.0 / period)
    rates = np.diag(draws.rate_over(volume))
    assert rates == pytest.approx([-np.log1p(-1.0 / period)] * 2, rel=1e-6)


@pytest.mark.parametrize("draws", [GEV, THRESHOLD])
def test_rates_fall_from_that_of_all_avalanches(draws: FrequencyDraws) -> None:
    low, high = draws.ends()
    rates = draws.rate_over(np.linspace(low - 5.0, high, 50))
    assert rates[:, 0] == pytest.approx(draws.rate, rel=0.01)
    assert (np.diff(rates, axis=1) <= 1e-12).all()
    assert (rates[:, -1] < 0.01 * draws.rate).all()


def test_yearly_maxima_are_those_of_a_poisson_process() -> None:
    """By simulation: the largest of Poisson many volumes with the rate over each volume."""
    rng = np.random.default_rng(1)
    grid = np.linspace(4.0, 20.0, 2000)
    over = GEV.rate_over(grid)[0]
    n_years = 400_000
    count = rng.poisson(GEV.rate[0], n_years)
    year = np.repeat(np.arange(n_years), count)
    volume = np.interp(rng.random(len(year)) * GEV.rate[0], over[::-1], grid[::-1])
    largest = np.full(n_years, -np.inf)
    np.maximum.at(largest, year, volume)
    for probability in (0.05, 0.01):
        assert np.mean(largest > GEV.log_volume(probability)[0]) == pytest.approx(
            probability, rel=0.03
        )


def test_under_the_threshold_records_are_counted() -> None:
    rates = THRESHOLD.rate_over(np.array([7.0, 8.5, 9.7]))
    assert rates[0] == pytest.approx([0.5, 0.5 * (0.4 + 0.6 * 0.8), 0.5 * 0.4])
    # 1.2 of 4 avalanches are over the threshold's: a period short enough ends among the records.
    chance = -np.expm1(-0.5 * (0.4 + 0.6 * 0.6))
    assert THRESHOLD.log_volume(chance)[0] == 9.0
    assert THRESHOLD.log_volume(0.9)[0] == 8.0


def test_where_avalanches_are_rarer_than_the_chance_it_is_the_smallest_of_them() -> None:
    found = GEV.log_volume(0.9)
    smallest = [stats.genextreme.ppf(1e-3, c, m, s) for c, m, s in zip(*gev_of(GEV), strict=True)]
    np.testing.assert_allclose(found, smallest, rtol=1e-6)


def gev_of(draws: GevDraws) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return draws.gev.shape, draws.gev.location, draws.gev.scale


def test_the_ends_hold_all_but_one_in_ten_thousand_over_the_threshold() -> None:
    low, high = THRESHOLD.ends()
    assert low == 8.0
    # 1e-4 of a generalised Pareto, in closed form; `shape` has the sign of genextreme.
    k = THRESHOLD.shape
    far = 10.0 + THRESHOLD.scale * (1.0 - 1e-4**k) / k
    assert high == pytest.approx(np.quantile(far, 0.9))
