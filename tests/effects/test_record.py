"""Effects on the record: epoch bias, leading edge, observation limit, stated errors."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.effects.columns import build_columns
from avahazard.effects.effect import (
    Effect,
    FrontEffect,
    LimitEffect,
    RecordErrorEffect,
    ShiftEffect,
    VolumeErrorEffect,
)
from avahazard.effects.record import (
    EPOCH_BIAS,
    LEADING_EDGE,
    MIN_SPREAD,
    MOST,
    OBSERVATION_LIMIT,
    RECORD_ERROR,
    VOLUME_ERROR,
    largest_factor,
)
from avahazard.records.collection import Event, Path
from tests.effects.examples import N_PATHS, columns, events, sites

PATHS = {name: Path(name) for name in "AB"}


def test_old_records_are_shifted() -> None:
    entry = EPOCH_BIAS
    effect = entry.build(entry.facts(columns(), sites()))
    assert isinstance(effect, ShiftEffect)
    by_year = {1920: 50.0, 1948: 50.0, 1949: 37.5, 1950: 25.0, 1951: 12.5, 1952: 0.0, 2000: 0.0}
    dated = (*(Event(str(y), "P0", date=str(y)) for y in by_year), Event("undated", "P0"))
    shift = effect.shift(columns(dated), np.array([50.0, 1950.0]))
    assert shift == pytest.approx(np.array([*by_year.values(), 0.0]))


def test_the_year_is_sought_among_the_dates_of_the_records() -> None:
    entry = EPOCH_BIAS
    year = entry.build(entry.facts(columns(), sites())).parameters[1]
    assert 1900 <= year.low < year.neutral < year.high <= 1980


def test_the_front_is_ahead_by_a_share_of_the_deposit() -> None:
    effect = LEADING_EDGE.build({})
    assert isinstance(effect, FrontEffect)
    known = (Event("a", "P0", deposit_length_m=80.0), Event("b", "P0"))
    assert effect.advance(columns(known), np.array([0.5])).tolist() == [40.0, 0.0]


def _limit() -> Effect:
    entry = OBSERVATION_LIMIT
    return entry.build(entry.facts(columns(), sites()))


def test_a_declared_limit_holds_and_others_lie_above_the_highest_stop() -> None:
    effect, table = _limit(), columns()
    assert isinstance(effect, LimitEffect)
    limit = effect.limit(table, np.array([20.0]))
    for k in range(N_PATHS):
        selected = table.path_index == k
        highest = 250.0 + 4.0 * (k + 30)
        assert limit[selected] == pytest.approx(400.0 if k == 0 else highest + 20.0)


def test_an_estimated_limit_lies_above_stops_that_are_recorded_by_x() -> None:
    entry, smooth = OBSERVATION_LIMIT, sites()[1].smooth
    x = 0.5 * (smooth.x_min + smooth.x_max)
    by_x = tuple(
        replace(e, runout_elevation_m=None, runout_x_m=x) if k == 1 else e
        for k, e in enumerate(events())
    )
    table = columns(by_x)
    effect = entry.build(entry.facts(table, sites()))
    assert isinstance(effect, LimitEffect)
    limit = effect.limit(table, np.array([20.0]))
    assert table.path_index[1] == 1
    assert limit[1] == pytest.approx(float(smooth.height(x)) + 20.0)


def test_far_above_every_stop_there_is_no_limit() -> None:
    effect, table = _limit(), columns()
    assert isinstance(effect, LimitEffect)
    limit = effect.limit(table, effect.neutral)
    assert np.all(np.isnan(limit[table.path_index > 0]))
    assert np.all(limit[table.path_index == 0] == 400.0)


def test_a_path_without_a_known_stop_has_no_limit() -> None:
    entry = OBSERVATION_LIMIT
    unknown = tuple(
        replace(e, runout_elevation_m=None, left_profile=True) if e.path_id == "P2" else e
        for e in events()
    )
    effect = entry.build(entry.facts(columns(unknown), sites()))
    assert isinstance(effect, LimitEffect)
    table = columns(unknown)
    assert np.all(np.isnan(effect.limit(table, np.array([20.0]))[table.path_index == 2]))


@pytest.mark.parametrize(
    ("n_stops", "declared", "enough"), [(4, None, False), (5, None, True), (1, 900.0, True)]
)
def test_a_limit_of_sight_takes_some_stops_of_a_path_or_is_declared(
    n_stops: int, declared: float | None, enough: bool
) -> None:
    stops = np.full(11, np.nan)
    stops[:n_stops] = 500.0
    stops[-4:] = 600.0
    path = np.repeat([0, 1], [7, 4])
    table = replace(
        build_columns([Event(str(i), "AB"[k]) for i, k in enumerate(path)], PATHS, np.zeros(11)),
        stop_elevation=stops,
    )
    sites: Any = [
        SimpleNamespace(path=Path("A", observed_below_m=declared)),
        SimpleNamespace(path=Path("B")),
    ]
    lack = definition("observation-limit").lacking(table, sites)
    assert (lack is None) == enough
    assert lack is None or "5 stops" in lack


def test_the_factor_is_one_at_neutral_and_of_either_side_alike() -> None:
    for entry in (RECORD_ERROR, VOLUME_ERROR):
        effect = entry.build(entry.facts(columns(), ()))
        assert isinstance(effect, RecordErrorEffect | VolumeErrorEffect)
        (log_factor,) = effect.parameters
        assert (log_factor.neutral, log_factor.low) == (0.0, -MOST)


def _volumes(path_means: list[float], deviations: list[float], error: float) -> float:
    chosen = tuple(
        replace(e, path_id=f"P{k}", volume_m3=float(np.exp(mean + d)), volume_rel_sigma=error)
        for k, mean in enumerate(path_means)
        for e, d in zip(events(), deviations, strict=False)
    )
    return largest_factor(columns(chosen))


def test_errors_of_volumes_go_up_to_the_scatter_within_paths() -> None:
    # Two paths with deviations ±1: 8 events, 2 means, so a variance of 8/6.
    deviations = [1.0, -1.0, 1.0, -1.0]
    by_hand = np.sqrt(8.0 / 6.0 - MIN_SPREAD**2) / 0.4
    assert _volumes([9.0, 12.0], deviations, 0.4) == pytest.approx(by_hand)
    # What paths differ by is no error.
    assert _volumes([9.0, 9.0], deviations, 0.4) == pytest.approx(by_hand)
    assert _volumes([9.0], deviations, 0.0) == np.inf


def test_volumes_more_alike_than_their_errors_let_these_be_smaller_only() -> None:
    alike = tuple(replace(e, volume_m3=1e4 + i) for i, e in enumerate(events()))
    entry = VOLUME_ERROR
    (parameter,) = entry.build(entry.facts(columns(alike), ())).parameters
    assert (parameter.low, parameter.high) == (-MOST, 0.0)


def test_what_they_need() -> None:
    exact = tuple(replace(e, volume_rel_sigma=0.0) for e in events())
    assert VOLUME_ERROR.lacking(columns(exact), ()) is not None
    assert VOLUME_ERROR.lacking(columns(events()[:19]), ()) is not None
    assert VOLUME_ERROR.lacking(columns(), ()) is None
    assert RECORD_ERROR.lacking(columns(events()[:19]), ()) is not None
    assert RECORD_ERROR.lacking(columns(), ()) is None
