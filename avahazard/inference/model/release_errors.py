"""Errors of release elevations, and what they do to the records of stops."""

from collections.abc import Mapping, Sequence

import numpy as np

from avahazard.arrays import Bools, Floats, Ints
from avahazard.effects.columns import RELEASE_SIGMA
from avahazard.effects.site import Site, release_place
from avahazard.physics.block import STOPPED
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.runout_curve import MU, RunoutCurve, tabulate
from avahazard.physics.terrain import MAX_CELL_M, build_terrain
from avahazard.records.collection import Event, Path
from avahazard.records.errors import AvahazardError


def stated_release_sigma(events: Sequence[Event], paths: Mapping[str, Path]) -> Floats:
    """Error (m) of each event's release elevation `[n_events]`: its own, else its path's, else 0.

    0 too where all that is known is H/L: what is off is then the ratio, not a height.
    Raises `AvahazardError` where it is stated and is no number of metres, 0 or more.
    """
    sigma = np.zeros(len(events))
    for i, event in enumerate(events):
        of_path = paths[event.path_id].covariates if event.path_id else {}
        value = event.covariates.get(RELEASE_SIGMA)
        value = of_path.get(RELEASE_SIGMA) if value is None else value
        if value is None:
            continue
        if not isinstance(value, int | float) or not 0.0 <= value < np.inf:
            raise AvahazardError(
                f"{RELEASE_SIGMA} of event {event.event_id} is '{value}'.",
                "It must be a number of metres, 0 or more: one standard deviation.",
            )
        sigma[i] = 0.0 if event.in_ratio else float(value)
    return sigma


def carried_error(
    stated: Floats,
    sites: Sequence[Site],
    path_index: Ints,
    release: Ints,
    on_line: Bools,
    in_x: Bools,
    observed: Floats,
    fall_height: Floats,
) -> Floats:
    """The errors `stated` of the releases (m), carried to what they move, `[2, n_events]`.

    To the record (m), and to the log of the friction under which the block runs beyond its profile.
    On the energy line L = H/μ without a profile (`on_line`); else `in_x` or in elevation.
    For an event beyond its profile, whose `observed` is nan, at the profile's end.
    """
    errors = np.zeros((2, len(stated)))
    line = on_line & (stated > 0.0)
    errors[0, line] = (stated * observed / fall_height)[line]
    for k, site in enumerate(sites):
        for coordinate in (True, False):
            selected = (path_index == k) & (in_x == coordinate) & (stated > 0.0)
            if np.any(selected):
                start = site.release_x[release[selected]]
                known = stated[selected], observed[selected]
                errors[:, selected] = on_site(site, start, *known, coordinate)
    return errors


def on_site(site: Site, release_x: Floats, sigma: Floats, observed: Floats, in_x: bool) -> Floats:
    """`carried_error` `[2, n]` of records on a site, in x or in elevation; nan is its end.

    `release_x` and `sigma` (m of elevation), `[n]` each, are where the blocks start. Half the
    difference between F from one σ higher and from one σ lower; where one of them does not start
    or runs beyond the profile, the difference to the other.
    """
    heights = site.smooth.height(release_x)
    places = np.array(
        [
            [release_place(site.smooth, float(z + s)), x, release_place(site.smooth, float(z - s))]
            for x, z, s in zip(release_x, heights, sigma, strict=True)
        ]
    )
    terrain = build_terrain(site.smooth, np.unique(places), MAX_CELL_M)
    starts = np.searchsorted(terrain.x, places.ravel())
    curves = tabulate(build_cells(terrain, no_resistance(terrain)), starts)
    record, leaving = errors = np.zeros((2, len(observed)))
    end = site.smooth.x_max if in_x else site.end_y
    for i, at in enumerate(np.where(np.isnan(observed), end, observed)):
        three = curves[3 * i : 3 * i + 3]
        leaving[i] = half_difference(*_leaving_frictions(three))
        value = np.where(three.status == STOPPED, three.x if in_x else three.y, np.nan)
        off = np.abs(value[1] - at)
        if np.isfinite(off).any():
            record[i] = half_difference(*value[:, int(np.nanargmin(off))])
    return errors


def half_difference(high: float, middle: float, low: float) -> float:
    """Of the outer two; where one is nan, of the other to the middle, whole; 0 without both."""
    if np.isfinite(high) and np.isfinite(low):
        return 0.5 * abs(high - low)
    known = [v for v in (high, low) if np.isfinite(v)]
    return abs(known[0] - middle) if known and np.isfinite(middle) else 0.0


def _leaving_frictions(curves: RunoutCurve) -> Floats:
    """Log friction `[n_curves]` with which blocks come to one place, the last that all reach.

    The edge of leaving itself is known to a step of the friction grid alone; nan where a block
    does not start.
    """
    stops = [np.flatnonzero(status == STOPPED) for status in curves.status]
    farthest = (np.max(x[of]) for x, of in zip(curves.x, stops, strict=True) if len(of))
    place = min(farthest, default=np.nan)
    found = np.full(len(curves.x), np.nan)
    for k, of in enumerate(stops):
        if len(of):
            rising = np.maximum.accumulate(curves.x[k, of[::-1]])
            found[k] = np.interp(place, rising, np.log(MU[of[::-1]]))
    return found
