"""Apparent friction of records whose friction is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import build_observations
from avahazard.inference.paper.apparent import STATUSES
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.friction import N_REPLICATES, back_calculate, show_frictions
from tests.workflow.worlds import bowl, smooth_bowl, stop_x

FRICTIONS = (0.42, 0.48, 0.55, 0.62, 0.7)


def _events(**given: float) -> tuple[Event, ...]:
    stops = {mu: stop_x(mu) for mu in FRICTIONS}
    by_x = [Event(f"x{mu}", "B", runout_x_m=x, **given) for mu, x in stops.items()]
    by_y = [
        Event(f"y{mu}", "B", runout_elevation_m=float(smooth_bowl().height(x)), **given)
        for mu, x in stops.items()
    ]
    return (*by_x, *by_y)


def _found(records: Records):
    observations = build_observations(records)
    return back_calculate(observations, predict_records(observations, (), {}))


def test_the_friction_of_known_runs_is_given_back() -> None:
    found = _found(bowl(1900.0, _events()))
    assert [STATUSES[code] for code in found.status] == ["unique"] * 10
    assert found.mu == pytest.approx([*FRICTIONS, *FRICTIONS], abs=2e-3)


def test_its_spread_is_the_error_of_the_record_over_the_slope_of_f() -> None:
    found = _found(bowl(1900.0, _events(runout_sigma_m=5.0)))
    for i, mu in enumerate(FRICTIONS):
        slope = (stop_x(mu + 0.01) - stop_x(mu - 0.01)) / 0.02
        assert found.perturbation.mu_sd[i] == pytest.approx(5.0 / abs(slope), rel=0.15)


def test_without_a_profile_it_is_h_over_l() -> None:
    straight = Event("s", fall_height_m=500.0, runout_length_m=1400.0, runout_sigma_m=14.0)
    found = _found(bowl(1900.0, (*_events()[:2], straight)))
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


def _stored(database: str, records: Records) -> None:
    with writing(database) as session:
        save_records(session, records)


def test_document(database: str) -> None:
    events = tuple(
        replace(event, volume_m3=1e4 * (i + 1)) for i, event in enumerate(_events(runout_sigma_m=5))
    )
    _stored(database, bowl(1900.0, events))
    document = show_frictions(database, "B", 8.0)
    assert [event["path_id"] for event in document["events"]] == ["B"] * 10
    assert document["jumps"] == []
    whole, one = document["density"]
    assert (whole["path_id"], one["path_id"], one["kappa"], one["n"]) == ("all", "B", 8.0, 10)
    assert np.array_equal(whole["pdf"], one["pdf"])
    inside = ~np.asarray(one["extrapolated"])
    assert one["mu"][inside].min() >= 0.418
    assert one["mu"][inside].max() <= 0.702
    check = document["perturbation"]
    assert (check["n_replicates"], check["n_events"], check["law"]) == (
        N_REPLICATES,
        10,
        "exponential",
    )
    a = check["parameters"]["a"]
    assert a["mean"] == pytest.approx(a["value"], abs=3.0 * a["sd"])
    assert 0.0 < a["sd"] < a["se"]


def test_without_volumes_there_is_no_law(database: str) -> None:
    _stored(database, bowl(1900.0, _events()))
    check = show_frictions(database)["perturbation"]
    assert (check["law"], check["parameters"]) == (None, {})
    assert check["mu_sd_median"] > 0.0


def test_a_terrace_makes_f_jump(database: str) -> None:
    # The block stops on the terrace or passes its edge and runs far down.
    x = np.linspace(0.0, 1600.0, 161)
    slope = np.select([x < 500.0, x < 650.0, x < 1000.0], [0.7, 0.0, 0.7], 0.1)
    y = 1200.0 - np.concatenate([[0.0], np.cumsum(slope[:-1] * np.diff(x))])
    edge = Event("edge", "T", runout_x_m=800.0)
    _stored(database, Records((Path("T"),), (Profile("T", x, y),), (edge,)))
    document = show_frictions(database)
    (event,) = document["events"]
    assert event["status"] == "jump"
    assert event["mu_low"] < event["mu"] < event["mu_high"]
    (jump,) = document["jumps"]
    assert jump["path_id"] == "T"
    assert jump["jump_m"] > 100.0
    assert event["mu_low"] - 0.003 < jump["mu"] < event["mu_high"]


def test_a_path_without_events(database: str) -> None:
    _stored(database, bowl())
    with pytest.raises(AvahazardError, match="Path B has no events"):
        show_frictions(database, "B")
