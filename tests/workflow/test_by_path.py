"""Work path by path: of the records of a region little is held, whatever the number of paths."""

from __future__ import annotations

import gc
import tracemalloc
from dataclasses import fields, replace
from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.engine import EngineName, set_engine
from avahazard.hazard.frequency import known_volumes
from avahazard.hazard.future_events import MAX_CLASSES
from avahazard.records.collection import (
    Event,
    Path,
    Profile,
    Records,
    Speed,
    data_fingerprint,
    only_paths,
)
from avahazard.records.errors import AvahazardError
from avahazard.results.base import silent
from avahazard.store import records as store_records
from avahazard.store.records import save_records
from avahazard.store.results import read_run
from avahazard.store.session import reading, writing
from avahazard.synth.making import make_dataset
from avahazard.workflow import by_path
from avahazard.workflow.by_path import PathTask, any_events, fingerprint_of, path_answer, survey
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import init_database
from avahazard.workflow.hazard import hazard_work
from avahazard.workflow.requests import CalibrateRequest, HazardRequest
from tests.workflow.worlds import height

N_POINTS = 400
PROFILE_BYTES = 2 * 8 * N_POINTS
FEW, MANY = 50, 100
"""Paths: of fewer the grid on which yearly maxima are fitted decides the peak."""
AT_ONCE = 10
ASKED = HazardRequest(return_periods=[30.0])


@pytest.fixture(autouse=True)
def few_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_records, "PATHS_AT_ONCE", AT_ONCE)


@pytest.fixture(scope="module")
def databases(tmp_path_factory: pytest.TempPathFactory) -> dict[int, str]:
    """Regions of few and of many bowls, with a model of two of them."""
    folder = tmp_path_factory.mktemp("regions")
    return {n: region(folder, n) for n in (FEW, MANY)}


def region(folder: FilePath, n: int) -> str:
    file = str(folder / f"{n}.db")
    init_database(file)
    rng = np.random.default_rng(n)
    x = np.linspace(0.0, 1900.0, N_POINTS)
    names = [f"B{k:03d}" for k in range(n)]
    records = Records(
        tuple(Path(name, observed_from=1900, observed_to=1999) for name in names),
        tuple(Profile(name, x, height(x), ("open",) * N_POINTS) for name in names),
        tuple(
            Event(
                f"{name}-{year}",
                name,
                date=str(year),
                runout_x_m=float(rng.uniform(900.0, 1700.0)),
                volume_m3=float(rng.lognormal(9.0, 1.0)),
            )
            for name in names
            for year in (1950, 1960, 1970)
        ),
    )
    with writing(file) as session:
        save_records(session, records)
    calibrate(file, "m", CalibrateRequest(method="gibbs", draws=100, chains=2, paths=names[:2]))
    return file


def nothing(task: PathTask) -> tuple[list[dict[str, object]], tuple[()]]:
    """A unit of work that runs no block; connections that are done with wait for no search."""
    if task.position % AT_ONCE == 0:
        gc.collect()
    return [{"path_id": task.path_id, "notes": []}], ()


def run(database: str) -> int:
    """All of `hazard` but the runs of the block; the number of paths."""
    work, _ = hazard_work(database, "m", ASKED)
    work = replace(work, answer=nothing, settings={**work.settings, "try": id(work)})
    stored, _ = by_path.run_paths(database, work, silent)
    with reading(database) as session:
        return sum(1 for _ in read_run(session, stored))


@pytest.mark.slow
def test_memory_does_not_grow_with_the_number_of_paths(databases: dict[int, str]) -> None:
    run(databases[FEW])  # what is made once only
    peaks = {}
    for n, database in databases.items():
        gc.collect()
        tracemalloc.start()
        assert run(database) == n
        peaks[n] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    # Names, volumes and a digest of each path are held: its profile alone is more than that.
    assert (peaks[MANY] - peaks[FEW]) / (MANY - FEW) < PROFILE_BYTES


def test_few_profiles_are_there_at_a_time(databases: dict[int, str]) -> None:
    work, _ = hazard_work(databases[MANY], "m", ASKED)
    gc.collect()
    before = live_profiles()
    most = 0
    for task in by_path.path_tasks(databases[MANY], work.survey, work.path_ids):
        assert task.records.profiles[0].path_id == task.path_id
        if task.position % AT_ONCE == 2:
            most = max(most, live_profiles())
    assert AT_ONCE <= most - before <= 2 * AT_ONCE


def live_profiles() -> int:
    return sum(type(thing) is Profile for thing in gc.get_objects())


