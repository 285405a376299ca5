"""The records for the report, each beside what the model says of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.expected import expected_records
from avahazard.effects.columns import EventColumns
from avahazard.effects.site import stop_place
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, PLACE
from avahazard.inference.paper.calibration import recorded_elevation
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.prediction.stops import predict_stops
from avahazard.inference.seeds import generator
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.records.defaults import H_OVER_L_REL_SIGMA
from avahazard.records.event import Event
from avahazard.report.html.content import EventView
from avahazard.results.base import RATIO
from avahazard.workflow.compare import COORDINATES
from avahazard.workflow.model_friction import from_reference

RECORD_DRAWS = 1000
QUANTILES = (0.05, 0.5, 0.95)
NO_SCATTER = -12.0
"""Log scatter of friction that is as good as none."""


def event_views(
    events: tuple[Event, ...],
    model: FittedModel,
    mu: Floats,
) -> tuple[EventView, ...]:
    """The events of the model, in its order; `mu` `[n_events]` is their apparent friction."""
    observations = model.observations
    draws = _predicted(model)
    metres = model.sigma_m is not None
    recorded = observations.as_recorded(observations.observed)
    observed = recorded_elevation(observations) if metres else recorded
    smooth = {site.path.path_id: site.smooth for site in observations.sites}
    reference = mu * np.exp(-from_reference(model))
    views = []
    for i, event in enumerate(events):
        known = bool(np.isfinite(draws[i]).all())
        low, middle, high = np.quantile(draws[i], QUANTILES) if known else (0.0, 0.0, 0.0)
        kind = ELEVATION if metres and observations.kind[i] == PLACE else int(observations.kind[i])
        views.append(
            event_view(
                event,
                smooth.get(event.path_id or ""),
                coordinate=RATIO if observations.in_ratio else COORDINATES[kind],
                observed_m=None if observations.kind[i] == LEFT else float(observed[i]),
                mu=float(mu[i]) if np.isfinite(mu[i]) else None,
                mu_reference=float(reference[i]) if np.isfinite(reference[i]) else None,
                predicted=(float(low), float(middle), float(high)) if known else None,
            )
        )
    return tuple(views)


def event_view(
    event: Event,
    smooth: SmoothProfile | None,
    *,
    coordinate: str = "elevation",
    observed_m: float | None = None,
    mu: float | None = None,
    mu_reference: float | None = None,
    predicted: tuple[float, float, float] | None = None,
) -> EventView:
    """One event with its place on the path's smoothed profile, where it has one."""
    return EventView(
        event_id=event.event_id,
        path_id=event.path_id,
        date=event.date,
        year=event.year,
        volume_m3=event.volume_m3,
        left_profile=event.left_profile,
        coordinate=coordinate,
        observed_m=observed_m,
        sigma_m=H_OVER_L_REL_SIGMA * (event.h_over_l or 0.0)
        if event.in_ratio
        else event.runout_sigma_m,
        stop_x_m=None if smooth is None else stop_place(smooth, event),
        mu=mu,
        mu_reference=mu_reference,
        predicted=predicted,
    )


def unknown_columns(columns: EventColumns) -> Mapping[str, int]:
    """For every column of the events that some lack, by how many."""
    lacking = {name: int(np.isnan(values).sum()) for name, values in columns.numbers.items()}
    lacking |= {name: int(np.sum(values == "")) for name, values in columns.texts.items()}
    return {name: n for name, n in lacking.items() if n}


def _predicted(model: FittedModel) -> Floats:
    """Draws `[n_events, n_draws]` of each record with its error."""
    # The very draws that `compare` scores.
    rng = generator(0, "compare")
    if model.sigma_m is None:
        return expected_records(model, RECORD_DRAWS, rng).draws
    # Its scatter is in metres of elevation, about the stop of the median friction.
    sigma = model.sigma_m[model.evenly(RECORD_DRAWS)]
    flat = model.draws.copy()
    flat[:, model.layout.scatter] = NO_SCATTER
    stops = predict_stops(replace(model, draws=flat), RECORD_DRAWS, rng)
    noise = sigma * rng.standard_normal(stops.elevation.shape)
    elevation = np.where(stops.left, stops.elevation, stops.elevation + noise)
    elevation[model.observations.kind == LENGTH] = np.nan
    return elevation
