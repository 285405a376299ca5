"""Synthetic datasets of effects that no catalogue lists, as folders of CSV files.

`python benchmarks/worlds.py make ARM SEED FOLDER` writes one; ARM is a name of `ARMS`, with
" + speeds" for 45 tracks of 9 measured speeds: `make "wet and large" 7 here`.  The folder has
paths, profiles, events and velocities of three quarters of the winters, `held_out/events.csv` of
the others, and `truth.json`.  `arms` in place of `make …` lists the names.

Seeds below 1000 are for building; those from 5000 on are for the final measurement alone.
Nothing here is shared with avahazard: the block is integrated by Runge and Kutta's method.
"""

from __future__ import annotations

import csv
import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, timedelta
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Force = Callable[["State"], Floats]

G = 9.81
STEP_M = 4.0
N_EVENTS, N_PATHS, HELD_OUT = 240, 9, 0.25
N_TRACKS, N_PLACES = 45, 9
FIRST_WINTER, LAST_WINTER, WINTER_DAYS = 1961, 2020, 150
RECORD_SIGMA_M, VOLUME_SIGMA, SCATTER = 15.0, 0.3, 0.10
SPEEDS = " + speeds"


@dataclass(frozen=True, slots=True)
class Terrain:
    """A path at nodes half a step apart, arrays `[n_nodes]`: slope is -dy/dx."""

    x: Floats
    y: Floats
    slope: Floats
    curvature: Floats


@dataclass(frozen=True, slots=True)
class State:
    """Where the blocks are and how fast, arrays `[n]` or numbers of the place; `path` is its
    number, `share` the part of the path above its flat end that lies behind."""

    path: int
    share: float
    elevation: float
    slope: float
    curvature: float
    speed: Floats
    load: Floats


@dataclass(slots=True)
class World:
    """Avalanches before they run, arrays `[n_events]`; an arm changes them in place.

    `release` is a node of the terrain, `order` which of its winter an avalanche is on its path,
    `days_since` the days since the last one there (inf: none). `force` is a resistance per mass
    (m/s²) beside friction.
    """

    rng: np.random.Generator
    terrains: list[Terrain]
    lengths_m: Floats
    path: Ints
    winter: Ints
    day: Ints
    volume_m3: Floats
    release: Ints
    order: Ints
    days_since: Floats
    columns: dict[str, NDArray[Any]]
    log_mu: Floats
    scatter: Floats
    force: Force | None = None
    path_columns: dict[str, NDArray[Any]] = field(default_factory=dict)
    student_df: float | None = None
    wrong_share: float = 0.0
    unseen_share: float = 0.0
    volume_sigma: float = VOLUME_SIGMA
    stated_volume_sigma: float = VOLUME_SIGMA
    stated_sigma_m: float = RECORD_SIGMA_M

    def level(self, column: str, level: str) -> Floats:
        """1 where a column has a level, else 0."""
        return (self.columns[column] == level).astype(float)


@dataclass(frozen=True, slots=True)
class Arm:
    """`change` hides something in a dataset and returns its parameters.

    `right` are keys that count as right, `right_with_speeds` those where speeds are measured
    (where they differ), `neutral` those that are part of the truth: neither right nor wrong.
    """

    change: Callable[[World], dict[str, Any]]
    right: tuple[str, ...] = ()
    neutral: tuple[str, ...] = ()
    right_with_speeds: tuple[str, ...] | None = None
    n_paths: int = N_PATHS


# --- what is hidden --------------------------------------------------------------------------


def nothing(_: World) -> dict[str, Any]:
    """The base model alone."""
    return {}


def by_speed(power: float, at_30: float) -> Callable[[World], dict[str, Any]]:
    """Resistance c u^power, of `at_30` m/s² at 30 m/s."""

    def change(world: World) -> dict[str, Any]:
        c = at_30 / 30.0**power
        world.force = lambda s: c * s.speed**power
        world.log_mu -= 0.2
        return {"form": "c u^power", "c": c, "power": power}

    return change


