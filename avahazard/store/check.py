"""Whether a database is whole."""

from __future__ import annotations

from collections.abc import Iterator

from sqlalchemy import select, text
from sqlalchemy.orm import Session

from avahazard.store.checksums import document_checksum, path_checksum
from avahazard.store.draws import chunk_fault
from avahazard.store.result_tables import (
    CalibrationTable,
    DrawChunkTable,
    PathResultTable,
    ResultTable,
)
from avahazard.store.results import KINDS


def check_database(session: Session) -> list[str]:
    """Return what is wrong: damaged pages, references to nothing, checksums that differ."""
    problems = []
    if session.get_bind().dialect.name == "sqlite":
        for (line,) in session.execute(text("PRAGMA integrity_check")):
            if line != "ok":
                problems.append(f"The file is damaged: {line}.")
        for table, row, parent, _ in session.execute(text("PRAGMA foreign_key_check")):
            problems.append(f"Row {row} of {table} refers to {parent} that is not there.")
    for calibration, model in session.execute(select(CalibrationTable.id, CalibrationTable.model)):
        for fault in _draw_faults(session, calibration):
            problems.append(f"The draws of {model} (calibration {calibration}): {fault}.")
    tables: list[type[ResultTable]] = [CalibrationTable, *(kind.table for kind in KINDS)]
    for table in tables:
        problems += _result_faults(session, table)
    problems += _path_faults(session)
    return problems


def _result_faults(session: Session, table: type[ResultTable]) -> Iterator[str]:
    for key in session.scalars(select(table.id)).all():
        where = f"Row {key} of {table.__tablename__}"
        try:
            row = session.execute(
                select(table.model, table.result, table.sha256).where(table.id == key)
            ).one()
        except ValueError:
            yield f"{where} is no document any more."
            continue
        if document_checksum(row.model, row.result) != row.sha256:
            yield f"{where}, by {row.model}, is not what was stored: its checksum differs."


def _path_faults(session: Session) -> Iterator[str]:
    table = PathResultTable
    told = (table.run, table.position, table.path_id, table.result, table.notes, table.failed)
    for run, position in session.execute(select(table.run, table.position)).all():
        where = f"Result {position} of run {run} in path_results"
        query = select(*told, table.sha256).where(table.run == run, table.position == position)
        try:
            *found, digest = session.execute(query).one()
        except ValueError:
            yield f"{where} is no document any more."
            continue
        if path_checksum(*found) != digest:
            yield f"{where} is not what was stored: its checksum differs."


def _draw_faults(session: Session, calibration: int) -> Iterator[str]:
    query = (
        select(DrawChunkTable)
        .where(DrawChunkTable.calibration == calibration)
        .order_by(DrawChunkTable.parameter, DrawChunkTable.chunk)
    )
    shapes: dict[str, tuple[int, int]] = {}
    chunks: dict[str, int] = {}
    for row in session.scalars(query):
        expected = chunks.get(row.parameter, 0)
        chunks[row.parameter] = row.chunk + 1
        if fault := chunk_fault(row, expected):
            yield fault
        n_draws = shapes.get(row.parameter, (0, 0))[1] + row.n_draws
        shapes[row.parameter] = (row.n_chains, n_draws)
        session.expunge(row)
    if not shapes:
        yield "there are none"
    elif len(set(shapes.values())) > 1:
        sizes = ", ".join(f"{name} {c} × {n}" for name, (c, n) in shapes.items())
        yield f"the parameters differ in number of chains or draws ({sizes})"
