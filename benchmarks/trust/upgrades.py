"""Databases of every earlier revision, with data, upgraded and held against what was there."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from alembic import command
from sqlalchemy import Connection, MetaData, Table, insert, select

from avahazard.store import schema
from avahazard.store.session import make_engine
from avahazard.workflow.database import check
from benchmarks.trust.jobs import downgrade, make_state
from benchmarks.trust.places import Place, copied
from benchmarks.trust.running import Ran, ended, run, start

MOVED = {"hazard_results": "hazard", "zone_results": "zones"}
"""Tables of before whose documents stand path by path in `path_results` now, by their kind."""

ANSWERS = (
    ("compare", "base"),
    ("diagnose", "base", "--worlds", "39"),
    ("zones", "base", "--return-period", "30"),
)
Dump = dict[str, list[dict[str, Any]]]


@dataclass(slots=True)
class Upgraded:
    """What came of bringing a database of `revision` up to date, by one or two at once."""

    place: str
    revision: str
    at_once: int
    n_rows: int
    faults: list[str] = field(default_factory=list)


def earlier_revisions() -> list[str]:
    """The revisions before that of the program, oldest first."""
    return sorted(set(schema._revisions()) - {schema.head()})


def upgrade_all(
    place: Place,
    folder: Path,
    revisions: Sequence[str],
    at_once: Sequence[int] = (1, 2),
    full: bool = True,
) -> Iterator[Upgraded]:
    """Upgrade a database of each of `revisions`, by one process and by two at once.

    It holds records and a model with its draws; if `full`, answers of every kind too.

    Its rows are those of the program, taken back to that revision; its tables are made as that
    revision made them.
    """
    inside = folder / "new"
    inside.mkdir()
    source = place.new(inside)
    make_state("answered" if full else "model", source, folder)
    for words in ANSWERS if full else ():
        run(source, words, folder).check()
    try:
        for revision in revisions:
            with (
                copied(place, source, folder / "back") as back,
                _made(place, revision, back, folder) as old,
            ):
                for n in at_once:
                    with copied(place, old, folder / "upgraded") as database:
                        yield _upgrade(place, revision, n, database, folder)
    finally:
        place.drop(source)


def _upgrade(place: Place, revision: str, at_once: int, database: str, folder: Path) -> Upgraded:
    before = dump(database)
    found = Upgraded(place.name, revision, at_once, sum(map(len, before.values())))
    if at_once == 1:
        ran: list[Ran] = [run(database, ("db", "upgrade"), folder)]
    else:
        words = ("db", "upgrade")
        both = [start(database, words, folder, stdout=-1, stderr=-1) for _ in range(at_once)]
        ran = [ended(process, words) for process in both]
    found.faults += [one.errors or one.broken for one in ran if one.status != 0]
    found.faults += differences(before, dump(database))
    found.faults += check(database, full=False).problems
    return found


@contextmanager
def _made(place: Place, revision: str, back: str, folder: Path) -> Iterator[str]:
    """A database of tables made by the migrations up to `revision`, with the rows of `back`."""
    downgrade(back, revision)
    inside = folder / "made"
    inside.mkdir()
    database = place.new(inside)
    engine = make_engine(database, migrates=True).execution_options(writes=True)
    with engine.begin() as connection:
        config = schema._config()
        config.attributes["connection"] = connection
        command.upgrade(config, revision)
        _fill(connection, dump(back))
    engine.dispose()
    try:
        yield database
    finally:
        place.drop(database)
        shutil.rmtree(inside)


def _fill(connection: Connection, rows: Dump) -> None:
    tables = MetaData()
    tables.reflect(connection)
    for table in tables.sorted_tables:
        if table.name != "alembic_version" and rows[table.name]:
            connection.execute(insert(table), rows[table.name])
    if connection.dialect.name == "postgresql":  # numbers go on after those that were given
        for table in tables.sorted_tables:
            if "id" in table.c:
                connection.exec_driver_sql(
                    f"SELECT setval(pg_get_serial_sequence('{table.name}', 'id'), "
                    f"(SELECT coalesce(max(id), 1) FROM {table.name}))"
                )


def dump(database: str) -> Dump:
    """All rows of all tables, in the order of their keys."""
    engine = make_engine(database, migrates=True)
    with engine.connect() as connection:
        tables = MetaData()
        tables.reflect(connection)
        found = {name: _rows(connection, table) for name, table in tables.tables.items()}
    engine.dispose()
    return found


def _rows(connection: Connection, table: Table) -> list[dict[str, Any]]:
    query = select(table).order_by(*table.primary_key.columns)
    return [dict(row._mapping) for row in connection.execute(query)]


def differences(before: Dump, after: Dump) -> list[str]:
    """Rows of before that are not, column by column, in the tables of after."""
    found = []
    for name, rows in before.items():
        if name == "alembic_version":
            continue
        if name in MOVED:
            kept = _documents(after, MOVED[name])
            wanted = [(row["model"], row["created"], row["result"]) for row in rows]
            if kept != wanted:
                found.append(f"{name}: documents differ")
            continue
        there = after.get(name, [])
        columns = rows[0].keys() if rows else ()
        mine = [{column: row.get(column) for column in columns} for row in there]
        if mine != rows:
            found.append(f"{name}: rows differ")
    return found


def _documents(tables: Dump, kind: str) -> list[tuple[str, Any, list[Any]]]:
    found = []
    for one in tables["path_runs"]:
        if one["kind"] == kind:
            parts = [row["result"] for row in tables["path_results"] if row["run"] == one["id"]]
            whole = [entry for part in parts for entry in part]
            found.append((one["model"], one["created"], whole))
    return found
