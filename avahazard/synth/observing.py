"""From what happened to what was written down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.records.event import Event, Speed
from avahazard.records.path import Path
from avahazard.synth.integrator import LEFT_PROFILE
from avahazard.synth.running import Runs, uphill
from avahazard.synth.world import World

SLOWEST_MEASURED_M_S = 8.0
N_PLACES = 9


def record_sigma(years: NDArray[np.int64]) -> Floats:
    """sd of a recorded place: 25 m before 1905, falling linearly to 10 m in 1975 and after."""
    return np.round(np.interp(years, [1905, 1975], [25.0, 10.0]), 2)


def recorded_paths(world: World, runs: Runs) -> tuple[Path, ...]:
    """The paths, with the limit of sight where it is known."""
    if not world.limit_known:
        return tuple(s.path for s in world.sites)
    return tuple(
        replace(s.path, observed_below_m=float(limit)) if np.isfinite(limit) else s.path
        for s, limit in zip(world.sites, runs.limit_m, strict=True)
    )


def recorded_events(
    world: World, runs: Runs, kept: NDArray[np.int64], ids: list[str]
) -> tuple[tuple[Event, ...], NDArray[np.bool_]]:
    """The records of the events `kept`, and which of them are grossly wrong.

    On a path that rises anywhere an elevation is not one place: there x is recorded.
    """
    sigma = record_sigma(world.years)
    place, in_x, wrong = _recorded_places(world, runs, sigma)
    relative = world.settings.volume_rel_sigma
    noise = world.generator("volume errors").normal(size=len(kept))
    volume = np.round(world.volume_m3[kept] * np.exp(relative * noise))
    length = np.round(world.deposit_length_m[kept], 1)
    width = np.round(0.3 * length, 1)
    events = []
    for j, k in enumerate(kept):
        left = bool(runs.status[k] == LEFT_PROFILE)
        found = None if left else round(float(place[k]), 2)
        events.append(
            Event(
                event_id=ids[j],
                path_id=world.sites[world.path[k]].path.path_id,
                date=world.dates[k].isoformat(),
                runout_elevation_m=None if in_x[k] else found,
                runout_x_m=found if in_x[k] else None,
                runout_sigma_m=float(sigma[k]),
                left_profile=left,
                release_elevation_m=float(world.release_elevation_m[k]),
                volume_m3=float(volume[j]),
                deposit_length_m=float(length[j]),
                deposit_width_m=float(width[j]),
                deposit_thickness_m=round(float(2 * volume[j] / (length[j] * width[j])), 3),
                volume_rel_sigma=relative,
                covariates={
                    name: str(c[k]) if c.dtype.kind == "U" else float(c[k])
                    for name, c in world.columns.items()
                },
            )
        )
    return tuple(events), wrong[kept]


def _recorded_places(
    world: World, runs: Runs, sigma: Floats
) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    """Recorded coordinate of every event, whether it is x, and whether it is grossly wrong."""
    n = len(world.path)
    place, in_x = np.empty(n), np.zeros(n, bool)
    low, high = np.empty(n), np.empty(n)
    unit, blunder = world.generator("wrong records").uniform(size=(2, n))
    wrong = blunder < world.settings.wrong_share
    rng = world.generator("record errors")
    error = rng.normal(size=n)
    for k, (site, track) in enumerate(zip(world.sites, world.tracks, strict=True)):
        mine = world.path == k
        x = uphill(track, runs.front_x_m[mine], world.raised_m[mine])
        in_x[mine] = bool(np.any(np.diff(site.profile.y_m) >= 0.0))
        if in_x[mine].any():
            place[mine], low[mine], high[mine] = x, track.knots_m[0], track.knots_m[-1]
        else:
            y = site.profile.y_m
            place[mine], low[mine], high[mine] = track.elevation(x), y.min(), y.max()
    place = np.where(wrong, low + (high - low) * unit, place)
    written = place + sigma * error
    # Nobody writes down a place far off the path: such an error is drawn again.
    while len(off := np.flatnonzero((written < low - 2.9 * sigma) | (written > high))):
        written[off] = place[off] + sigma[off] * rng.normal(size=len(off))
    return written, in_x, wrong


def recorded_speeds(
    world: World, runs: Runs, kept: NDArray[np.int64], ids: list[str], share: float
) -> tuple[Speed, ...]:
    """Speeds of a share of the events at up to nine places each, with errors of 1 to 2 m/s."""
    rng = world.generator("speeds")
    chosen = np.sort(rng.permutation(len(kept))[: round(share * len(kept))])
    found = []
    for j in chosen:
        k = int(kept[j])
        path = int(world.path[k])
        row = int(np.count_nonzero(world.path[:k] == path))
        speeds, knots = runs.speeds[path][row], world.tracks[path].knots_m
        usable = np.flatnonzero(
            (speeds >= SLOWEST_MEASURED_M_S) & np.isin(knots, world.sites[path].profile.x_m)
        )
        if not len(usable):
            continue
        picks = np.unique(np.linspace(0, len(usable) - 1, N_PLACES).round().astype(int))
        for i in usable[picks]:
            sigma = round(float(rng.uniform(1.0, 2.0)), 1)
            speed = round(float(max(speeds[i] + sigma * rng.normal(), 0.0)), 2)
            found.append(Speed(ids[j], speed, sigma, x_m=float(knots[i])))
    return tuple(found)
