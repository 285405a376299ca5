"""One world of the study: calibrated as a user would, and set against its truth."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from avahazard.hazard.avalanches import Avalanches
from avahazard.hazard.exceedance import exceeded_runout
from avahazard.hazard.frequencies import VolumeSource, known_volumes, volume_frequencies
from avahazard.hazard.path_hazard import path_hazard
from avahazard.hazard.runout_bounds import spread
from avahazard.hazard.volume_bounds import volume_bounds
from avahazard.hazard.volume_frequency import return_volume
from avahazard.hazard.volume_region import Family
from avahazard.inference.likelihood.assemble import with_effects
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
PERIODS = (10.0, 30.0, 100.0, 300.0)
FAMILIES: tuple[Family, ...] = ("gev", "gpd")
CHAINS, DRAWS = 2, 400


def judge(world: TrueWorld, families: Sequence[Family] = FAMILIES) -> dict[str, Any]:
    """The true runout of 100 years of each path, and the intervals of both ways.

    `rising`: whether no quantile of the design runout falls as T rises.
    """
    started = time.monotonic()
    observations = build_observations(world.records if world.told is None else world.told)
    specification, facts = with_effects(observations, Specification(), world.effects)
    found = calibrate_model(
        observations, specification, facts, n_chains=CHAINS, n_draws=DRAWS, seed=world.seed
    )
    # The bounds are asked for on the whole profile, which the calibration may not have had.
    model = found.model if world.told is None else found.model.on(build_observations(world.records))
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
        for family in families:
            known = known_volumes(world.records)
            frequencies = volume_frequencies(known, world.seed, VolumeSource(family))
            frequency = frequencies.of(path_id)
            returned = return_volume(frequency, YEARS)
            volumes, at = frequency.volumes(), returned.volume_m3
            path = path_hazard(
                *(model, world.records, path_id, volumes, [at]),
                event_columns=False,
                volume_matters=True,
                seed=world.seed,
            )
            b, rising = design(path.avalanches)
            a = volume_bounds(path, at, 20_000, generator(world.seed, "coverage", path_id)).x
            line[family] = {
                "volume_m3": [returned.q05_m3, returned.volume_m3, returned.q95_m3],
                "a": [a.q05, a.q50, a.q95],
                "b": b,
                "rising": rising,
            }
        paths.append(line)
    return {
        "seed": world.seed,
        "converged": found.chains.diagnostics.converged,
        "paths": paths,
        "seconds": time.monotonic() - started,
    }


def design(avalanches: Avalanches) -> tuple[list[float | None], bool]:
    """5, 50 and 95 % of the design runout of 100 years, and whether it rises with T."""
    by_period = {}
    for years in PERIODS:
        found = spread(exceeded_runout(avalanches, years))
        by_period[years] = [found.q05, found.q50, found.q95]
    table = np.array([[np.inf if q is None else q for q in row] for row in by_period.values()])
    with np.errstate(invalid="ignore"):  # from beyond the end to beyond the end
        rising = not np.any(np.diff(table, axis=0) < 0.0)
    return by_period[YEARS], rising


def _or_none(x: float) -> float | None:
    return x if np.isfinite(x) else None
