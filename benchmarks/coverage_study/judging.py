"""One world of the study: calibrated as a user would, and set against its truth."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from avahazard.hazard.exceedance import exceeded_runout, runout_spread
from avahazard.hazard.future_events import future_bounds
from avahazard.hazard.volume_frequency import Family, return_volume
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.samplers.calibrate import calibrate_model
from avahazard.inference.samplers.calibrated import Calibrated
from avahazard.inference.seeds import generator
from avahazard.workflow.frequencies import VolumeSource, volume_frequencies
from avahazard.workflow.future_events import forecast, path_avalanches
from avahazard.workflow.stored.model import StoredFit
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
    stored = stored_fit(found)
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
            ready = path_avalanches(
                stored, world.records, path_id, frequency.volumes(), world.seed, observations
            )
            b = runout_spread(ready, exceeded_runout(ready, YEARS)).x
            forecaster, (future_event,) = forecast(
                stored, world.records, [(path_id, returned.volume_m3)], observations
            )
            rng = generator(world.seed, "coverage", path_id)
            a = future_bounds(forecaster, future_event, 20_000, rng).x
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


def stored_fit(found: Calibrated) -> StoredFit:
    """The model as it would come from the database."""
    n_slots = found.coordinates.shape[2]
    return StoredFit(
        name="made",
        parent=None,
        specification=found.specification,
        facts=found.facts,
        method=found.method,
        paths=(),
        slots=found.slots,
        coordinates=found.coordinates.reshape(-1, n_slots),
        offsets={},
        grids=found.grids,
        own=(),
        fingerprint="",
        result={},
    )


def _or_none(x: float) -> float | None:
    return x if np.isfinite(x) else None
