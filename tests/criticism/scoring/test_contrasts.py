"""A level against the other events, with paths that differ."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.criticism.scoring.contrasts import contrast_p, contrast_p_values

PATH = np.repeat(np.arange(9), [40, 10, 25, 8, 30, 15, 22, 12, 18])


def _flags(kind: str, rng: np.random.Generator) -> np.ndarray:
    """Levels that vary within paths, that belong to whole paths, or mostly so."""
    if kind == "events":
        return (rng.random(len(PATH)) < 0.3).astype(float)
    of_path = (rng.permutation(9) < 4).astype(float)[PATH]
    if kind == "paths":
        return of_path
    return np.where(rng.random(len(PATH)) < 0.2, 1.0 - of_path, of_path)


@pytest.mark.parametrize("spread", [0.0, 0.5])
@pytest.mark.parametrize("kind", ["events", "paths", "mixed"])
def test_p_values_of_nothing_are_even(kind: str, spread: float) -> None:
    rng = np.random.default_rng(1)
    found = []
    for _ in range(1500):
        z = rng.standard_normal(len(PATH)) + spread * rng.standard_normal(9)[PATH]
        found.append(contrast_p(z, _flags(kind, rng), PATH))
    p = np.array(found)
    for level in (0.01, 0.05, 0.2):
        # No more alarms than promised, and not far fewer where events of a path differ.
        assert np.mean(p < level) < level + 3.0 * np.sqrt(level / 1500) + 0.15 * level
    if kind == "events":
        assert np.mean(p < 0.2) > 0.13


def test_without_paths_that_differ_it_is_near_the_t_test() -> None:
    rng = np.random.default_rng(2)
    x = _flags("events", rng)
    z = rng.standard_normal(len(PATH)) * 1.2 + 0.4 * x
    p = contrast_p(z, x, PATH)
    assert p == pytest.approx(float(stats.ttest_ind(z[x == 1], z[x == 0]).pvalue), rel=0.5)


def test_whole_paths_are_the_t_test_of_their_means() -> None:
    rng = np.random.default_rng(3)
    path = np.repeat(np.arange(10), 20)
    x = (np.arange(10) < 4).astype(float)
    # A spread so wide that the events within a path say nothing.
    z = rng.standard_normal(200) + (30.0 * rng.standard_normal(10) + 20.0 * x)[path]
    means = np.bincount(path, z) / 20
    expected = stats.ttest_ind(means[x == 1], means[x == 0]).pvalue
    assert contrast_p(z, x[path], path) == pytest.approx(float(expected), rel=1e-3)


def test_a_level_within_paths_is_seen_through_their_spread() -> None:
    rng = np.random.default_rng(4)
    x = _flags("events", rng)
    z = rng.standard_normal(len(PATH)) + 2.0 * rng.standard_normal(9)[PATH] + 0.8 * x
    p = contrast_p(z, x, PATH)
    assert p is not None
    assert p < 1e-4


def test_levels_without_contrast_say_nothing() -> None:
    z = np.arange(6.0)
    assert contrast_p(z, np.ones(6), np.repeat([0, 1], 3)) is None
    of_path = np.array(["a", "a", "b", "b", "c", "c"])
    assert contrast_p_values(z, of_path, np.repeat([0, 1, 2], 2)) == {}
