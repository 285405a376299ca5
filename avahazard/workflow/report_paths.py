"""The paths for the report: the profile, the events, the bounds and the speeds of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.site import release_place
from avahazard.hazard.future_events import classes_of
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.notes import Note
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.lookup import of_path
from avahazard.records.path import Path, Profile, TerrainCrop
from avahazard.report.html.content import EventView, PathView, PlanView, SpeedLine
from avahazard.workflow.path import describe_path
from avahazard.workflow.report_events import event_view
from avahazard.workflow.runout import run_site

Rows = Sequence[Mapping[str, Any]]

MOST_PLACES = 200
ANY_VOLUME_M3 = 1e4
"""Stands for the volume where the model has no use for it."""


def path_views(
    stored: FittedModel,
    records: Records,
    events: Sequence[EventView],
    rows: Rows,
    alpha_beta: Rows,
    zones: Rows,
    grounds: Mapping[str, TerrainCrop],
) -> tuple[PathView, ...]:
    """The paths that the model was calibrated on or that have bounds, in the order of the store.

    `records` are all of the database; `events` are those of the calibration; `rows`, `alpha_beta`
    and `zones` are the documents of `hazard`, `alpha-beta` and `zones`, `grounds` the terrain by
    path.
    """
    bounded = {row["path_id"] for row in rows}
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
                notes=_notes(path, profile, smooth, recorded),
                speeds=[SpeedLine(*line) for line in speeds.get(path.path_id, ())],
                alpha_beta=_of(path, alpha_beta),
                zones=next(iter(_of(path, zones)), None),
                plan=None if profile is None else _plan(profile, grounds.get(path.path_id)),
            )
        )
    return tuple(views)


def _of(path: Path, rows: Rows) -> list[Mapping[str, Any]]:
    return [row for row in rows if row["path_id"] == path.path_id]


def _notes(
    path: Path, profile: Profile | None, smooth: SmoothProfile | None, events: list[Event]
) -> list[Note]:
    if profile is None or smooth is None:
        return []
    return list(describe_path(path, profile, smooth, events).notes)


def _speeds(
    model: FittedModel, records: Records, rows: Rows
) -> Iterator[tuple[str, list[tuple[Mapping[str, Any], Floats, Floats]]]]:
    """By path, for each of its rows: the row, x and speed of the block of median friction."""
    values = model.layout.effect_values(model.draws.mean(axis=0))
    for path_id in dict.fromkeys(row["path_id"] for row in rows):
        mine = [row for row in rows if row["path_id"] == path_id]
        volumes = [row["volume_m3"] or ANY_VOLUME_M3 for row in mine]
        events = [Event("", path_id=path_id, volume_m3=volume) for volume in volumes]
        future = classes_of(replace(of_path(records, path_id), events=tuple(events)))
        friction = model.median_friction(np.array(volumes), future.columns)
        resistance = model.resistance(future.site, values)
        lines = []
        for row, mu in zip(mine, friction, strict=True):
            if row["p_not_released"] > 0.5:
                continue
            found = run_site(future.site, float(mu), resistance).speeds
            places = np.array([[s.x_m, s.speed_m_s] for s in found])
            lines.append((row, places[:, 0], places[:, 1]))
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
