"""Paths: how profiles were regularised, what the block assumes, a run of it, and α-β runouts."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.covariate import unknown_values
from avahazard.effects.site import Site, path_site, release_place, stop_place
from avahazard.hazard.alpha_beta import REGRESSIONS, alpha_beta
from avahazard.hazard.future_events import FutureEvents, classes_of
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.prediction import extrapolation
from avahazard.notes import Note
from avahazard.physics import smooth_profile as smoothing
from avahazard.physics.block import LEFT_PROFILE, STATUS_NAMES, run
from avahazard.physics.cells import Resistance, build_cells, no_resistance
from avahazard.physics.runout_curve import MU
from avahazard.physics.speed import speeds_along
from avahazard.physics.terrain import build_terrain
from avahazard.records.collection import (
    Event,
    Path,
    Profile,
    Records,
    find_path,
    find_profile,
    no_profiles,
)
from avahazard.report.picture import require_picture
from avahazard.results import terrain as results
from avahazard.results.base import Rows, finite
from avahazard.workflow.requests import RunoutRequest
from avahazard.workflow.stored import limits_speed, load_stored, notes_of_fit, records_of

CONTRADICTED = 2.0
"""A given error is contradicted by points that scatter this many times as far."""


def view_path(database: str, path_id: str, plot: FilePath | None = None) -> results.PathCheck:
    """Return a path with its profile's fit and checks.

    `rises` and `sharp_bends` list the stretches where the regularised path rises, and where its
    radius of curvature is below `flow_length_m` (the median deposit length of its events, None if
    none is known). `plot` is a picture of the profile. Raises `AvahazardError` where the database,
    the path or its profile is missing, or `plot` is not the name of a picture.
    """
    records = records_of(database)
    path = find_path(records, path_id)
    profile = find_profile(records, path)
    events = [event for event in records.events if event.path_id == path_id]
    smooth = smoothing.smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    check = describe_path(path, profile, smooth, events)
    if plot is not None:
        from avahazard.report.plots import draw_path  # noqa: PLC0415 (matplotlib is slow)

        own = path.release_elevation_m
        starts = [own if e.release_elevation_m is None else e.release_elevation_m for e in events]
        releases = [release_place(smooth, elevation) for elevation in starts or [own]]
        stops = [place for e in events if (place := stop_place(smooth, e)) is not None]
        draw_path(plot, path, profile, smooth, np.array(releases), np.array(stops))
    return check


def describe_path(
    path: Path, profile: Profile, smooth: smoothing.SmoothProfile, events: Sequence[Event]
) -> results.PathCheck:
    """Check a path whose profile was regularised as `smooth`; see `view_path`."""
    terrain = build_terrain(smooth)
    x = np.sort(np.concatenate([terrain.x, terrain.gauss_x.ravel()]))
    _, slope, bending = smooth.derivatives(x)
    curvature = np.abs(bending) / (1.0 + slope**2) ** 1.5
    radius = 1.0 / np.maximum(curvature, 1e-12)
    lengths = [e.deposit_length_m for e in events if e.deposit_length_m is not None]
    flow_length = float(np.median(lengths)) if lengths else None
    check = results.PathCheck(
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


def _fit(profile: Profile, smooth: smoothing.SmoothProfile) -> results.ProfileFit:
    estimate = smoothing.point_error(profile.x_m, profile.y_m)
    posterior = smooth.posterior
    return results.ProfileFit(
        method=smooth.method,
        degree=smooth.degree,
        smoothing=smooth.smoothing,
        polynomial_rms_m=smoothing.legendre_profile(profile.x_m, profile.y_m).rms_m,
        rms_m=smooth.rms_m,
        max_deviation_m=smooth.max_deviation_m,
        elevation_sigma_m=smooth.sigma_m,
        sigma_from=smooth.sigma_source,
        sigma_estimate_m=float(estimate.sigma[0]) if estimate.source == "estimated" else None,
        ground_sd_m=None if posterior is None else float(np.mean(posterior.sd(profile.x_m))),
        block_m=smoothing.block_length(float(profile.x_m[-1] - profile.x_m[0])),
    )


def stretches(x: Floats, holds: NDArray[np.bool_]) -> Rows[results.Stretch]:
    """Return the first and last x of each run of places `[n]` where `holds` is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]])))
    pairs = zip(edges[::2], edges[1::2], strict=True)
    return Rows(results.Stretch(float(x[i]), float(x[j - 1])) for i, j in pairs)


def _notes(check: results.PathCheck) -> list[Note]:
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


def _stretches(parts: Sequence[results.Stretch]) -> list[Note]:
    return [Note("stretch", first=part.from_x_m, last=part.to_x_m) for part in parts]


def alpha_beta_paths(database: str, path_id: str | None = None) -> Rows[results.TerrainRunout]:
    """Return the α-β runout by each of `REGRESSIONS`, for one path or all that have a profile.

    Raises `AvahazardError` where the database, the path or its profile are missing.
    """
    records = records_of(database)
    with_profile = {profile.path_id for profile in records.profiles}
    paths = [path for path in records.paths if path.path_id in with_profile]
    if path_id is not None:
        paths = [find_path(records, path_id)]
    if not paths:
        raise no_profiles()
    rows = []
    for path in paths:
        profile = find_profile(records, path)
        smooth = smoothing.smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
        release_x = release_place(smooth, path.release_elevation_m)
        rows += [alpha_beta(path.path_id, smooth, release_x, by) for by in REGRESSIONS]
    return Rows(rows)


