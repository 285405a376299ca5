"""The highest of several modes, from wherever the search begins."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.fitting.mode_search import held_climb, search_mode
from avahazard.inference.fitting.star import gauss_newton
from tests.inference.studies import near, observations, posterior


def test_without_tables_it_is_the_plain_climb() -> None:
    model = posterior(observations(speeds=False))
    np.testing.assert_array_equal(search_mode(model)[1].u, find_mode(model).u)


def test_it_gets_over_the_valley_where_a_climb_stays() -> None:
    model = posterior(observations(), "turbulent-drag")
    (drag,) = model.layout.tables
    near_none = gauss_newton(model, near(model))
    _, found = search_mode(model)
    assert found.log_density > near_none.log_density + 2.0
    # From the other end of the range it comes to the same.
    far = near_none.u.copy()
    far[drag] = model.layout.slots[drag].high
    _, again = search_mode(model, far)
    assert again.log_density == pytest.approx(found.log_density, abs=0.05)
    assert again.u[drag] == pytest.approx(found.u[drag], abs=0.05)


def test_a_held_climb_moves_nothing_that_shapes_the_tables() -> None:
    model = posterior(observations(), "turbulent-drag")
    (drag,) = model.layout.tables
    start = near(model)
    value, u = held_climb(model, start, [drag], [0.7])
    assert u[drag] == 0.7
    assert u[-1] == start[-1]
    assert value > model.pinned(u).log_density(np.where(np.arange(len(u)) == drag, 0.7, start))
