"""Records in and out of every kind of database."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import delete, update

from avahazard.records.collection import (
    Event,
    Fingerprint,
    Path,
    Profile,
    Records,
    Speed,
    TerrainCrop,
    data_fingerprint,
)
from avahazard.records.errors import AvahazardError
from avahazard.records.intake import profile_difference
from avahazard.store import records as store_records
from avahazard.store.records import (
    load_by_pieces,
    load_events,
    load_records,
    load_terrain,
    path_summaries,
    save_records,
    save_terrain,
)
from avahazard.store.session import reading, writing
from avahazard.store.tables import Base, TerrainTable
from avahazard.synth.making import make_dataset

numbers = st.floats(allow_nan=False, allow_infinity=False, width=64)
words = st.text(
    st.characters(exclude_categories=("Cs",), exclude_characters="\0"), min_size=1, max_size=20
)
covariates = st.dictionaries(words, numbers | words, max_size=3)


def maybe(values: st.SearchStrategy[object]) -> st.SearchStrategy[object]:
    """Give a value or None."""
    return st.none() | values


@st.composite
def some_records(draw: st.DrawFn) -> Records:
    """Give records that refer to each other."""
    path_ids = draw(st.lists(words, min_size=1, max_size=3, unique=True))
    event_ids = draw(st.lists(words, max_size=4, unique=True))
    paths = [
        Path(
            path_id,
            name=draw(maybe(words)),
            section=draw(maybe(st.sampled_from(["open", "channelled"]))),
            catchment_ha=draw(maybe(numbers)),
            observed_from=draw(maybe(st.integers(1, 9999))),
            covariates=draw(covariates),
        )
        for path_id in path_ids
    ]
    profiles = [draw(some_profile(path_id)) for path_id in path_ids[:2]]
    events = [
        Event(
            event_id,
            path_id=draw(maybe(st.sampled_from(path_ids))),
            date=draw(maybe(st.just("1950-02-13"))),
            runout_x_m=draw(maybe(numbers)),
            runout_sigma_m=draw(numbers),
            left_profile=draw(st.booleans()),
            volume_m3=draw(maybe(numbers)),
            covariates=draw(covariates),
        )
        for event_id in event_ids
    ]
    speeds = [
        Speed(event_id, draw(numbers), draw(numbers), x_m=x)
        for event_id in event_ids
        for x in draw(st.lists(numbers, max_size=3, unique=True))
    ]
    return Records(tuple(paths), tuple(profiles), tuple(events), tuple(speeds))


@st.composite
def some_profile(draw: st.DrawFn, path_id: str) -> Profile:
    """Give a profile; the order of its points is all that the store has to keep."""
    n = draw(st.integers(5, 8))
    column = st.lists(numbers, min_size=n, max_size=n).map(np.array)
    return Profile(
        path_id,
        x_m=draw(column),
        y_m=draw(column),
        land_cover=draw(maybe(st.lists(words, min_size=n, max_size=n).map(tuple))),
        easting_m=draw(maybe(column)),
        crs=draw(maybe(words)),
        elevation_sigma_m=draw(maybe(column)),
    )


def assert_same(found: Records, expected: Records) -> None:
    """Hold two collections against each other, bit by bit and in order."""
    assert found.paths == expected.paths
    assert found.events == expected.events
    assert found.speeds == expected.speeds
    assert len(found.profiles) == len(expected.profiles)
    for one, other in zip(found.profiles, expected.profiles, strict=True):
        assert one.path_id == other.path_id
        assert profile_difference(one, other) is None
    assert data_fingerprint(found) == data_fingerprint(expected)


@settings(
    max_examples=40,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(records=some_records())
def test_records_come_back_as_they_were(any_database: str, records: Records) -> None:
    with writing(any_database) as session:
        for table in reversed(Base.metadata.sorted_tables):
            session.execute(delete(table))
        save_records(session, records)
    with reading(any_database) as session:
        assert_same(load_records(session), records)


FIRST = Records(
    (Path("P", covariates={"z": 1.0, "a": "x"}), Path("Q")),
    (Profile("P", np.arange(6.0), -np.arange(6.0), land_cover=("open",) * 6),),
    (Event("e", "P", runout_x_m=3.0, covariates={"k": 1.0}), Event("f", "Q", runout_x_m=4.0)),
    (Speed("e", 9.0, 1.0, x_m=1.0), Speed("e", 8.0, 1.0, elevation_m=2.0)),
)
CHANGE = Records(
    (Path("P", name="new", covariates={"b": "y"}),),
    (Profile("P", np.arange(5.0), -2 * np.arange(5.0)),),
    (Event("e", "Q", runout_x_m=5.0), Event("g", None, fall_height_m=1.0, runout_length_m=2.0)),
    (Speed("e", 7.0, 2.0, x_m=1.0),),
)


def test_saving_again_replaces_whole_records_in_their_place(any_database: str) -> None:
    with writing(any_database) as session:
        save_records(session, FIRST)
    with writing(any_database) as session:
        save_records(session, CHANGE)
    expected = Records(
        (CHANGE.paths[0], FIRST.paths[1]),
        CHANGE.profiles,
        (CHANGE.events[0], FIRST.events[1], CHANGE.events[1]),
        (CHANGE.speeds[0], FIRST.speeds[1]),
    )
    with reading(any_database) as session:
        assert_same(load_records(session), expected)


def test_nothing_is_stored_after_an_error(any_database: str) -> None:
    def fail() -> None:
        with writing(any_database) as session:
            save_records(session, FIRST)
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    with reading(any_database) as session:
        assert load_records(session) == Records()


def test_tables_have_every_field_of_the_records() -> None:
    tables = Base.metadata.tables
    for kind, table in ((Path, "paths"), (Event, "events"), (Speed, "speeds")):
        names = {f.name for f in fields(kind)} - {"covariates"}
        assert names == set(tables[table].columns.keys()) - {"id"}
    points = {f.name for f in fields(Profile)}
    assert points == set(tables["profile_points"].columns.keys()) - {"point"}


def test_many_records_are_saved_in_pieces(any_database: str) -> None:
    events = tuple(Event(f"e{i}", None, runout_x_m=float(i)) for i in range(1201))
    with writing(any_database) as session:
        save_records(session, Records(events=events))
        save_records(session, Records(events=tuple(replace(e, date="1950") for e in events)))
    with reading(any_database) as session:
        found = load_records(session).events
    assert found == tuple(replace(e, date="1950") for e in events)


def test_pieces_are_all_records_each_once(
    any_database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    world, _ = make_dataset(1, 40, 7)
    straight = Event("line", fall_height_m=1.0, runout_length_m=2.0, covariates={"k": 1.0})
    world = replace(
        world,
        events=(straight, *world.events),
        speeds=(
            Speed("line", 3.0, 1.0, x_m=0.5),
            *(Speed(e.event_id, 9.0, 1.0, x_m=9.0) for e in world.events[::2]),
        ),
    )
    with writing(any_database) as session:
        save_records(session, world)
    monkeypatch.setattr(store_records, "PATHS_AT_ONCE", 3)
    with reading(any_database) as session:
        pieces = list(load_by_pieces(session))
        by_name = load_records(session, ["P05", "none", "P02"])
        events = tuple(load_events(session))
        some = load_records(session, ["P02", "P05"], profiles=False, speeds=False)
        whole = load_records(session, profiles=False, speeds=False)
    assert [len(piece.paths) for piece in pieces] == [3, 3, 1, 0]
    assert pieces[-1].events == (straight,)
    assert_same(of_paths(world, {"P02", "P05"}), by_name)
    assert_same(of_paths(world, {p.path_id for p in pieces[0].paths}), pieces[0])
    assert events == world.events
    assert some == Records(paths=by_name.paths, events=by_name.events)
    assert whole == Records(paths=world.paths, events=world.events)
    fingerprint = Fingerprint()
    for piece in pieces:
        fingerprint.add(piece)
    assert fingerprint.hexdigest() == data_fingerprint(world)


def of_paths(records: Records, names: set[str]) -> Records:
    """Those of some paths, looked for one by one."""
    events = tuple(e for e in records.events if e.path_id in names)
    theirs = {e.event_id for e in events}
    return Records(
        tuple(p for p in records.paths if p.path_id in names),
        tuple(p for p in records.profiles if p.path_id in names),
        events,
        tuple(s for s in records.speeds if s.event_id in theirs),
    )


def test_words_that_come_again_are_held_once(any_database: str) -> None:
    cover = ("open", "forest") * 3
    records = Records(
        tuple(Path(f"P{k}") for k in range(2)),
        tuple(Profile(f"P{k}", np.arange(6.0), -np.arange(6.0), cover) for k in range(2)),
    )
    with writing(any_database) as session:
        save_records(session, records)
    with reading(any_database) as session:
        found = load_records(session).profiles
    assert len({id(word) for p in found for word in p.land_cover or ()}) == 2


X = np.array([0.0, 100.0, 300.0, 600.0, 1000.0])
RECORDS = Records(
    (Path("steep", name="Steep", section="open"), Path("bare"), Path("quiet")),
    (
        Profile("steep", X, np.array([900.0, 700.0, 420.0, 300.5, 310.0])),
        Profile("quiet", X, 500.0 - 0.2 * X),
    ),
    (
        Event("a", path_id="steep", date="1950-02-13", runout_elevation_m=400.0, volume_m3=2e4),
        Event("b", path_id="steep", date="1911", runout_elevation_m=400.0),
        Event("c", path_id="steep", left_profile=True, volume_m3=5e3),
        Event("d", path_id="bare", runout_elevation_m=100.0),
        Event("e", fall_height_m=300.0, runout_length_m=700.0),
    ),
)


def test_each_path_is_summed_up(any_database: str) -> None:
    with writing(any_database) as session:
        save_records(session, RECORDS)
    with reading(any_database) as session:
        steep, bare, quiet = path_summaries(session)
    assert (steep.path_id, steep.name, steep.section) == ("steep", "Steep", "open")
    assert (steep.n_points, steep.top_m, steep.drop_m, steep.length_m) == (5, 900.0, 599.5, 1000.0)
    assert (steep.n_events, steep.n_left_profile) == (3, 1)
    assert (steep.first_year, steep.last_year) == (1911, 1950)
    assert (steep.volume_min_m3, steep.volume_max_m3) == (5e3, 2e4)
    nothing = replace(
        bare, n_points=0, top_m=None, drop_m=None, length_m=None, n_events=1, n_left_profile=0,
        first_year=None, last_year=None, volume_min_m3=None, volume_max_m3=None,
    )  # fmt: skip
    assert bare == nothing
    assert (quiet.n_events, quiet.n_points, quiet.volume_max_m3) == (0, 5, None)


def crop(path_id: str, start: float) -> TerrainCrop:
    """Give a small piece of ground with a hole in it."""
    elevation = np.arange(6, dtype=np.float32).reshape(2, 3) + np.float32(start)
    elevation[1, 1] = np.nan
    return TerrainCrop(path_id, "EPSG:31287", 255_000.5, 382_000.25, 12.5, elevation)


def test_terrain_comes_back_and_is_replaced(any_database: str) -> None:
    with writing(any_database) as session:
        save_records(session, Records(paths=(Path("P"), Path("Q"), Path("R"))))
        save_terrain(session, [crop("P", 0.0), crop("Q", 1.0)])
    with writing(any_database) as session:
        save_terrain(session, [crop("P", 7.0)], outdated=["Q", "R"])
    with reading(any_database) as session:
        found = load_terrain(session, "P")
        assert (load_terrain(session, "Q"), load_terrain(session, "R")) == (None, None)
    assert found is not None
    expected = crop("P", 7.0)
    assert found.elevation_m.dtype == np.float32
    np.testing.assert_array_equal(found.elevation_m, expected.elevation_m)
    place = (found.crs, found.west_m, found.north_m, found.cell_m)
    assert place == (expected.crs, expected.west_m, expected.north_m, expected.cell_m)


def test_damaged_terrain_is_told(database: str) -> None:
    with writing(database) as session:
        save_records(session, Records(paths=(Path("P"),)))
        save_terrain(session, [crop("P", 0.0)])
        session.execute(update(TerrainTable).values(data=b"123"))
    with reading(database) as session, pytest.raises(AvahazardError, match="damaged"):
        load_terrain(session, "P")
