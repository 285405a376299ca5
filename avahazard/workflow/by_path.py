"""Work path by path: cut into tasks, done by the engine, stored as it comes, taken up again."""

import hashlib
import json
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any

import numpy as np

from avahazard.engine import spread_map
from avahazard.hazard.future_events import MAX_CLASSES
from avahazard.hazard.volume_records import DatedVolumes, dated_volumes
from avahazard.notes import Note
from avahazard.records.collection import Event, Fingerprint, Records, of_path, paths_to_run
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Report, plain
from avahazard.results.calibration import Calibration
from avahazard.store import records as stored
from avahazard.store.results import PathResult, RunKind, begin_run, finish_run, save_paths
from avahazard.store.session import Session, reading, writing


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """What is held of the records of a database: their fingerprint, and of each path little.

    `digests` of the records of each path are in the order in which paths were imported. `others`
    stand for the events of a path without any, where a model takes columns of the event.
    """

    fingerprint: str
    digests: Mapping[str, bytes]
    with_profile: frozenset[str]
    volumes: Sequence[DatedVolumes]
    others: tuple[Event, ...] = ()

    def paths_to_run(self, named: Sequence[str]) -> list[str]:
        """The paths that are named, or all with a profile. Raises as `paths_to_run`."""
        return paths_to_run(list(self.digests), self.with_profile, named)


def survey(session: Session) -> Survey:
    """Look over all records of a database."""
    whole, volumes = Fingerprint(), list[DatedVolumes]()
    digests: dict[str, bytes] = {}
    with_profile: set[str] = set()
    for piece in stored.load_by_pieces(session):
        for path in piece.paths:
            selected = of_path(piece, path.path_id)
            digests[path.path_id] = whole.add(selected)
            volumes.append(dated_volumes(path, selected.events))
        with_profile.update(profile.path_id for profile in piece.profiles)
        pathless = tuple(event for event in piece.events if event.path_id is None)
        whole.add(Records(events=pathless, speeds=piece.speeds))
    return Survey(whole.hexdigest(), digests, frozenset(with_profile), volumes)


def fingerprint_of(session: Session, path_ids: Sequence[str]) -> str:
    """The fingerprint of the records of some paths (`only_paths`)."""
    whole = Fingerprint()
    for some in stored.batched(list(dict.fromkeys(path_ids)), stored.PATHS_AT_ONCE):
        whole.add(stored.load_records(session, some))
    return whole.hexdigest()


def any_events(session: Session) -> tuple[Event, ...]:
    """Those of all paths that stand for the events of a path without any (`classes_to_come`)."""
    n = sum(event.path_id is not None for event in stored.load_events(session))
    kept = set(np.linspace(0, n - 1, min(n, MAX_CLASSES)).round().astype(int).tolist())
    there = (event for event in stored.load_events(session) if event.path_id is not None)
    return tuple(event for k, event in enumerate(there) if k in kept)


BATCH = 50
"""Paths that are stored together, at most."""
BATCH_S = 10.0
"""Seconds of work that an interruption may lose, about."""
FAILURES = (ArithmeticError, ValueError, LookupError)
"""What ends the work on one path only, besides `AvahazardError`."""


@dataclass(frozen=True, slots=True, eq=False)
class PathTask:
    """A path as one unit of work: its own records only, and their digest when the work began."""

    position: int
    path_id: str
    records: Records
    digest: bytes


Answer = Callable[[PathTask], tuple[Sequence[object], Sequence[Note]]]
"""Gives the documents of a path, and notes for people that are in none of them."""