def above_a_speed(world: World) -> dict[str, Any]:
    """Drag above 28 m/s only."""
    drag, threshold = 0.006, 28.0
    world.force = lambda s: drag * np.maximum(s.speed**2 - threshold**2, 0.0)
    world.log_mu -= 0.1
    return {"form": "c (u^2 - u0^2)+", "c": drag, "u0": threshold}


def by_slope(world: World) -> dict[str, Any]:
    """Friction grows with the slope."""
    per_slope = 0.35
    world.force = lambda s: per_slope * max(s.slope - 0.3, 0.0) * s.load
    world.log_mu -= 0.15
    return {"form": "c (tan - t0)+ N", "c": per_slope, "t0": 0.3}


def in_a_band(world: World) -> dict[str, Any]:
    """A constant resistance in a band of elevation."""
    force, low, high = 3.0, 1700.0, 1850.0
    world.force = lambda s: np.full(len(s.speed), force * float(low < s.elevation < high))
    return {"form": "c in z1..z2", "c": force, "z1": low, "z2": high}


def in_a_bend(world: World) -> dict[str, Any]:
    """A narrow bend takes momentum on three of the paths; its curvature in plan is no record."""
    drag, half = 0.006, 0.04
    bent = {int(k): float(world.rng.uniform(0.35, 0.6)) for k in _most_used(world)[:6:2]}

    def force(s: State) -> Floats:
        there = s.path in bent and abs(s.share - bent[s.path]) < half
        return drag * float(there) * s.speed**2

    world.force = force
    return {"form": "c u^2 in stretches", "c": drag, "half": half, "places": bent}


def in_a_stretch(world: World) -> dict[str, Any]:
    """One path has a rough stretch."""
    force, low, high, of = 4.0, 0.35, 0.55, int(_most_used(world)[0])
    world.force = lambda s: np.full(
        len(s.speed), force * float(s.path == of and low < s.share < high)
    )
    return {"form": "c in a stretch", "c": force, "from": low, "to": high, "path": of}


def wet_and_large(world: World) -> dict[str, Any]:
    """Wet snow matters only in large avalanches."""
    large = 1.0 / (1.0 + np.exp(-4.0 * (np.log(world.volume_m3) - np.log(7e4))))
    world.log_mu += 0.36 * world.level("snow_type", "wet") * large
    return {"log_mu": 0.36, "above_m3": 7e4}


def level_and_level(world: World) -> dict[str, Any]:
    """Wet snow has more friction after a storm, less without."""
    wet, storm = world.level("snow_type", "wet"), world.level("weather", "storm")
    world.log_mu += 0.5 * (wet - wet.mean()) * (storm - storm.mean())
    return {"log_mu": 0.5, "of": "the product of centred indicators"}


def level_and_smooth(world: World) -> dict[str, Any]:
    """Friction falls with new snow, in dry snow alone."""
    new = np.asarray(world.columns["new_snow_cm"], float)
    world.log_mu -= 0.3 * world.level("snow_type", "dry") * np.tanh((new - 60.0) / 25.0)
    return {"log_mu": -0.3, "shape": "tanh((new_snow_cm - 60) / 25)"}


def both_beyond_limits(world: World) -> dict[str, Any]:
    """Friction is low where strong wind meets much new snow, and neither matters by itself."""
    new, wind = (np.asarray(world.columns[name], float) for name in ("new_snow_cm", "wind_m_s"))
    world.log_mu -= 0.26 * ((new > 50.0) & (wind > 6.0))
    return {"log_mu": -0.26, "new_snow_cm": 50.0, "wind_m_s": 6.0}


def line_beyond_a_limit(world: World) -> dict[str, Any]:
    """Friction falls with new snow where the wind is strong, and not elsewhere."""
    new, wind = (np.asarray(world.columns[name], float) for name in ("new_snow_cm", "wind_m_s"))
    world.log_mu -= 0.2 * (new - 40.0) / 30.0 * (wind > 6.0)
    return {"log_mu": -0.2, "per_cm": 30.0, "wind_m_s": 6.0}


