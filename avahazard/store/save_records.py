"""Records into the database."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import attrgetter
from typing import Any

import numpy as np
from sqlalchemy import delete, func, insert, select, update
from sqlalchemy.orm import Session

from avahazard.arrays import Floats
from avahazard.records.collection import Records
from avahazard.records.event import Event, Speed
from avahazard.records.path import Covariate, Path, Profile
from avahazard.store.records import EVENT_COLUMNS, PATH_COLUMNS, POINT_COLUMNS, SPEED_COLUMNS
from avahazard.store.tables import (
    EventCovariateTable,
    EventTable,
    PathCovariateTable,
    PathTable,
    ProfilePointTable,
    SpeedTable,
)

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
