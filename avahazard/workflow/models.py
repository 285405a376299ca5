"""What is stored of models: all of them in short, and one in full."""

from __future__ import annotations

import datetime as dt
from typing import Any

from avahazard.store.calibrations import latest_calibration
from avahazard.store.models import list_models, load_model
from avahazard.store.session import reading

IN_SHORT = ("parent", "law", "scatter", "distribution", "method", "effects", "n_events")


def show_models(database: str) -> list[dict[str, Any]]:
    """One entry a model, oldest first: what it is made of, whether it converged, and when.

    Raises:
        AvahazardError: the database cannot be used.
    """
    rows = []
    with reading(database) as session:
        for model in list_models(session):
            calibration = latest_calibration(session, model.name)
            rows.append(
                {
                    "model": model.name,
                    **{key: calibration.result[key] for key in IN_SHORT},
                    "converged": calibration.converged,
                    "created": _utc(model.created),
                }
            )
    return rows


def show_model(database: str, name: str) -> dict[str, Any]:
    """The document of a model's calibration, and `created`, the time in UTC.

    Raises:
        AvahazardError: there is no such model.
    """
    with reading(database) as session:
        created = load_model(session, name).created
        result = latest_calibration(session, name).result
    return {**result, "created": _utc(created)}


def _utc(time: dt.datetime) -> str:
    return f"{time.isoformat(timespec='seconds')}Z"