def second_of_winter(world: World) -> dict[str, Any]:
    """A second avalanche in a winter runs on the first one's deposit."""
    world.log_mu -= 0.24 * (world.order > 1)
    return {"log_mu": -0.24}


def soon_after(world: World) -> dict[str, Any]:
    """Friction is low soon after the last avalanche on the path."""
    world.log_mu -= 0.4 * np.exp(-world.days_since / 20.0)
    return {"log_mu": -0.4, "days": 20.0}


def change_on_a_path(world: World) -> dict[str, Any]:
    """From some winter on one path has more friction."""
    of = int(_most_used(world)[0])
    year = int(np.median(world.winter[world.path == of]))
    world.log_mu += 0.4 * ((world.path == of) & (world.winter >= year))
    return {"log_mu": 0.4, "path": of, "winter": year}


def change_on_all(world: World) -> dict[str, Any]:
    """From the winter of 1992 on friction is higher."""
    world.log_mu += 0.18 * (world.winter >= 1992)
    return {"log_mu": 0.18, "winter": 1992}


def change_for_years(world: World) -> dict[str, Any]:
    """In the winters of 1978 to 1989 friction is higher."""
    world.log_mu += 0.22 * ((world.winter >= 1978) & (world.winter <= 1989))
    return {"log_mu": 0.22, "winters": [1978, 1989]}


def change_on_three(world: World) -> dict[str, Any]:
    """From the winter of 1990 on three of the paths have more friction."""
    paths = _most_used(world)[1:8:3]
    world.log_mu += 0.3 * (np.isin(world.path, paths) & (world.winter >= 1990))
    return {"log_mu": 0.3, "paths": paths.tolist(), "winter": 1990}


def wind_on_three(world: World) -> dict[str, Any]:
    """Friction falls with wind on three of the paths, and not elsewhere."""
    paths, wind = _most_used(world)[1:8:3], np.asarray(world.columns["wind_m_s"], float)
    world.log_mu -= 0.2 * np.isin(world.path, paths) * (wind - 7.0) / 4.0
    return {"log_mu": -0.2, "per_m_s": 4.0, "paths": paths.tolist()}


def wide_in_wet_snow(world: World) -> dict[str, Any]:
    """The scatter is three times as wide in wet snow."""
    world.scatter *= np.where(world.columns["snow_type"] == "wet", 2.1, 0.7)
    return {"dry": 0.7 * SCATTER, "wet": 2.1 * SCATTER}


def two_kinds(world: World) -> dict[str, Any]:
    """A second kind of avalanche that nobody recorded."""
    second = world.rng.uniform(size=len(world.path)) < 0.35
    world.log_mu -= 0.27 * second
    world.scatter *= 0.7
    return {"share": 0.35, "log_mu": -0.27, "second": second.astype(int).tolist()}


def heavy_tails(world: World) -> dict[str, Any]:
    """The scatter has the tails of Student's t."""
    world.student_df = 4.0
    return {"df": 4.0}


def storms(world: World) -> dict[str, Any]:
    """Avalanches come in storms of three days that share their snow."""
    n = len(world.path) // 10
    of = world.rng.choice(n, len(world.path), p=world.rng.dirichlet(np.full(n, 8.0)))
    world.winter = world.rng.integers(FIRST_WINTER, LAST_WINTER + 1, n)[of]
    world.day = world.rng.integers(0, WINTER_DAYS - 3, n)[of] + world.rng.integers(0, 3, len(of))
    world.log_mu += world.rng.normal(0.0, 0.1, n)[of]
    return {"sd": 0.1}


def winters(world: World) -> dict[str, Any]:
    """Winters differ."""
    by = world.rng.normal(0.0, 0.1, LAST_WINTER + 1 - FIRST_WINTER)
    world.log_mu += by[world.winter - FIRST_WINTER]
    return {"sd": 0.1}


