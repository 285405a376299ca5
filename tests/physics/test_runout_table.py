from __future__ import annotations

import numpy as np

from avahazard.physics.block import run
from avahazard.physics.runout_table import MU, MU_STEP, runout_table
from tests.physics.paths import bowl, cells_of, terrain_of


def test_the_grid_is_uniform_and_covers_avalanches() -> None:
    np.testing.assert_allclose(np.diff(MU), MU_STEP)
    assert MU[0] <= 0.05
    assert MU[-1] >= 1.2


def test_the_table_is_the_runs() -> None:
    cells = cells_of(terrain_of(bowl()))
    starts = np.array([0, 9, 4])
    table, stops = runout_table(cells, starts), run(cells, starts, MU)
    np.testing.assert_array_equal(table.x, stops.x)
    np.testing.assert_array_equal(table.y, stops.y)
    assert table.x.shape == (3, len(MU))
    np.testing.assert_array_equal(table.left, np.isnan(table.x))
    held = table.x == cells.x[starts][:, None]
    np.testing.assert_array_equal(table.not_released, held)
    assert table.left.any()
    assert held.any()
