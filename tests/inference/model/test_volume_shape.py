"""The shape of a population of volumes, from records with errors."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm, truncnorm

from avahazard.inference.model.volume_shape import (
    MOST_PULL,
    WIDEST,
    VolumeShape,
    _curvature,
    cut_normals,
    largest_volume,
    volume_shape,
)

AWAY = np.linspace(-5.0, 5.0, 41)


def _recorded(true: np.ndarray, error: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Records of values with mean 0 and variance 1, and their errors."""
    rng = np.random.default_rng(seed)
    return true + error * rng.standard_normal(len(true)), np.full(len(true), error)


@pytest.mark.parametrize("error", [1e-6, 0.1, 0.5, 2.0])
def test_with_a_normal_shape_what_is_true_is_the_normal_given_the_record(error: float) -> None:
    shape = VolumeShape(np.linspace(-9.0, 9.0, 2001), norm.logpdf(np.linspace(-9.0, 9.0, 2001)))
    recorded = np.array([-3.0, 0.0, 0.4, 2.5])
    mean, sd = shape.moments(recorded, np.full(4, error))
    trust = 1.0 / (1.0 + error**2)
    np.testing.assert_allclose(mean, trust * recorded, atol=1e-4)
    np.testing.assert_allclose(sd, np.sqrt(1.0 - trust), rtol=1e-3)


def test_moments_are_those_of_the_density() -> None:
    logs = -0.5 * AWAY**2 + np.where(AWAY > 1.0, -2.0 * (AWAY - 1.0) ** 2, 0.0)
    shape = VolumeShape(AWAY, logs)
    recorded, error = np.array([-1.0, 0.8, 2.2]), np.array([0.6, 0.4, 0.9])
    mean, sd = shape.moments(recorded, error)
    for k in range(3):

        def density(v: float, power: int, k: int = k) -> float:
            own = np.exp(np.interp(v, AWAY, logs)) * norm.pdf(recorded[k], v, error[k])
            return float(own * v**power)

        total, first, second = (
            quad(density, -5, 5, args=(power,), points=list(AWAY[8:33]), limit=200)[0]
            for power in range(3)
        )
        assert mean[k] == pytest.approx(first / total, abs=2e-3)
        assert sd[k] == pytest.approx(np.sqrt(second / total - (first / total) ** 2), rel=5e-3)


@pytest.mark.parametrize(("n", "error"), [(30, 0.3), (240, 0.3), (240, 1.0), (3000, 0.5)])
def test_normals_ask_for_no_other_shape(n: int, error: float) -> None:
    evidence = []
    for seed in range(12):
        true = np.random.default_rng([7, seed]).standard_normal(n)
        evidence.append(volume_shape(*_recorded(true, error, seed))[1])
    assert max(evidence) < 4.0
    assert np.mean(np.array(evidence) > 1.0) < 0.2


@pytest.mark.parametrize(("n", "error"), [(2000, 0.5), (4000, 0.8)])
def test_volumes_that_thin_out_as_a_power_are_read_as_such(n: int, error: float) -> None:
    """Their logs are exponential: given a record the true one is less by as much everywhere."""
    true = np.random.default_rng(n).exponential(1.0, n) - 1.0
    recorded, errors = _recorded(true, error, 3)
    shape, evidence = volume_shape(recorded, errors)
    assert evidence > 5.0
    mean, sd = shape.moments(recorded, errors)
    top = recorded > np.quantile(recorded, 0.9)
    plain = recorded / (1.0 + error**2)
    assert abs(np.mean(true - mean)) < 0.05
    assert abs(np.mean((true - mean)[top])) < 0.4 * abs(np.mean((true - plain)[top]))
    assert np.mean((true - mean) ** 2) < 0.95 * np.mean((true - plain) ** 2)
    assert np.sqrt(np.mean((true - mean) ** 2)) == pytest.approx(np.sqrt(np.mean(sd**2)), rel=0.08)


def test_it_has_mean_nought_and_spread_one() -> None:
    true = np.random.default_rng(5).exponential(1.0, 500) - 1.0
    shape, _ = volume_shape(*_recorded(true, 0.3, 4))
    share = np.exp(shape.log_density)
    assert share.sum() == pytest.approx(1.0)
    assert share @ shape.away == pytest.approx(0.0, abs=1e-9)
    assert share @ shape.away**2 == pytest.approx(1.0)


