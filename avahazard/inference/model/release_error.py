"""What the error of a release elevation does to the record: dF/dz₀ times it.

The recorded stop is set against F(μ; z₀) from the release z₀ that the record tells. Where that is
off, the stop is off by what F changes: an error of the record, as far as the likelihood goes. It
is taken by the block without effects, at the friction that stops it at the record.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.columns import RELEASE_SIGMA
from avahazard.effects.site import Site, release_place
from avahazard.physics.block import LEFT_PROFILE, NOT_RELEASED, STOPPED
from avahazard.physics.cells import build_cells
from avahazard.physics.resistance import no_resistance
from avahazard.physics.runout_curve import tabulate
from avahazard.physics.terrain import MAX_CELL_M, build_terrain
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.path import Path


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


def release_sigma(
    stated: Floats,
    sites: Sequence[Site],
    path_index: NDArray[np.int64],
    release: NDArray[np.int64],
    observed: Floats,
    fall_height: Floats,
    *,
    straight: NDArray[np.bool_],
    in_x: NDArray[np.bool_],
) -> Floats:
    """The errors `stated` of the releases carried to the records (m), `[n_events]` each.

    On the energy line L = H/μ where `straight`; else in x where `in_x`, in elevation where not. 0
    for an event that left its profile, whose `observed` is nan.
    """
    result = np.zeros(len(stated))
    line = straight & (stated > 0.0)
    result[line] = (stated * observed / fall_height)[line]
    for k, site in enumerate(sites):
        for coordinate in (True, False):
            mine = (path_index == k) & (in_x == coordinate) & (stated > 0.0)
            mine &= np.isfinite(observed)
            if np.any(mine):
                start = site.release_x[release[mine]]
                result[mine] = on_site(site, start, stated[mine], observed[mine], coordinate)
    return result


def on_site(site: Site, release_x: Floats, sigma: Floats, observed: Floats, in_x: bool) -> Floats:
    """Error (m) of the records `observed` `[n]` on a site, in x or in elevation.

    `release_x` and `sigma` (m of elevation), `[n]` each, are where the blocks start. Half the
    difference between F from one σ higher and from one σ lower; where one of them does not start,
    the difference to the other.
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
    curve = tabulate(build_cells(terrain, no_resistance(terrain)), starts)
    end = site.smooth.x_max if in_x else float(site.terrain.y[-1])
    value = np.where(curve.status == LEFT_PROFILE, end, curve.x if in_x else curve.y)
    value = value.reshape(*places.shape, -1)
    status = curve.status.reshape(value.shape)
    found = np.zeros(len(observed))
    for i in range(len(observed)):
        off = np.abs(value[i, 1] - observed[i])
        off = np.where(status[i, 1] == STOPPED, off, np.inf)
        at = int(np.argmin(off))
        if not np.isfinite(off[at]):
            continue
        high, middle, low = value[i, :, at]
        started = status[i, :, at] != NOT_RELEASED
        if started[0] and started[2]:
            found[i] = 0.5 * abs(high - low)
        else:
            found[i] = abs((high if started[0] else low) - middle)
    return found
