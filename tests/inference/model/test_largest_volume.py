"""The largest volume that there is, from records with errors."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm, truncnorm

from avahazard.inference.model.largest_volume import (
    MOST_PULL,
    WIDEST,
    cut_normals,
    largest_volume,
)


def _recorded(
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
    largest, ratio = largest_volume(*_recorded(4000, 200, 2.0, 0.3, seed))
    assert largest == pytest.approx(2.0, abs=0.12)
    assert ratio > 10.0


@pytest.mark.parametrize(("n", "n_paths", "error"), [(60, 4, 0.5), (240, 9, 0.3), (4000, 200, 0.8)])
def test_where_there_is_none_it_is_not(n: int, n_paths: int, error: float) -> None:
    ratios = [largest_volume(*_recorded(n, n_paths, 40.0, error, seed))[1] for seed in range(20)]
    assert max(ratios) < 2.0


def test_the_ratio_is_that_of_the_densities() -> None:
    recorded, sigma, path, centre, spread = _recorded(60, 3, 0.8, 0.4, 1)
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
