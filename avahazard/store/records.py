"""Records in and out of the database: all, those of some paths, or piece by piece."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import fields
from itertools import chain, groupby
from operator import attrgetter, itemgetter
from sys import intern
from typing import Any

import numpy as np
from sqlalchemy import ColumnElement, Select, case, delete, func, insert, select, update
from sqlalchemy.orm import Session

from avahazard.arrays import Floats
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event, Speed
from avahazard.records.path import Covariate, Path, Profile, TerrainCrop
from avahazard.results.base import Rows
from avahazard.results.terrain import PathSummary
from avahazard.store.tables import (
    EventCovariateTable,
    EventTable,
    PathCovariateTable,
    PathTable,
    ProfilePointTable,
    SpeedTable,
    TerrainTable,
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


KEYS_A_STATEMENT = 500
POINTS_AT_ONCE = 20_000


def save_records(session: Session, records: Records) -> None:
    """Store `records`; one that is there already (the same id) is replaced whole."""
    replaced = _save(session, PathTable, "path_id", PATH_COLUMNS, records.paths)
    _save_covariates(session, PathCovariateTable, "path_id", records.paths, replaced)
    _save_profiles(session, records.profiles)
    replaced = _save(session, EventTable, "event_id", EVENT_COLUMNS, records.events)
    _save_covariates(session, EventCovariateTable, "event_id", records.events, replaced)
    _save_speeds(session, records.speeds)


def _insert(
    session: Session, table: Any, columns: Sequence[str], rows: Sequence[tuple[Any, ...]]
) -> None:
    """Insert rows of these columns by the driver: the mapper would take them one by one."""
    if not rows:
        return
    connection = session.connection()
    statement = insert(table.__table__).compile(
        dialect=connection.dialect, column_keys=list(columns)
    )
    if statement.positional:
        assert statement.positiontup is not None
        order = [columns.index(name) for name in statement.positiontup]
        if order != list(range(len(columns))):
            rows = [tuple(row[k] for k in order) for row in rows]
        connection.exec_driver_sql(str(statement), rows)
    else:
        named = [dict(zip(columns, row, strict=True)) for row in rows]
        connection.exec_driver_sql(str(statement), named)


def _save(
    session: Session,
    table: Any,
    key: str,
    columns: Sequence[str],
    records: Sequence[Path | Event],
) -> list[str]:
    """Insert the records whose key is not there, update the others in their place: their keys."""
    ids = _stored_ids(session, table, key, [getattr(record, key) for record in records])
    read = attrgetter(*columns)
    _insert(session, table, columns, [read(r) for r in records if getattr(r, key) not in ids])
    old = [
        {**dict(zip(columns, read(r), strict=True)), "id": ids[getattr(r, key)]}
        for r in records
        if getattr(r, key) in ids
    ]
    if old:
        session.execute(update(table), old)
    return list(ids)


def _stored_ids(session: Session, table: Any, key: str, names: Sequence[str]) -> dict[str, int]:
    """The ids of the rows with one of these names, by name."""
    column = getattr(table, key)
    query = select(column, table.id)
    # One look at few rows takes less time than to ask for many names.
    if (session.scalar(select(func.count()).select_from(table)) or 0) <= len(names):
        wanted = set(names)
        return {name: id_ for name, id_ in session.execute(query) if name in wanted}
    return {
        name: id_
        for some in _batches(names)
        for name, id_ in session.execute(query.where(column.in_(some)))
    }


def _save_covariates(
    session: Session,
    table: type[PathCovariateTable | EventCovariateTable],
    key: str,
    records: Sequence[Path | Event],
    replaced: Sequence[str],
) -> None:
    """Insert the covariates of records, in the place of those of the ones that are `replaced`."""
    _delete(session, table, key, replaced)
    rows = [
        (getattr(record, key), name, i, *_covariate(value))
        for record in records
        for i, (name, value) in enumerate(record.covariates.items())
    ]
    _insert(session, table, [key, "name", "position", "number", "word"], rows)


def _covariate(value: Covariate) -> tuple[Covariate | None, Covariate | None]:
    """The number, or the word, that it is."""
    return (None, value) if isinstance(value, str) else (value, None)


def _save_profiles(session: Session, profiles: Sequence[Profile]) -> None:
    _delete(session, ProfilePointTable, "path_id", [p.path_id for p in profiles])
    columns = ["point", *POINT_COLUMNS]
    rows: list[tuple[Any, ...]] = []
    for profile in profiles:
        n = len(profile.x_m)
        of_points = (_column(getattr(profile, name), n) for name in POINT_COLUMNS)
        rows += zip(range(n), *of_points, strict=True)
        if len(rows) > POINTS_AT_ONCE:
            _insert(session, ProfilePointTable, columns, rows)
            rows = []
    _insert(session, ProfilePointTable, columns, rows)


def _column(value: Floats | tuple[str, ...] | str | None, n: int) -> Sequence[float | str | None]:
    if isinstance(value, np.ndarray):
        return [float(number) for number in value]
    return value if isinstance(value, tuple) else [value] * n


def _save_speeds(session: Session, speeds: Sequence[Speed]) -> None:
    """Update the speeds that are there at the same place, insert the others."""
    ids: dict[tuple[str, float | None, float | None], int] = {}
    for keys in _batches(list(dict.fromkeys(s.event_id for s in speeds))):
        query = select(
            SpeedTable.id, SpeedTable.event_id, SpeedTable.x_m, SpeedTable.elevation_m
        ).where(SpeedTable.event_id.in_(keys))
        for id_, event_id, x_m, elevation_m in session.execute(query):
            ids[event_id, x_m, elevation_m] = id_
    read = attrgetter(*SPEED_COLUMNS)
    new: list[tuple[Any, ...]] = []
    old: list[dict[str, Any]] = []
    for speed in speeds:
        place = (speed.event_id, speed.x_m, speed.elevation_m)
        if place in ids:
            values = dict(zip(SPEED_COLUMNS, read(speed), strict=True))
            old.append({**values, "id": ids[place]})
        else:
            new.append(read(speed))
    _insert(session, SpeedTable, SPEED_COLUMNS, new)
    if old:
        session.execute(update(SpeedTable), old)


def _delete(session: Session, table: Any, key: str, owners: Sequence[str]) -> None:
    for keys in _batches(owners):
        session.execute(delete(table).where(getattr(table, key).in_(keys)))


def _batches(keys: Sequence[str]) -> Iterable[Sequence[str]]:
    """Cut into pieces that a statement can take: databases limit their parameters."""
    return (keys[i : i + KEYS_A_STATEMENT] for i in range(0, len(keys), KEYS_A_STATEMENT))


def path_summaries(session: Session) -> Rows[PathSummary]:
    """One entry a path, in the order in which they came; lengths in m, volumes in m3.

    None where something is not known. No record is loaded: a region has many.
    """
    profiles, events = _profile_extents(session), _event_extents(session)
    rows = []
    query = select(PathTable.path_id, PathTable.name, PathTable.section).order_by(PathTable.id)
    for path_id, name, section in session.execute(query):
        n_points, top, lowest, length = profiles.get(path_id, (0, None, None, None))
        n, left, first, last, small, large = events.get(path_id, (0, 0, None, None, None, None))
        rows.append(
            PathSummary(
                path_id=path_id,
                name=name,
                section=section,
                n_points=n_points,
                top_m=top,
                drop_m=None if top is None or lowest is None else top - lowest,
                length_m=length,
                n_events=n,
                n_left_profile=int(left),
                first_year=None if first is None else int(first),
                last_year=None if last is None else int(last),
                volume_min_m3=small,
                volume_max_m3=large,
            )
        )
    return Rows(rows)


def _profile_extents(session: Session) -> dict[str, tuple[Any, ...]]:
    """Points, top, lowest point and length of each profile."""
    point = ProfilePointTable
    query = select(
        point.path_id,
        func.count(),
        func.max(case((point.point == 0, point.y_m))),
        func.min(point.y_m),
        func.max(point.x_m) - func.min(point.x_m),
    )
    return {row[0]: tuple(row[1:]) for row in session.execute(query.group_by(point.path_id))}


def _event_extents(session: Session) -> dict[str, tuple[Any, ...]]:
    """Number, those that left, first and last year, smallest and largest volume by path."""
    event = EventTable
    year = func.substr(event.date, 1, 4)
    query = select(
        event.path_id,
        func.count(),
        func.sum(case((event.left_profile, 1), else_=0)),
        func.min(year),
        func.max(year),
        func.min(event.volume_m3),
        func.max(event.volume_m3),
    )
    return {row[0]: tuple(row[1:]) for row in session.execute(query.group_by(event.path_id))}


LITTLE_ENDIAN = np.dtype("<f4")


def save_terrain(
    session: Session, crops: Sequence[TerrainCrop], outdated: Iterable[str] = ()
) -> None:
    """Store `crops`, in the place of those stored before for their paths and for `outdated`."""
    for path_id in sorted({*outdated, *(crop.path_id for crop in crops)}):
        session.execute(delete(TerrainTable).where(TerrainTable.path_id == path_id))
    for crop in crops:
        n_rows, n_columns = crop.elevation_m.shape
        values = {
            "path_id": crop.path_id,
            "crs": crop.crs,
            "west_m": crop.west_m,
            "north_m": crop.north_m,
            "cell_m": crop.cell_m,
            "n_rows": n_rows,
            "n_columns": n_columns,
            "data": np.ascontiguousarray(crop.elevation_m, LITTLE_ENDIAN).tobytes(),
        }
        session.execute(insert(TerrainTable), values)


def load_terrain(session: Session, path_id: str) -> TerrainCrop | None:
    """Return the ground around a path, None where no terrain model was given for it.

    Raises:
        AvahazardError: what is stored is damaged.
    """
    row = session.get(TerrainTable, path_id)
    if row is None:
        return None
    if len(row.data) != row.n_rows * row.n_columns * LITTLE_ENDIAN.itemsize:
        raise AvahazardError(
            f"The terrain stored for path {path_id} is damaged: it has {len(row.data)} bytes.",
            "Import the line of the path again with --dem and --update, or take a backup.",
        )
    values = np.frombuffer(row.data, LITTLE_ENDIAN).reshape(row.n_rows, row.n_columns)
    return TerrainCrop(
        path_id, row.crs, row.west_m, row.north_m, row.cell_m, values.astype(np.float32)
    )
