"""Calibrations of models in and out of the database."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from avahazard.records.errors import AvahazardError
from avahazard.records.plain import plain
from avahazard.store.checksums import document_checksum
from avahazard.store.draws import save_draws
from avahazard.store.models import load_model, now
from avahazard.store.result_tables import CalibrationTable


@dataclass(frozen=True, slots=True)
class StoredCalibration:
    """A calibration without its draws; `id` finds those."""

    id: int
    model: str
    settings: dict[str, Any]
    seed: int
    data_fingerprint: str
    diagnostics: dict[str, Any]
    converged: bool
    result: dict[str, Any]
    created: dt.datetime


def save_calibration(
    session: Session,
    model: str,
    *,
    settings: dict[str, Any],
    seed: int,
    data_fingerprint: str,
    diagnostics: dict[str, Any],
    converged: bool,
    result: dict[str, Any],
    draws: Mapping[str, NDArray[np.float64]],
) -> int:
    """Store a calibration of a stored model, with draws `[n_chains, n_draws]`; return its id.

    Raises:
        AvahazardError: there is no such model.
    """
    load_model(session, model)
    row = CalibrationTable(
        model=model,
        settings=plain(settings),
        seed=seed,
        data_fingerprint=data_fingerprint,
        diagnostics=plain(diagnostics),
        converged=bool(converged),
        result=plain(result),
        created=now(),
        sha256=document_checksum(model, plain(result)),
    )
    session.add(row)
    session.flush()
    save_draws(session, row.id, draws)
    return row.id


def latest_calibration(session: Session, model: str) -> StoredCalibration:
    """Return the last calibration of `model`.

    Raises:
        AvahazardError: there is no such model, or it has not been calibrated.
    """
    load_model(session, model)
    query = select(CalibrationTable).where(CalibrationTable.model == model)
    row = session.scalar(query.order_by(CalibrationTable.id.desc()).limit(1))
    if row is None:
        raise AvahazardError(
            f"The model {model} has no calibration.", "Calibrate it under another name."
        )
    return StoredCalibration(
        row.id,
        row.model,
        row.settings,
        row.seed,
        row.data_fingerprint,
        row.diagnostics,
        row.converged,
        row.result,
        row.created,
    )
