"""What is stored of paths and models; by the database alone, so that it takes no time to start."""

import datetime as dt

from avahazard.results.base import Rows
from avahazard.results.calibration import ModelSummary
from avahazard.results.terrain import PathSummary
from avahazard.store.records import path_summaries
from avahazard.store.results import list_models
from avahazard.store.session import reading


def list_paths(database: str) -> Rows[PathSummary]:
    """Return one entry a path: its profile's size, its number of events, their volumes."""
    with reading(database) as session:
        return path_summaries(session)


def show_models(database: str) -> Rows[ModelSummary]:
    """One entry a model, oldest first: what it is made of, whether it converged, and when."""
    with reading(database) as session:
        models = list_models(session)
    return Rows(
        ModelSummary.from_dict(
            {**m.result, **m.result["diagnostics"], "created": in_utc(m.created)}
        )
        for m in models
    )


def in_utc(time: dt.datetime) -> str:
    """The time of a model, stored in UTC, as text."""
    return f"{time.isoformat(timespec='seconds')}Z"
