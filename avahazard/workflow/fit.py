"""Least-squares laws of friction against volume, on the apparent friction of the records."""

from __future__ import annotations

import numpy as np

from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import build_observations
from avahazard.inference.paper.back_calculation import back_calculate
from avahazard.inference.paper.least_squares import LawFit, fit_every_law
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Rows
from avahazard.results.friction import Fits, FittedParameter, LeastSquares
from avahazard.store.records import load_records
from avahazard.store.session import reading


def fit_laws(database: str) -> Fits:
    """Fit every law; `n_events` of a fit counts the events with a volume and a friction.

    Raises:
        AvahazardError: the database is missing, or there are too few such events.
    """
    with reading(database) as session:
        observations = build_observations(load_records(session))
    mu = back_calculate(observations, predict_records(observations, (), {})).mu
    volume = np.exp(observations.columns.log_volume)
    n_events = int(np.sum(np.isfinite(mu) & np.isfinite(volume)))
    if n_events < 2:
        raise AvahazardError(
            "A law needs events with a volume and an apparent friction; "
            f"there {'is' if n_events == 1 else 'are'} {n_events or 'none'}.",
            "Import events with volume_m3, or with the deposit's length, width and thickness.",
        )
    fits, notes = fit_every_law(volume, mu)
    if n_events < observations.n_events:
        notes.append(
            f"{observations.n_events - n_events} of {observations.n_events} events are left out: "
            "they have no volume, or no friction stops the block where they did (see "
            "`avahazard friction`)."
        )
    return Fits(Rows(_entry(fit, n_events) for fit in fits), tuple(notes))


def _entry(fit: LawFit, n_events: int) -> LeastSquares:
    names, units = fit.law.names, fit.law.units
    parameters = zip(names, units, fit.parameters, fit.standard_errors, strict=True)
    return LeastSquares(
        law=fit.law.name,
        parameters={
            name: FittedParameter(float(value), float(se), unit)
            for name, unit, value, se in parameters
        },
        covariance=tuple(tuple(row) for row in fit.covariance.tolist()),
        r2=float(fit.r2),
        aic=float(fit.aic),
        n_events=n_events,
    )
