"""Least-squares laws of friction against volume, on the apparent friction of the records."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.paper.apparent import back_calculate
from avahazard.inference.paper.least_squares import LawFit, fit_every_law, usable
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import only_paths
from avahazard.report.picture import require_picture
from avahazard.results.base import Rows
from avahazard.results.friction import Fits, FittedParameter, LeastSquares
from avahazard.store.records import load_records
from avahazard.store.session import reading


def fit_laws(database: str, path_id: str | None = None, plot: Path | None = None) -> Fits:
    """Fit every law, to the events of one path or of all.

    `n_events` of a fit counts the events with a volume and a friction. With `plot` a picture of
    the laws on the points is written there.

    Raises:
        AvahazardError: the database or the path is missing, there are too few such events, or
            `plot` is not the name of a picture.
    """
    if plot is not None:
        require_picture(plot)
    with reading(database) as session:
        records = load_records(session)
    observations = build_observations(only_paths(records, () if path_id is None else (path_id,)))
    mu = back_calculate(observations, predict_records(observations, (), {})).mu
    found, volume, mu = fit_laws_of(observations, mu)
    if plot is not None:
        from avahazard.report.friction_pictures import draw_laws  # noqa: PLC0415 (slow)

        draw_laws(plot, found, volume, mu)
    return found


def fit_laws_of(observations: Observations, mu: Floats) -> tuple[Fits, Floats, Floats]:
    """Every law fitted to apparent frictions `mu` `[n_events]`; the points (V, μ) `[n]` it took.

    Raises `AvahazardError` where fewer than two events have both.
    """
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
            f"left out of {observations.n_events} events: {observations.n_events - n_events}, "
            "without a volume, or stopped where no friction stops the block (see "
            "`avahazard friction`)."
        )
    return Fits(Rows(_entry(fit, n_events) for fit in fits), tuple(notes)), *usable(volume, mu)


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
