"""Models in and out of the database."""

from __future__ import annotations

import datetime as dt
import hashlib
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from avahazard.records.errors import AvahazardError
from avahazard.records.plain import plain
from avahazard.store.tables import ModelTable


@dataclass(frozen=True, slots=True)
class StoredModel:
    """A model by name; `effect_file` is the text of a user's own effects, for the record only."""

    name: str
    specification: dict[str, Any]
    parent: str | None
    effect_file: str | None
    effect_sha256: str | None
    created: dt.datetime


def save_model(
    session: Session,
    name: str,
    specification: dict[str, Any],
    *,
    parent: str | None = None,
    effect_file: str | None = None,
) -> None:
    """Store a new model.

    Raises:
        AvahazardError: the name is taken, or the parent is not there.
    """
    refuse_taken_name(session, name)
    if parent is not None:
        load_model(session, parent)
    text = effect_file
    session.add(
        ModelTable(
            name=name,
            specification=plain(specification),
            parent=parent,
            effect_file=text,
            effect_sha256=None if text is None else hashlib.sha256(text.encode()).hexdigest(),
            created=now(),
        )
    )
    session.flush()


def refuse_taken_name(session: Session, name: str) -> None:
    """Refuse a name that a model has already: what was calibrated is never overwritten.

    Raises:
        AvahazardError: the name is taken, empty, or over 200 characters.
    """
    if not 0 < len(name.strip()) <= 200:
        raise AvahazardError("A model needs a name of 1 to 200 characters.")
    if session.scalar(select(ModelTable.id).where(ModelTable.name == name)) is not None:
        raise AvahazardError(
            f"There is a model {name} already.",
            "Take another name: a stored model is kept. `avahazard models` lists them.",
        )


def load_model(session: Session, name: str) -> StoredModel:
    """Return the model `name`.

    Raises:
        AvahazardError: there is none.
    """
    row = session.scalar(select(ModelTable).where(ModelTable.name == name))
    if row is None:
        names = ", ".join(session.scalars(select(ModelTable.name).order_by(ModelTable.id)).all())
        raise AvahazardError(
            f"There is no model {name}.",
            f"Stored are: {names}." if names else f"Make it: `avahazard calibrate {name}`.",
        )
    return _stored(row)


def list_models(session: Session) -> list[StoredModel]:
    """Return all models, oldest first."""
    return [_stored(row) for row in session.scalars(select(ModelTable).order_by(ModelTable.id))]


def now() -> dt.datetime:
    """Return the time in UTC, without a zone: not every database keeps one."""
    return dt.datetime.now(dt.UTC).replace(tzinfo=None)


def _stored(row: ModelTable) -> StoredModel:
    return StoredModel(
        row.name, row.specification, row.parent, row.effect_file, row.effect_sha256, row.created
    )
