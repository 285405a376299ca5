"""Databases of every earlier revision, with data, upgraded and held against what was there."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from alembic import command
from sqlalchemy import Connection, MetaData, insert, select

from avahazard.store import tables
from avahazard.store.session import make_engine
from avahazard.workflow.database import check
from benchmarks.study import Line, bullets, table
from benchmarks.trust.commands import (
    ended,
    link_records,
    make_state,
    migrate,
    run,
    start,
    write_records,
)
from benchmarks.trust.places import Place, copied, places

MOVED = {"hazard_results": "hazard", "zone_results": "zones"}
"""Tables of before whose documents stand path by path in `path_results` now, by their kind."""
UPGRADE = ("db", "upgrade")
ANSWERS = (
    ("compare", "base"),
    ("diagnose", "base"),
    ("zones", "base", "--no-drag", "--return-period", "30"),
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


def upgrades(_given: Any, folder: Path) -> Line:
    """Databases of every earlier revision."""
    write_records(folder)
    rows = []
    for place in places():
        inside = link_records(folder, folder / place.name)
        for one in upgrade_all(place, inside, earlier_revisions()):
            rows.append(asdict(one))
            print(rows[-1])
    return {"rows": rows}


def page(found: Line) -> str:
    """A row for each revision."""
    by_revision: dict[str, list[Line]] = {}
    for row in found["rows"]:
        by_revision.setdefault(row["revision"], []).append(row)
    rows = [
        (
            revision,
            selected[0]["n_rows"],
            len(selected),
            sum(bool(row["faults"]) for row in selected),
        )
        for revision, selected in by_revision.items()
    ]
    wrong = [f"{r['place']}, {r['revision']}: {f}" for r in found["rows"] for f in r["faults"]]
    return (
        table(("revision", "rows", "upgrades", "with a difference"), rows)
        + "\n\n"
        + bullets(wrong, "Every row is unchanged.")
    )


def earlier_revisions() -> list[str]:
    """The revisions before that of the program, oldest first."""
    return sorted(set(tables._revisions()) - {tables.head()})


def upgrade_all(
    place: Place,
    folder: Path,
    revisions: Sequence[str],
    at_once: Sequence[int] = (1, 2),
    full: bool = True,
) -> Iterator[Upgraded]:
    """Upgrade a database of each of `revisions`, by one process and by two at once.

    It holds records and a model with its draws; if `full`, answers of every kind too. Its rows are
    those of the program, taken back to that revision; its tables are made as that revision made
    them.
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
        ran = [run(database, UPGRADE, folder)]
    else:
        both = [start(database, UPGRADE, folder) for _ in range(at_once)]
        ran = [ended(process, UPGRADE) for process in both]
    found.faults += [one.errors or one.discontinuous for one in ran if one.status != 0]
    found.faults += differences(before, dump(database))
    found.faults += check(database, full=False).problems
    return found


@contextmanager
def _made(place: Place, revision: str, back: str, folder: Path) -> Iterator[str]:
    """A database of tables made by the migrations up to `revision`, with the rows of `back`."""
    migrate(back, command.downgrade, revision)
    inside = folder / "made"
    inside.mkdir()
    database = place.new(inside)
    migrate(database, command.upgrade, revision)
    engine = make_engine(database, migrates=True).execution_options(writes=True)
    with engine.begin() as connection:
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
    for table_ in tables.sorted_tables:
        if table_.name != "alembic_version" and rows[table_.name]:
            connection.execute(insert(table_), rows[table_.name])
    if connection.dialect.name == "postgresql":  # numbers go on after those that were given
        for table_ in tables.sorted_tables:
            if "id" in table_.c:
                connection.exec_driver_sql(
                    f"SELECT setval(pg_get_serial_sequence('{table_.name}', 'id'), "
                    f"(SELECT coalesce(max(id), 1) FROM {table_.name}))"
                )


def dump(database: str) -> Dump:
    """All rows of all tables, in the order of their keys."""
    engine = make_engine(database, migrates=True)
    with engine.connect() as connection:
        tables = MetaData()
        tables.reflect(connection)
        found = {
            name: [
                dict(r) for r in connection.execute(select(t).order_by(*t.primary_key)).mappings()
            ]
            for name, t in tables.tables.items()
        }
    engine.dispose()
    return found


def differences(before: Dump, after: Dump) -> list[str]:
    """Rows of before that are not, column by column, in the tables of after."""
    found = []
    for name, rows in before.items():
        if name in MOVED:
            if _documents(after, MOVED[name]) != [
                (row["model"], row["created"], row["result"]) for row in rows
            ]:
                found.append(f"{name}: documents differ")
        elif name != "alembic_version":
            columns = rows[0].keys() if rows else ()
            there = [{column: row.get(column) for column in columns} for row in after.get(name, [])]
            if there != rows:
                found.append(f"{name}: rows differ")
    return found


def _documents(tables: Dump, kind: str) -> list[tuple[str, Any, list[Any]]]:
    found = []
    for one in tables["path_runs"]:
        if one["kind"] == kind:
            parts = [row["result"] for row in tables["path_results"] if row["run"] == one["id"]]
            found.append(
                (one["model"], one["created"], [entry for part in parts for entry in part])
            )
    return found