def test_a_record_far_beyond_the_ends_is_drawn_back_and_finite() -> None:
    true = np.random.default_rng(6).uniform(-1.7, 1.7, 2000)
    shape, evidence = volume_shape(*_recorded(true, 0.3, 5))
    assert evidence > 5.0
    mean, sd = shape.moments(np.array([-30.0, 3.0, 30.0]), np.array([0.3, 0.3, 0.3]))
    assert np.all(np.isfinite(mean))
    assert np.all(sd > 0.0)
    assert mean[1] < 2.4 < mean[2] < 30.0


def test_the_curvature_bears_shares_that_are_no_numbers_any_more() -> None:
    """A step of the fit may try a shape of which most places have a share under 1e-308."""
    eta, count = np.array([0.0, 900.0, 0.0]), np.array([1.0, 2.0])
    found = _curvature(eta, np.full((2, 3), -0.3), count, np.eye(3))
    np.testing.assert_allclose(found, np.eye(3), atol=1e-12)


def _cut_records(
    n: int, n_paths: int, top: float, error: float, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """Records of normals of spread 1, cut at `top`, as `largest_volume` takes them."""
    rng = np.random.default_rng(seed)
    path = np.arange(n) % n_paths
    middle = rng.normal(0.0, 0.4, n_paths)[path]
    true = middle + truncnorm.rvs(-np.inf, top - middle, random_state=rng)
    recorded = true + error * rng.standard_normal(n)
    centre = np.bincount(path, recorded) / np.bincount(path)
    spread2 = np.sum((recorded - centre[path]) ** 2) / (n - n_paths) - error**2
    return recorded, np.full(n, error), path, centre, float(np.sqrt(spread2))


def test_cut_normals_have_the_moments_asked_for() -> None:
    centre, count = np.array([-0.4, 0.1, 0.5]), np.array([10, 30, 20])
    cut = cut_normals(centre, count, 0.8, 1.6)
    laws = [truncnorm(-np.inf, (1.6 - c) / cut.spread, c, cut.spread) for c in cut.centre]
    np.testing.assert_allclose([law.mean() for law in laws], centre, atol=1e-4)
    variance = np.average([law.var() for law in laws], weights=count)
    assert np.sqrt(variance) == pytest.approx(0.8, abs=1e-4)


def test_without_an_end_they_are_what_is_recorded() -> None:
    centre = np.array([-0.4, 0.1])
    for largest in (np.inf, 40.0):
        cut = cut_normals(centre, np.array([1, 1]), 0.8, largest)
        np.testing.assert_allclose([*cut.centre, cut.spread], [-0.4, 0.1, 0.8], rtol=1e-9)


def test_where_no_normal_is_so_skewed_it_is_as_wide_as_it_may_be() -> None:
    cut = cut_normals(np.array([0.0, 0.0]), np.array([5, 5]), 1.0, 0.2)
    assert 1.0 < cut.spread <= WIDEST
    assert np.all(cut.centre > 0.2)


def test_records_of_one_path_that_crowd_at_the_end_do_not_carry_its_centre_away() -> None:
    centre = np.array([0.0, 2.0])
    cut = cut_normals(centre, np.array([500, 5]), 1.0, 2.05)
    assert cut.centre[1] - centre[1] == pytest.approx(MOST_PULL * cut.spread, rel=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_it_is_found_where_records_lie_beyond_it(seed: int) -> None:
    largest, ratio = largest_volume(*_cut_records(4000, 200, 2.0, 0.3, seed))
    assert largest == pytest.approx(2.0, abs=0.12)
    assert ratio > 10.0


@pytest.mark.parametrize(("n", "n_paths", "error"), [(60, 4, 0.5), (240, 9, 0.3), (4000, 200, 0.8)])
def test_where_there_is_none_it_is_not(n: int, n_paths: int, error: float) -> None:
    ratios = [largest_volume(*_cut_records(n, n_paths, 40.0, error, seed))[1] for seed in range(20)]
    assert max(ratios) < 2.0


def test_the_ratio_is_that_of_the_densities() -> None:
    recorded, sigma, path, centre, spread = _cut_records(60, 3, 0.8, 0.4, 1)
    largest, ratio = largest_volume(recorded, sigma, path, centre, spread)
    cut = cut_normals(centre, np.bincount(path), spread, largest)
    free = norm.logpdf(recorded, centre[path], np.hypot(spread, sigma)).sum()
    told = 0.0
    for r, e, k in zip(recorded, sigma, path, strict=True):
        law = truncnorm(-np.inf, (largest - cut.centre[k]) / cut.spread, cut.centre[k], cut.spread)
        told += np.log(
            quad(lambda v, r=r, e=e, f=law: f.pdf(v) * norm.pdf(r, v, e), -8, largest)[0]
        )
    assert ratio == pytest.approx(told - free - 0.5 * np.log(60), abs=1e-5)
