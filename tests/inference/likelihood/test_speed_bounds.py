"""The most that a cell of frictions can hold of a record with speeds."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.likelihood.record_density import DEPTH, REACH
from avahazard.inference.likelihood.speed_bounds import cell_bounds

ONE_SPEED = (np.array([10.0]), np.eye(1), 0.0)
"""A measured square, the inverse of its error, and a constant, as `whitening` gives them."""
NO_JUMP = (-1, np.empty(1))


def part(speeds: np.ndarray) -> np.ndarray:
    """Speeds `[n, 1]` as a part of a wider table, which is how a record finds them."""
    return np.tile(speeds, 2)[:, :1]


def test_the_bound_of_a_cell_by_hand() -> None:
    ends, record = np.array([-3.0, -1.0, -2.0, -5.0]), np.array([100.0, 200.0, 300.0, 400.0])
    speeds = part(np.sqrt(10.0 - np.sqrt(-2.0 * ends))[:, None])
    left = np.array([True, True, False, False])
    told = (speeds, *NO_JUMP, ONE_SPEED, record, left)
    # Nobody stops in the first cell; the second misses the record by a standard deviation.
    stopped = cell_bounds(*told, False, 350.0, 50.0)
    np.testing.assert_allclose(stopped, [-np.inf, -1.5, -2.0])
    np.testing.assert_allclose(cell_bounds(*told, True, np.nan, 50.0), [-1.0, -1.0, -np.inf])
    # What no cell can explain is looked for in all of them.
    nobody = (speeds, *NO_JUMP, ONE_SPEED, record, np.zeros(4, dtype=np.bool_))
    np.testing.assert_array_equal(cell_bounds(*nobody, True, np.nan, 50.0), 0.0)


@pytest.mark.parametrize("seed", range(20))
def test_no_cell_that_counts_is_passed_over(seed: int) -> None:
    """Speeds are asked for where the record leaves a chance: the rest is below `DEPTH`."""
    rng = np.random.default_rng(seed)
    n = 60
    record, left = np.sort(rng.uniform(0.0, 900.0, n)), np.arange(n) >= 55
    speeds = part(np.sort(rng.uniform(0.0, 8.0, (n, 1)), axis=0)[::-1])
    cell, jumped = int(rng.integers(n)), np.array([1.5])
    observed, error = float(rng.uniform(0.0, 900.0)), 25.0
    constant = (-30.0, 0.0, 30.0)[seed % 3]  # the density at its highest is exp(-constant)
    told = (*ONE_SPEED[:2], constant)
    found = cell_bounds(speeds, cell, jumped, told, record, left, False, observed, error)
    square = speeds[:, 0] ** 2
    square[cell] = 1.5
    ends = -0.5 * (10.0 - square) ** 2 - constant
    z = (record - observed) / error
    miss = np.where(z[1:] * z[:-1] > 0.0, np.minimum(abs(z[1:]), abs(z[:-1])), 0.0)
    whole = np.maximum(ends[1:], ends[:-1]) - 0.5 * miss**2
    whole[left[1:] & left[:-1]] = -np.inf
    whole[miss > REACH] = -np.inf  # no points of the likelihood there
    counts = whole > np.max(whole) - DEPTH
    np.testing.assert_allclose(found[counts], whole[counts], rtol=1e-12)
    assert np.all(found[~counts] <= np.max(whole) - DEPTH)
