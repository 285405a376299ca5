"""Models, and runs of `hazard` and `zones` as they lie in the database, from documents alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from sqlalchemy.orm import Session

from avahazard.results.base import plain
from avahazard.store.results import (
    PathResult,
    RunKind,
    begin_run,
    finish_run,
    save_model,
    save_paths,
)
from tests.results.samples import CALIBRATION

KEPT = {"specification": {"effects": []}, "paths": []}


def save_bare(
    session: Session,
    name: str,
    specification: dict[str, Any] = KEPT,
    settings: dict[str, Any] | None = None,
    result: dict[str, Any] | None = None,
    draws: Mapping[str, np.ndarray] | None = None,
    *,
    parent: str | None = None,
    effect_file: str | None = None,
) -> None:
    """Store a model of which little is known."""
    document = plain(CALIBRATION, keyed=True) if result is None else result
    document = {**document, "model": name, "parent": parent}
    save_model(session, specification, settings or {}, document, draws or {}, effect_file)


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
