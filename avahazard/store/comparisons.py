"""Comparisons of models with the measurements, in and out of the database."""

from __future__ import annotations

from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from avahazard.records.plain import plain
from avahazard.store.models import load_model, now
from avahazard.store.result_tables import ComparisonTable


def save_comparison(session: Session, model: str, result: dict[str, Any]) -> None:
    """Store the document of a comparison of `model`.

    Raises:
        AvahazardError: there is no such model.
    """
    load_model(session, model)
    session.add(ComparisonTable(model=model, result=plain(result), created=now()))
    session.flush()


def latest_comparison(session: Session, model: str) -> dict[str, Any] | None:
    """Return the last comparison of `model`, None where it has none."""
    query = select(ComparisonTable.result).where(ComparisonTable.model == model)
    return session.scalar(query.order_by(ComparisonTable.id.desc()).limit(1))
