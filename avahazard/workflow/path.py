"""One path: how its profile was regularised, and whether the block's assumptions hold there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.site import release_place, stop_place
from avahazard.notes import Note
from avahazard.physics.point_error import point_error
from avahazard.physics.smooth_profile import (
    SmoothProfile,
    block_length,
    legendre_profile,
    smooth_profile,
)
from avahazard.physics.terrain import build_terrain
from avahazard.records.event import Event
from avahazard.records.lookup import find_path, find_profile
from avahazard.records.path import Path, Profile
from avahazard.results.base import Rows
from avahazard.results.terrain import PathCheck, PathSummary, ProfileFit, Stretch
from avahazard.store.records import load_records, path_summaries
from avahazard.store.session import reading


def list_paths(database: str) -> Rows[PathSummary]:
    """Return one entry a path: its profile's size, its number of events, their volumes.

    Raises `AvahazardError` where the database cannot be used.
    """
    with reading(database) as session:
        return path_summaries(session)


CONTRADICTED = 2.0
"""A given error is contradicted by points that scatter this many times as far."""


def view_path(database: str, path_id: str, plot: FilePath | None = None) -> PathCheck:
    """Return a path with its profile's fit and checks.

    `rises` and `sharp_bends` list the stretches where the regularised path rises, and where its
    radius of curvature is below `flow_length_m` (the median deposit length of its events, None if
    none is known). `notes` says it in words. With `plot` a picture of the profile is written there.
    Raises `AvahazardError` where the database, the path or its profile is missing, or `plot` is not
    the name of a picture.
    """
    with reading(database) as session:
        records = load_records(session)
    path = find_path(records, path_id)
    profile = find_profile(records, path)
    events = [event for event in records.events if event.path_id == path_id]
    smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    check = describe_path(path, profile, smooth, events)
    if plot is not None:
        from avahazard.report.path_pictures import draw_path  # noqa: PLC0415 (matplotlib is slow)

        releases = [_release(smooth, path, event) for event in events] or [_release(smooth, path)]
        stops = [place for e in events if (place := stop_place(smooth, e)) is not None]
        draw_path(plot, path, profile, smooth, np.array(releases), np.array(stops))
    return check


def describe_path(
    path: Path, profile: Profile, smooth: SmoothProfile, events: list[Event]
) -> PathCheck:
    """Check a path whose profile was regularised as `smooth`; see `view_path`."""
    terrain = build_terrain(smooth)
    x = np.sort(np.concatenate([terrain.x, terrain.gauss_x.ravel()]))
    _, slope, bending = smooth.derivatives(x)
    curvature = np.abs(bending) / (1.0 + slope**2) ** 1.5
    radius = 1.0 / np.maximum(curvature, 1e-12)
    lengths = [e.deposit_length_m for e in events if e.deposit_length_m is not None]
    flow_length = float(np.median(lengths)) if lengths else None
    check = PathCheck(
        path_id=path.path_id,
        n_points=len(profile.x_m),
        n_events=len(events),
        fit=_fit(profile, smooth),
        monotone=bool(np.all(slope <= 0.0)),
        rises=stretches(x, slope > 0.0),
        min_curvature_radius_m=float(radius.min()),
        flow_length_m=flow_length,
        sharp_bends=Rows() if flow_length is None else stretches(x, radius < flow_length),
        drop_m=float(profile.y_m[0] - profile.y_m.min()),
        length_m=float(profile.x_m[-1] - profile.x_m[0]),
        notes=(),
    )
    return replace(check, notes=tuple(_notes(check)))


def _fit(profile: Profile, smooth: SmoothProfile) -> ProfileFit:
    estimate = point_error(profile.x_m, profile.y_m)
    posterior = smooth.posterior
    return ProfileFit(
        method=smooth.method,
        degree=smooth.degree,
        smoothing=smooth.smoothing,
        polynomial_rms_m=legendre_profile(profile.x_m, profile.y_m).rms_m,
        rms_m=smooth.rms_m,
        max_deviation_m=smooth.max_deviation_m,
        elevation_sigma_m=smooth.sigma_m,
        sigma_from=smooth.sigma_source,
        sigma_estimate_m=float(estimate.sigma[0]) if estimate.source == "estimated" else None,
        ground_sd_m=None if posterior is None else float(np.mean(posterior.sd(profile.x_m))),
        block_m=block_length(float(profile.x_m[-1] - profile.x_m[0])),
    )


def stretches(x: Floats, holds: NDArray[np.bool_]) -> Rows[Stretch]:
    """Return the first and last x of each run of places `[n]` where `holds` is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]])))
    pairs = zip(edges[::2], edges[1::2], strict=True)
    return Rows(Stretch(float(x[i]), float(x[j - 1])) for i, j in pairs)


def _notes(check: PathCheck) -> list[Note]:
    notes = []
    fit = check.fit
    sigma, estimate = fit.elevation_sigma_m, fit.sigma_estimate_m
    if fit.sigma_from == "assumed":
        notes.append(Note("error_assumed", n=check.n_points, sigma=sigma))
    elif fit.sigma_from == "given" and estimate is not None and estimate > CONTRADICTED * sigma:
        notes.append(Note("points_scatter", scatter=estimate, sigma=sigma))
    if not check.monotone:
        notes.append(Note("path_rises", places=_stretches(check.rises)))
    if check.sharp_bends:
        places = _stretches(check.sharp_bends)
        notes.append(Note("sharp_bends", length=check.flow_length_m, places=places))
    return notes


def _stretches(parts: Sequence[Stretch]) -> list[Note]:
    return [Note("stretch", first=part.from_x_m, last=part.to_x_m) for part in parts]


def _release(smooth: SmoothProfile, path: Path, event: Event | None = None) -> float:
    elevation = path.release_elevation_m
    if event is not None and event.release_elevation_m is not None:
        elevation = event.release_elevation_m
    return release_place(smooth, elevation)
