"""The world before its avalanches run: what effects read and change."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import date, timedelta

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from avahazard.arrays import Floats
from avahazard.synth.integrator import Track, make_track
from avahazard.synth.settings import Settings, SitePlan, generator

WINTER_DAYS = 150
STEEP = 0.8  # the tangent of a slope on which nearly all of these avalanches start


@dataclass(slots=True)
class World:
    """All arrays `[n_events]` unless said; an effect changes them in place.

    There are more events than will be recorded, since some are not seen. `path` points
    into `sites` and `tracks`; `day` counts from 1 December; `log_mu` is the median of log
    friction and `scatter` the sd of what is added to it. `lead_m` is how far along the
    path the front is ahead of the centre of mass; `raised_m` how much too high a stop was
    written down; `unseen_share` the share of a path's events that stop too high to be seen,
    and `limit_known` whether its `observed_below_m` is told.
    """

    seed: int
    settings: Settings
    sites: tuple[SitePlan, ...]
    tracks: list[Track]
    path: NDArray[np.int64]
    volume_m3: Floats
    release_elevation_m: Floats
    day: NDArray[np.int64]
    dates: list[date]
    deposit_length_m: Floats
    log_mu: Floats
    scatter: Floats
    lead_m: Floats
    raised_m: Floats
    unseen_share: float
    limit_known: bool = True
    columns: dict[str, NDArray[np.float64] | NDArray[np.str_]] = field(default_factory=dict)

    @property
    def years(self) -> NDArray[np.int64]:
        """Calendar year of each event."""
        return np.array([d.year for d in self.dates])

    def generator(self, key: str) -> np.random.Generator:
        """Random numbers for one purpose."""
        return generator(self.seed, key)


def draw_world(seed: int, sites: tuple[SitePlan, ...], settings: Settings, spare: float) -> World:
    """The base world: events by path, their volumes, releases, dates and columns.

    `spare` is how many times the events of each site are drawn.
    """
    path = np.repeat(np.arange(len(sites)), [int(np.ceil(spare * s.n_events)) + 6 for s in sites])
    n = len(path)
    tracks = [
        make_track(s.profile.x_m, s.profile.y_m, s.profile.land_cover, settings.smooth_m)
        for s in sites
    ]
    volume = _draw_volumes(generator(seed, "volumes"), sites, path)
    release = _draw_releases(generator(seed, "releases"), sites, tracks, path)
    rng = generator(seed, "dates")
    first = np.array([s.path.observed_from or 1900 for s in sites])[path]
    last = np.array([s.path.observed_to or 2020 for s in sites])[path]
    day = rng.integers(0, WINTER_DAYS, n)
    # A winter is named by its January; its December belongs to the year before.
    winter = rng.integers(first + 1, last + 1)
    dates = [date(int(w) - 1, 12, 1) + timedelta(int(d)) for w, d in zip(winter, day, strict=True)]
    spread = np.exp(generator(seed, "deposits").normal(0.0, 0.5, n))
    world = World(
        seed=seed,
        settings=settings,
        sites=sites,
        tracks=tracks,
        path=path,
        volume_m3=volume,
        release_elevation_m=np.round(release, 1),
        day=day,
        dates=dates,
        deposit_length_m=10.0 * np.cbrt(volume) * spread,
        log_mu=settings.law.log_friction(volume),
        scatter=np.full(n, settings.scatter),
        lead_m=np.zeros(n),
        raised_m=np.zeros(n),
        unseen_share=settings.censored_share,
    )
    _draw_columns(world)
    return world


def _draw_volumes(
    rng: np.random.Generator, sites: tuple[SitePlan, ...], path: NDArray[np.int64]
) -> Floats:
    uniform = rng.uniform(size=len(path))
    volume = np.empty(len(path))
    for k, s in enumerate(sites):
        mine = path == k
        ends = np.log([s.volume_low_m3, s.volume_high_m3])
        low, high = ndtr((ends - np.log(s.volume_median_m3)) / s.volume_log_sd)
        z = ndtri(low + (high - low) * uniform[mine])
        volume[mine] = s.volume_median_m3 * np.exp(s.volume_log_sd * z)
        if s.pin_range:
            volume[np.flatnonzero(mine)[:2]] = s.volume_low_m3, s.volume_high_m3
    return volume


def _draw_releases(
    rng: np.random.Generator,
    sites: tuple[SitePlan, ...],
    tracks: list[Track],
    path: NDArray[np.int64],
) -> Floats:
    """Elevations of steep places near the top; the steepest of the upper half without such."""
    uniform = rng.uniform(size=len(path))
    release = np.empty(len(path))
    for k, (site, track) in enumerate(zip(sites, tracks, strict=True)):
        x, y = track.fine(2.0)
        slope, drop = track.slope(x), site.drop_m or float(y.max() - y.min())
        zone = (y >= y.max() - site.release_share * drop) & (y <= y.max() - 0.02 * drop)
        steep = np.flatnonzero(zone & (slope >= STEEP))
        if not len(steep):
            upper = np.flatnonzero(y >= y.max() - 0.5 * drop)
            steep = upper[slope[upper] >= np.quantile(slope[upper], 0.8)]
        mine = path == k
        release[mine] = y[steep[(uniform[mine] * len(steep)).astype(int)]]
    return release


def _draw_columns(world: World) -> None:
    n = len(world.path)
    snow = world.generator("snow").choice(["dry", "mixed", "wet"], size=n, p=[0.5, 0.2, 0.3])
    world.columns["snow_type"] = snow
    degrees = np.minimum(world.generator("temperature").normal(-6.0, 3.0, n), 0.0)
    world.columns["snow_temperature_c"] = np.asarray(np.round(degrees, 1), np.float64)
    for k in range(world.settings.decoys):
        rng = world.generator(f"decoy {k}")
        noise = rng.normal(size=n)
        name = f"decoy_{k + 1}"
        if k % 4 == 1:
            world.columns[name] = np.array(["x", "y", "z"])[rng.integers(0, 3, n)]
            continue
        followed = {2: np.log(world.volume_m3), 3: world.release_elevation_m}.get(k % 4)
        if followed is not None:
            noise = 0.7 * (followed - followed.mean()) / followed.std() + np.sqrt(0.51) * noise
        world.columns[name] = np.round(noise, 3)
