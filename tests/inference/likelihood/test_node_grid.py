from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.likelihood import node_grid
from avahazard.inference.likelihood.node_grid import LEAST_KEPT, MOST_BYTES, within
from avahazard.inference.likelihood.predicted import predict_records
from tests.inference.studies import near, observations, posterior


def test_large_tables_are_kept_in_smaller_number() -> None:
    assert within(16, 1000) == 16
    assert within(16, MOST_BYTES // 5) == 5
    assert within(16, 10 * MOST_BYTES) == LEAST_KEPT


def test_blocks_that_no_parameter_moves_are_run_once(monkeypatch: pytest.MonkeyPatch) -> None:
    model = posterior(observations(speeds=False))
    model.nodes.point(())
    with monkeypatch.context() as patch:
        patch.setattr(node_grid, "run_blocks", None)
        found = model.nodes.predicted_at(near(model))
    fresh = predict_records(model.observations, (), {}, model.nodes.curvature)
    np.testing.assert_array_equal(found.record, fresh.record)


def test_blocks_that_parameters_move_are_run_for_each() -> None:
    model = posterior(observations(speeds=False), "turbulent-drag")
    weak, strong = (
        model.nodes.predicted_at(near(model, **{"turbulent-drag.drag": drag})).record
        for drag in (0.1, 2.0)
    )
    assert not np.array_equal(weak, strong, equal_nan=True)