@dataclass(frozen=True, slots=True, eq=False)
class PathWork:
    """What is done on every one of the paths `path_ids` by a stored model, by `answer(task)`.

    `survey` is of the records of the database; `settings` are all that the result hangs on besides
    the model and the records.
    """

    kind: RunKind
    what: str
    answer: Answer
    model: Calibration
    survey: Survey
    path_ids: list[str]
    settings: Mapping[str, Any]

    @property
    def rests_on(self) -> dict[str, Any]:
        """The readable part of all that the results hang on."""
        found = {"data_fingerprint": self.survey.fingerprint, "avahazard": version("avahazard")}
        return {**plain(self.settings), **found}

    @property
    def key(self) -> str:
        """The key of all that the results hang on."""
        whole = {"paths": self.path_ids, "model": plain(self.model, keyed=True)}
        text = json.dumps({**self.rests_on, **whole}, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()


def path_tasks(
    database: str, survey: Survey, path_ids: Sequence[str], done: Collection[str] = ()
) -> Iterator[PathTask]:
    """A task for each path that is not done; records are read as the tasks are taken."""
    position = {path_id: k for k, path_id in enumerate(path_ids)}
    left = [path_id for path_id in path_ids if path_id not in done]
    for piece in stored.batched(left, stored.PATHS_AT_ONCE):
        with reading(database) as session:
            records = stored.load_records(session, piece)
        for path_id in piece:
            own = of_path(records, path_id)
            yield PathTask(position[path_id], path_id, own, survey.digests[path_id])


def run_paths(database: str, work: PathWork, report: Report) -> tuple[int, tuple[Note, ...]]:
    """Do the work on the paths and store it in batches, going on where it was interrupted.

    Returns the number of the run, and a note where it took up an interrupted one. A path that fails
    is stored with its reason. Raises `AvahazardError` where somebody has changed the records of a
    path meanwhile; where all paths fail, that of the first, and nothing is kept.
    """
    with writing(database) as session:
        run, done = begin_run(session, work.kind, work.model.model, work.key, work.rests_on)
    failures: list[AvahazardError] = []
    waiting: list[PathResult] = []
    stored_at = time.monotonic()
    for found in _results(database, work, done, report):
        if found.failed is not None and not failures:
            failures.append(AvahazardError(found.failed, found.hint))
        waiting.append(found)
        if len(waiting) >= BATCH or time.monotonic() - stored_at > BATCH_S:
            with writing(database) as session:
                save_paths(session, run, waiting)
            waiting, stored_at = [], time.monotonic()
    with writing(database) as session:
        save_paths(session, run, waiting)
        failed = finish_run(session, run)
    if failed is not None:
        raise next(iter(failures), AvahazardError(failed))
    went_on = Note("went_on", n=len(done), total=len(work.path_ids))
    return run, (went_on,) if done else ()


STARTING = 2.2
"""Workers take about as long to start as so many paths; those in work are half done."""


def _results(
    database: str, work: PathWork, done: Collection[str], report: Report
) -> Iterator[PathResult]:
    """The results of the paths that are not done yet, as they come."""
    tasks = path_tasks(database, work.survey, work.path_ids, done)
    shared = work.answer, work.survey.others
    began, n = time.monotonic(), len(work.path_ids)
    report(work.what, len(done) / max(n, 1))
    for k, found in enumerate(spread_map(path_answer, shared, tasks), 1):
        yield found
        rate, there = k / max(time.monotonic() - began, 1e-9), len(done) + k
        share = (there + 0.5 + STARTING) / (n + STARTING) if there < n else 1.0
        report(f"{work.what}: {there} of {n} paths, {rate:.2g} a second", share)


def path_answer(shared: tuple[Answer, tuple[Event, ...]], task: PathTask) -> PathResult:
    """The result of a path, or why it failed; `shared` are what is done and the survey's `others`.

    Raises `AvahazardError` where somebody has changed its records since the work began.
    """
    answer, others = shared
    own = task.records
    # Here, where many do it, and not by who gives out the work.
    if Fingerprint().add(own) != task.digest:
        raise AvahazardError(
            f"The records of path {task.path_id} have been changed since this began.",
            "Give the same command again: it takes the records as they are now.",
        )
    task = replace(task, records=replace(own, events=own.events or others))
    try:
        found = answer(task)
    except AvahazardError as error:
        return PathResult(task.position, task.path_id, failed=error.message, hint=error.hint)
    except FAILURES as error:
        reason = f"{type(error).__name__} on path {task.path_id}: {error}"
        return PathResult(task.position, task.path_id, failed=reason)
    documents, notes = plain(found, keyed=True)
    return PathResult(task.position, task.path_id, tuple(documents), tuple(notes))
