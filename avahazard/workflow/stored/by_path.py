"""Work path by path: cut into tasks, done by the engine, stored as it comes, taken up again."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from avahazard.engine import spread_map
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import of_path
from avahazard.records.plain import plain
from avahazard.results.base import Report
from avahazard.store.records import PATHS_AT_ONCE, load_paths
from avahazard.store.results import (
    PathResult,
    any_found,
    begin_run,
    drop_run,
    finish_run,
    save_paths,
)
from avahazard.store.session import reading, writing
from avahazard.workflow.stored.path_unit import PathShared, PathTask, PathWork, path_answer
from avahazard.workflow.stored.region_fit import RegionFit

BATCH = 50
"""Paths that are stored together, at most."""
BATCH_S = 10.0
"""Seconds of work that an interruption may lose, about."""


@dataclass(frozen=True, slots=True)
class PathRun:
    """A run that is stored: its number, how many paths it has, and how many it had before."""

    run: int
    n_paths: int
    n_before: int


def went_on(run: PathRun) -> str:
    """That a run took up an interrupted one."""
    return f"went on where it was interrupted: {run.n_before} of {run.n_paths} paths were done."


def path_tasks(
    database: str, stored: RegionFit, path_ids: Sequence[str], done: Collection[str] = ()
) -> Iterator[PathTask]:
    """A task for each path that is not done; records are read as the tasks are taken."""
    left = [(k, path_id) for k, path_id in enumerate(path_ids) if path_id not in done]
    for start in range(0, len(left), PATHS_AT_ONCE):
        piece = left[start : start + PATHS_AT_ONCE]
        with reading(database) as session:
            records = load_paths(session, [path_id for _, path_id in piece])
        for position, path_id in piece:
            digest = stored.survey.digests[path_id]
            yield PathTask(position, path_id, of_path(records, path_id), digest)


def run_paths(
    database: str,
    stored: RegionFit,
    path_ids: Sequence[str],
    work: PathWork[Any],
    report: Report,
) -> PathRun:
    """Do the work on the paths and store it in batches, going on where it was interrupted.

    A path that fails is stored with its reason. Raises `AvahazardError`, that of the first, where
    all paths do; nothing is then kept. It is raised too where somebody has changed the records of a
    path meanwhile.
    """
    key, settings = _settings(stored, path_ids, work)
    with writing(database) as session:
        run, done = begin_run(session, work.kind, stored.name, key, settings)
    first_failure: AvahazardError | None = None
    waiting: list[PathResult] = []
    stored_at = time.monotonic()
    for found in _results(database, stored, path_ids, done, work, report):
        if found.failed is not None and first_failure is None:
            first_failure = AvahazardError(found.failed, found.hint)
        waiting.append(found)
        if len(waiting) >= BATCH or time.monotonic() - stored_at > BATCH_S:
            with writing(database) as session:
                save_paths(session, run, waiting)
            waiting, stored_at = [], time.monotonic()
    with writing(database) as session:
        save_paths(session, run, waiting)
        if first_failure is not None and not any_found(session, run):
            drop_run(session, run)
        else:
            finish_run(session, run)
            first_failure = None
    if first_failure is not None:
        raise first_failure
    return PathRun(run, len(path_ids), len(done))


def run_key(stored: RegionFit, path_ids: Sequence[str], work: PathWork[Any]) -> str:
    """The key of all that the results hang on."""
    return _settings(stored, path_ids, work)[0]


def _settings(
    stored: RegionFit, path_ids: Sequence[str], work: PathWork[Any]
) -> tuple[str, dict[str, Any]]:
    """The key of all that the results hang on, and what of it is told."""
    told = {
        **plain(work.settings),
        "data_fingerprint": stored.survey.fingerprint,
        "avahazard": version("avahazard"),
    }
    whole = {**told, "paths": list(path_ids), "model": plain(stored.result)}
    text = json.dumps(whole, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest(), told


def _results(
    database: str,
    stored: RegionFit,
    path_ids: Sequence[str],
    done: Collection[str],
    work: PathWork[Any],
    report: Report,
) -> Iterator[PathResult]:
    """The results of the paths that are not done yet, as they come."""
    tasks = path_tasks(database, stored, path_ids, done)
    began, n = time.monotonic(), len(path_ids)
    report(work.what, float(len(done)), n)
    for k, found in enumerate(spread_map(path_answer, PathShared.of(stored, work), tasks), 1):
        yield found
        rate, there = k / max(time.monotonic() - began, 1e-9), len(done) + k
        report(f"{work.what}: {there} of {n} paths, {rate:.2g} a second", float(there), n)
