"""Draws of frequencies, and the GEV."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.special import logsumexp

from avahazard.hazard.extremes import (
    DEVIATIONS,
    LOG_SCALES,
    MEAN_OFFSET,
    SHAPES,
    SPREAD,
    FrequencyDraws,
    Gev,
    GevDraws,
    ThresholdDraws,
    gev_draws,
    gev_likelihood,
    gpd_draws,
    gpd_likelihood,
    over_locations,
    regional_prior,
    shape_prior,
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
    smallest = stats.genextreme.ppf(1e-3, *GEV.gev)
    np.testing.assert_allclose(found, smallest, rtol=1e-6)


def test_the_ends_hold_all_but_one_in_ten_thousand_over_the_threshold() -> None:
    low, high = THRESHOLD.ends()
    assert low == 8.0
    # 1e-4 of a generalised Pareto, in closed form; `shape` has the sign of genextreme.
    k = THRESHOLD.shape
    far = 10.0 + THRESHOLD.scale * (1.0 - 1e-4**k) / k
    assert high == pytest.approx(np.quantile(far, 0.9))


def test_the_gev_grid_is_scipys_density() -> None:
    sample = stats.genextreme.rvs(0.1, 9.0, 1.1, size=12, random_state=1)
    found = gev_likelihood(sample)
    for i, k, m in ((30, 10, 16), (40, 14, 10), (25, 3, 20)):
        scale = np.exp(LOG_SCALES[i])
        offset = DEVIATIONS[m] * SPREAD / np.sqrt(12) - MEAN_OFFSET[k]
        expected = stats.genextreme.logpdf(
            sample, SHAPES[k], sample.mean() + offset * scale, scale
        ).sum()
        assert found[i, k, m] == pytest.approx(expected + LOG_SCALES[i])


def test_over_locations_sums_what_is_there_and_leaves_nought_nought() -> None:
    rng = np.random.default_rng(6)
    given = rng.normal(-50.0, 30.0, (4, 3, 5))
    given[1, 2] = -np.inf
    given[2, 1, :4] = -np.inf
    expected = logsumexp(given, axis=2)
    assert expected[1, 2] == -np.inf
    np.testing.assert_allclose(over_locations(given), expected, rtol=1e-13)


def test_the_pareto_grid_is_scipys_density() -> None:
    excess = stats.genpareto.rvs(-0.1, scale=0.8, size=20, random_state=2)
    found = gpd_likelihood(excess)
    for i, k in ((34, 8), (40, 12), (20, 20)):
        expected = stats.genpareto.logpdf(excess, -SHAPES[k], scale=np.exp(LOG_SCALES[i])).sum()
        assert found[i, k] == pytest.approx(expected)


def test_draws_gather_about_the_truth_of_a_long_record() -> None:
    rng = np.random.default_rng(3)
    sample = stats.genextreme.rvs(0.15, 9.0, 1.2, size=400, random_state=rng)
    gev = gev_draws(sample, shape_prior(), gev_likelihood(sample), 2000, rng)
    best = stats.genextreme.fit(sample)
    for values, found in zip(gev, best, strict=True):
        assert np.mean(values) == pytest.approx(found, abs=0.3 * np.std(values) + 0.01)
    excess = stats.genpareto.rvs(-0.15, scale=0.9, size=600, random_state=rng)
    scale, shape = gpd_draws(shape_prior(), gpd_likelihood(excess), 2000, rng)
    fitted = stats.genpareto.fit(excess, floc=0.0)
    assert np.mean(scale) == pytest.approx(fitted[2], abs=0.03)
    assert np.mean(shape) == pytest.approx(-fitted[0], abs=0.05)


def test_maxima_with_errors_tell_the_true_ones_less_surely() -> None:
    """Against the truth over many samples: centred on it, and as wide as they miss it."""
    rng = np.random.default_rng(5)
    error, truth = 0.6, stats.genextreme(0.2, 9.0, 0.9)
    chance, away, exact_width, width = 0.97, [], [], []
    for _ in range(24):
        true = truth.rvs(40, random_state=rng)
        recorded = true + error * rng.standard_normal(40)
        made = [
            stats.genextreme.ppf(
                chance,
                *gev_draws(
                    values, shape_prior(error=e), gev_likelihood(values, error=e), 300, rng, error=e
                ),
            )
            for values, e in ((true, 0.0), (recorded, error))
        ]
        exact_width.append(made[0].std())
        width.append(made[1].std())
        away.append((made[1].mean() - truth.ppf(chance)) / made[1].std())
    assert abs(np.mean(away)) < 0.5
    assert 0.7 < np.std(away) < 1.3
    # Records freed of their errors beforehand would be taken for exact.
    assert np.mean(width) > 1.1 * np.mean(exact_width)


def test_other_paths_narrow_the_prior_but_not_to_a_point() -> None:
    rng = np.random.default_rng(4)
    samples = [stats.genextreme.rvs(0.1, k, 0.7, size=120, random_state=rng) for k in range(4)]
    prior = regional_prior(np.sum([over_locations(gev_likelihood(s)) for s in samples], axis=0))
    density = np.exp(prior - logsumexp(prior))
    scales, shapes = density.sum(axis=1), density.sum(axis=0)
    mean = float(scales @ LOG_SCALES)
    assert mean == pytest.approx(np.log(0.7), abs=0.08)
    assert float(scales @ (LOG_SCALES - mean) ** 2) ** 0.5 == pytest.approx(0.2, abs=0.05)
    centre = float(shapes @ SHAPES)
    assert float(shapes @ (SHAPES - centre) ** 2) ** 0.5 == pytest.approx(0.1, abs=0.04)


@pytest.mark.parametrize("error", [0.0, 0.5])
def test_the_prior_is_flat_in_the_log_of_the_scale_with_which_records_spread(error: float) -> None:
    found = shape_prior(error)
    # Errors add to the variance: they count as scales of this shape.
    in_scales = error / stats.genextreme.std(SHAPES[10])
    whole = 0.5 * np.log(np.exp(2.0 * LOG_SCALES) + in_scales**2)
    by_hand = np.gradient(whole, LOG_SCALES)
    row = np.exp(found[:, 10] - found[-1, 10])
    np.testing.assert_allclose(row[1:-1] / row[-2], (by_hand / by_hand[-2])[1:-1], rtol=0.02)
    if not error:
        normal = -0.5 * ((SHAPES - 0.2) / 0.15) ** 2
        np.testing.assert_allclose(np.diff(found[5]), np.diff(normal), atol=1e-9)
        np.testing.assert_array_equal(found, shape_prior())


@pytest.mark.parametrize("cell", [(20, 0, 5), (40, 13, 16), (30, 26, 27)])
def test_draws_of_one_cell_lie_evenly_within_it(cell: tuple[int, int, int]) -> None:
    sample = np.array([8.0, 9.0, 9.5, 11.0])
    i, k, m = cell
    likelihood = np.full((len(LOG_SCALES), len(SHAPES), len(DEVIATIONS)), -np.inf)
    likelihood[cell] = 0.0
    prior = np.zeros((len(LOG_SCALES), len(SHAPES)))
    gev = gev_draws(sample, prior, likelihood, 20_000, np.random.default_rng(4))
    # The mean of the GEV lies DEVIATIONS standard errors from the sample's.
    width = np.diff(DEVIATIONS)[0] * SPREAD / np.sqrt(len(sample))
    mean = sample.mean() + DEVIATIONS[m] * SPREAD / np.sqrt(len(sample)) * gev.scale
    off = (gev.location - mean) / gev.scale + MEAN_OFFSET[k]
    assert off.mean() == pytest.approx(0.0, abs=0.02 * width)
    assert off.std() == pytest.approx(width / np.sqrt(12.0), rel=0.02)
    assert np.ptp(off) <= width * (1.0 + 1e-9)
    for values, grid, at in ((np.log(gev.scale), LOG_SCALES, i), (gev.shape, SHAPES, k)):
        assert np.abs(values - grid[at]).max() <= 0.5 * np.diff(grid)[0] * (1.0 + 1e-9)


def test_means_are_sought_within_five_standard_errors() -> None:
    assert (DEVIATIONS[0], DEVIATIONS[-1]) == (-5.0, 5.0)