def paths_differ(world: World) -> dict[str, Any]:
    """Paths differ, and have columns that do nothing."""
    n = len(world.terrains)
    world.path_columns["aspect"] = np.round(world.rng.uniform(0.0, 360.0, n))
    world.path_columns["area_ha"] = np.round(world.rng.lognormal(2.5, 0.6, n), 1)
    world.log_mu += world.rng.normal(0.0, 0.12, n)[world.path]
    return {"sd": 0.12}


def volume_errors(world: World) -> dict[str, Any]:
    """Volumes are worse than is stated."""
    world.volume_sigma, world.stated_volume_sigma = 1.0, 0.3
    return {"true": 1.0, "stated": 0.3}


def record_errors(world: World) -> dict[str, Any]:
    """Runouts are worse than is stated."""
    world.stated_sigma_m = 5.0
    return {"true": RECORD_SIGMA_M, "stated": 5.0}


def gross_errors(world: World) -> dict[str, Any]:
    """Some runouts are anywhere."""
    world.wrong_share = 0.15
    return {"share": 0.15}


def declared_limits(world: World) -> dict[str, Any]:
    """Short runouts go undetected, and the limits are stated."""
    world.unseen_share = 0.3
    return {"share": 0.3}


def _most_used(world: World) -> Ints:
    """Numbers of the paths, the one with most events first."""
    return np.argsort(-np.bincount(world.path, minlength=len(world.terrains)), kind="stable")


ON_A_PATH = ("path-effect",)
ARMS: dict[str, Arm] = {
    "force by u": Arm(by_speed(1.0, 2.0), ("force:speed", "turbulent-drag")),
    "force by u^1.5": Arm(by_speed(1.5, 2.0), ("force:speed", "turbulent-drag")),
    "force above a speed": Arm(above_a_speed, ("force:speed", "turbulent-drag")),
    "force by slope": Arm(by_slope, ("force:slope",)),
    "force in a band": Arm(in_a_band, ("force:elevation",), ("entrainment", *ON_A_PATH)),
    "force in a bend": Arm(
        in_a_bend, ("force:distance", *ON_A_PATH), ON_A_PATH, ("force:distance",)
    ),
    "force in a stretch": Arm(
        in_a_stretch, ("force:distance", "path:HERE", *ON_A_PATH), ON_A_PATH, ("force:distance",)
    ),
    "wet and large": Arm(wet_and_large, ("interaction:snow_type*volume",), ("snow-type",)),
    "wet after a storm": Arm(
        level_and_level, ("interaction:snow_type*weather",), ("snow-type", "covariate:weather")
    ),
    "new snow if dry": Arm(
        level_and_smooth,
        ("interaction:new_snow_cm*snow_type",),
        ("snow-type", "covariate:new_snow_cm"),
    ),
    "wind on new snow": Arm(
        both_beyond_limits,
        ("interaction:new_snow_cm*wind_m_s",),
        ("covariate:new_snow_cm", "covariate:wind_m_s"),
    ),
    "new snow if windy": Arm(
        line_beyond_a_limit,
        ("interaction:new_snow_cm*wind_m_s",),
        ("covariate:new_snow_cm", "covariate:wind_m_s"),
    ),
    "second of the winter": Arm(
        second_of_winter,
        ("covariate:order_in_winter", "covariate:days_since_last"),
        ("covariate:volume_in_winter",),
    ),
    "soon after the last": Arm(
        soon_after,
        ("covariate:days_since_last",),
        ("covariate:order_in_winter", "covariate:volume_in_winter"),
    ),
    "change on a path": Arm(change_on_a_path, ("change:HERE",), ("path:HERE", *ON_A_PATH)),
    "change on all paths": Arm(change_on_all, ("change:all",), ("covariate:year",)),
    "change for some years": Arm(change_for_years, ("change:years",), ("covariate:year",)),
    "change on three paths": Arm(change_on_three, ("change:several",), ("change:HERE", *ON_A_PATH)),
    "wind on three paths": Arm(
        wind_on_three, ("interaction:wind_m_s*path_id",), ("covariate:wind_m_s", *ON_A_PATH)
    ),
    "wide in wet snow": Arm(wide_in_wet_snow, ("scatter:snow_type",)),
    "two kinds": Arm(two_kinds, ("two-kinds",)),
    "null": Arm(nothing),
    "null: heavy tails": Arm(heavy_tails),
    "null: storms": Arm(storms, neutral=("storm-effect", "winter-effect")),
    "null: winters": Arm(winters, neutral=("winter-effect", "storm-effect")),
    "null: 2 paths": Arm(paths_differ, neutral=ON_A_PATH, n_paths=2),
    "null: 3 paths": Arm(paths_differ, neutral=ON_A_PATH, n_paths=3),
    "null: 4 paths": Arm(paths_differ, neutral=ON_A_PATH, n_paths=4),
    "null: paths differ": Arm(paths_differ, neutral=ON_A_PATH),
    "null: volume errors": Arm(volume_errors, neutral=("volume-error",)),
    "null: record errors": Arm(record_errors, neutral=("record-error",)),
    "null: gross errors": Arm(gross_errors),
    "null: declared limits": Arm(declared_limits),
}
"""By name; "HERE" in a key stands for the path on which something is hidden."""


