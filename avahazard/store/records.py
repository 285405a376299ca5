"""Records in and out of the database: all, those of some paths, or piece by piece."""

import zlib
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import fields
from itertools import chain, groupby
from operator import attrgetter, itemgetter
from sys import intern
from typing import Any, NamedTuple

import numpy as np
import sqlalchemy as sa
from sqlalchemy.orm import Session, defer

from avahazard.records.collection import (
    NUMBERS_OF_POINTS,
    Covariate,
    Event,
    Path,
    Profile,
    Records,
    Simulation,
    Speed,
    TerrainCrop,
)
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Rows
from avahazard.results.terrain import PathSummary
from avahazard.store.tables import (
    Base,
    EventCovariateTable,
    EventTable,
    PathCovariateTable,
    PathTable,
    ProfilePointTable,
    SimulationTable,
    SpeedTable,
    TerrainTable,
)

AT_A_TIME = {"yield_per": 2000}
"""Rows that are fetched together: the records alone are held, not the rows as well."""
PATHS_AT_ONCE = 50
"""Paths whose records are one piece, where they are read piece by piece."""
Chosen = Callable[[Any], sa.ColumnElement[bool]]
"""A condition on a column of names of paths."""


def _columns(table: type[Base]) -> list[str]:
    """The columns of a table, less the number that keeps the order of its rows."""
    return [column.name for column in table.__table__.columns if column.name != "id"]


class Kind(NamedTuple):
    """Records with further columns: their class, their table, that of the columns, their name."""

    record: Any
    table: Any
    covariates: Any
    key: str


PATHS = Kind(Path, PathTable, PathCovariateTable, "path_id")
EVENTS = Kind(Event, EventTable, EventCovariateTable, "event_id")
SPEED_COLUMNS, POINT_COLUMNS = _columns(SpeedTable), _columns(ProfilePointTable)


def load_records(
    session: Session,
    path_ids: Sequence[str] | None = None,
    *,
    profiles: bool = True,
    speeds: bool = True,
) -> Records:
    """Return all records, or those of these paths, as imported; profiles and speeds if wanted."""
    chosen = None if path_ids is None else _among(path_ids)
    return Records(
        paths=tuple(_of_kind(session, PATHS, chosen)),
        profiles=tuple(_profiles(session, chosen)) if profiles else (),
        events=tuple(_of_kind(session, EVENTS, chosen)),
        speeds=tuple(_speeds(session, chosen)) if speeds else (),
        simulations=tuple(load_simulations(session, chosen)) if profiles else (),
    )


def load_by_pieces(session: Session) -> Iterator[Records]:
    """Give all records, some paths at a time, in the same order; those without a path come last."""
    path_ids = session.scalars(sa.select(PathTable.path_id).order_by(PathTable.id)).all()
    for some in batched(path_ids, PATHS_AT_ONCE):
        yield load_records(session, some)
    yield Records(
        events=tuple(_of_kind(session, EVENTS, lambda column: column.is_(None))),
        speeds=tuple(_speeds(session, lambda column: column.is_(None))),
    )


def load_events(session: Session) -> Iterator[Event]:
    """Give all events, in the same order."""
    return _of_kind(session, EVENTS, None)


def load_profiles(session: Session, path_ids: Collection[str]) -> list[Profile]:
    """Return the profiles of these paths, of those that have one."""
    pieces = batched(sorted(path_ids), PATHS_AT_ONCE)
    return [profile for some in pieces for profile in _profiles(session, _among(some))]


def _among(path_ids: Sequence[str]) -> Chosen:
    return lambda column: column.in_(path_ids)


def _of_kind(session: Session, kind: Kind, chosen: Chosen | None) -> Iterator[Any]:
    """Paths or events in their order, each with its further columns."""
    table, more, key = kind.table, kind.covariates, kind.key
    query = _of(more, [key, "name", "number", "word"], table.path_id, chosen)
    query = query.join(table, getattr(table, key) == getattr(more, key))
    groups = groupby(_rows(session, query.order_by(table.id, more.position)), itemgetter(0))
    owner, covariates = next(groups, (None, ()))
    query = _of(table, _columns(table), table.path_id, chosen)
    for row in _rows(session, query.order_by(table.id)):
        found: dict[str, Covariate] = {}
        if getattr(row, key) == owner:
            # A few names and words come again and again: each is held once.
            for _, name, number, word in covariates:
                found[intern(name)] = intern(word) if number is None else number
            owner, covariates = next(groups, (None, ()))
        yield kind.record(**row._mapping, covariates=found)


def _speeds(session: Session, chosen: Chosen | None) -> Iterator[Speed]:
    query = _of(SpeedTable, SPEED_COLUMNS, EventTable.path_id, chosen)
    if chosen is not None:
        query = query.join(EventTable, EventTable.event_id == SpeedTable.event_id)
    return (Speed(**row._mapping) for row in _rows(session, query.order_by(SpeedTable.id)))


def _of(table: Any, columns: Sequence[str], of_path: Any, chosen: Chosen | None) -> sa.Select[Any]:
    """Columns of a table, where the name of the path is a chosen one."""
    query = sa.select(*(getattr(table, name) for name in columns))
    return query if chosen is None else query.where(chosen(of_path))


