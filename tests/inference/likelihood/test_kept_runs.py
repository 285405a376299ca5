"""Runs of the block and what is kept of them."""

from __future__ import annotations

import numpy as np

from avahazard.inference.likelihood.kept_runs import KEPT_ASKED, KEPT_RUNS, KeptRuns
from tests.inference.studies import observations, posterior


def test_no_more_is_kept_than_there_is_room_for() -> None:
    model = posterior(observations(36, 6, False), "turbulent-drag", "epoch-bias")
    runs = KeptRuns(model.observations, model.effects, 1.0, in_sight=True)
    for k in range(KEPT_RUNS + 10):
        drag = np.array([1e-5 * k])
        runs.records({"turbulent-drag": drag, "epoch-bias": np.array([0.0, 1950.0])})
    for k in range(KEPT_ASKED + 10):
        raised = np.array([float(k), 1950.0])
        runs.near_records({"turbulent-drag": drag, "epoch-bias": raised})
    assert len(runs._runs) <= KEPT_RUNS
    assert len(runs._asked) <= KEPT_ASKED
    assert not runs.emptied()._runs


def test_runs_are_kept_by_what_moves_the_block() -> None:
    model = posterior(observations(36, 6, False), "turbulent-drag", "epoch-bias")
    runs = KeptRuns(model.observations, model.effects, 1.0, in_sight=True)
    for drag, raised in ((1e-3, 0.0), (1e-3, 20.0), (2e-3, 20.0)):
        told = {"turbulent-drag": np.array([drag]), "epoch-bias": np.array([raised, 1950.0])}
        np.testing.assert_array_equal(runs.records(told).record, runs.fresh_records(told).record)
    assert len(runs._runs) == 2