SPEED_EVERY_M, MOST_PLACES = 10.0, 100
"""Speeds are reported about so far apart, at so many places at most."""


def run_block(database: str, path_id: str, request: RunoutRequest) -> results.Runout:
    """Run the block down a path from its release, by itself or with the effects of a model.

    By a model the friction is the posterior median of that of an event of the volume, unless it is
    given; effects on the motion are at their posterior means, for F and F' (`table`) too. `plot` is
    a picture of these, or else of the path with the run and its speeds. Raises `AvahazardError`
    where there is no such path, profile or model, or `plot` is not the name of a picture.
    """
    require_picture(request.plot)
    model = None
    if request.model is not None:
        model, records = load_stored(database, request.model, request.effect_files)
    else:
        records = records_of(database)
    path = find_path(records, path_id)
    profile = find_profile(records, path)
    if model is None:
        assert request.mu is not None
        site = path_site(path, profile)
        resistance = no_resistance(site.terrain)
        found = run_site(site, request.mu, resistance)
    else:
        # One event of that volume, from the path's own release.
        event = Event("", path_id=path_id, volume_m3=request.volume_m3)
        future = classes_of(Records((path,), (profile,), (event,)), model.columns)
        site = future.site
        resistance = model.resistance(site, model.layout.effect_values(model.draws.mean(axis=0)))
        found = _by_model(model, future, resistance, request)
    if request.table:
        found = with_table(found, site, resistance)
    if request.plot is not None:
        from avahazard.report.plots import draw_curve, draw_run  # noqa: PLC0415 (slow)

        if request.table:
            draw_curve(request.plot, found)
        else:
            drag = model is not None and limits_speed(model)
            draw_run(request.plot, site.smooth, found, drag=drag)
    return found


def _by_model(
    model: FittedModel, future: FutureEvents, resistance: Resistance, request: RunoutRequest
) -> results.Runout:
    mu, volume = request.mu, request.volume_m3
    source = "given" if mu is not None else "posterior median"
    notes, path_id = list(notes_of_fit(model)), future.site.path.path_id
    if mu is None:
        mu = float(model.median_friction(np.array([volume]), future.columns)[0])
        at = [
            f"{entry.column} = {note.values['level']}"
            for entry in model.definitions
            if entry.column is not None and not entry.uses_volume
            for note in unknown_values(entry.column, model.facts[entry.key], future.columns)
        ]
        notes += [Note("mu_at", values=at)] if at else []
    if volume is not None and not model.ignores_volume:
        notes += extrapolation(model, path_id, volume, path_id)
    found = run_site(future.site, mu, resistance)
    return replace(found, model=model.name, volume_m3=volume, mu_from=source, notes=tuple(notes))


def run_site(site: Site, mu: float, resistance: Resistance) -> results.Runout:
    """Run the block down a path from its first release."""
    terrain = site.terrain_for(resistance)
    cells = build_cells(terrain, resistance)
    start = terrain.node(site.release_x[0])
    stops = run(cells, np.array([start]), np.array([mu]))
    status = int(stops.status[0, 0])
    left = status == LEFT_PROFILE
    release_x = float(site.release_x[0])
    end = site.smooth.x_max if left else float(stops.x[0, 0])
    n_places = min(MOST_PLACES, int(np.ceil((end - release_x) / SPEED_EVERY_M)) + 1)
    x = np.linspace(release_x, end, n_places)
    nodes = terrain.x[(terrain.x >= release_x) & (terrain.x <= end)]
    speeds = speeds_along(cells, start, np.array([mu]), np.concatenate([x, nodes]))[0]
    if not left:
        # At the stop itself the interpolation leaves a rest of rounding.
        speeds[len(x) - 1] = 0.0
    return results.Runout(
        path_id=site.path.path_id,
        mu=mu,
        status=STATUS_NAMES[status],
        release_x_m=release_x,
        release_elevation_m=float(site.smooth.height(release_x)),
        runout_x_m=None if left else end,
        runout_elevation_m=None if left else float(stops.y[0, 0]),
        speed_max_m_s=float(speeds.max()),
        lift_off_x_m=finite(stops.lift_off_x[0, 0]),
        speeds=Rows(map(results.SpeedHere, x.tolist(), speeds.tolist())),
    )


def with_table(found: results.Runout, site: Site, resistance: Resistance) -> results.Runout:
    """The run of a site with F(μ), its derivative and its jumps under the same resistance."""
    curve = site.table(site.cells(resistance))[0]
    mu = [round(value, 6) for value in MU.tolist()]
    x, y, dx, dy = (list(map(finite, of)) for of in (curve.x, curve.y, *curve.derivative()))
    status = [STATUS_NAMES[k] for k in curve.status]
    jumps = [
        results.RunoutJump(mu[j], mu[j + 1], float(curve.x[j]), float(curve.x[j + 1]))
        for j in np.flatnonzero(curve.jumps)
    ]
    return replace(
        found, table=Rows(map(results.RunoutAt, mu, x, y, status, dx, dy)), jumps=Rows(jumps)
    )
