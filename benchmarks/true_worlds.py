"""Simulated datasets whose truth is drawn; their records are made by `avahazard.synth`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from avahazard.records.collection import Path, Profile, Records
from avahazard.synth.dataset import (
    LEFT_PROFILE,
    NOT_RELEASED,
    STEEP,
    Exponential,
    Settings,
    SitePlan,
    make_track,
    run_track,
)
from avahazard.synth.making import FIRST_YEAR, LAST_YEAR, concave_profile, make_dataset

Floats = NDArray[np.float64]

N_PATHS = 5
N_YEARS = LAST_YEAR - FIRST_YEAR + 1
N_AVALANCHES = 400_000
N_RELEASES = 10
MU = np.geomspace(0.1, 1.2, 240)
STEP_M = 5.0
PATHS_DIFFER, OF_STRENGTH_1 = "path-effect", 0.15


@dataclass(frozen=True, slots=True)
class TrueWorld:
    """Records, and what made them: the rate of each path and its site.

    `offsets` `[n_paths]` of log friction set the paths apart. The model has `effects`, and is
    calibrated on `told` where that is not all of `records`; hazard is of the year `as_of`.
    """

    seed: int
    records: Records
    sites: tuple[SitePlan, ...]
    rates: Floats
    settings: Settings
    offsets: Floats = field(default_factory=lambda: np.zeros(N_PATHS))
    effects: tuple[str, ...] = ()
    told: Records | None = None
    as_of: int | None = None


def true_world(seed: int, tau: float = 0.0, unseen: float = 0.0) -> TrueWorld:
    """Dataset number `seed`: friction law, scatter, rates, volumes and terrain are all drawn.

    Paths differ by `tau` (sd on log friction), and a share `unseen` of the avalanches of each
    stops above what is seen; the model then has the path effect.
    """
    rng = np.random.default_rng([seed, 2005])
    settings = Settings(
        law=Exponential(a=float(rng.uniform(0.42, 0.58)), n=float(rng.uniform(2e-7, 9e-7))),
        scatter=float(rng.uniform(0.08, 0.2)),
        volume_rel_sigma=float(rng.uniform(0.2, 0.5)),
    )
    log_sd = float(rng.uniform(0.7, 1.2))
    rates = rng.uniform(0.12, 0.5, N_PATHS)
    counts = np.maximum(rng.poisson((1.0 - unseen) * rates * N_YEARS), 3)
    sites = tuple(_site(rng, k, int(counts[k]), log_sd) for k in range(N_PATHS))
    settings = replace(settings, censored_share=unseen)
    effects = {PATHS_DIFFER: tau / OF_STRENGTH_1} if tau else {}
    records, truth = make_dataset(
        seed, int(counts.sum()), N_PATHS, effects, settings=settings, sites=sites
    )
    if not tau:
        return TrueWorld(seed, records, sites, rates, settings)
    told = truth["effects"][PATHS_DIFFER]["parameters"]["log_mu"]  # type: ignore[index]
    offsets = np.array([told[site.path.path_id] for site in sites])
    return TrueWorld(seed, records, sites, rates, settings, offsets, (PATHS_DIFFER,))


SPARSE_PATHS, SPARSE_FROM = 12, 1950


def sparse_world(seed: int) -> TrueWorld:
    """Paths with about five records each in 70 winters, which do not say when they were watched."""
    rng = np.random.default_rng([seed, 2042])
    settings = Settings(
        law=Exponential(a=float(rng.uniform(0.42, 0.58)), n=float(rng.uniform(2e-7, 9e-7))),
        scatter=float(rng.uniform(0.08, 0.2)),
        volume_rel_sigma=float(rng.uniform(0.2, 0.5)),
    )
    log_sd = float(rng.uniform(0.7, 1.2))
    rates, counts = np.zeros(SPARSE_PATHS), np.zeros(SPARSE_PATHS, int)
    while len(none := np.flatnonzero(counts == 0)):
        # What nobody recorded is no path of the data.
        rates[none] = rng.uniform(0.02, 0.12, len(none))
        counts[none] = rng.poisson(rates[none] * (LAST_YEAR - SPARSE_FROM))
    sites = tuple(
        _site(rng, k, int(n), log_sd, first_year=SPARSE_FROM) for k, n in enumerate(counts)
    )
    records, _ = make_dataset(seed, int(counts.sum()), SPARSE_PATHS, settings=settings, sites=sites)
    paths = (replace(path, observed_from=None, observed_to=None) for path in records.paths)
    records = replace(records, paths=tuple(paths))
    return TrueWorld(seed, records, sites, rates, settings, np.zeros(SPARSE_PATHS))


def denser_world(seed: int) -> TrueWorld:
    """Avalanches of earlier years were recorded more rarely; the true rate is that of the end."""
    world, rng = true_world(seed), np.random.default_rng([seed, 2043])
    growth = rng.uniform(0.005, 0.025)
    chance = rng.random(len(world.records.events))
    events = tuple(
        event
        for event, u in zip(world.records.events, chance, strict=True)
        if u < np.exp(growth * ((event.year or LAST_YEAR) - LAST_YEAR))
    )
    return replace(world, records=replace(world.records, events=events))


def drawn_ground(rng: np.random.Generator, tail_m: float) -> tuple[Floats, Floats]:
    """x and y (m) of a path as those of `synth`, with steps and a flat end of `tail_m`."""
    waves = tuple(
        (float(rng.uniform(0.02, 0.09)), float(rng.uniform(low, low + 1.5)), float(rng.uniform()))
        for low in (1.0, 2.5, 4.0)
    )
    return concave_profile(
        float(rng.uniform(600.0, 2000.0)),
        top_m=2600.0,
        slopes=(float(rng.uniform(0.95, 1.1)), float(rng.uniform(0.05, 0.12))),
        power=float(rng.uniform(1.3, 1.9)),
        waves=waves,
        tail=(tail_m, 0.03),
    )


def _site(
    rng: np.random.Generator, k: int, n_events: int, log_sd: float, first_year: int = FIRST_YEAR
) -> SitePlan:
    """A path whose end is long: its 100-year runout lies on it."""
    x, y = drawn_ground(rng, 4000.0)
    path_id = f"P{k + 1}"
    return SitePlan(
        path=Path(path_id, observed_from=first_year, observed_to=LAST_YEAR),
        profile=Profile(path_id, x, y),
        n_events=n_events,
        volume_median_m3=float(rng.lognormal(np.log(7e4), 0.5)),
        volume_log_sd=log_sd,
    )


@dataclass(frozen=True, slots=True)
class Runs:
    """Runs of path k from places of its release zone over `MU`, `[n_releases, n_friction]`."""

    stop: Floats
    held: NDArray[np.bool_]


def run_path(world: TrueWorld, k: int) -> Runs:
    """Run the block of path k by the integrator of `synth`; stops are inf past the end."""
    site = world.sites[k]
    track = make_track(site.profile.x_m, site.profile.y_m)
    x, y = track.fine(2.0)
    zone = (y >= y.max() - site.release_share * np.ptp(y)) & (y <= y.max() - 0.02 * np.ptp(y))
    steep = x[zone & (track.slope(x) >= STEEP)]
    assert len(steep)
    starts = steep[((np.arange(N_RELEASES) + 0.5) / N_RELEASES * len(steep)).astype(int)]
    runs = [run_track(track, np.full(len(MU), start), MU, STEP_M) for start in starts]
    status = np.array([run[0] for run in runs])
    stop = np.where(status == LEFT_PROFILE, np.inf, np.array([run[1] for run in runs]))
    return Runs(stop, status == NOT_RELEASED)


def true_runouts(world: TrueWorld, k: int, runs: Runs, volume_m3: Floats | None = None) -> Floats:
    """Runouts x (m) `[n]` of a great many avalanches of path k, inf past the end, in order.

    Volumes and scatter are drawn, or the volumes given.
    """
    settings = world.settings
    rng = np.random.default_rng([world.seed, k, 1])
    if volume_m3 is None:
        volume_m3 = true_volumes(world, k, rng.random(N_AVALANCHES))
    log_mu = settings.law.log_friction(volume_m3) + world.offsets[k]
    log_mu = log_mu + settings.scatter * rng.standard_normal(len(volume_m3))
    which = rng.integers(N_RELEASES, size=len(log_mu))
    runouts = np.empty(len(log_mu))
    for j, (stop, held) in enumerate(zip(runs.stop, runs.held, strict=True)):
        selected = which == j
        at = np.interp(log_mu[selected], np.log(MU), np.arange(len(MU)))
        low = np.minimum(at.astype(int), len(MU) - 2)
        part = at - low
        with np.errstate(invalid="ignore"):
            between = stop[low] * (1.0 - part) + stop[low + 1] * part
        near = stop[np.rint(at).astype(int)]
        found = np.where(np.isfinite(between), between, near)
        # What does not move is no avalanche: it is not in the rate either.
        runouts[selected] = np.where(held[np.rint(at).astype(int)], np.nan, found)
    return np.sort(runouts[~np.isnan(runouts)])


def true_volumes(world: TrueWorld, k: int, probability: Floats) -> Floats:
    """Volumes (m3) of path k that a share `probability` of its avalanches stays under."""
    site = world.sites[k]
    ends = np.log([site.volume_low_m3, site.volume_high_m3]) - np.log(site.volume_median_m3)
    low, high = ndtr(ends / site.volume_log_sd)
    z = ndtri(low + (high - low) * probability)
    return np.asarray(site.volume_median_m3 * np.exp(site.volume_log_sd * z))


def exceeded_once(world: TrueWorld, k: int, runouts: Floats, years: float) -> float:
    """The runout x (m) that a year exceeds with chance 1/years, of ordered `runouts`."""
    share = -np.log1p(-1.0 / years) / world.rates[k]
    return float(runouts[max(0, int(np.floor((1.0 - share) * len(runouts))))])


TAU = 0.12
"""Paths differ by so much (sd on log friction)."""
UNSEEN, LEFT = 0.3, 1.0 / 3.0


def with_a_third_left(seed: int) -> TrueWorld:
    """Profiles for the calibration end where a third of the records lie beyond.

    The runout of 100 years is then given on the whole profile.
    """
    world = true_world(seed)
    profiles = tuple(_cut(world.records, p) for p in world.records.profiles)
    ends = {p.path_id: p for p in profiles}
    events = []
    for event in world.records.events:
        profile = ends[event.path_id or ""]
        beyond = event.left_profile
        if event.runout_elevation_m is not None:
            beyond = event.runout_elevation_m < profile.y_m[-1]
        if event.runout_x_m is not None:
            beyond = event.runout_x_m > profile.x_m[-1]
        place = {"runout_elevation_m": None, "runout_x_m": None, "left_profile": True}
        events.append(replace(event, **place) if beyond else event)  # type: ignore[arg-type]
    told = Records(world.records.paths, profiles, tuple(events), world.records.speeds)
    return replace(world, told=told)


def _cut(records: Records, profile: Profile) -> Profile:
    """The profile up to where two thirds of its records lie."""
    selected = [e for e in records.events if e.path_id == profile.path_id]
    places = []
    for event in selected:
        x = event.runout_x_m
        if event.runout_elevation_m is not None:
            x = float(np.interp(-event.runout_elevation_m, -profile.y_m, profile.x_m))
        places.append(profile.x_m[-1] if x is None else x)
    end = float(np.quantile(places, 1.0 - LEFT))
    n = max(int(np.searchsorted(profile.x_m, end)), 3)
    cover = None if profile.land_cover is None else profile.land_cover[:n]
    return replace(profile, x_m=profile.x_m[:n], y_m=profile.y_m[:n], land_cover=cover)


PLAIN, SPARSE, DENSER, AS_OF = "plain", "sparse", "denser", "denser as of"
ARMS: dict[str, Callable[[int], TrueWorld]] = {
    PLAIN: true_world,
    "paths differ": lambda seed: true_world(seed, tau=TAU),
    "limit of sight": lambda seed: true_world(seed, unseen=UNSEEN),
    "a third left": with_a_third_left,
    SPARSE: sparse_world,
    DENSER: denser_world,
    AS_OF: lambda seed: replace(denser_world(seed), as_of=LAST_YEAR),
}
