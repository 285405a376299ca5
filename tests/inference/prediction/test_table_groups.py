"""Groups of posterior draws that share tables."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from avahazard.inference.prediction.table_groups import table_groups


def test_every_draw_is_in_one_group() -> None:
    parameters = np.random.default_rng(1).standard_normal((1000, 2))
    groups = table_groups(parameters, 32)
    assert len(groups) == 32
    assert sorted(np.concatenate(groups).tolist()) == list(range(1000))


def test_groups_of_one_parameter_are_slices_of_its_order() -> None:
    parameters = np.random.default_rng(2).lognormal(size=(640, 1))
    groups = table_groups(parameters, 16)
    lows = [parameters[g].min() for g in groups]
    highs = [parameters[g].max() for g in groups]
    order = np.argsort(lows)
    assert all(highs[i] <= lows[j] for i, j in pairwise(order))


@pytest.mark.parametrize("n_parameters", [1, 2])
def test_what_goes_along_with_the_tables_is_kept(n_parameters: int) -> None:
    parameters = np.random.default_rng(3).standard_normal((4000, n_parameters))
    groups = table_groups(parameters, 32)
    within = np.mean([parameters[g].var(axis=0) for g in groups])
    assert within < 0.02 * n_parameters**4


def test_nothing_to_split() -> None:
    assert len(table_groups(np.empty((50, 0)), 32)) == 1
    assert len(table_groups(np.full((50, 2), 0.3), 32)) == 1
    assert len(table_groups(np.repeat([[0.0], [1.0]], 5, axis=0), 32)) == 2