# --- terrain and motion ----------------------------------------------------------------------


def draw_terrain(rng: np.random.Generator) -> tuple[Terrain, float]:
    """A path that flattens, with steps, and its length (m) down to its flat end of 4 km."""
    t = np.linspace(0.0, 1.0, 4001)
    top, power, flat = rng.uniform(1.0, 1.15), rng.uniform(1.3, 1.8), 0.03
    slope = flat + (top - flat) * (1.0 - t) ** power
    for k in (1.0, 2.5, 4.0):
        phase = 2.0 * np.pi * ((k + rng.uniform(0.0, 1.0)) * t + rng.uniform())
        slope = slope * (
            1.0 + rng.uniform(0.02, 0.08) * 16.0 * (t * (1.0 - t)) ** 2 * np.sin(phase)
        )
    length = float(rng.uniform(800.0, 1500.0) / np.trapezoid(slope, t))
    x = np.arange(0.0, length + 4000.0, STEP_M / 2.0)
    s = np.where(x < length, np.interp(x / length, t, slope), flat)
    fall = np.concatenate([[0.0], np.cumsum(0.5 * (s[1:] + s[:-1]) * STEP_M / 2.0)])
    curvature = -np.gradient(s, x) / (1.0 + s**2) ** 1.5
    return Terrain(x, rng.uniform(2350.0, 2600.0) - fall, s, curvature), length


