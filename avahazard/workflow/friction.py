"""Apparent friction of the recorded events, its density, and what the records' errors do to it.

These are the paper's views of the records, for people. Calibration does not use them. The block
runs by itself, as in the paper, or with the effects of a stored model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np

from avahazard.inference.likelihood.predicted import Predicted, predict_records
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.paper.apparent import STATUSES, BackCalculation, back_calculate
from avahazard.inference.paper.density import DEFAULT_KAPPA
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.lookup import find_path
from avahazard.report.picture import require_picture
from avahazard.results.base import Rows
from avahazard.results.friction import (
    ApparentEvent,
    Frictions,
)
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.friction_views import (
    Kappa,
    friction_densities,
    largest_jumps,
    perturbation_check,
)
from avahazard.workflow.model_friction import apparent_friction, friction_view, from_reference
from avahazard.workflow.stored.model import load_stored, on_events
from avahazard.workflow.stored.notes import notes_of_fit
from avahazard.workflow.stored.own_effects import own_effects


def show_frictions(
    database: str,
    path_id: str | None = None,
    kappa: Kappa = DEFAULT_KAPPA,
    plot: FilePath | None = None,
    model: str | None = None,
    effect_files: Sequence[FilePath] = (),
) -> Frictions:
    """The apparent friction of every event, of one path or all.

    `kappa` "auto" takes, for each density, that with the best held-out likelihood. With `model`
    the effects of that stored model on the motion and the record are at work, and the events are
    those that it was calibrated on, or the path's. With `plot` a picture of the densities is
    written there, and by a model also of its law with the events beside it.

    Raises:
        AvahazardError: the database, the model or the path is missing, there are no events, a
            path of theirs has no profile, or `plot` is not the name of a picture.
    """
    require_picture(plot)
    if model is not None:
        return _by_model(database, model, path_id, kappa, plot, effect_files)
    with reading(database) as session:
        records = load_records(session)
    if path_id is not None:
        mine = _events_of(records, path_id)
        records = Records(records.paths, records.profiles, mine, records.speeds)
    observations = build_observations(records)
    predicted = predict_records(observations, (), {})
    frictions = _frictions(observations, back_calculate(observations, predicted), predicted, kappa)
    if plot is not None:
        from avahazard.report.friction_pictures import draw_densities  # noqa: PLC0415 (slow)

        draw_densities(plot, frictions.density)
    return frictions


def _by_model(
    database: str,
    name: str,
    path_id: str | None,
    kappa: Kappa,
    plot: FilePath | None,
    effect_files: Sequence[FilePath],
) -> Frictions:
    stored, records = load_stored(database, name, own_effects(database, name, effect_files))
    fitted = stored
    if path_id is not None:
        fitted = on_events(stored, records, _events_of(records, path_id))
    observations = fitted.observations
    found, predicted = apparent_friction(fitted)
    reference = found.mu * np.exp(-from_reference(fitted))
    frictions = _frictions(observations, found, predicted, kappa)
    events = zip(frictions.events, reference, strict=True)
    frictions = replace(
        frictions,
        model=name,
        notes=notes_of_fit(stored),
        events=Rows(replace(event, mu_reference=_finite(mu)) for event, mu in events),
    )
    if plot is not None:
        from avahazard.report.friction_pictures import draw_frictions  # noqa: PLC0415 (slow)

        volume = np.exp(observations.columns.log_volume)
        draw_frictions(plot, frictions, friction_view(fitted), volume, reference)
    return frictions


def _events_of(records: Records, path_id: str) -> tuple[Event, ...]:
    find_path(records, path_id)
    mine = tuple(event for event in records.events if event.path_id == path_id)
    if not mine:
        raise AvahazardError(
            f"Path {path_id} has no events.", "Import some: avahazard import FOLDER."
        )
    return mine


def _frictions(
    observations: Observations, found: BackCalculation, predicted: Predicted, kappa: Kappa
) -> Frictions:
    return Frictions(
        events=_events(found, observations),
        density=friction_densities(found.mu, observations, kappa),
        perturbation=perturbation_check(found, observations),
        jumps=largest_jumps(observations, predicted, found),
    )


def _events(found: BackCalculation, observations: Observations) -> Rows[ApparentEvent]:
    columns = observations.columns
    return Rows(
        ApparentEvent(
            event_id=columns.event_id[i],
            path_id=columns.paths[k] if k >= 0 else None,
            mu=_finite(found.mu[i]),
            mu_sd=_finite(found.perturbation.mu_sd[i]),
            status=STATUSES[found.status[i]],
            mu_low=_finite(found.mu_low[i]),
            mu_high=_finite(found.mu_high[i]),
        )
        for i, k in enumerate(columns.path_index)
    )


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
