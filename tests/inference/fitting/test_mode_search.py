"""The highest of several modes, from wherever the search begins."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.fitting.mode_search import search_mode, thinned
from tests.inference.studies import observations, posterior


def test_without_tables_it_is_the_plain_climb() -> None:
    model = posterior(observations())
    np.testing.assert_array_equal(search_mode(model)[1].u, find_mode(model).u)


def test_it_gets_over_the_valley_where_a_climb_stays() -> None:
    model = posterior(observations(), "turbulent-drag")
    (drag,) = model.layout.tables
    climb = find_mode(model)
    _, found = search_mode(model)
    assert found.log_density > climb.log_density + 2.0
    # From the other end of the grid it comes to the same.
    far = climb.u.copy()
    far[drag] = model.layout.slots[drag].grid[-1]
    _, again = search_mode(model, far)
    assert again.log_density == pytest.approx(found.log_density, abs=0.05)
    assert again.u[drag] == pytest.approx(found.u[drag], abs=0.05)


def test_thinned_keeps_the_ends() -> None:
    grid = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert thinned(grid, 3) == [0.0, 3.0, 6.0]
    assert thinned(grid, 99) == grid
