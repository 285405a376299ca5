"""Records and draws as places along the path."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.criticism.scoring.expected import ExpectedRecords
from avahazard.criticism.scoring.in_x import in_x
from avahazard.inference.model.observations import build_observations
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile

X = np.arange(0.0, 2001.0, 20.0)
SLOPE = 0.5


def test_elevations_become_places_and_places_stay() -> None:
    events = (
        Event("z", path_id="p", runout_elevation_m=1500.0, volume_m3=1e4, runout_sigma_m=10.0),
        Event("x", path_id="p", runout_x_m=1300.0, volume_m3=1e4, runout_sigma_m=10.0),
        Event("left", path_id="p", left_profile=True, volume_m3=1e4),
        Event("bare", fall_height_m=500.0, runout_length_m=1000.0, volume_m3=1e4),
    )
    profile = Profile("p", X, 2000.0 - SLOPE * X)
    observations = build_observations(Records((Path("p"),), (profile,), events))
    draws = np.array([[1520.0, 1480.0], [1280.0, 1330.0], [1200.0, 1000.0], [900.0, 1100.0]])
    left = np.array([[False, False], [False, False], [False, True], [False, False]])
    expected = ExpectedRecords(
        observed=np.array([1500.0, 1300.0, 1000.0, 1000.0]),
        sigma=np.array([10.0, 10.0, 10.0, 10.0]),
        draws=draws,
        left=left,
        x=draws,
        sign=np.array([1.0, -1.0, 1.0, -1.0]),
    )
    found = in_x(expected, observations)
    assert found is not None
    assert found.observed == pytest.approx([1000.0, 1300.0, 2000.0], abs=0.5)
    assert found.draws == pytest.approx(
        np.array([[960.0, 1040.0], [1280.0, 1330.0], [1600.0, 2000.0]]), abs=0.5
    )
    # An error of elevation is twice as much along a slope of 1 in 2.
    assert found.sigma[:2] == pytest.approx([20.0, 10.0], abs=0.1)
    assert (found.sign == 1.0).all()
    assert found.error == pytest.approx([0.0, 5.0, -200.0], abs=0.5)


def test_nothing_without_a_profile() -> None:
    event = Event("bare", fall_height_m=500.0, runout_length_m=1000.0, volume_m3=1e4)
    observations = build_observations(Records((), (), (event,)))
    one = np.array([1000.0])
    assert in_x(ExpectedRecords(one, one, one[:, None], one[:, None] < 0, one[:, None], one),
                observations) is None  # fmt: skip
