"""Effects on the stated errors of records and volumes, and how far they may go."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.effects.effect import RecordErrorEffect, VolumeErrorEffect
from avahazard.effects.stated_errors import (
    MIN_SPREAD,
    MOST,
    RECORD_ERROR,
    VOLUME_ERROR,
    largest_factor,
)
from tests.effects.examples import columns, events


def test_the_factor_is_one_at_neutral_and_of_either_side_alike() -> None:
    for entry in (RECORD_ERROR, VOLUME_ERROR):
        effect = entry.build(entry.facts(columns(), ()))
        assert isinstance(effect, RecordErrorEffect | VolumeErrorEffect)
        assert effect.scale(effect.neutral) == 1.0
        assert effect.scale(np.array([np.log(2.5)])) == pytest.approx(2.5)
        assert effect.scale(np.array([-np.log(2.5)])) == pytest.approx(0.4)


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