def run(
    terrain: Terrain, release: Ints, mu: Floats, force: Force | None, path: int, length_m: float
) -> tuple[Floats, Floats]:
    """Stops x `[n]` (NaN: not released, inf: beyond the end) and u² `[n_nodes / 2, n]` of blocks.

    `release` are even numbers of nodes.
    """
    n, last = len(mu), (len(terrain.x) - 1) // 2 * 2
    w, moving, stop = np.zeros(n), np.zeros(n, bool), np.full(n, np.nan)
    kept = np.zeros((last // 2 + 1, n))

    def rate(i: int, w: Floats) -> Floats:
        s, w = terrain.slope[i], np.maximum(w, 0.0)
        arc = np.sqrt(1.0 + s * s)
        load = np.maximum(G / arc + terrain.curvature[i] * w, 0.0)
        pull = G * s / arc - mu * load
        if force is not None:
            at = (terrain.x[i] / length_m, terrain.y[i], s, terrain.curvature[i])
            pull = pull - force(State(path, *at, np.sqrt(w), load))
        return np.asarray(2.0 * arc * pull)

    for i in range(int(release.min()), last, 2):
        start = release == i
        if not (moving.any() or np.any(release >= i)):
            break
        moving = moving | start
        a = rate(i, w)
        b = rate(i + 1, w + 0.5 * STEP_M * a)
        c = rate(i + 1, w + 0.5 * STEP_M * b)
        d = rate(i + 2, w + STEP_M * c)
        new = w + STEP_M / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        over = moving & (new <= 0.0)
        ended = over & ~start
        part = w[ended] / np.maximum(w[ended] - new[ended], 1e-12)
        stop[ended] = terrain.x[i] + STEP_M * part
        moving = moving & ~over
        w = np.where(moving, new, 0.0)
        kept[i // 2 + 1] = w
    stop[moving] = np.inf
    return stop, kept


# --- a dataset -------------------------------------------------------------------------------


def draw_world(rng: np.random.Generator, n_paths: int) -> World:
    """The base dataset."""
    drawn = [draw_terrain(rng) for _ in range(n_paths)]
    n = N_EVENTS
    path = np.sort(rng.choice(n_paths, n, p=rng.dirichlet(np.full(n_paths, 12.0))))
    years = np.arange(FIRST_WINTER, LAST_WINTER + 1)
    winter = rng.choice(years, n, p=rng.dirichlet(np.ones(len(years))))
    day = rng.integers(0, WINTER_DAYS, n)
    while len(twice := _same_day(path, winter, day)):
        day[twice] = rng.integers(0, WINTER_DAYS, len(twice))
    release = np.empty(n, np.int64)
    for k, (terrain, length) in enumerate(drawn):
        steep = np.flatnonzero((terrain.slope > 0.8) & (terrain.x < 0.15 * length))
        steep = steep[steep % 2 == 0]
        release[path == k] = rng.choice(steep, int(np.sum(path == k)))
    median = np.exp(rng.normal(np.log(5e4), 0.4, n_paths))[path]
    volume = np.clip(median * np.exp(rng.normal(0.0, 0.9, n)), 2e3, 8e5)
    order, since = _memory(path, winter, day)
    degrees = np.minimum(rng.normal(-5.0, 3.0, n), 0.0)
    return World(
        rng=rng,
        terrains=[t for t, _ in drawn],
        lengths_m=np.array([length for _, length in drawn]),
        path=path,
        winter=winter,
        day=day,
        volume_m3=volume,
        release=release,
        order=order,
        days_since=since,
        columns={
            "snow_type": np.where(rng.uniform(size=n) < 0.4, "wet", "dry"),
            "weather": np.where(rng.uniform(size=n) < 0.5, "storm", "clear"),
            "snow_temperature_c": np.round(degrees, 1),
            "new_snow_cm": np.round(rng.gamma(4.0, 15.0, n)),
            "wind_m_s": np.round(rng.gamma(3.0, 2.3, n), 1),
        },
        log_mu=np.log(rng.uniform(0.42, 0.5)) - rng.uniform(3e-7, 9e-7) * volume,
        scatter=np.full(n, SCATTER),
    )


def _same_day(path: Ints, winter: Ints, day: Ints) -> Ints:
    """Events that have path and day of another before them."""
    key = (path * 10_000 + winter) * 1_000 + day
    _, first = np.unique(key, return_index=True)
    return np.setdiff1d(np.arange(len(key)), first)


def _memory(path: Ints, winter: Ints, day: Ints) -> tuple[Ints, Floats]:
    """Which of its winter on its path an event is, and the days since the last (inf: none)."""
    order, since = np.ones(len(path), np.int64), np.full(len(path), np.inf)
    dates = np.array([_date(w, d).toordinal() for w, d in zip(winter, day, strict=True)])
    for k in np.unique(path):
        at = np.flatnonzero(path == k)
        at = at[np.argsort(dates[at])]
        for before, now in pairwise(at):
            since[now] = dates[now] - dates[before]
            if winter[before] == winter[now]:
                order[now] = order[before] + 1
    return order, since


def _date(winter: int, day: int) -> date:
    return date(int(winter) - 1, 12, 1) + timedelta(int(day))


def run_all(world: World, rows: Ints, mu: Floats) -> tuple[Floats, list[Floats]]:
    """Stops `[n]` of the events `rows`, and u² by path."""
    stop, speeds = np.empty(len(rows)), []
    for k, terrain in enumerate(world.terrains):
        selected = world.path[rows] == k
        if not selected.any():
            speeds.append(np.zeros((1, 0)))
            continue
        release = world.release[rows[selected]]
        length = float(world.lengths_m[k])
        stop[selected], w = run(terrain, release, mu[selected], world.force, k, length)
        speeds.append(w)
    return stop, speeds


def drawn(arm: str, seed: int) -> tuple[World, dict[str, Any], Floats]:
    """The dataset of an arm before its avalanches run, what is hidden in it, and the shift of log
    friction `[n_events]` that this is."""
    name = arm.removesuffix(SPEEDS)
    rng = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(name.encode())]))
    world = draw_world(rng, ARMS[name].n_paths)
    before = world.log_mu.copy()
    return world, ARMS[name].change(world), world.log_mu - before


