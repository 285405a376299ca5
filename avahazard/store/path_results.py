"""What `hazard` and `zones` found, path by path, in and out of the database."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import select
from sqlalchemy.orm import Session

from avahazard.records.plain import plain
from avahazard.store.checksums import path_checksum
from avahazard.store.models import load_model, now
from avahazard.store.result_tables import PathResultTable, PathRunTable

RunKind = Literal["hazard", "zones"]
BOUNDS: RunKind = "hazard"
ZONES: RunKind = "zones"
READ_AHEAD = 50
"""Paths that are read at a time."""


@dataclass(frozen=True, slots=True)
class PathResult:
    """The documents of one path, plain, the `position`-th of its run; or why it `failed`.

    `hint`, what would mend that, is not stored.
    """

    position: int
    path_id: str
    documents: tuple[dict[str, Any], ...] = ()
    notes: tuple[str, ...] = ()
    failed: str | None = None
    hint: str = ""


def begin_run(
    session: Session, kind: RunKind, model: str, key: str, settings: Mapping[str, Any]
) -> tuple[int, set[str]]:
    """Begin a run, or take up the interrupted one of this key; with the paths that it has.

    Raises `AvahazardError` where there is no such model.
    """
    load_model(session, model)
    there = interrupted_run(session, kind, model, key)
    if there is not None:
        return there
    row = PathRunTable(kind=kind, model=model, key=key, settings=plain(settings), created=now())
    session.add(row)
    session.flush()
    return row.id, set()


def interrupted_run(
    session: Session, kind: RunKind, model: str, key: str
) -> tuple[int, set[str]] | None:
    """The run of this key that was not finished, with the paths that it has; None without one."""
    query = select(PathRunTable.id).where(
        PathRunTable.kind == kind,
        PathRunTable.model == model,
        PathRunTable.key == key,
        PathRunTable.finished.is_(None),
    )
    run = session.scalar(query.order_by(PathRunTable.id.desc()).limit(1))
    return None if run is None else (run, _paths(session, run))


def save_paths(session: Session, run: int, results: Sequence[PathResult]) -> None:
    """Store results of a run. Paths that it has stay: who computes them again gets the same."""
    # By the key of the table: their names stand among documents, which would all be read.
    kept = select(PathResultTable.position).where(
        PathResultTable.run == run,
        PathResultTable.position.in_([found.position for found in results]),
    )
    there = set(session.scalars(kept))
    for found in results:
        if found.position not in there:
            place = (run, found.position, found.path_id)
            told = (list(found.documents), list(found.notes), found.failed)
            session.add(
                PathResultTable(
                    run=run,
                    position=found.position,
                    path_id=found.path_id,
                    result=told[0],
                    notes=told[1],
                    failed=told[2],
                    sha256=path_checksum(*place, *told),
                )
            )
    session.flush()


def finish_run(session: Session, run: int) -> None:
    """Say that all paths of a run are there: from now on it is the latest."""
    session.get_one(PathRunTable, run).finished = now()
    session.flush()


def any_found(session: Session, run: int) -> bool:
    """Whether a run has a path that did not fail."""
    query = select(PathResultTable.position).where(
        PathResultTable.run == run, PathResultTable.failed.is_(None)
    )
    return session.scalar(query.limit(1)) is not None


def drop_run(session: Session, run: int) -> None:
    """Forget a run."""
    session.delete(session.get_one(PathRunTable, run))
    session.flush()


def read_run(session: Session, run: int) -> Iterator[PathResult]:
    """What a run found, in the order of its paths, a few in memory at a time."""
    table = PathResultTable
    query = select(table.position, table.path_id, table.result, table.notes, table.failed)
    ordered = query.where(table.run == run).order_by(table.position)
    for position, path_id, result, notes, failed in session.execute(
        ordered.execution_options(yield_per=READ_AHEAD)
    ):
        yield PathResult(position, path_id, tuple(result), tuple(notes), failed)


def latest_run(session: Session, kind: RunKind, model: str) -> int | None:
    """The last run that was finished, None where there is none."""
    query = select(PathRunTable.id).where(
        PathRunTable.kind == kind, PathRunTable.model == model, PathRunTable.finished.is_not(None)
    )
    return session.scalar(
        query.order_by(PathRunTable.finished.desc(), PathRunTable.id.desc()).limit(1)
    )


def latest_key(session: Session, kind: RunKind, model: str) -> str | None:
    """The key of all that the latest run hangs on, None without a run."""
    run = latest_run(session, kind, model)
    return None if run is None else session.get_one(PathRunTable, run).key


def latest_documents(session: Session, kind: RunKind, model: str) -> list[dict[str, Any]] | None:
    """All documents of the latest run, without the paths that failed; None without a run."""
    run = latest_run(session, kind, model)
    if run is None:
        return None
    return [document for found in read_run(session, run) for document in found.documents]


def _paths(session: Session, run: int) -> set[str]:
    return set(session.scalars(select(PathResultTable.path_id).where(PathResultTable.run == run)))
