"""Apparent friction of records whose friction is known."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import build_observations
from avahazard.inference.paper.apparent import STATUSES
from avahazard.inference.paper.back_calculation import back_calculate
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from tests.workflow.worlds import FRICTIONS, bowl, known_stops, smooth_bowl, stop_x


def _found(records: Records):
    observations = build_observations(records)
    return back_calculate(observations, predict_records(observations, (), {}))


def test_the_friction_of_known_runs_is_given_back() -> None:
    found = _found(bowl(1900.0, known_stops()))
    assert [STATUSES[code] for code in found.status] == ["unique"] * 10
    assert found.mu == pytest.approx([*FRICTIONS, *FRICTIONS], abs=2e-3)


def test_its_spread_is_the_error_of_the_record_over_the_slope_of_f() -> None:
    found = _found(bowl(1900.0, known_stops(runout_sigma_m=5.0)))
    for i, mu in enumerate(FRICTIONS):
        slope = (stop_x(mu + 0.01) - stop_x(mu - 0.01)) / 0.02
        assert found.perturbation.mu_sd[i] == pytest.approx(5.0 / abs(slope), rel=0.15)


def test_without_a_profile_it_is_h_over_l() -> None:
    straight = Event("s", fall_height_m=500.0, runout_length_m=1400.0, runout_sigma_m=14.0)
    found = _found(bowl(1900.0, (*known_stops()[:2], straight)))
    assert found.mu[2] == 500.0 / 1400.0
    assert found.mu_low[2] == found.mu_high[2] == found.mu[2]
    assert found.perturbation.mu_sd[2] == pytest.approx(0.01 * found.mu[2], rel=0.15)
    alone = _found(Records(events=(straight,)))
    assert alone.mu == found.mu[2]


def test_records_that_bound_friction_from_one_side() -> None:
    left = Event("left", "B", left_profile=True)
    short = Event("short", "B", runout_x_m=-5.0)
    found = _found(bowl(1000.0, (left, short)))
    assert [STATUSES[code] for code in found.status] == ["below", "above"]
    assert np.isnan(found.mu).all()
    assert np.isnan(found.perturbation.mu_sd).all()
    # The block of this friction just reaches x = 1000 m (of a bowl regularised a little otherwise).
    assert stop_x(found.mu_high[0]) == pytest.approx(1000.0, abs=30.0)
    # Nothing is released where the slope is less than μ.
    steepness = -float(smooth_bowl(1000.0).derivatives(np.zeros(1))[1][0])
    assert steepness <= found.mu_high[1] <= steepness + 0.0025


def test_where_no_friction_stops_the_block_the_one_that_held_it_bounds() -> None:
    # A plane: the block runs off it, or does not start.
    x = np.linspace(0.0, 500.0, 21)
    plane = Records(
        (Path("B"),), (Profile("B", x, 500.0 - 0.6 * x),), (Event("a", "B", runout_x_m=490.0),)
    )
    found = _found(plane)
    assert STATUSES[found.status[0]] == "below"
    assert found.mu_high[0] == pytest.approx(0.6, abs=0.01)
