"""The paths for the report: the profile, the events, the bounds and the speeds of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.expected import expected_records
from avahazard.effects.columns import EventColumns
from avahazard.effects.site import release_place, stop_place
from avahazard.hazard.future_events import classes_of
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.model.friction_model import LEAST_LOG_SCATTER
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, PLACE
from avahazard.inference.paper.calibration import recorded_elevation
from avahazard.inference.prediction import predict_stops
from avahazard.inference.seeds import generator
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.records.collection import Records
from avahazard.records.defaults import H_OVER_L_REL_SIGMA
from avahazard.records.event import Event
from avahazard.records.lookup import of_path
from avahazard.records.path import Path, Profile, TerrainCrop
from avahazard.report.html.content import EventView, PathView, PlanView, SpeedLine
from avahazard.results.base import RATIO
from avahazard.results.hazard import HazardRow
from avahazard.results.terrain import TerrainRunout
from avahazard.results.zones import ZonedPath
from avahazard.workflow.compare import COORDINATES, RECORD_DRAWS
from avahazard.workflow.friction import from_reference
from avahazard.workflow.path import describe_path
from avahazard.workflow.runout import run_site

R = TypeVar("R", HazardRow, TerrainRunout, ZonedPath)
MOST_PLACES = 200
ANY_VOLUME_M3 = 1e4
"""Stands for the volume where the model has no use for it."""


def path_views(
    stored: FittedModel,
    records: Records,
    events: Sequence[EventView],
    rows: Sequence[HazardRow],
    alpha_beta: Sequence[TerrainRunout],
    zones: Sequence[ZonedPath],
    grounds: Mapping[str, TerrainCrop],
) -> tuple[PathView, ...]:
    """The paths that the model was calibrated on or that have bounds, in the order of the store.

    `records` are all of the database; `events` are those of the calibration; `rows`, `alpha_beta`
    and `zones` are the results of `hazard`, `alpha-beta` and `zones`, `grounds` the terrain by
    path.
    """
    bounded = {row.path_id for row in rows}
    trained = set(stored.paths) or {path.path_id for path in records.paths}
    shown = [p for p in records.paths if p.path_id in trained | bounded]
    profiles = {profile.path_id: profile for profile in records.profiles}
    known = {site.path.path_id: site.smooth for site in stored.observations.sites}
    speeds = dict(_speeds(stored, records, rows))
    views = []
    for path in shown:
        profile = profiles.get(path.path_id)
        recorded = [e for e in records.events if e.path_id == path.path_id]
        smooth = known.get(path.path_id)
        if smooth is None and profile is not None:
            smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
        mine = [e for e in events if e.path_id == path.path_id]
        views.append(
            PathView(
                path=path,
                profile=profile,
                smooth=smooth,
                release_x=None
                if smooth is None
                else release_place(smooth, path.release_elevation_m),
                events=tuple(mine) or tuple(event_view(e, smooth) for e in recorded),
                rows=_of(path, rows),
                notes=[]
                if profile is None or smooth is None
                else list(describe_path(path, profile, smooth, recorded).notes),
                speeds=speeds.get(path.path_id, []),
                alpha_beta=_of(path, alpha_beta),
                zones=next(iter(_of(path, zones)), None),
                plan=None if profile is None else _plan(profile, grounds.get(path.path_id)),
            )
        )
    return tuple(views)


def _of(path: Path, rows: Sequence[R]) -> list[R]:
    return [row for row in rows if row.path_id == path.path_id]


def _speeds(
    model: FittedModel, records: Records, rows: Sequence[HazardRow]
) -> Iterator[tuple[str, list[SpeedLine]]]:
    """By path, for each of its rows: the row, x and speed of the block of median friction."""
    values = model.layout.effect_values(model.draws.mean(axis=0))
    for path_id in dict.fromkeys(row.path_id for row in rows):
        mine = [row for row in rows if row.path_id == path_id]
        volumes = [row.volume_m3 or ANY_VOLUME_M3 for row in mine]
        events = [Event("", path_id=path_id, volume_m3=volume) for volume in volumes]
        future = classes_of(replace(of_path(records, path_id), events=tuple(events)))
        friction = model.median_friction(np.array(volumes), future.columns)
        resistance = model.resistance(future.site, values)
        lines = []
        for row, mu in zip(mine, friction, strict=True):
            if row.p_not_released > 0.5:
                continue
            found = run_site(future.site, float(mu), resistance).speeds
            places = np.array([[s.x_m, s.speed_m_s] for s in found])
            lines.append(SpeedLine(row, places[:, 0], places[:, 1]))
        yield path_id, lines


def _plan(profile: Profile, ground: TerrainCrop | None) -> PlanView | None:
    """The path from above, by its own coordinates; None where it has none."""
    some = np.unique(np.linspace(0, len(profile.x_m) - 1, MOST_PLACES).round().astype(int))
    if profile.easting_m is not None and profile.northing_m is not None:
        return PlanView(
            profile.x_m[some],
            profile.easting_m[some],
            profile.northing_m[some],
            profile.crs or "?",
            ground if ground is not None and ground.crs == profile.crs else None,
        )
    if profile.lon is not None and profile.lat is not None:
        return PlanView(profile.x_m[some], profile.lon[some], profile.lat[some], None)
    return None


QUANTILES = (0.05, 0.5, 0.95)


def event_views(events: tuple[Event, ...], model: FittedModel, mu: Floats) -> tuple[EventView, ...]:
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
    flat[:, model.layout.scatter] = LEAST_LOG_SCATTER
    stops = predict_stops(replace(model, draws=flat), RECORD_DRAWS, rng)
    noise = sigma * rng.standard_normal(stops.elevation.shape)
    elevation = np.where(stops.left, stops.elevation, stops.elevation + noise)
    elevation[model.observations.kind == LENGTH] = np.nan
    return elevation
