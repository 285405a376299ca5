"""What is stored of models: all of them in short, and one in full."""

from __future__ import annotations

import datetime as dt
from dataclasses import replace

from avahazard.results.base import Rows
from avahazard.results.calibration import Calibration
from avahazard.results.models import ModelSummary
from avahazard.store.models import list_models, load_model
from avahazard.store.records import load_records
from avahazard.store.results import latest_calibration
from avahazard.store.session import reading
from avahazard.workflow.stored.notes import notes_of

IN_SHORT = ("parent", "law", "scatter", "distribution", "method", "effects", "n_events")


def show_models(database: str) -> Rows[ModelSummary]:
    """One entry a model, oldest first: what it is made of, whether it converged, and when.

    Raises:
        AvahazardError: the database cannot be used.
    """
    rows = []
    with reading(database) as session:
        for model in list_models(session):
            found = latest_calibration(session, model.name)
            rows.append(
                ModelSummary.from_dict(
                    {
                        "model": model.name,
                        **{key: found.result[key] for key in IN_SHORT},
                        "converged": found.converged,
                        "created": _utc(model.created),
                    }
                )
            )
    return Rows(rows)


def show_model(database: str, name: str) -> Calibration:
    """A model's calibration, and `created`, the time in UTC.

    Raises:
        AvahazardError: there is no such model.
    """
    with reading(database) as session:
        created = load_model(session, name).created
        result = latest_calibration(session, name).result
        known = notes_of(session, name, load_records(session))
    found = Calibration.from_dict(result)
    # Those of the calibration and those of today; the former have not converged in figures.
    notes = [n for n in known if n.key != "unconverged" and n not in found.notes]
    return replace(found, notes=(*found.notes, *notes), created=_utc(created))


def _utc(time: dt.datetime) -> str:
    return f"{time.isoformat(timespec='seconds')}Z"
