"""Speeds, pressures and zones, in and out of the database."""

from __future__ import annotations

from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from avahazard.records.plain import plain
from avahazard.store.models import load_model, now
from avahazard.store.result_tables import ZoneTable


def save_zones(session: Session, model: str, result: list[dict[str, Any]]) -> None:
    """Store what `zones` found by `model`: an entry a path.

    Raises:
        AvahazardError: there is no such model.
    """
    load_model(session, model)
    session.add(ZoneTable(model=model, result=plain(result), created=now()))
    session.flush()


def latest_zones(session: Session, model: str) -> list[dict[str, Any]] | None:
    """Return the last zones by `model`, None where it has none."""
    query = select(ZoneTable.result).where(ZoneTable.model == model)
    return session.scalar(query.order_by(ZoneTable.id.desc()).limit(1))
