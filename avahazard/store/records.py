"""Records out of the database: all, those of some paths, or piece by piece."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import fields
from itertools import chain, groupby
from operator import itemgetter
from sys import intern
from typing import Any

import numpy as np
from sqlalchemy import ColumnElement, Select, select
from sqlalchemy.orm import Session

from avahazard.arrays import Floats
from avahazard.records.collection import Records
from avahazard.records.event import Event, Speed
from avahazard.records.path import Covariate, Path, Profile
from avahazard.store.tables import (
    EventCovariateTable,
    EventTable,
    PathCovariateTable,
    PathTable,
    ProfilePointTable,
    SpeedTable,
)

AT_A_TIME = {"yield_per": 2000}
"""Rows that are fetched together: the records alone are held, not the rows as well."""
PATHS_AT_ONCE = 50
"""Paths whose records are one piece, where they are read piece by piece."""
PATH_COLUMNS = [f.name for f in fields(Path) if f.name != "covariates"]
EVENT_COLUMNS = [f.name for f in fields(Event) if f.name != "covariates"]
SPEED_COLUMNS = [f.name for f in fields(Speed)]
POINT_COLUMNS = [f.name for f in fields(Profile)]
Chosen = Callable[[Any], ColumnElement[bool]]
"""A condition on a column of names of paths."""


def load_records(session: Session) -> Records:
    """Return all records, in the order in which they were first imported."""
    return _load(session, None)


def load_paths(session: Session, path_ids: Sequence[str]) -> Records:
    """Return the records of these paths, in the same order; unknown names are left out."""
    return _load(session, _among(path_ids))


def load_by_pieces(session: Session) -> Iterator[Records]:
    """Give all records, some paths at a time, in the same order; those without a path come last."""
    path_ids = session.scalars(select(PathTable.path_id).order_by(PathTable.id)).all()
    for start in range(0, len(path_ids), PATHS_AT_ONCE):
        yield load_paths(session, path_ids[start : start + PATHS_AT_ONCE])
    yield _load(session, lambda column: column.is_(None))


def load_events(session: Session) -> Iterator[Event]:
    """Give all events, in the same order."""
    return _events(session, None)


def load_without_profiles(
    session: Session, path_ids: Collection[str] = (), *, speeds: bool = False
) -> Records:
    """Return paths and events alone: of these paths, or all, with events without a path.

    All `speeds` are with them if they are asked for.
    """
    wanted = set(path_ids)
    return Records(
        paths=tuple(p for p in _paths(session, None) if not wanted or p.path_id in wanted),
        events=tuple(e for e in load_events(session) if not wanted or e.path_id in wanted),
        speeds=tuple(_speeds(session, None)) if speeds else (),
    )


def load_profiles(session: Session, path_ids: Collection[str]) -> list[Profile]:
    """Return the profiles of these paths, of those that have one."""
    each = sorted(path_ids)
    found: list[Profile] = []
    for start in range(0, len(each), PATHS_AT_ONCE):
        found += _profiles(session, _among(each[start : start + PATHS_AT_ONCE]))
    return found


def _among(path_ids: Sequence[str]) -> Chosen:
    return lambda column: column.in_(path_ids)


def _load(session: Session, chosen: Chosen | None) -> Records:
    return Records(
        paths=tuple(_paths(session, chosen)),
        profiles=tuple(_profiles(session, chosen)),
        events=tuple(_events(session, chosen)),
        speeds=tuple(_speeds(session, chosen)),
    )


def _paths(session: Session, chosen: Chosen | None) -> Iterator[Path]:
    query = _of(PathTable, PATH_COLUMNS, PathTable.path_id, chosen).order_by(PathTable.id)
    covariates = _covariates(session, PathCovariateTable, "path_id", PathTable, chosen)
    for row in _rows(session, query):
        yield Path(**row._mapping, covariates=covariates.of(row.path_id))


def _events(session: Session, chosen: Chosen | None) -> Iterator[Event]:
    query = _of(EventTable, EVENT_COLUMNS, EventTable.path_id, chosen).order_by(EventTable.id)
    covariates = _covariates(session, EventCovariateTable, "event_id", EventTable, chosen)
    for row in _rows(session, query):
        yield Event(**row._mapping, covariates=covariates.of(row.event_id))


def _speeds(session: Session, chosen: Chosen | None) -> Iterator[Speed]:
    query = _of(SpeedTable, SPEED_COLUMNS, EventTable.path_id, chosen)
    if chosen is not None:
        query = query.join(EventTable, EventTable.event_id == SpeedTable.event_id)
    return (Speed(**row._mapping) for row in _rows(session, query.order_by(SpeedTable.id)))


def _of(table: Any, columns: Sequence[str], of_path: Any, chosen: Chosen | None) -> Select[Any]:
    """Columns of a table, where the name of the path is a chosen one."""
    query = select(*(getattr(table, name) for name in columns))
    return query if chosen is None else query.where(chosen(of_path))


def _rows(session: Session, query: Select[Any]) -> Iterable[Any]:
    # Of columns, not of objects: the mapper would make each row anew.
    found = session.connection().execute(query, execution_options=AT_A_TIME)
    return chain.from_iterable(found.partitions())


class _Covariates:
    """Covariates by owner, taken from rows that are in the order of the owners."""

    def __init__(self, rows: Iterable[Any]) -> None:
        self._groups = groupby(rows, key=lambda row: row[0])
        self._next = next(self._groups, None)

    def of(self, owner: str) -> dict[str, Covariate]:
        """Those of an owner, who comes after those that were asked for before."""
        if self._next is None or self._next[0] != owner:
            return {}
        # A few names and words come again and again: each is held once.
        found: dict[str, Covariate] = {
            intern(name): intern(word) if number is None else number
            for _, name, number, word in self._next[1]
        }
        self._next = next(self._groups, None)
        return found


def _covariates(
    session: Session,
    table: type[PathCovariateTable | EventCovariateTable],
    key: str,
    owners: type[PathTable | EventTable],
    chosen: Chosen | None,
) -> _Covariates:
    query = _of(table, [key, "name", "number", "word"], owners.path_id, chosen)
    query = query.join(owners, getattr(owners, key) == getattr(table, key))
    return _Covariates(_rows(session, query.order_by(owners.id, table.position)))


def _profiles(session: Session, chosen: Chosen | None) -> Iterator[Profile]:
    query = (
        _of(ProfilePointTable, POINT_COLUMNS, ProfilePointTable.path_id, chosen)
        .join(PathTable, PathTable.path_id == ProfilePointTable.path_id)
        .order_by(PathTable.id, ProfilePointTable.point)
    )
    of_path = POINT_COLUMNS.index("path_id")
    for path_id, group in groupby(_rows(session, query), key=itemgetter(of_path)):
        columns = dict(zip(POINT_COLUMNS, zip(*group, strict=True), strict=True))
        yield Profile(
            path_id=path_id,
            x_m=np.array(columns["x_m"]),
            y_m=np.array(columns["y_m"]),
            land_cover=_whole(columns["land_cover"]),
            easting_m=_array(columns["easting_m"]),
            northing_m=_array(columns["northing_m"]),
            crs=columns["crs"][0],
            lon=_array(columns["lon"]),
            lat=_array(columns["lat"]),
            elevation_sigma_m=_array(columns["elevation_sigma_m"]),
        )


def _whole(words: tuple[str | None, ...]) -> tuple[str, ...] | None:
    # As above: held once.
    return None if None in words else tuple(intern(word) for word in words if word is not None)


def _array(values: tuple[Any, ...]) -> Floats | None:
    return None if None in values else np.array(values, dtype=np.float64)
