"""What commands found by a model, a JSON document each, in and out of the database."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from sqlalchemy import select
from sqlalchemy.orm import Session

from avahazard.records.plain import plain
from avahazard.store.checksums import document_checksum
from avahazard.store.models import load_model, now
from avahazard.store.result_tables import ComparisonTable, DiagnosisTable, ResultTable

Document = TypeVar("Document")


@dataclass(frozen=True, slots=True)
class Kind(Generic[Document]):
    """A kind of result: the table that keeps it, and the type of its document."""

    table: type[ResultTable]


COMPARISON: Kind[dict[str, Any]] = Kind(ComparisonTable)
DIAGNOSIS: Kind[dict[str, Any]] = Kind(DiagnosisTable)
KINDS: tuple[Kind[Any], ...] = (COMPARISON, DIAGNOSIS)


def save_result(session: Session, kind: Kind[Document], model: str, document: Document) -> None:
    """Store what was found by `model`.

    Raises:
        AvahazardError: there is no such model.
    """
    load_model(session, model)
    result = plain(document)
    digest = document_checksum(model, result)
    session.add(kind.table(model=model, result=result, created=now(), sha256=digest))
    session.flush()


def latest_result(session: Session, kind: Kind[Document], model: str) -> Document | None:
    """Return what was found last by `model`, None where nothing was."""
    query = select(kind.table.result).where(kind.table.model == model)
    return session.scalar(query.order_by(kind.table.id.desc()).limit(1))
