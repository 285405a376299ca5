"""The avalanches of a world run down, and some of them are seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.synth.integrator import LEFT_PROFILE, NOT_RELEASED, run_track
from avahazard.synth.track import Track
from avahazard.synth.world import World


@dataclass(frozen=True, slots=True)
class Runs:
    """What truly happened, arrays `[n_events]`.

    The front is `lead_m` ahead of the stop of the centre of mass. `speeds[k]` holds the
    speeds of the events of path k at its knots. `limit_m [n_paths]` is the elevation below
    which events of a path are seen, infinite where all are.
    """

    mu: Floats
    status: NDArray[np.int64]
    stop_x_m: Floats
    front_x_m: Floats
    front_elevation_m: Floats
    speeds: list[Floats]
    seen: NDArray[np.bool_]
    limit_m: Floats


def run_world(world: World) -> Runs:
    """Run every event; one that nothing sets moving is not seen either."""
    n, rng = len(world.path), world.generator("scatter")
    df = world.settings.student_df
    unit = rng.normal(size=n) if df is None else rng.standard_t(df, size=n)
    mu = np.exp(world.log_mu + world.scatter * unit)
    status, stop = np.zeros(n, np.int64), np.zeros(n)
    front, elevation = np.zeros(n), np.zeros(n)
    told = [s.path.observed_below_m for s in world.sites]
    limit = np.array([np.inf if t is None else t for t in told])
    speeds = []
    for k, track in enumerate(world.tracks):
        mine = world.path == k
        release = track.place(world.release_elevation_m[mine])
        status[mine], stop[mine], u = run_track(track, release, mu[mine])
        speeds.append(u)
        front[mine] = ahead(track, stop[mine], world.lead_m[mine])
        elevation[mine] = track.elevation(front[mine])
        moved = mine & (status != NOT_RELEASED)
        if world.unseen_share > 0.0 and moved.any():
            limit[k] = np.round(np.quantile(elevation[moved], 1.0 - world.unseen_share))
    end = np.array([t.knots_m[-1] for t in world.tracks])[world.path]
    status[(front >= end) & (status != NOT_RELEASED)] = LEFT_PROFILE
    seen = (status != NOT_RELEASED) & (elevation <= limit[world.path])
    return Runs(mu, status, stop, front, elevation, speeds, seen, limit)


def ahead(track: Track, x_m: Floats, lead_m: Floats) -> Floats:
    """x of the place a length (m) further along the path; at most the end of the profile."""
    x, y = track.fine()
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    there = np.interp(np.interp(x_m, x, arc) + lead_m, arc, x)
    return np.where(lead_m == 0.0, x_m, there)


def uphill(track: Track, x_m: Floats, rise_m: Floats) -> Floats:
    """x of the first place back up the path that is higher by `rise_m`."""
    x, y = track.fine()
    out = np.array(x_m, float)
    lowest = int(np.argmin(y))
    for j in np.flatnonzero(rise_m > 0.0):
        i = min(int(np.searchsorted(x, x_m[j])), lowest)
        higher = np.flatnonzero(y[: i + 1] >= y[i] + rise_m[j])
        out[j] = x[higher[-1]] if len(higher) else x[0]
    return out
