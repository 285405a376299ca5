"""Avalanches to come, as events that a model can be applied to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import RELEASE_SIGMA
from avahazard.hazard.release_zone import ENOUGH_RELEASES, ReleaseZone, release_zone, stated_zone
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.release_error import stated_release_sigma
from avahazard.inference.seeds import generator
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.lookup import of_path

MAX_CLASSES = 24
"""Recorded events, at most, that an avalanche to come may be like."""


def path_release_zone(records: Records, path_id: str) -> ReleaseZone | None:
    """The release zone of a path from its records, None where they tell of one place only.

    Recorded releases are freed of their errors. Where too few are recorded it is what the path
    states of its zone, the error of its own release.
    """
    mine = of_path(records, path_id)
    ((path,), (profile,)) = mine.paths, mine.profiles
    top = float(np.max(profile.y_m))
    recorded = [e for e in mine.events if e.release_elevation_m is not None]
    if len(recorded) < ENOUGH_RELEASES:
        stated = path.covariates.get(RELEASE_SIGMA)
        own = top if path.release_elevation_m is None else path.release_elevation_m
        return stated_zone(own, float(stated)) if isinstance(stated, int | float) else None
    elevations = [e.release_elevation_m for e in recorded]
    sigma = stated_release_sigma(recorded, {path_id: path})
    return release_zone(np.array(elevations, np.float64), top, sigma)


def classes_to_come(
    records: Records, path_id: str, volume_m3: float, *, event_columns: bool
) -> tuple[Event, ...]:
    """Events of this volume that an avalanche to come on the path may be, equally likely.

    They start along the release zone of the path's records, or where the path says. With
    `event_columns` they are like the path's recorded ones (those of all paths, where it has none)
    in these; volume, release and columns know nothing of each other.
    """
    zone = path_release_zone(records, path_id)
    models: list[Event] = []
    if event_columns:
        models = list(of_path(records, path_id).events)
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
            Event(f"to come {k}", path_id=path_id, volume_m3=volume_m3),
            date=model.date,
            deposit_length_m=model.deposit_length_m,
            release_elevation_m=release,
            covariates=model.covariates,
        )
        for k, (model, release) in enumerate(zip(models, releases, strict=True))
    )


def at_volumes(observations: Observations, volume: Floats) -> Observations:
    """Every event once for each volume (m3) `[n_volumes]`.

    With more than one volume they are columns only: their block cannot be run.
    """
    n = len(volume)
    columns = observations.columns
    nodes = np.repeat(observations.volumes.log_volume, n, axis=0)
    return replace(
        observations,
        columns=replace(
            columns,
            event_id=tuple(name for name in columns.event_id for _ in range(n)),
            path_index=np.repeat(columns.path_index, n),
            year=np.repeat(columns.year, n),
            day_of_winter=np.repeat(columns.day_of_winter, n),
            day=np.repeat(columns.day, n),
            winter=np.repeat(columns.winter, n),
            location=np.repeat(columns.location, n),
            release_elevation=np.repeat(columns.release_elevation, n),
            volume_error=np.repeat(columns.volume_error, n),
            deposit_length=np.repeat(columns.deposit_length, n),
            stop_elevation=np.repeat(columns.stop_elevation, n),
            section=np.repeat(columns.section, n),
            log_volume=np.tile(np.log(volume), len(columns)),
            numbers={name: np.repeat(v, n) for name, v in columns.numbers.items()},
            texts={name: np.repeat(v, n) for name, v in columns.texts.items()},
        ),
        volumes=replace(observations.volumes, log_volume=nodes),
        observed=np.repeat(observations.observed, n),
    )
