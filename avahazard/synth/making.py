"""A world, from a seed to its records and its truth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace

import numpy as np
from numpy.typing import NDArray

from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.synth.effects import NEED_SPEEDS, Parameters, WorldEffect, find_effect
from avahazard.synth.integrator import LEFT_PROFILE
from avahazard.synth.observing import recorded_events, recorded_paths, recorded_speeds
from avahazard.synth.running import Runs, run_world
from avahazard.synth.settings import Settings, SitePlan
from avahazard.synth.sites import make_sites
from avahazard.synth.world import World, draw_world

SPARES = (1.2, 2.5, 5.0, 10.0, 20.0)


def make_world(
    seed: int,
    n_events: int = 240,
    n_paths: int = 9,
    effects: Mapping[str, float] | None = None,
    settings: Settings | None = None,
    sites: tuple[SitePlan, ...] | None = None,
    own_effects: Mapping[str, WorldEffect] | None = None,
) -> tuple[Records, dict[str, object]]:
    """Records of a world with known effects, and its truth (what `truth.json` holds).

    `effects` maps a key of the catalogue, or of `own_effects`, to its strength. `sites`
    gives the paths; without it they are made up. Same arguments, same result, bit for bit.
    Raises AvahazardError for an unknown effect, for too few events, and for a world whose
    avalanches do not start or are never seen.
    """
    settings = settings or Settings()
    effects = effects or {}
    own = own_effects or {}
    if sites is None:
        if n_paths < 1 or n_events < n_paths:
            raise AvahazardError(
                f"{n_events} events cannot be spread over {n_paths} paths.",
                "Ask for at least one path and as many events as paths.",
            )
        sites = make_sites(seed, n_paths, n_events)
    applied = {key: own.get(key) or find_effect(key) for key in effects}
    for spare in SPARES:
        world = draw_world(seed, sites, settings, spare)
        parameters = {key: apply(world, effects[key]) for key, apply in applied.items()}
        runs = run_world(world)
        kept = _first_seen(world, runs)
        if kept is not None:
            return _record(world, runs, kept, effects, parameters)
    raise AvahazardError(
        "Too few avalanches of this world start and are seen.",
        "Use weaker effects, a steeper release zone, or a smaller share of unseen events.",
    )


def _first_seen(world: World, runs: Runs) -> NDArray[np.int64] | None:
    """As many seen events of each site as it should have, by date; None when too few."""
    kept = []
    for k, site in enumerate(world.sites):
        seen = np.flatnonzero(runs.seen & (world.path == k))[: site.n_events]
        if len(seen) < site.n_events:
            return None
        kept.append(sorted(seen, key=lambda i: (world.dates[i], i)))
    return np.concatenate(kept).astype(np.int64)


def _record(
    world: World,
    runs: Runs,
    kept: NDArray[np.int64],
    effects: Mapping[str, float],
    parameters: Mapping[str, Parameters],
) -> tuple[Records, dict[str, object]]:
    ids: list[str] = []
    for site in world.sites:
        ids += [f"{site.path.path_id}-{j + 1:03d}" for j in range(site.n_events)]
    share = world.settings.speeds
    if share is None:
        share = 0.3 if any(effects.get(key, 0.0) for key in NEED_SPEEDS) else 0.0
    events, wrong = recorded_events(world, runs, kept, ids)
    records = Records(
        paths=recorded_paths(world, runs),
        profiles=tuple(s.profile for s in world.sites),
        events=events,
        speeds=recorded_speeds(world, runs, kept, ids, share),
    )
    return records, _truth(world, runs, kept, ids, wrong, effects, parameters, share)


def _truth(
    world: World,
    runs: Runs,
    kept: NDArray[np.int64],
    ids: list[str],
    wrong: NDArray[np.bool_],
    effects: Mapping[str, float],
    parameters: Mapping[str, Parameters],
    share: float,
) -> dict[str, object]:
    law = world.settings.law
    limits = {
        s.path.path_id: float(limit)
        for s, limit in zip(world.sites, runs.limit_m, strict=True)
        if np.isfinite(limit)
    }
    return {
        "seed": world.seed,
        "n_events": len(kept),
        "n_paths": len(world.sites),
        "law": {"name": type(law).__name__.lower(), **asdict(law)},
        "settings": {
            key: value
            for key, value in asdict(replace(world.settings, speeds=share)).items()
            if key != "law"
        },
        "effects": {
            key: {"strength": float(strength), "parameters": parameters[key]}
            for key, strength in effects.items()
        },
        "seen_below_m": limits,
        "events": [
            {
                "event_id": ids[j],
                "volume_m3": float(world.volume_m3[k]),
                "mu": float(runs.mu[k]),
                "mu_median": float(np.exp(world.log_mu[k])),
                "scatter": float(world.scatter[k]),
                "status": "left_profile" if runs.status[k] == LEFT_PROFILE else "stopped",
                "stop_x_m": float(runs.stop_x_m[k]),
                "front_x_m": float(runs.front_x_m[k]),
                "front_elevation_m": float(runs.front_elevation_m[k]),
                "wrong_record": bool(wrong[j]),
            }
            for j, k in enumerate(kept)
        ],
    }
