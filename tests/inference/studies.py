"""Small studies with every kind of record, for tests of the posterior."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from avahazard.effects.effect import Effect
from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Event, Path, Profile, Records, Speed

SNOW = ("dry", "wet", "dry", "mixed", "wet")


def profile(k: int) -> Profile:
    """A bowl that is a little steeper or flatter on each path, with forest in its middle."""
    x = np.linspace(0.0, 1900.0 + 40.0 * k, 96)
    y = 1000.0 + 60.0 * k - (0.78 + 0.02 * k) * x + 2e-4 * x**2
    cover = np.where((x > 700.0) & (x < 1200.0), "forest", "open")
    return Profile(f"P{k}", x, y, tuple(str(c) for c in cover))


@cache
def records(n_events: int = 36, n_paths: int = 6, speeds: bool = True) -> Records:
    """Events of every kind: stops by elevation and by place, left, straight, with speeds."""
    rng = np.random.default_rng(7)
    paths = tuple(
        Path(
            f"P{k}",
            section=("channelled", "open")[k % 2],
            observed_below_m=520.0 if k == 1 else None,
        )
        for k in range(n_paths)
    )
    profiles = tuple(profile(k) for k in range(n_paths))
    events, measured = [], []
    for i in range(n_events):
        k = i % n_paths
        path, points = paths[k], profiles[k]
        volume = float(np.exp(rng.normal(10.5, 1.0)))
        place = float(rng.uniform(0.6, 0.98) * points.x_m[-1])
        elevation = float(np.interp(place, points.x_m, points.y_m))
        event = Event(
            f"e{i:02d}",
            path.path_id,
            date=f"{1900 + 6 * (i // 2)}-0{1 + i // 2 % 4}-1{i % 9}",
            runout_elevation_m=elevation,
            runout_sigma_m=10.0 + i % 16,
            release_elevation_m=float(points.y_m[0]) - 10.0 * (i % 7),
            volume_m3=volume,
            volume_rel_sigma=0.3,
            deposit_length_m=30.0 + 2.0 * i,
            covariates={"snow_type": SNOW[(i // n_paths) % 5], "wind": float(rng.normal())},
        )
        if i % 9 == 4:
            event = replace(event, runout_elevation_m=None, runout_x_m=place)
        elif i % 9 == 5:
            event = replace(event, runout_elevation_m=None, left_profile=True)
        events.append(event)
        if speeds and i % 9 == 4:
            measured += [
                Speed(event.event_id, 28.0 - 8.0 * s, 3.0, x_m=(0.3 + 0.25 * s) * place)
                for s in range(2)
            ]
    events += [
        Event(
            f"s{i}",
            fall_height_m=500.0,
            runout_length_m=900.0 + 80.0 * i,
            volume_m3=2e4 * (1 + i),
            covariates={"snow_type": SNOW[i], "wind": float(i)},
        )
        for i in range(3)
    ]
    return Records(paths, profiles, tuple(events), tuple(measured))


@cache
def observations(n_events: int = 36, n_paths: int = 6, speeds: bool = True) -> Observations:
    """The records arranged for the likelihood."""
    return build_observations(records(n_events, n_paths, speeds))


def posterior(given: Observations, *effects: str, **settings: str) -> Posterior:
    """The posterior of a model on observations; `settings` are those of `Specification`."""
    specification, facts = with_effects(given, Specification(**settings), effects)  # type: ignore[arg-type]
    return assemble(given, specification, facts)


def near(model: Posterior, spread: float = 0.0, seed: int = 0, **values: float) -> np.ndarray:
    """Coordinates with plausible law and scatter, the rest neutral; `values` replace by name."""
    layout = model.layout
    u = np.array([s.mean if np.isnan(s.neutral) else s.neutral for s in layout.slots])
    named = {"log a": -0.8, "n in 1e-6/m3": 1.0, "log sigma": np.log(0.15), "tau": 0.6}
    named["log c in 1e5 m3"] = 2.0
    if not layout.log_scatter:
        named["log sigma"] = np.log(0.08)
    names = [s.name for s in layout.slots]
    for name, value in (named | values).items():
        if name in names:
            u[names.index(name)] = value
    u = u + spread * np.random.default_rng(seed).standard_normal(len(u))
    return np.clip(u, layout.low, layout.high)


def effect_of(model: Posterior, key: str) -> Effect:
    """The effect of that key in a model."""
    return next(e for e in model.effects if e.key == key)


def one_path(n_events: int, seed: int, sigma: float = 10.0, cut_m: float = 1900.0) -> Records:
    """Events on one bowl that follow the exponential law; volumes are exactly known.

    Those that pass `cut_m` are beyond the profile, which ends there.
    """
    rng = np.random.default_rng(seed)
    whole = profile(0)
    keep = whole.x_m <= cut_m
    points = Profile("P0", whole.x_m[keep], whole.y_m[keep])
    volume = np.exp(rng.normal(10.5, 1.0, n_events))
    mu = 0.45 * np.exp(-1e-6 * volume + 0.15 * rng.standard_normal(n_events))
    bare = tuple(
        Event(f"e{i}", "P0", volume_m3=float(v), volume_rel_sigma=1e-6, left_profile=True)
        for i, v in enumerate(volume)
    )
    path = Path("P0")
    given = build_observations(Records((path,), (points,), bare))
    table = posterior(given).nodes.predicted_at(np.empty(0))
    events = []
    for i, event in enumerate(bare):
        stop = float(np.interp(mu[i], MU, table.record[i]))
        if np.interp(mu[i], MU, table.status[i] == LEFT_PROFILE) >= 0.5:
            events.append(event)
            continue
        found = stop + sigma * float(rng.standard_normal())
        events.append(
            replace(event, left_profile=False, runout_elevation_m=found, runout_sigma_m=sigma)
        )
    return Records((path,), (points,), tuple(events))