def make(arm: str, seed: int, folder: Path) -> dict[str, Any]:
    """Write a dataset of an arm; return its truth."""
    with_speeds, entry = arm.endswith(SPEEDS), ARMS[arm.removesuffix(SPEEDS)]
    world, parameters, _ = drawn(arm, seed)
    rng, n = world.rng, len(world.path)
    mu, stop = np.empty(n), np.full(n, np.nan)
    limit = np.full(entry.n_paths, np.inf)
    again = np.arange(n)
    for _ in range(100):  # what does not start, or is undetected, is drawn again
        unit = (
            rng.normal(size=len(again))
            if world.student_df is None
            else rng.standard_t(world.student_df, size=len(again))
        )
        mu[again] = np.exp(world.log_mu[again] + world.scatter[again] * unit)
        stop[again], _ = run_all(world, again, mu[again])
        elevation = _elevation(world, stop)
        if world.unseen_share and not np.isfinite(limit).any() and not np.isnan(stop).any():
            of = [elevation[world.path == k] for k in range(entry.n_paths)]
            limit = np.array([np.round(np.quantile(z, 1.0 - world.unseen_share)) for z in of])
        again = np.flatnonzero(np.isnan(stop) | (elevation > limit[world.path]))
        if not len(again):
            break
    assert not len(again), f"{arm}, seed {seed}: avalanches that do not start"
    here = f"P{int(parameters.get('path', -1)) + 1:02d}"
    keys = entry.right_with_speeds if with_speeds and entry.right_with_speeds else entry.right
    held_out = held_out_winters(rng, world.winter)
    truth = {
        "arm": arm,
        "seed": seed,
        "right": [key.replace("HERE", here) for key in keys],
        "neutral": [key.replace("HERE", here) for key in entry.neutral],
        "parameters": parameters,
    }
    _write(folder, world, mu, stop, limit, held_out, with_speeds, truth)
    return truth


def held_out_winters(rng: np.random.Generator, winter: Ints) -> NDArray[np.bool_]:
    """Events of winters that together have a quarter of the events: what an avalanche runs on is
    known in either part."""
    years, counts = np.unique(winter, return_counts=True)
    turn = rng.permutation(len(years))
    n = int(np.argmin(np.abs(np.cumsum(counts[turn]) - HELD_OUT * len(winter)))) + 1
    return np.isin(winter, years[turn[:n]])


def _elevation(world: World, x: Floats) -> Floats:
    out = np.empty(len(x))
    for k, t in enumerate(world.terrains):
        selected = world.path == k
        out[selected] = np.interp(x[selected], t.x, t.y)
    return out


