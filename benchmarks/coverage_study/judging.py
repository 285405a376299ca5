"""One world of the study: calibrated as a user would, and set against its truth."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from avahazard.hazard.exceedance import exceeded_runout
from avahazard.hazard.frequencies import VolumeSource, volume_frequencies
from avahazard.hazard.path_hazard import path_hazard
from avahazard.hazard.runout_bounds import spread
from avahazard.hazard.volume_bounds import volume_bounds
from avahazard.hazard.volume_frequency import return_volume
from avahazard.hazard.volume_region import Family
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.samplers.calibrate import calibrate_model
from avahazard.inference.seeds import generator
from benchmarks.coverage_study.world import (
    TrueWorld,
    exceeded_once,
    run_path,
    true_runouts,
    true_volumes,
)

YEARS = 100.0
FAMILIES: tuple[Family, ...] = ("gev", "gpd")
CHAINS, DRAWS = 2, 400


def judge(world: TrueWorld) -> dict[str, Any]:
    """The true runout of 100 years of each path, and the intervals of both ways."""
    started = time.monotonic()
    observations = build_observations(world.records)
    found = calibrate_model(
        observations, Specification(), {}, n_chains=CHAINS, n_draws=DRAWS, seed=world.seed
    )
    paths: list[dict[str, Any]] = []
    for k in range(len(world.sites)):
        path_id = world.sites[k].path.path_id
        runs = run_path(world, k)
        runouts = true_runouts(world, k, runs)
        share = -np.log1p(-1.0 / YEARS) / world.rates[k]
        volume = float(true_volumes(world, k, np.array([1.0 - share]))[0])
        line: dict[str, Any] = {
            "path_id": path_id,
            "n_events": world.sites[k].n_events,
            "end_x_m": float(world.sites[k].profile.x_m[-1]),
            "true_volume_m3": volume,
            "true_x_m": _or_none(exceeded_once(world, k, runouts, YEARS)),
            "true_of_volume_x_m": [
                _or_none(float(x))
                for x in np.quantile(
                    true_runouts(world, k, runs, np.full(100_000, volume)),
                    [0.05, 0.5, 0.95],
                    method="lower",
                )
            ],
        }
        for family in FAMILIES:
            frequencies = volume_frequencies(world.records, world.seed, VolumeSource(family))
            frequency = frequencies.of(path_id)
            returned = return_volume(frequency, YEARS)
            volumes, at = frequency.volumes(), returned.volume_m3
            path = path_hazard(
                *(found.model, world.records, path_id, volumes, [at]),
                event_columns=False,
                volume_matters=True,
                seed=world.seed,
            )
            b = spread(exceeded_runout(path.avalanches, YEARS))
            a = volume_bounds(path, at, 20_000, generator(world.seed, "coverage", path_id)).x
            line[family] = {
                "volume_m3": [returned.q05_m3, returned.volume_m3, returned.q95_m3],
                "a": [a.q05, a.q50, a.q95],
                "b": [b.q05, b.q50, b.q95],
            }
        paths.append(line)
    return {
        "seed": world.seed,
        "converged": found.chains.diagnostics.converged,
        "paths": paths,
        "seconds": time.monotonic() - started,
    }


def _or_none(x: float) -> float | None:
    return x if np.isfinite(x) else None
