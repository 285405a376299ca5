"""The eliminated system of crossed offsets against the whole matrix."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.likelihood.offset_system import (
    by_offset,
    log_determinant,
    offset_system,
    solved,
    variances,
)
from avahazard.kernels import kernel

N_EVENTS = 40


@kernel
def found(index, rest, h, keep, prior, slope):  # type: ignore[no-untyped-def]
    """All that the system gives."""
    bend, cross, root = offset_system(index, rest, h, keep, prior)
    step = solved(rest, bend, cross, root, slope)
    spread = variances(rest, bend, cross, root)
    return bend, root, step, log_determinant(rest, bend, root), spread


@kernel
def summed(index, keep, g, n_offsets):  # type: ignore[no-untyped-def]
    return by_offset(index, keep, g, n_offsets)


def crossed(seed: int) -> tuple[np.ndarray, ...]:
    """Five paths, the largest grouping, and three winters; some events have no winter."""
    rng = np.random.default_rng(seed)
    winter = np.where(rng.uniform(size=N_EVENTS) < 0.3, -1, 5 + rng.integers(0, 3, N_EVENTS))
    index = np.stack([rng.integers(0, 5, N_EVENTS), winter])
    rest = np.array([-1] * 5 + [0, 1, 2])
    keep = rng.uniform(size=N_EVENTS) < 0.8
    return index, rest, rng.uniform(0.0, 9.0, N_EVENTS), keep, rng.uniform(1.0, 20.0, 8)


def whole(index: np.ndarray, h: np.ndarray, keep: np.ndarray, prior: np.ndarray) -> np.ndarray:
    """The precision of all offsets, event by event."""
    matrix = np.diag(prior)
    for i in np.flatnonzero(keep):
        mine = index[:, i][index[:, i] >= 0]
        matrix[np.ix_(mine, mine)] += h[i]
    return matrix


@pytest.mark.parametrize("seed", range(4))
def test_steps_determinant_and_variances_are_those_of_the_whole_matrix(seed: int) -> None:
    index, rest, h, keep, prior = crossed(seed)
    slope = np.random.default_rng(seed).standard_normal(8)
    bend, _, step, determinant, spread = found(index, rest, h, keep, prior, slope)
    matrix = whole(index, h, keep, prior)
    np.testing.assert_allclose(bend, np.diag(matrix))
    np.testing.assert_allclose(step, np.linalg.solve(matrix, slope), atol=1e-12)
    assert determinant == pytest.approx(np.linalg.slogdet(matrix)[1])
    np.testing.assert_allclose(spread, np.diag(np.linalg.inv(matrix)), rtol=1e-9)


def test_one_grouping_is_a_diagonal() -> None:
    index, _, h, keep, prior = crossed(1)
    index, prior, slope = index[:1].copy(), prior[:5].copy(), np.arange(5.0)
    bend, root, step, determinant, spread = found(index, np.full(5, -1), h, keep, prior, slope)
    assert root.size == 0
    own = np.diag(whole(index, h, keep, prior))
    np.testing.assert_allclose(bend, own)
    np.testing.assert_allclose(spread, 1.0 / own)
    np.testing.assert_allclose(step, slope / own)
    assert determinant == pytest.approx(np.sum(np.log(own)))


def test_sums_by_offset_are_over_the_events_that_count() -> None:
    index, _, h, keep, _ = crossed(2)
    expected = [
        sum(h[i] for i in np.flatnonzero(keep) for a in range(2) if index[a, i] == k)
        for k in range(8)
    ]
    np.testing.assert_allclose(summed(index, keep, h, 8), expected)