def test_tasks_are_the_paths_in_their_order_less_those_done(databases: dict[int, str]) -> None:
    work, _ = hazard_work(databases[FEW], "m", ASKED)
    assert work.path_ids == [f"B{k:03d}" for k in range(FEW)]
    done = {"B000", "B007", f"B{FEW - 1:03d}"}
    tasks = list(by_path.path_tasks(databases[FEW], work.survey, work.path_ids, done))
    assert [task.path_id for task in tasks] == [p for p in work.path_ids if p not in done]
    assert all(work.path_ids[task.position] == task.path_id for task in tasks)
    for task in tasks:
        assert [p.path_id for p in task.records.paths] == [task.path_id]
        assert [e.event_id for e in task.records.events] == [
            f"{task.path_id}-{year}" for year in (1950, 1960, 1970)
        ]


@pytest.fixture
def changing(tmp_path: FilePath) -> str:
    return region(tmp_path, AT_ONCE + 1)


def test_records_that_change_meanwhile_end_the_work(changing: str) -> None:
    work, _ = hazard_work(changing, "m", ASKED)
    shared, path_ids = (nothing, ()), work.path_ids
    tasks = by_path.path_tasks(changing, work.survey, path_ids)
    answers = [path_answer(shared, next(tasks)) for _ in range(AT_ONCE)]
    assert [found.path_id for found in answers] == path_ids[:AT_ONCE]
    assert not any(found.failed for found in answers)
    with writing(changing) as session:
        save_records(session, Records(events=(Event("new", path_ids[-1], runout_x_m=1000.0),)))
    with pytest.raises(AvahazardError, match=f"path {path_ids[-1]} have been changed") as error:
        path_answer(shared, next(tasks))
    assert "same command again" in error.value.hint
    again, _ = hazard_work(changing, "m", ASKED)
    assert again.survey.fingerprint != work.survey.fingerprint


@pytest.mark.parametrize("engine", ["local", "processes"])
def test_such_a_change_ends_a_run_by_any_engine(changing: str, engine: EngineName) -> None:
    """What the worker says reaches who asked, with its hint, and is no path's failure."""
    work, _ = hazard_work(changing, "m", ASKED)
    with writing(changing) as session:
        save_records(session, Records(events=(Event("new", work.path_ids[-1], runout_x_m=1000.0),)))
    set_engine(engine, workers=1)
    try:
        with pytest.raises(AvahazardError, match=f"path {work.path_ids[-1]} have been") as error:
            by_path.run_paths(changing, work, silent)
    finally:
        set_engine("local")
    assert "same command again" in error.value.hint


@pytest.fixture(scope="module")
def world() -> Records:
    """Seven paths with events, two without any, one of them without a profile; and a slide."""
    made, _ = make_dataset(2, 90, 8)
    last = made.paths[-1].path_id
    slide = Event("slide", fall_height_m=1.0, runout_length_m=2.0)
    return replace(
        made,
        paths=(*made.paths, Path("bare")),
        events=(slide, *(e for e in made.events if e.path_id != last)),
        speeds=(Speed("slide", 3.0, 1.0, x_m=0.5), Speed(made.events[0].event_id, 9.0, 1.0, 9.0)),
    )


@pytest.fixture
def filled(any_database: str, world: Records, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(store_records, "PATHS_AT_ONCE", 3)
    with writing(any_database) as session:
        save_records(session, world)
    return any_database


def test_it_tells_what_the_whole_records_do(filled: str, world: Records) -> None:
    with reading(filled) as session:
        found = survey(session)
        some = ["P03", "P01", "P03"]
        of_some = fingerprint_of(session, some)
    assert found.fingerprint == data_fingerprint(world)
    assert of_some == data_fingerprint(only_paths(world, some))
    assert list(found.digests) == [path.path_id for path in world.paths]
    assert len(set(found.digests.values())) == len(world.paths)
    assert found.with_profile == {profile.path_id for profile in world.profiles}
    for one, other in zip(found.volumes, known_volumes(world), strict=True):
        for field in fields(one):
            np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))


def test_events_that_stand_for_others_are_spread_evenly(filled: str, world: Records) -> None:
    with reading(filled) as session:
        found = any_events(session)
    there = [event for event in world.events if event.path_id is not None]
    assert len(found) == MAX_CLASSES < len(there)
    assert (found[0], found[-1]) == (there[0], there[-1])
    steps = np.diff([there.index(event) for event in found])
    assert steps.max() - steps.min() <= 1


def test_nothing_stands_for_others_where_there_is_nothing(any_database: str) -> None:
    with reading(any_database) as session:
        assert any_events(session) == ()
        assert survey(session).fingerprint == data_fingerprint(Records())
