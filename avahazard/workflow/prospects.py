"""Avalanches to come, as events that a model can be applied to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.prospect import Forecaster, Prospect, forecaster
from avahazard.inference.study import build_study
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.workflow.stored_model import (
    StoredFit,
    coordinates_for,
    posterior_for,
    training_records,
)

Floats = NDArray[np.float64]

EVENT_COLUMNS = ("snow-type", "season", "leading-edge", "covariate:")
"""Effects that look at columns of the event; the others know it by its path and volume."""


def takes_event_columns(stored: StoredFit) -> bool:
    """Whether the model's friction or front depends on columns of the event itself."""
    own = {entry.key for entry in stored.own}
    return any(key.startswith(EVENT_COLUMNS) or key in own for key in stored.specification.effects)


def ignores_volume(stored: StoredFit) -> bool:
    """Whether the model gives the same runout for every volume."""
    specification = stored.specification
    return (
        specification.law == "constant"
        and specification.scatter == "constant"
        and "covariate:volume_m3" not in specification.effects
        and not stored.own
    )


def forecast(
    stored: StoredFit, records: Records, wanted: Sequence[tuple[str, float | None]]
) -> tuple[Forecaster, tuple[Prospect, ...]]:
    """Make a model ready for avalanches of (path, volume in m3), released where the path says.

    Where the model takes columns of the event, an avalanche to come is like any of the path's
    recorded ones (of all, where it has none) in these; its volume and release are its own.
    """
    like_records = takes_event_columns(stored)
    events: list[Event] = []
    prospects = []
    for path_id, volume in wanted:
        models = [e for e in records.events if e.path_id == path_id] if like_records else []
        if like_records and not models:
            models = [e for e in records.events if e.path_id is not None]
        first = len(events)
        for model in models or [Event("")]:
            events.append(_to_come(model, len(events), path_id, volume))
        prospects.append(Prospect(path_id, volume, np.arange(first, len(events))))
    prior = build_study(training_records(stored, records))
    future = Records(records.paths, records.profiles, tuple(events))
    _, posterior = posterior_for(stored, future, prior)
    volumes = np.array([1.0 if e.volume_m3 is None else e.volume_m3 for e in events])
    ready = forecaster(
        posterior,
        coordinates_for(stored, posterior),
        stored.offsets,
        volumes,
        metres=stored.method == "metropolis",
    )
    return ready, tuple(prospects)


def _to_come(model: Event, number: int, path_id: str, volume: float | None) -> Event:
    """An event of the path at its own release, with the covariates of `model`."""
    return replace(
        Event(f"to come {number}", path_id=path_id, volume_m3=volume),
        date=model.date,
        deposit_length_m=model.deposit_length_m,
        covariates=model.covariates,
    )
