"""Records out of the database."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import fields
from itertools import groupby
from operator import attrgetter
from sys import intern
from typing import Any

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from avahazard.arrays import Floats
from avahazard.records.collection import Records
from avahazard.records.event import Event, Speed
from avahazard.records.path import Covariate, Path, Profile
from avahazard.store.tables import (
    Base,
    EventCovariateTable,
    EventTable,
    PathCovariateTable,
    PathTable,
    ProfilePointTable,
    SpeedTable,
)

AT_A_TIME = {"yield_per": 2000}
"""Rows that are fetched together: the records alone are held, not the rows as well."""
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


def _rows(
    session: Session, table: type[Base], columns: Sequence[str], *order: str
) -> Iterable[Any]:
    query = select(*(getattr(table, name) for name in columns))
    query = query.order_by(*(getattr(table, name) for name in order))
    return session.execute(query, execution_options=AT_A_TIME)


def _load_covariates(
    session: Session, table: type[PathCovariateTable | EventCovariateTable], key: str
) -> dict[str, dict[str, Covariate]]:
    found: dict[str, dict[str, Covariate]] = {}
    for owner, name, number, word in _rows(
        session, table, [key, "name", "number", "word"], key, "position"
    ):
        # A few names and words come again and again: each is held once.
        value = intern(word) if number is None else number
        found.setdefault(owner, {})[intern(name)] = value
    return found


def _load_profiles(session: Session) -> Iterable[Profile]:
    query = (
        select(*(getattr(ProfilePointTable, name) for name in POINT_COLUMNS))
        .join(PathTable, PathTable.path_id == ProfilePointTable.path_id)
        .order_by(PathTable.id, ProfilePointTable.point)
    )
    rows = session.execute(query, execution_options=AT_A_TIME)
    for path_id, group in groupby(rows, key=attrgetter("path_id")):
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