def _write(
    folder: Path,
    world: World,
    mu: Floats,
    stop: Floats,
    limit: Floats,
    held_out: NDArray[np.bool_],
    with_speeds: bool,
    truth: dict[str, Any],
) -> None:
    """All files of a dataset."""
    rng, n = world.rng, len(world.path)
    ids = [f"P{k + 1:02d}-{j:03d}" for j, k in enumerate(world.path)]
    end = np.array([t.x[-1] for t in world.terrains])[world.path]
    wrong = rng.uniform(size=n) < world.wrong_share
    place = np.where(wrong, rng.uniform(0.2, 1.0, n) * world.lengths_m[world.path], stop)
    written = np.clip(place + RECORD_SIGMA_M * rng.normal(size=n), 0.0, end)
    left = ~np.isfinite(stop)
    volume = world.volume_m3 * np.exp(world.volume_sigma * rng.normal(size=n))
    events = [
        {
            "event_id": ids[j],
            "path_id": f"P{world.path[j] + 1:02d}",
            "date": _date(world.winter[j], world.day[j]).isoformat(),
            "runout_x_m": "" if left[j] else round(float(written[j]), 1),
            "runout_sigma_m": world.stated_sigma_m,
            "left_profile": int(left[j]),
            "release_elevation_m": round(
                float(world.terrains[world.path[j]].y[world.release[j]]), 2
            ),
            "volume_m3": round(float(volume[j])),
            "volume_rel_sigma": world.stated_volume_sigma,
            **{name: column[j] for name, column in world.columns.items()},
        }
        for j in range(n)
    ]
    paths = [
        {
            "path_id": f"P{k + 1:02d}",
            "observed_from": FIRST_WINTER - 1,
            "observed_to": LAST_WINTER,
            **({"observed_below_m": limit[k]} if np.isfinite(limit[k]) else {}),
            **{name: column[k] for name, column in world.path_columns.items()},
        }
        for k in range(len(world.terrains))
    ]
    profiles = [
        {"path_id": f"P{k + 1:02d}", "x_m": round(float(x), 1), "y_m": round(float(y), 3)}
        for k, t in enumerate(world.terrains)
        for x, y in zip(t.x[::5], t.y[::5], strict=True)
    ]
    (folder / "held_out").mkdir(parents=True, exist_ok=True)
    _rows(folder / "paths.csv", paths)
    _rows(folder / "profiles.csv", profiles)
    _rows(folder / "events.csv", [e for e, h in zip(events, held_out, strict=True) if not h])
    _rows(
        folder / "held_out" / "events.csv", [e for e, h in zip(events, held_out, strict=True) if h]
    )
    if with_speeds:
        _rows(folder / "velocities.csv", _speeds(world, mu, stop, np.flatnonzero(~held_out), ids))
    truth["events"] = {
        "event_id": ids,
        "volume_m3": np.round(world.volume_m3).tolist(),
        "mu": np.round(mu, 5).tolist(),
        "mu_median": np.round(np.exp(world.log_mu), 5).tolist(),
        "scatter": np.round(world.scatter, 4).tolist(),
        "stop_x_m": [None if not np.isfinite(x) else round(float(x), 2) for x in stop],
        "held_out": held_out.astype(int).tolist(),
    }
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")


def _speeds(
    world: World, mu: Floats, stop: Floats, rows: Ints, ids: Sequence[str]
) -> list[dict[str, Any]]:
    """Speeds of `N_TRACKS` of the events `rows` at places between release and stop."""
    rng, found = world.rng, []
    usable = rows[np.isfinite(stop[rows])]
    chosen = np.sort(rng.permutation(usable)[:N_TRACKS])
    _, squares = run_all(world, chosen, mu[chosen])
    for k, terrain in enumerate(world.terrains):
        x = terrain.x[::2]
        for row, j in enumerate(chosen[world.path[chosen] == k]):
            first = terrain.x[world.release[j]]
            for part in np.linspace(0.08, 0.92, N_PLACES):
                at = round(float(first + part * (stop[j] - first)), 1)
                u = float(np.sqrt(np.interp(at, x[: len(squares[k])], squares[k][:, row])))
                sigma = round(float(rng.uniform(1.0, 2.0)), 1)
                speed = round(max(u + sigma * float(rng.normal()), 0.0), 2)
                found.append(
                    {"event_id": ids[j], "x_m": at, "speed_m_s": speed, "speed_sigma_m_s": sigma}
                )
    return found


def _rows(file: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    with file.open("w", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
