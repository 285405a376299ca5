"""One run of the block down a path, with its speeds: of a friction, or by a stored model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np

from avahazard.effects.site import Site, path_site
from avahazard.hazard.future_events import classes_of
from avahazard.inference.prediction import extrapolation
from avahazard.physics.block import LEFT_PROFILE, STATUS_NAMES, run
from avahazard.physics.cells import Resistance, build_cells, no_resistance
from avahazard.physics.runout_curve import MU
from avahazard.physics.speed import speeds_along
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.lookup import find_path, find_profile
from avahazard.report.picture import require_picture
from avahazard.results.base import Rows
from avahazard.results.terrain import Runout, RunoutAt, RunoutJump, SpeedHere
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.effects import own_effects
from avahazard.workflow.stored import load_stored, notes_of_fit

SPEED_EVERY_M, MOST_PLACES = 10.0, 100
"""Speeds are told about so far apart, at so many places at most."""


def run_path(
    database: str, path_id: str, mu: float, *, table: bool = False, plot: FilePath | None = None
) -> Runout:
    """Run the block of friction `mu` down a path from its release.

    With `table` F(μ) and F'(μ) are told as well. `plot` is a picture of these, or else of the path
    with the run and its speeds. Raises `AvahazardError` where the database, the path or its profile
    is missing, μ is not a positive number, or `plot` is not the name of a picture.
    """
    require_picture(plot)
    if not (np.isfinite(mu) and mu > 0.0):
        raise AvahazardError(f"The friction is {mu:g}.", "It must be a number over 0, such as 0.4.")
    with reading(database) as session:
        records = load_records(session)
    path = find_path(records, path_id)
    site = path_site(path, find_profile(records, path))
    found = run_site(site, mu)
    if table:
        found = with_table(found, site)
    if plot is not None:
        _draw(plot, site, found)
    return found


def run_model(
    database: str,
    path_id: str,
    name: str,
    *,
    volume_m3: float | None,
    mu: float | None = None,
    table: bool = False,
    plot: FilePath | None = None,
    effect_files: Sequence[FilePath] = (),
) -> Runout:
    """Run the block down a path with the effects of model `name`.

    The friction is the posterior median of that of an event of `volume_m3`, or `mu` where that is
    given; effects on the motion are at their posterior means, for `table` (F and F') too. `plot` as
    in `run_path`. Raises `AvahazardError` where there is no such model, path or profile, neither
    `mu` nor a volume over 0 is given, or `plot` is not the name of a picture.
    """
    require_picture(plot)
    if mu is None and not (volume_m3 is not None and np.isfinite(volume_m3) and volume_m3 > 0.0):
        raise AvahazardError("The volume must be a number over 0.", "Give it in m3: --volume 20000")
    model, records = load_stored(database, name, own_effects(database, name, effect_files))
    path = find_path(records, path_id)
    profile = find_profile(records, path)
    # One event of that volume, from the path's own release.
    event = Event("", path_id=path_id, volume_m3=volume_m3)
    future = classes_of(Records((path,), (profile,), (event,)))
    source = "given"
    if mu is None:
        assert volume_m3 is not None
        mu = float(model.median_friction(np.array([volume_m3]), future.columns)[0])
        source = "posterior median"
    site = future.site
    resistance = model.resistance(site, model.layout.effect_values(model.draws.mean(axis=0)))
    notes = list(notes_of_fit(model))
    if volume_m3 is not None and not model.ignores_volume:
        notes += extrapolation(model, path_id, volume_m3).notes(path_id)
    found = replace(
        run_site(site, mu, resistance),
        model=name,
        volume_m3=volume_m3,
        mu_from=source,
        notes=tuple(notes),
    )
    if table:
        found = with_table(found, site, resistance)
    if plot is not None:
        _draw(plot, site, found)
    return found


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
    lift_off = float(stops.lift_off_x[0, 0])
    return Runout(
        path_id=site.path.path_id,
        mu=mu,
        status=STATUS_NAMES[status],
        release_x_m=release_x,
        release_elevation_m=float(site.smooth.height(release_x)),
        runout_x_m=None if left else end,
        runout_elevation_m=None if left else float(stops.y[0, 0]),
        speed_max_m_s=float(speeds.max()),
        lift_off_x_m=lift_off if np.isfinite(lift_off) else None,
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
                runout_x_m=_finite(curve.x[j]),
                runout_elevation_m=_finite(curve.y[j]),
                status=STATUS_NAMES[curve.status[j]],
                dx_dmu_m=_finite(dx[j]),
                dy_dmu_m=_finite(dy[j]),
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


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _draw(file: FilePath, site: Site, found: Runout) -> None:
    from avahazard.report.path_pictures import draw_curve, draw_run  # noqa: PLC0415 (slow)

    if found.table is not None:
        draw_curve(file, found)
    else:
        draw_run(file, site.smooth, found)
