"""The paths and what is recorded on each."""

from __future__ import annotations

from avahazard.results.base import Rows
from avahazard.results.terrain import PathSummary
from avahazard.store.records import path_summaries
from avahazard.store.session import reading


def list_paths(database: str) -> Rows[PathSummary]:
    """Return one entry a path: its profile's size, its number of events, their volumes.

    Raises:
        AvahazardError: the database cannot be used.
    """
    with reading(database) as session:
        return path_summaries(session)
