"""Runs of `hazard` and `zones` as they lie in the database, from documents alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

from sqlalchemy.orm import Session

from avahazard.store.results import (
    PathResult,
    RunKind,
    begin_run,
    finish_run,
    save_paths,
)


def save_documents(
    session: Session, kind: RunKind, model: str, documents: Sequence[Mapping[str, Any]]
) -> None:
    """Store a whole run at once, from documents sorted by their `path_id`."""
    run, _ = begin_run(session, kind, model, "", {})
    groups = groupby(documents, key=lambda document: str(document["path_id"]))
    save_paths(
        session,
        run,
        [PathResult(k, name, tuple(dict(d) for d in of)) for k, (name, of) in enumerate(groups)],
    )
    finish_run(session, run)
