"""Runs of the block: what is kept of them, and near which stops they are made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.inference.likelihood import predicted
from avahazard.inference.likelihood.kept_runs import (
    FAR,
    KEPT_ASKED,
    KEPT_RUNS,
    KeptRuns,
    _within,
    keep,
    stops_asked,
)
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import LEFT, LENGTH
from tests.inference.studies import observations, posterior


@pytest.mark.parametrize(
    ("size", "most"), [(0, 64), (1_000_000, 64), (2_000_000, 32), (40_000_000, 2), (10**12, 2)]
)
def test_fewer_are_kept_where_they_are_large(size: int, most: int) -> None:
    kept: dict[int, str] = {}
    for k in range(70):
        keep(kept, k, "", 64, size)
    assert list(kept) == list(range(70))[-most:]


VALUES = {"leading-edge": np.array([0.8]), "epoch-bias": np.array([15.0, 1950.0])}


@pytest.mark.parametrize("effects", [(), ("leading-edge",)])
def test_every_stop_within_reach_of_a_record_is_asked_for(effects: tuple[str, ...]) -> None:
    given = observations()
    model = posterior(given, *effects)
    values = {key: VALUES[key] for key in effects}
    table = predict_records(given, model.effects, values)
    # The block's own stops: what its front comes to is another thing.
    block = predict_records(given, (), {})
    asked = stops_asked(given, model.effects, values)
    tracks = {track.event for track in given.speeds}
    for i in np.flatnonzero(given.kind != LENGTH):
        one = asked[given.columns.path_index[i]]
        low, high = one.low[given.release[i]], one.high[given.release[i]]
        left = table.status[i] == 1
        if given.kind[i] == LEFT:
            assert low <= np.min(block.x[i][left]) <= high
            assert np.isinf(high) == (i in tracks)
            continue
        z = (table.record[i] - given.observed[i]) / table.sigma[i]
        near = ~left & (np.abs(z) < FAR)
        assert near.any()
        assert low <= np.min(block.x[i][near])
        assert high >= np.max(block.x[i][near])


def test_little_else_is_asked_for() -> None:
    given = observations()
    asked = stops_asked(given, (), {})
    length = given.sites[0].smooth.x_max - given.sites[0].smooth.x_min
    assert np.median(asked[0].high - asked[0].low) < 0.5 * length


def test_what_left_asks_for_the_end_of_its_path_alone() -> None:
    given = observations(36, 6, False)
    i = int(np.flatnonzero(given.kind == LEFT)[0])
    k, site = given.columns.path_index[i], given.sites[given.columns.path_index[i]]
    alone = replace(given, kind=np.where(given.columns.path_index == k, LEFT, given.kind))
    one = stops_asked(alone, (), {})[k]
    length = site.smooth.x_max - site.smooth.x_min
    assert one.low[given.release[i]] > site.smooth.x_max - 0.01 * length
    assert one.high[given.release[i]] == pytest.approx(site.smooth.x_max)


def test_places_between_which_a_record_lies_are_near_it_however_small_its_error() -> None:
    z = np.array(
        [
            [-100.0, -50.0, 40.0, 90.0],  # between two places
            [-100.0, -8.0, 40.0, 8.0],  # there and back
            [100.0, 60.0, 20.0, np.nan],  # near none: the nearest
        ]
    )
    first, last = _within(z)
    assert first.tolist() == [1, 0, 2]
    assert last.tolist() == [2, 3, 2]


def test_a_record_that_no_stop_is_near_asks_for_the_nearest() -> None:
    given = observations(12, 6, False)
    i = int(np.flatnonzero(given.kind == 0)[0])
    observed = given.observed.copy()
    observed[i] += 5000.0
    one = stops_asked(replace(given, observed=observed), (), {})[given.columns.path_index[i]]
    # Higher than all the path: its top.
    assert one.low[given.release[i]] <= given.sites[0].smooth.x_min + 20.0


@pytest.mark.parametrize("near", [False, True])
def test_sites_are_run_in_groups_as_if_all_at_once(
    monkeypatch: pytest.MonkeyPatch, near: bool
) -> None:
    given = observations()
    asked = stops_asked(given, (), {}) if near else None
    together = predicted.run_blocks(given, (), {}, 1.0, asked)
    monkeypatch.setattr(predicted, "SITES_AT_ONCE", 2)
    apart = predicted.run_blocks(given, (), {}, 1.0, asked)
    assert len(given.sites) > 2
    assert len(apart.tables) == len(together.tables) == len(given.sites)
    for one, other in zip(apart.tables, together.tables, strict=True):
        np.testing.assert_array_equal(one.x, other.x)


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
