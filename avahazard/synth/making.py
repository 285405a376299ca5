"""A synthetic dataset, from a seed to its records and its truth."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace

import numpy as np
from scipy.integrate import cumulative_trapezoid

from avahazard.arrays import Bools, Floats, Ints
from avahazard.records.collection import Event, Path, Profile, Records, Speed
from avahazard.records.errors import AvahazardError
from avahazard.synth.dataset import (
    LEFT_PROFILE,
    NOT_RELEASED,
    Dataset,
    Settings,
    SitePlan,
    Sites,
    Track,
    draw_dataset,
    generator,
    run_track,
)
from avahazard.synth.effects import NEED_SPEEDS, Parameters, find_effect

SPACING_M = 15.0
FIRST_YEAR, LAST_YEAR = 1900, 2020
RUN_ON_M, RUN_ON_SPACING_M = 5000.0, 50.0
"""How far the last slope of a simulated path continues: rare avalanches stop there."""
BEND_M, VALLEY_SLOPE = 300.0, 0.03
"""Over what distance the run-out of a falling path flattens, and to which slope."""
MOST_RISE = 0.25
"""How far up a counter-slope rises at most, as a share of the drop: it stays below the release."""


def concave_profile(
    drop_m: float,
    top_m: float,
    slopes: tuple[float, float] = (1.0, 0.10),
    power: float = 1.5,
    waves: tuple[tuple[float, float, float], ...] = (),
    tail: tuple[float, float] = (0.0, 0.0),
) -> tuple[Floats, Floats]:
    """Profile points x, y `[n_points]` in metres of a path with a given drop.

    The slope falls from `slopes[0]` to `slopes[1]` as (1 - t)^power of the relative
    distance t. Each wave (amplitude, number over the path, phase) varies it in the middle
    of the path, which makes steps. `tail` (length in m, slope) follows the lowest point;
    a negative slope rises to the other side of the valley.
    """
    t = np.linspace(0.0, 1.0, 4001)
    slope = slopes[1] + (slopes[0] - slopes[1]) * (1.0 - t) ** power
    in_middle = np.clip((t - 0.12) / 0.1, 0.0, 1.0) * np.clip((0.9 - t) / 0.2, 0.0, 1.0)
    steps = sum((a * np.sin(2 * np.pi * (k * t + phase)) for a, k, phase in waves), np.zeros(4001))
    slope = slope * (1.0 + in_middle * steps)
    length = drop_m / float(np.trapezoid(slope, t))
    x = np.arange(0.0, length + tail[0] + SPACING_M, SPACING_M)
    # The slope bends over 150 m into that of the tail.
    into_tail = np.clip((x - length + 75.0) / 150.0, 0.0, 1.0) * (tail[0] > 0.0)
    at = np.interp(x / length, t, slope) * (1.0 - into_tail) + tail[1] * into_tail
    fall = cumulative_trapezoid(at, dx=SPACING_M, initial=0)
    return np.round(x, 1), np.round(top_m - fall, 3)


def make_sites(seed: int, n_paths: int, n_events: int) -> Sites:
    """`n_paths` paths with drops of 600 to 2000 m and about `n_events` / `n_paths` events each."""
    rng = generator(seed, "sites")
    weights = rng.lognormal(0.0, 0.4, n_paths)
    least = min(6, n_events // n_paths)
    counts = least + rng.multinomial(n_events - least * n_paths, weights / weights.sum())
    sections = rng.permutation(["channelled", "open"] * ((n_paths + 1) // 2))[:n_paths]
    return tuple(
        _make_site(rng, f"P{k + 1:02d}", str(sections[k]), int(counts[k])) for k in range(n_paths)
    )


def _make_site(rng: np.random.Generator, path_id: str, section: str, n_events: int) -> SitePlan:
    drop = float(rng.uniform(600.0, 2000.0))
    waves = tuple(
        (float(rng.uniform(0.02, 0.09)), float(rng.uniform(low, low + 1.5)), float(rng.uniform()))
        for low in (1.0, 2.5, 4.0)
    )
    counter_slope = rng.uniform() < 0.2
    x, y = concave_profile(
        drop,
        top_m=float(rng.uniform(2000.0, 2900.0)),
        slopes=(float(rng.uniform(0.95, 1.1)), float(rng.uniform(0.05, 0.12))),
        power=float(rng.uniform(1.3, 1.9)),
        waves=waves,
        tail=(float(rng.uniform(300.0, 500.0)), -0.12 if counter_slope else 0.06),
    )
    length, fall = float(x[-1]), float(y.max() - y.min())
    x, y = _run_on(x, y)
    cover = np.full(len(x), "open", dtype=object)
    if rng.uniform() < 0.65:
        first = rng.uniform(0.35, 0.6)
        t = x / length
        cover[(t > first) & (t < first + rng.uniform(0.1, 0.3))] = "forest"
    return SitePlan(
        path=Path(
            path_id,
            name=f"Synthetic path {path_id}",
            location="made up",
            orientation=str(rng.choice(["N", "NE", "E", "SE", "S", "SW", "W", "NW"])),
            section=section,
            catchment_ha=round(float(rng.lognormal(2.5, 0.6)), 1),
            observed_from=FIRST_YEAR,
            observed_to=LAST_YEAR,
        ),
        profile=Profile(path_id, x, y, land_cover=tuple(str(c) for c in cover)),
        n_events=n_events,
        volume_median_m3=float(rng.lognormal(np.log(7e4), 0.5)),
        drop_m=fall,
    )


def _run_on(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """The profile, and `RUN_ON_M` more of it; what was there stays as it was.

    Where it falls it flattens to the valley's floor; where it rises it goes on to rise, ever less,
    by `MOST_RISE` of the path's drop at most.
    """
    step = RUN_ON_SPACING_M
    more = np.arange(step, RUN_ON_M + step, step)
    last = float((y[-2] - y[-1]) / (x[-1] - x[-2]))
    if last >= 0.0:
        floor = min(last, VALLEY_SLOPE)
        slope = floor + (last - floor) * np.clip(1.0 - more / BEND_M, 0.0, 1.0)
    else:
        slope = last * np.exp(-more * (-last) / (MOST_RISE * float(y[0] - y[-1])))
    fall = np.cumsum(slope * step)
    return np.append(x, np.round(x[-1] + more, 1)), np.append(y, np.round(y[-1] - fall, 3))


@dataclass(frozen=True, slots=True)
class Runs:
    """What truly happened, arrays `[n_events]`.

    The front is `lead_m` ahead of the stop of the centre of mass. `speeds[k]` holds the
    speeds of the events of path k at its knots. `limit_m [n_paths]` is the elevation below
    which events of a path are seen, infinite where all are.
    """

    mu: Floats
    status: Ints
    stop_x_m: Floats
    front_x_m: Floats
    front_elevation_m: Floats
    speeds: list[Floats]
    seen: Bools
    limit_m: Floats


def run_dataset(dataset: Dataset) -> Runs:
    """Run every event; one that does not start is undetected too."""
    n, rng = len(dataset.path), dataset.generator("scatter")
    mu = np.exp(dataset.log_mu + dataset.scatter * rng.normal(size=n))
    status, stop = np.zeros(n, np.int64), np.zeros(n)
    front, elevation = np.zeros(n), np.zeros(n)
    told = [s.path.observed_below_m for s in dataset.sites]
    limit = np.array([np.inf if t is None else t for t in told])
    speeds = []
    for k, track in enumerate(dataset.tracks):
        selected = dataset.path == k
        release = track.place(dataset.release_elevation_m[selected])
        status[selected], stop[selected], u = run_track(track, release, mu[selected])
        speeds.append(u)
        front[selected] = ahead(track, stop[selected], dataset.lead_m[selected])
        elevation[selected] = track.elevation(front[selected])
        moved = selected & (status != NOT_RELEASED)
        if dataset.unseen_share > 0.0 and moved.any():
            limit[k] = np.round(np.quantile(elevation[moved], 1.0 - dataset.unseen_share))
    end = np.array([t.knots_m[-1] for t in dataset.tracks])[dataset.path]
    status[(front >= end) & (status != NOT_RELEASED)] = LEFT_PROFILE
    seen = (status != NOT_RELEASED) & (elevation <= limit[dataset.path])
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


SLOWEST_MEASURED_M_S = 8.0
N_PLACES = 9


def recorded_events(
    dataset: Dataset, runs: Runs, kept: Ints, ids: list[str]
) -> tuple[tuple[Event, ...], Bools]:
    """The records of the events `kept` (x where a path rises), and which are grossly wrong."""
    sigma = np.round(np.interp(dataset.years, [1905, 1975], [25.0, 10.0]), 2)
    place, in_x, wrong = _recorded_places(dataset, runs, sigma)
    relative = dataset.settings.volume_rel_sigma
    noise = dataset.generator("volume errors").normal(size=len(kept))
    volume = np.round(dataset.volume_m3[kept] * np.exp(relative * noise))
    length = np.round(dataset.deposit_length_m[kept], 1)
    width = np.round(0.3 * length, 1)
    events = []
    for j, k in enumerate(kept):
        left = bool(runs.status[k] == LEFT_PROFILE)
        found = None if left else round(float(place[k]), 2)
        events.append(
            Event(
                event_id=ids[j],
                path_id=dataset.sites[dataset.path[k]].path.path_id,
                date=dataset.dates[k].isoformat(),
                runout_elevation_m=None if in_x[k] else found,
                runout_x_m=found if in_x[k] else None,
                runout_sigma_m=float(sigma[k]),
                left_profile=left,
                release_elevation_m=float(dataset.release_elevation_m[k]),
                volume_m3=float(volume[j]),
                deposit_length_m=float(length[j]),
                deposit_width_m=float(width[j]),
                deposit_thickness_m=round(float(2 * volume[j] / (length[j] * width[j])), 3),
                volume_rel_sigma=relative,
                covariates={
                    name: str(c[k]) if c.dtype.kind == "U" else float(c[k])
                    for name, c in dataset.columns.items()
                },
            )
        )
    return tuple(events), wrong[kept]


def _recorded_places(dataset: Dataset, runs: Runs, sigma: Floats) -> tuple[Floats, Bools, Bools]:
    """Recorded coordinate of every event, whether it is x, and whether it is grossly wrong."""
    n = len(dataset.path)
    place, in_x = np.empty(n), np.zeros(n, bool)
    low, high = np.empty(n), np.empty(n)
    unit, blunder = dataset.generator("wrong records").uniform(size=(2, n))
    wrong = blunder < dataset.settings.wrong_share
    rng = dataset.generator("record errors")
    error = rng.normal(size=n)
    for k, (site, track) in enumerate(zip(dataset.sites, dataset.tracks, strict=True)):
        selected = dataset.path == k
        x = uphill(track, runs.front_x_m[selected], dataset.raised_m[selected])
        in_x[selected] = bool(np.any(np.diff(site.profile.y_m) >= 0.0))
        if in_x[selected].any():
            place[selected], low[selected], high[selected] = x, track.knots_m[0], track.knots_m[-1]
        else:
            y = site.profile.y_m
            place[selected], low[selected], high[selected] = track.elevation(x), y.min(), y.max()
    place = np.where(wrong, low + (high - low) * unit, place)
    written = place + sigma * error
    # Nobody writes down a place far off the path: such an error is drawn again.
    while len(off := np.flatnonzero((written < low - 2.9 * sigma) | (written > high))):
        written[off] = place[off] + sigma[off] * rng.normal(size=len(off))
    return written, in_x, wrong


def recorded_speeds(
    dataset: Dataset, runs: Runs, kept: Ints, ids: list[str], share: float
) -> tuple[Speed, ...]:
    """Speeds of a share of the events at up to nine places each, with errors of 1 to 2 m/s."""
    rng = dataset.generator("speeds")
    chosen = np.sort(rng.permutation(len(kept))[: round(share * len(kept))])
    found = []
    for j in chosen:
        k = int(kept[j])
        path = int(dataset.path[k])
        row = int(np.count_nonzero(dataset.path[:k] == path))
        speeds, knots = runs.speeds[path][row], dataset.tracks[path].knots_m
        usable = np.flatnonzero(
            (speeds >= SLOWEST_MEASURED_M_S) & np.isin(knots, dataset.sites[path].profile.x_m)
        )
        if not len(usable):
            continue
        picks = np.unique(np.linspace(0, len(usable) - 1, N_PLACES).round().astype(int))
        for i in usable[picks]:
            sigma = round(float(rng.uniform(1.0, 2.0)), 1)
            speed = round(float(max(speeds[i] + sigma * rng.normal(), 0.0)), 2)
            found.append(Speed(ids[j], speed, sigma, x_m=float(knots[i])))
    return tuple(found)


SPARES = (1.2, 2.5, 5.0, 10.0, 20.0)


def make_dataset(
    seed: int,
    n_events: int = 240,
    n_paths: int = 9,
    effects: Mapping[str, float] | None = None,
    settings: Settings | None = None,
    sites: Sites | None = None,
) -> tuple[Records, dict[str, object]]:
    """Records of a dataset with known effects, and its truth (what `truth.json` holds).

    `effects` maps a key of the catalogue to its strength. `sites` gives the paths; without it they
    are made up. Same arguments, same result, bit for bit. Raises AvahazardError for an unknown
    effect, for too few events, and for a dataset whose avalanches do not start or are never seen.
    """
    settings = settings or Settings()
    effects = effects or {}
    if sites is None:
        if n_paths < 1 or n_events < n_paths:
            raise AvahazardError(
                f"{n_events} events cannot be spread over {n_paths} paths.",
                "Ask for at least one path and as many events as paths.",
            )
        sites = make_sites(seed, n_paths, n_events)
    applied = {key: find_effect(key) for key in effects}
    for spare in SPARES:
        dataset = draw_dataset(seed, sites, settings, spare)
        parameters = {key: apply(dataset, effects[key]) for key, apply in applied.items()}
        runs = run_dataset(dataset)
        kept = _first_seen(dataset, runs)
        if kept is not None:
            return _record(dataset, runs, kept, effects, parameters)
    raise AvahazardError(
        "Too few avalanches of this dataset start and are detected.",
        "Use weaker effects, a steeper release zone, or a smaller share of undetected events.",
    )


def _first_seen(dataset: Dataset, runs: Runs) -> Ints | None:
    """As many seen events of each site as it should have, by date; None when too few."""
    kept = []
    for k, site in enumerate(dataset.sites):
        seen = np.flatnonzero(runs.seen & (dataset.path == k))[: site.n_events]
        if len(seen) < site.n_events:
            return None
        kept.append(sorted(seen, key=lambda i: (dataset.dates[i], i)))
    return np.concatenate(kept).astype(np.int64)


def _record(
    dataset: Dataset,
    runs: Runs,
    kept: Ints,
    effects: Mapping[str, float],
    parameters: Mapping[str, Parameters],
) -> tuple[Records, dict[str, object]]:
    sites = dataset.sites
    ids = [f"{s.path.path_id}-{j + 1:03d}" for s in sites for j in range(s.n_events)]
    share = dataset.settings.speeds
    if share is None:
        share = 0.3 if any(effects.get(key, 0.0) for key in NEED_SPEEDS) else 0.0
    events, wrong = recorded_events(dataset, runs, kept, ids)
    limits = {
        s.path.path_id: float(limit)
        for s, limit in zip(sites, runs.limit_m, strict=True)
        if np.isfinite(limit)
    }
    paths = tuple(s.path for s in sites)
    if dataset.limit_known:
        paths = tuple(replace(p, observed_below_m=limits.get(p.path_id)) for p in paths)
    speeds = recorded_speeds(dataset, runs, kept, ids, share)
    records = Records(paths, tuple(s.profile for s in sites), events, speeds)
    settings = asdict(replace(dataset.settings, speeds=share))
    truth = {
        "seed": dataset.seed,
        "n_events": len(kept),
        "n_paths": len(sites),
        "law": {"name": type(dataset.settings.law).__name__.lower(), **settings.pop("law")},
        "settings": settings,
        "effects": {
            key: {"strength": float(strength), "parameters": parameters[key]}
            for key, strength in effects.items()
        },
        "seen_below_m": limits,
        "events": [
            {
                "event_id": ids[j],
                "volume_m3": float(dataset.volume_m3[k]),
                "mu": float(runs.mu[k]),
                "mu_median": float(np.exp(dataset.log_mu[k])),
                "scatter": float(dataset.scatter[k]),
                "status": "left_profile" if runs.status[k] == LEFT_PROFILE else "stopped",
                "stop_x_m": float(runs.stop_x_m[k]),
                "front_x_m": float(runs.front_x_m[k]),
                "front_elevation_m": float(runs.front_elevation_m[k]),
                "wrong_record": bool(wrong[j]),
            }
            for j, k in enumerate(kept)
        ],
    }
    return records, truth