def _rows(session: Session, query: sa.Select[Any]) -> Iterable[Any]:
    # Of columns, not of objects: the mapper would make each row anew.
    found = session.connection().execute(query, execution_options=AT_A_TIME)
    return chain.from_iterable(found.partitions())


def _profiles(session: Session, chosen: Chosen | None) -> Iterator[Profile]:
    point = ProfilePointTable
    query = _of(point, POINT_COLUMNS, point.path_id, chosen)
    query = query.join(PathTable, PathTable.path_id == point.path_id)
    rows = _rows(session, query.order_by(PathTable.id, point.point))
    for path_id, group in groupby(rows, key=attrgetter("path_id")):
        columns = dict(zip(POINT_COLUMNS, zip(*group, strict=True), strict=True))
        # As above: a word is held once.
        words = columns["land_cover"]
        cover = None if None in words else tuple(map(intern, words))
        numbers: dict[str, Any] = {
            name: None if None in columns[name] else np.array(columns[name], dtype=np.float64)
            for name in NUMBERS_OF_POINTS
        }
        yield Profile(path_id, **numbers, land_cover=cover, crs=columns["crs"][0])


KEYS_A_STATEMENT = 500
"""Names that a statement may hold: databases limit their parameters."""
POINTS_AT_ONCE = 20_000


def save_records(session: Session, records: Records) -> None:
    """Store `records`; one that is there already (the same id) is replaced whole."""
    _save(session, PATHS, records.paths)
    _save_profiles(session, records.profiles)
    _save(session, EVENTS, records.events)
    _save_speeds(session, records.speeds)


def _insert(session: Session, table: Any, rows: Sequence[tuple[Any, ...]]) -> None:
    """Insert rows of all columns by the driver: the mapper would take them one by one."""
    if not rows:
        return
    columns, connection = _columns(table), session.connection()
    made = sa.insert(table.__table__).compile(dialect=connection.dialect, column_keys=columns)
    values: Any = rows
    if not made.positional:
        values = [dict(zip(columns, row, strict=True)) for row in rows]
    connection.exec_driver_sql(str(made), values)


def _save(session: Session, kind: Kind, records: Sequence[Path | Event]) -> None:
    name = attrgetter(kind.key)
    ids = _stored_ids(session, kind, list(map(name, records)))
    _write(session, kind.table, records, [ids.get(name(record)) for record in records])
    _delete(session, kind.covariates, kind.key, list(ids))
    rows = [
        (name(r), column, i, *((None, value) if isinstance(value, str) else (value, None)))
        for r in records
        for i, (column, value) in enumerate(r.covariates.items())
    ]
    _insert(session, kind.covariates, rows)


def _write(session: Session, table: type[Base], records: Sequence[Any], ids: Sequence[Any]) -> None:
    """Insert the records that have no id yet, update the others in their place."""
    columns = _columns(table)
    rows = list(map(attrgetter(*columns), records))
    _insert(session, table, [row for id_, row in zip(ids, rows, strict=True) if id_ is None])
    there = [
        {"id": id_, **dict(zip(columns, row, strict=True))}
        for id_, row in zip(ids, rows, strict=True)
        if id_ is not None
    ]
    if there:
        session.execute(sa.update(table), there)


def _stored_ids(session: Session, kind: Kind, names: Sequence[str]) -> dict[str, int]:
    column = getattr(kind.table, kind.key)
    query = sa.select(column, kind.table.id)
    # One look at few rows takes less time than to ask for many names.
    if (session.scalar(sa.select(sa.func.count()).select_from(kind.table)) or 0) <= len(names):
        wanted = set(names)
        return {name: id_ for name, id_ in session.execute(query) if name in wanted}
    return {
        name: id_
        for some in batched(names, KEYS_A_STATEMENT)
        for name, id_ in session.execute(query.where(column.in_(some)))
    }


def _save_profiles(session: Session, profiles: Sequence[Profile]) -> None:
    _delete(session, ProfilePointTable, "path_id", [p.path_id for p in profiles])
    rows: list[tuple[Any, ...]] = []
    for profile in profiles:
        n = len(profile.x_m)
        columns = {name: getattr(profile, name, None) for name in POINT_COLUMNS}
        columns["point"] = tuple(range(n))
        rows += zip(*(_column(value, n) for value in columns.values()), strict=True)
        if len(rows) > POINTS_AT_ONCE:
            _insert(session, ProfilePointTable, rows)
            rows = []
    _insert(session, ProfilePointTable, rows)


def _column(value: Any, n: int) -> Sequence[Any]:
    if isinstance(value, np.ndarray):
        return [float(number) for number in value]
    return value if isinstance(value, tuple) else [value] * n


def _save_speeds(session: Session, speeds: Sequence[Speed]) -> None:
    place = attrgetter("event_id", "x_m", "elevation_m")
    ids: dict[tuple[Any, ...], int] = {}
    for some in batched(list(dict.fromkeys(s.event_id for s in speeds)), KEYS_A_STATEMENT):
        query = sa.select(SpeedTable.id, *place(SpeedTable)).where(SpeedTable.event_id.in_(some))
        ids |= {tuple(where): id_ for id_, *where in session.execute(query)}
    _write(session, SpeedTable, speeds, [ids.get(place(speed)) for speed in speeds])


