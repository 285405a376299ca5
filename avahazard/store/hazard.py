"""Bounds of the runout, in and out of the database."""

from __future__ import annotations

from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from avahazard.records.plain import plain
from avahazard.store.models import load_model, now
from avahazard.store.result_tables import HazardTable


def save_hazard(session: Session, model: str, rows: list[dict[str, Any]]) -> None:
    """Store the rows of the bounds by `model`.

    Raises:
        AvahazardError: there is no such model.
    """
    load_model(session, model)
    session.add(HazardTable(model=model, result=plain(rows), created=now()))
    session.flush()


def latest_hazard(session: Session, model: str) -> list[dict[str, Any]] | None:
    """Return the last rows of bounds by `model`, None where it has none."""
    query = select(HazardTable.result).where(HazardTable.model == model)
    return session.scalar(query.order_by(HazardTable.id.desc()).limit(1))
