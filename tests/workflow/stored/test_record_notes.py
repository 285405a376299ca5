"""Notes on the records of a model: paths that miss their terrain, contradictions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.inference.model.observations import build_observations
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from avahazard.report.language import language_of
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.models import show_model
from avahazard.workflow.requests import CalibrateRequest
from avahazard.workflow.stored.record_notes import record_notes
from tests.workflow.worlds import bowl, height, known_stops


def events() -> tuple[Event, ...]:
    return known_stops(volume_m3=3e4)


def notes(records: Records) -> tuple[str, ...]:
    return record_notes(records, build_observations(records).sites)


def cliff(depth_m: float) -> Records:
    """The bowl with a step of that depth on 20 m, and points that are said to be exact."""
    x = np.linspace(0.0, 1900.0, 96)
    y = height(x) + depth_m * (x < 500.0)
    profile = Profile("B", x, y, elevation_sigma_m=np.full(len(x), 0.5))
    return Records((Path("B"),), (profile,), events())


def test_right_records_need_no_note() -> None:
    assert notes(bowl(events=events())) == ()


def test_a_path_that_misses_its_terrain_is_told_with_the_place() -> None:
    (note,) = notes(cliff(120.0))
    assert note.startswith("the path B that the block runs on misses the points of its profile by ")
    place = float(note.split("at x = ")[1].split(" m")[0])
    assert 400.0 < place < 600.0


def test_an_error_of_the_points_is_no_misfit() -> None:
    rough = cliff(0.0)
    noise = np.random.default_rng(1).normal(0.0, 5.0, 96)
    (profile,) = rough.profiles
    told = replace(profile, y_m=profile.y_m + noise, elevation_sigma_m=np.full(len(noise), 5.0))
    assert notes(replace(rough, profiles=(told,))) == ()


def test_values_that_cannot_all_be_true_are_told(database: str) -> None:
    wrong = Event(
        "wrong",
        "B",
        runout_x_m=900.0,
        volume_m3=1e6,
        volume_rel_sigma=0.1,
        deposit_length_m=10.0,
        deposit_width_m=10.0,
        deposit_thickness_m=2.0,
    )
    before = Event("before", "B", runout_x_m=900.0, left_profile=True, volume_m3=1e4)
    records = bowl(events=(*events(), wrong, before))
    note, of_place = notes(records)
    assert "event wrong contradicts itself: volume_m3 is 1e+06; accepted would be about 100" in note
    assert "event before contradicts itself: runout_x_m is 900" in of_place
    for code in ("de", "fr", "it"):
        told = language_of(code).told(note)
        assert "accepted" not in told
        assert "half of length" not in told
        assert "left_profile 0, or" not in language_of(code).told(of_place)
        assert "wrong" in told
    five = tuple(replace(wrong, event_id=f"w{k}", date=f"195{k}") for k in range(5))
    many = notes(replace(records, events=five))
    assert len(many) == 4
    assert many[-1] == "2 more records contradict themselves."
    # It is stored with the model, and everything that shows the model says it.
    with writing(database) as session:
        save_records(session, records)
    assert note in calibrate(database, "m", CalibrateRequest(chains=2, draws=50)).notes
    assert show_model(database, "m").notes.count(note) == 1


def test_stops_over_the_limit_of_sight_are_told_but_not_those_across_the_valley() -> None:
    x = np.linspace(0.0, 2000.0, 101)
    valley = Profile("V", x, 500.0 + np.abs(x - 1400.0) * np.where(x < 1400.0, 0.5, 0.3))
    (path,) = (Path("V", observed_below_m=600.0),)

    def told(*events: Event) -> tuple[str, ...]:
        return record_notes(Records((path,), (valley,), events), ())

    seen = Event("seen", "V", runout_x_m=1300.0, runout_sigma_m=10.0, volume_m3=1e4)
    across = Event("across", "V", runout_x_m=1900.0, runout_sigma_m=10.0, volume_m3=1e4)
    barely = Event("barely", "V", runout_x_m=1180.0, runout_sigma_m=10.0, volume_m3=1e4)
    high = Event("high", "V", runout_x_m=900.0, runout_sigma_m=10.0, volume_m3=1e4)
    assert told(seen, across, barely) == ()
    (note,) = told(seen, high, across)
    assert note.startswith("a record of path V stops over its observed_below_m (600 m)")
    assert "event high at 735 m" in note
    for code in ("de", "fr", "it"):
        assert language_of(code).told(note) != note


def test_an_avalanche_that_is_there_twice_is_told() -> None:
    first, *others = events()
    again = replace(first, event_id="again")
    (note,) = notes(bowl(events=(first, *others, again)))
    assert note.startswith(f"events {first.event_id} = again are alike in path, day and stop")
    for code in ("de", "fr", "it"):
        told = language_of(code).told(note)
        assert "again" in told
        assert "alike" not in told
