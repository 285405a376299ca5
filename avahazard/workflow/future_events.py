"""Avalanches to come, as events that a model can be applied to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.avalanches import Avalanches, avalanches
from avahazard.hazard.event_volumes import EventVolumes
from avahazard.hazard.future_events import Forecaster, FutureEvent, forecaster
from avahazard.hazard.release_zone import ReleaseZone, release_zone
from avahazard.inference.seeds import generator
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.workflow.stored.model import StoredFit

Floats = NDArray[np.float64]

MAX_CLASSES = 24
"""Recorded events, at most, that an avalanche to come may be like."""


def takes_event_columns(stored: StoredFit) -> bool:
    """Whether the model's friction or front depends on columns of the event itself."""
    return any(entry.event_columns for entry in stored.definitions)


def ignores_volume(stored: StoredFit) -> bool:
    """Whether the model gives the same runout for every volume."""
    specification = stored.specification
    return (
        specification.law == "constant"
        and specification.scatter == "constant"
        and not any(entry.uses_volume for entry in stored.definitions)
    )


def path_release_zone(records: Records, path_id: str) -> ReleaseZone | None:
    """The release zone of a path from its records, None where they tell of one place only."""
    recorded = [
        event.release_elevation_m
        for event in records.events
        if event.path_id == path_id and event.release_elevation_m is not None
    ]
    (top,) = (float(np.max(p.y_m)) for p in records.profiles if p.path_id == path_id)
    return release_zone(np.array(recorded, np.float64), top)


def forecast(
    stored: StoredFit, wanted: Sequence[tuple[str, float | None]]
) -> tuple[Forecaster, tuple[FutureEvent, ...]]:
    """Make a model ready for avalanches of (path, volume in m3), by `classes_to_come`."""
    events: list[Event] = []
    future_events = []
    for path_id, volume in wanted:
        first = len(events)
        classes = classes_to_come(stored, path_id, volume)
        events += [replace(e, event_id=f"to come {first + k}") for k, e in enumerate(classes)]
        future_events.append(FutureEvent(path_id, volume, np.arange(first, len(events))))
    volumes = np.array([1.0 if e.volume_m3 is None else e.volume_m3 for e in events])
    ready = forecaster(stored.on(events), volumes)
    return ready, tuple(future_events)


def path_avalanches(
    stored: StoredFit, path_id: str, volumes: EventVolumes, seed: int
) -> Avalanches:
    """What comes down a path by a model and its draws of `volumes`."""
    middle = float(np.exp(np.median(volumes.log_volume)))
    classes = classes_to_come(stored, path_id, middle)
    rng = generator(seed, "avalanches", path_id)
    return avalanches(stored.on(classes), path_id, volumes, rng)


def classes_to_come(stored: StoredFit, path_id: str, volume: float | None) -> tuple[Event, ...]:
    """Events of this volume (m3) that an avalanche to come on the path may be, equally likely.

    They start along the release zone of the path's records, or where the path says. Where the
    model takes columns of the event, they are like the path's recorded ones (those of all paths,
    where it has none) in these; volume, release and columns know nothing of each other.
    """
    records = stored.records
    zone = path_release_zone(records, path_id)
    models: list[Event] = []
    if takes_event_columns(stored):
        models = [e for e in records.events if e.path_id == path_id]
        models = models or [e for e in records.events if e.path_id is not None]
        kept = np.linspace(0, len(models) - 1, min(len(models), MAX_CLASSES)).round().astype(int)
        models = [models[k] for k in np.unique(kept)]
    models = models or [Event("")]
    if zone is not None and len(models) < len(zone.elevations()):
        # Every column meets several releases.
        models = models * -(-len(zone.elevations()) // len(models))
    releases: list[float | None] = [None] * len(models)
    if zone is not None:
        order = generator(0, "releases to come", path_id).permutation(len(models))
        releases = [float(z) for z in zone.elevations(len(models))[order]]
    return tuple(
        replace(
            Event(f"to come {k}", path_id=path_id, volume_m3=volume),
            date=model.date,
            deposit_length_m=model.deposit_length_m,
            release_elevation_m=release,
            covariates=model.covariates,
        )
        for k, (model, release) in enumerate(zip(models, releases, strict=True))
    )
