from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from avahazard.inference.likelihood import kept_runs
from avahazard.inference.likelihood.block_runs import BlockRuns, run_blocks
from avahazard.inference.likelihood.interpolation import packed, unpacked
from avahazard.inference.likelihood.keeping import LEAST_KEPT, MOST_BYTES, within
from avahazard.inference.likelihood.nodes import build_nodes
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.layout import regridded
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.physics.runout_curve import MU
from avahazard.synth.making import make_world
from avahazard.synth.settings import Settings
from tests.inference.studies import near, observations, posterior


def test_large_tables_are_kept_in_smaller_number() -> None:
    assert within(16, 1000) == 16
    assert within(16, MOST_BYTES // 5) == 5
    assert within(16, 10 * MOST_BYTES) == LEAST_KEPT


def test_blocks_that_no_parameter_moves_are_run_once(monkeypatch: pytest.MonkeyPatch) -> None:
    model = posterior(observations(speeds=False))
    model.nodes.point(())
    with monkeypatch.context() as patch:
        patch.setattr(kept_runs, "run_blocks", None)
        found = model.nodes.predicted_at(near(model))
    fresh = predict_records(model.observations, (), {})
    np.testing.assert_array_equal(found.record, fresh.record)


def test_blocks_that_parameters_move_are_run_for_each() -> None:
    model = posterior(observations(speeds=False), "turbulent-drag")
    weak, strong = (
        model.nodes.predicted_at(near(model, **{"turbulent-drag.drag": drag})).record
        for drag in (0.1, 2.0)
    )
    assert not np.array_equal(weak, strong, equal_nan=True)


@cache
def in_sight() -> Observations:
    """Events of which sight is not limited, some with speeds and one that left."""
    records = make_world(5, 24, 2, {}, Settings(speeds=0.4))[0]
    gone = replace(records.events[3], left_profile=True, runout_elevation_m=None, runout_x_m=None)
    events = tuple(gone if e.event_id == gone.event_id else e for e in records.events)
    return build_observations(replace(records, events=events))


@pytest.mark.parametrize(
    "effects", [("turbulent-drag",), ("cohesion", "leading-edge"), ("speed-weakening",)]
)
def test_nodes_near_the_records_are_those_of_whole_tables(effects: tuple[str, ...]) -> None:
    grid = posterior(in_sight(), *effects).nodes
    for share in (0.3, 0.9):
        slots = [grid.layout.slots[axis] for axis in (*grid.layout.tables, -1)]
        index = tuple(int(share * (len(slot.grid) - 1)) for slot in slots)
        found = grid._of_point(index)
        scatter = float(np.exp(slots[-1].grid[index[-1]]))
        whole = build_nodes(
            grid.observations, grid.predicted(index), scatter, None, True, grid.panels()
        )
        # Weights alone tell which places count.
        found, whole = unpacked(found), unpacked(packed(whole, in_sight=True))
        for name in ("weight", "tail", "log_scale", "floor"):
            np.testing.assert_allclose(
                getattr(found, name), getattr(whole, name), rtol=1e-9, atol=1e-12, err_msg=name
            )
        counts = whole.weight > 0.0
        np.testing.assert_allclose(found.place[counts], whole.place[counts], rtol=1e-9)


def test_few_frictions_are_run_near_the_records(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = posterior(in_sight(), "turbulent-drag").nodes
    runs: list[BlockRuns] = []

    def kept(*args: Any) -> BlockRuns:
        runs.append(run_blocks(*args))
        return runs[-1]

    monkeypatch.setattr(kept_runs, "run_blocks", kept)
    grid.panels()
    grid._of_point((3, 4))
    whole, near = runs
    frictions = [np.count_nonzero(s.any(axis=1)) for s in near.speeds]
    assert np.mean(frictions) < 0.3 * np.mean(
        [np.count_nonzero(s.any(axis=1)) for s in whole.speeds]
    )
    distinct = [len(np.unique(row)) for table in near.tables for row in table.x]
    assert np.mean(distinct) < 0.3 * len(MU)


def test_a_scatter_along_tracks_asks_for_no_new_run(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = posterior(in_sight(), "turbulent-drag").nodes
    grid._of_point((3, 4))
    monkeypatch.setattr(kept_runs, "run_blocks", None)
    one, other = grid._of_point((3, 4)), grid._of_point((3, 7))
    assert not np.array_equal(one.log_scale, other.log_scale)
    # Nor do the same places of another grid.
    slot = grid.layout.slots[grid.layout.tables[0]]
    finer = tuple(np.union1d(slot.grid, [0.5 * (slot.grid[3] + slot.grid[4])]).tolist())
    again = grid.regridded(regridded(grid.layout, {slot.name: finer}))
    assert again._of_point((3, 7)) is other
