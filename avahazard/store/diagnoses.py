"""Diagnoses of models, in and out of the database."""

from __future__ import annotations

from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from avahazard.records.plain import plain
from avahazard.store.models import load_model, now
from avahazard.store.result_tables import DiagnosisTable


def save_diagnosis(session: Session, model: str, result: dict[str, Any]) -> None:
    """Store the document of a diagnosis of `model`.

    Raises:
        AvahazardError: there is no such model.
    """
    load_model(session, model)
    session.add(DiagnosisTable(model=model, result=plain(result), created=now()))
    session.flush()


def latest_diagnosis(session: Session, model: str) -> dict[str, Any] | None:
    """Return the last diagnosis of `model`, None where it has none."""
    query = select(DiagnosisTable.result).where(DiagnosisTable.model == model)
    return session.scalar(query.order_by(DiagnosisTable.id.desc()).limit(1))
