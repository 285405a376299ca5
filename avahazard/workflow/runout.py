"""One run of the block down a path, with its speeds: of a friction, or by a stored model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.effects.site import Site, path_site
from avahazard.hazard.future_events import FutureEvents, classes_of
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.prediction import extrapolation
from avahazard.physics.block import LEFT_PROFILE, STATUS_NAMES, run
from avahazard.physics.cells import Resistance, build_cells, no_resistance
from avahazard.physics.runout_curve import MU
from avahazard.physics.speed import speeds_along
from avahazard.records.collection import Event, Records, find_path, find_profile
from avahazard.report.picture import require_picture
from avahazard.results.base import Rows, finite
from avahazard.results.terrain import Runout, RunoutAt, RunoutJump, SpeedHere
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.requests import RunoutRequest
from avahazard.workflow.stored import limits_speed, load_stored, notes_of_fit

SPEED_EVERY_M, MOST_PLACES = 10.0, 100
"""Speeds are told about so far apart, at so many places at most."""


def run_block(database: str, path_id: str, request: RunoutRequest) -> Runout:
    """Run the block down a path from its release, by itself or with the effects of a model.

    By a model the friction is the posterior median of that of an event of the volume, unless it is
    given; effects on the motion are at their posterior means, for F and F' (`table`) too. `plot` is
    a picture of these, or else of the path with the run and its speeds. Raises `AvahazardError`
    where there is no such path, profile or model, or `plot` is not the name of a picture.
    """
    require_picture(request.plot)
    if request.model is not None:
        model, records = load_stored(database, request.model, request.effect_files)
    else:
        model = None
        with reading(database) as session:
            records = load_records(session)
    path = find_path(records, path_id)
    profile = find_profile(records, path)
    if model is None:
        assert request.mu is not None
        site, resistance = path_site(path, profile), None
        found = run_site(site, request.mu)
    else:
        # One event of that volume, from the path's own release.
        event = Event("", path_id=path_id, volume_m3=request.volume_m3)
        future = classes_of(Records((path,), (profile,), (event,)))
        site = future.site
        resistance = model.resistance(site, model.layout.effect_values(model.draws.mean(axis=0)))
        found = _by_model(model, future, resistance, request)
    if request.table:
        found = with_table(found, site, resistance)
    if request.plot is not None:
        from avahazard.report.path_pictures import draw_curve, draw_run  # noqa: PLC0415 (slow)

        if request.table:
            draw_curve(request.plot, found)
        else:
            drag = model is not None and limits_speed(model)
            draw_run(request.plot, site.smooth, found, drag=drag)
    return found


def _by_model(
    model: FittedModel, future: FutureEvents, resistance: Resistance, request: RunoutRequest
) -> Runout:
    mu, volume = request.mu, request.volume_m3
    source = "given" if mu is not None else "posterior median"
    if mu is None:
        mu = float(model.median_friction(np.array([volume]), future.columns)[0])
    notes = list(notes_of_fit(model))
    path_id = future.site.path.path_id
    if volume is not None and not model.ignores_volume:
        notes += extrapolation(model, path_id, volume).notes(path_id)
    found = run_site(future.site, mu, resistance)
    return replace(found, model=model.name, volume_m3=volume, mu_from=source, notes=tuple(notes))


def run_site(site: Site, mu: float, resistance: Resistance | None = None) -> Runout:
    """Run the block down a path from its first release; by itself without any effect."""
    resistance = no_resistance(site.terrain) if resistance is None else resistance
    terrain = site.terrain_for(resistance)
    cells = build_cells(terrain, resistance)
    start = terrain.node(site.release_x[0])
    stops = run(cells, np.array([start]), np.array([mu]))
    status = int(stops.status[0, 0])
    left = status == LEFT_PROFILE
    release_x = float(site.release_x[0])
    end = site.smooth.x_max if left else float(stops.x[0, 0])
    x = np.linspace(
        release_x, end, min(MOST_PLACES, int(np.ceil((end - release_x) / SPEED_EVERY_M)) + 1)
    )
    nodes = terrain.x[(terrain.x >= release_x) & (terrain.x <= end)]
    speeds = speeds_along(cells, start, np.array([mu]), np.concatenate([x, nodes]))[0]
    if not left:
        # At the stop itself the interpolation leaves a rest of rounding.
        speeds[len(x) - 1] = 0.0
    return Runout(
        path_id=site.path.path_id,
        mu=mu,
        status=STATUS_NAMES[status],
        release_x_m=release_x,
        release_elevation_m=float(site.smooth.height(release_x)),
        runout_x_m=None if left else end,
        runout_elevation_m=None if left else float(stops.y[0, 0]),
        speed_max_m_s=float(speeds.max()),
        lift_off_x_m=finite(stops.lift_off_x[0, 0]),
        speeds=Rows(
            SpeedHere(float(place), float(speed)) for place, speed in zip(x, speeds, strict=False)
        ),
    )


def with_table(found: Runout, site: Site, resistance: Resistance | None = None) -> Runout:
    """The run of a site with F(μ), its derivative and its jumps under the same resistance."""
    resistance = no_resistance(site.terrain) if resistance is None else resistance
    curve = site.table(site.cells(resistance))[0]
    dx, dy = curve.derivative()
    return replace(
        found,
        table=Rows(
            RunoutAt(
                mu=round(float(MU[j]), 6),
                runout_x_m=finite(curve.x[j]),
                runout_elevation_m=finite(curve.y[j]),
                status=STATUS_NAMES[curve.status[j]],
                dx_dmu_m=finite(dx[j]),
                dy_dmu_m=finite(dy[j]),
            )
            for j in range(len(MU))
        ),
        jumps=Rows(
            RunoutJump(
                mu_low=round(float(MU[j]), 6),
                mu_high=round(float(MU[j + 1]), 6),
                from_x_m=float(curve.x[j]),
                to_x_m=float(curve.x[j + 1]),
            )
            for j in np.flatnonzero(curve.jumps)
        ),
    )
