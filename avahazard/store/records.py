"""Records in and out of the database."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from itertools import groupby
from operator import attrgetter
from typing import Any

import numpy as np
from sqlalchemy import delete, insert, select, update
from sqlalchemy.orm import Session

from avahazard.records.collection import Records
from avahazard.records.event import Event, Speed
from avahazard.records.path import Covariate, Floats, Path, Profile
from avahazard.store.tables import (
    Base,
    EventCovariateTable,
    EventTable,
    PathCovariateTable,
    PathTable,
    ProfilePointTable,
    SpeedTable,
)

KEYS_A_STATEMENT = 500
PATH_COLUMNS = [f.name for f in fields(Path) if f.name != "covariates"]
EVENT_COLUMNS = [f.name for f in fields(Event) if f.name != "covariates"]
SPEED_COLUMNS = [f.name for f in fields(Speed)]
POINT_COLUMNS = [f.name for f in fields(Profile)]


def load_records(session: Session) -> Records:
    """Return all records, in the order in which they were first imported."""
    path_covariates = _load_covariates(session, PathCovariateTable, "path_id")
    event_covariates = _load_covariates(session, EventCovariateTable, "event_id")
    return Records(
        paths=tuple(
            Path(**row._mapping, covariates=path_covariates.get(row.path_id, {}))
            for row in _rows(session, PathTable, PATH_COLUMNS, "id")
        ),
        profiles=tuple(_load_profiles(session)),
        events=tuple(
            Event(**row._mapping, covariates=event_covariates.get(row.event_id, {}))
            for row in _rows(session, EventTable, EVENT_COLUMNS, "id")
        ),
        speeds=tuple(
            Speed(**row._mapping) for row in _rows(session, SpeedTable, SPEED_COLUMNS, "id")
        ),
    )


def save_records(session: Session, records: Records) -> None:
    """Store `records`; one that is there already (the same id) is replaced whole."""
    _save(session, PathTable, "path_id", _values(records.paths, PATH_COLUMNS))
    _save_covariates(session, PathCovariateTable, "path_id", records.paths)
    _save_profiles(session, records.profiles)
    _save(session, EventTable, "event_id", _values(records.events, EVENT_COLUMNS))
    _save_covariates(session, EventCovariateTable, "event_id", records.events)
    _save_speeds(session, records.speeds)


def _rows(
    session: Session, table: type[Base], columns: Sequence[str], *order: str
) -> Sequence[Any]:
    query = select(*(getattr(table, name) for name in columns))
    return session.execute(query.order_by(*(getattr(table, name) for name in order))).all()


def _load_covariates(
    session: Session, table: type[PathCovariateTable | EventCovariateTable], key: str
) -> dict[str, dict[str, Covariate]]:
    found: dict[str, dict[str, Covariate]] = {}
    for owner, name, number, word in _rows(
        session, table, [key, "name", "number", "word"], key, "position"
    ):
        found.setdefault(owner, {})[name] = word if number is None else number
    return found


def _load_profiles(session: Session) -> Iterable[Profile]:
    query = (
        select(*(getattr(ProfilePointTable, name) for name in POINT_COLUMNS))
        .join(PathTable, PathTable.path_id == ProfilePointTable.path_id)
        .order_by(PathTable.id, ProfilePointTable.point)
    )
    for path_id, group in groupby(session.execute(query), key=attrgetter("path_id")):
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


def _whole(values: tuple[Any, ...]) -> tuple[Any, ...] | None:
    return None if None in values else values


def _array(values: tuple[Any, ...]) -> Floats | None:
    return None if None in values else np.array(values, dtype=np.float64)


def _values(
    records: Sequence[Path | Event | Speed], columns: Sequence[str]
) -> list[dict[str, Any]]:
    read = attrgetter(*columns)
    return [dict(zip(columns, read(record), strict=True)) for record in records]


def _insert(session: Session, table: type[Base], rows: Sequence[dict[str, Any]]) -> None:
    """Insert rows, all with the same keys: past the mapper, which would take them one by one."""
    if rows:
        session.connection().execute(insert(table.__table__), rows)  # type: ignore[arg-type]


def _save(session: Session, table: Any, key: str, rows: Sequence[dict[str, Any]]) -> None:
    """Insert the rows whose key is not there, update the others in their place."""
    column = getattr(table, key)
    ids: dict[str, int] = {}
    for keys in _batches([row[key] for row in rows]):
        ids.update(
            (name, id_)
            for id_, name in session.execute(select(table.id, column).where(column.in_(keys)))
        )
    new = [row for row in rows if row[key] not in ids]
    old = [{**row, "id": ids[row[key]]} for row in rows if row[key] in ids]
    _insert(session, table, new)
    if old:
        session.execute(update(table), old)


def _save_covariates(
    session: Session,
    table: type[PathCovariateTable | EventCovariateTable],
    key: str,
    records: Sequence[Path | Event],
) -> None:
    _delete(session, table, key, [getattr(record, key) for record in records])
    rows = [
        {key: getattr(record, key), "name": name, "position": i, **_covariate(value)}
        for record in records
        for i, (name, value) in enumerate(record.covariates.items())
    ]
    _insert(session, table, rows)


def _covariate(value: Covariate) -> Mapping[str, Covariate | None]:
    is_word = isinstance(value, str)
    return {"number": None if is_word else value, "word": value if is_word else None}


def _save_profiles(session: Session, profiles: Sequence[Profile]) -> None:
    _delete(session, ProfilePointTable, "path_id", [p.path_id for p in profiles])
    for profile in profiles:
        n = len(profile.x_m)
        columns = {name: _column(getattr(profile, name), n) for name in POINT_COLUMNS}
        rows = [
            {"point": i, **{name: column[i] for name, column in columns.items()}} for i in range(n)
        ]
        _insert(session, ProfilePointTable, rows)


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
    new: list[dict[str, Any]] = []
    old: list[dict[str, Any]] = []
    for speed, values in zip(speeds, _values(speeds, SPEED_COLUMNS), strict=True):
        place = (speed.event_id, speed.x_m, speed.elevation_m)
        if place in ids:
            old.append({**values, "id": ids[place]})
        else:
            new.append(values)
    _insert(session, SpeedTable, new)
    if old:
        session.execute(update(SpeedTable), old)


def _delete(session: Session, table: Any, key: str, owners: Sequence[str]) -> None:
    for keys in _batches(owners):
        session.execute(delete(table).where(getattr(table, key).in_(keys)))


def _batches(keys: Sequence[str]) -> Iterable[Sequence[str]]:
    """Cut into pieces that a statement can take: databases limit their parameters."""
    return (keys[i : i + KEYS_A_STATEMENT] for i in range(0, len(keys), KEYS_A_STATEMENT))