def _delete(session: Session, table: Any, key: str, owners: Sequence[str]) -> None:
    for some in batched(owners, KEYS_A_STATEMENT):
        session.execute(sa.delete(table).where(getattr(table, key).in_(some)))


def batched(names: Sequence[str], n: int) -> Iterator[Sequence[str]]:
    """The names in pieces of `n` at most."""
    return (names[start : start + n] for start in range(0, len(names), n))


def path_summaries(session: Session) -> Rows[PathSummary]:
    """One entry a path, in their order, by the database alone; lengths in m, volumes in m3."""
    path, point, event = PathTable, ProfilePointTable, EventTable
    year = sa.cast(sa.func.substr(event.date, 1, 4), sa.Integer)
    top = sa.func.max(sa.case((point.point == 0, point.y_m)))
    profiles = sa.select(
        point.path_id,
        sa.func.count().label("n"),
        top.label("top"),
        (top - sa.func.min(point.y_m)).label("drop"),
        (sa.func.max(point.x_m) - sa.func.min(point.x_m)).label("length"),
    )
    events = sa.select(
        event.path_id,
        sa.func.count().label("n"),
        sa.func.sum(sa.case((event.left_profile, 1), else_=0)).label("left"),
        sa.func.min(year).label("first"),
        sa.func.max(year).label("last"),
        sa.func.min(event.volume_m3).label("small"),
        sa.func.max(event.volume_m3).label("large"),
    )
    p = profiles.group_by(point.path_id).subquery()
    e = events.group_by(event.path_id).subquery()
    n_points, n, left = (sa.func.coalesce(number, 0) for number in (p.c.n, e.c.n, e.c.left))
    query = (
        sa.select(path.path_id, path.name, path.section, n_points, p.c.top, p.c.drop, p.c.length)
        .add_columns(n, left, e.c.first, e.c.last, e.c.small, e.c.large)
        .outerjoin(p, p.c.path_id == path.path_id)
        .outerjoin(e, e.c.path_id == path.path_id)
    )
    return Rows(PathSummary(*row) for row in session.execute(query.order_by(path.id)))


LITTLE_ENDIAN = np.dtype("<f4")


def save_terrain(
    session: Session, crops: Sequence[TerrainCrop], outdated: Iterable[str] = ()
) -> None:
    """Store `crops`, in the place of those stored before for their paths and for `outdated`."""
    _delete(session, TerrainTable, "path_id", [*outdated, *(crop.path_id for crop in crops)])
    place = attrgetter("path_id", "crs", "west_m", "north_m", "cell_m")
    rows = [
        (*place(crop), *crop.elevation_m.shape, crop.elevation_m.astype(LITTLE_ENDIAN).tobytes())
        for crop in crops
    ]
    _insert(session, TerrainTable, rows)


def load_terrain(session: Session, path_id: str) -> TerrainCrop | None:
    """Return the ground around a path, None without; refused where what is stored is damaged."""
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


PLAIN = [f.name for f in fields(Simulation) if f.name not in ("stop_x_m", "peak_kpa")]


def save_simulation(session: Session, run: Simulation) -> None:
    """Store a run, with its peak pressures, in the place of one made before on other ground."""
    assert run.peak_kpa is not None
    row = SimulationTable(**{name: getattr(run, name) for name in PLAIN})
    row.stop_x_m = None if np.isnan(run.stop_x_m) else float(run.stop_x_m)
    row.n_rows, row.n_columns = run.peak_kpa.shape
    row.data = zlib.compress(run.peak_kpa.astype(LITTLE_ENDIAN).tobytes())
    session.merge(row)


def load_simulations(
    session: Session, chosen: Chosen | None = None, *, peaks: bool = False
) -> list[Simulation]:
    """Return the runs on chosen paths, by path, volume, friction; damaged `peaks` are refused."""
    table = SimulationTable
    query = sa.select(table).order_by(table.path_id, table.volume_m3, table.friction)
    if chosen is not None:
        query = query.where(chosen(table.path_id))
    if not peaks:
        query = query.options(defer(table.data))
    return [_simulation(row, peaks) for row in session.scalars(query)]


def _simulation(row: SimulationTable, peaks: bool) -> Simulation:
    peak = None
    if peaks:
        try:
            values = np.frombuffer(zlib.decompress(row.data), LITTLE_ENDIAN)
            peak = values.reshape(row.n_rows, row.n_columns).astype(np.float32)
        except (zlib.error, ValueError) as error:
            raise AvahazardError(
                f"A stored run of {row.engine} on path {row.path_id} is damaged.",
                "Take a backup, or a new database, and simulate again.",
            ) from error
    return Simulation(
        **{name: getattr(row, name) for name in PLAIN},
        stop_x_m=np.nan if row.stop_x_m is None else row.stop_x_m,
        peak_kpa=peak,
    )
