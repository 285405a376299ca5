"""Which part of a design runout misses its truth: volumes, middle or scatter of friction.

… benchmarks/coverage_parts.py "paths differ" 1 12     worlds 1 to 12 of an arm of the study

Each part in turn is given its truth, the others stay as they were estimated. Prints a table.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[threads] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402
from scipy.special import ndtr  # noqa: E402

from avahazard.arrays import Floats  # noqa: E402
from avahazard.hazard.avalanches import Avalanches  # noqa: E402
from avahazard.hazard.exceedance import exceeded_runout  # noqa: E402
from avahazard.hazard.frequencies import known_volumes, volume_frequencies  # noqa: E402
from avahazard.hazard.path_hazard import path_hazard  # noqa: E402
from avahazard.inference.likelihood.assemble import with_effects  # noqa: E402
from avahazard.inference.model.observations import build_observations  # noqa: E402
from avahazard.inference.model.specification import Specification  # noqa: E402
from avahazard.inference.samplers.calibrate import calibrate_model  # noqa: E402
from benchmarks.coverage_study.arms import ARMS  # noqa: E402
from benchmarks.coverage_study.judging import CHAINS, DRAWS, YEARS  # noqa: E402
from benchmarks.coverage_study.world import (  # noqa: E402
    TrueWorld,
    exceeded_once,
    run_path,
    true_runouts,
)

Row = tuple[float, float, float]
"""Rank of the truth among the draws, error of their median (m), width of 90 % of them (m)."""


def main() -> None:
    """Go through the worlds; print how often the truth lies under and over 90 % of the draws."""
    arm, first, last = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    rows: dict[str, list[Row]] = {}
    for seed in range(first, last + 1):
        for part, row in ranks(ARMS[arm](seed)):
            rows.setdefault(part, []).append(row)
        print(f"world {seed}", file=sys.stderr, flush=True)
    n = len(next(iter(rows.values())))
    print(f"{arm}, worlds {first} to {last}, {n} paths\n")
    print("| true | covers | below | above | mean rank | sd of rank | error | width |")
    print("|---|---|---|---|---|---|---|---|")
    for part, found in rows.items():
        rank, error, width = np.array(found).T
        below, above = np.mean(rank <= 0.05), np.mean(rank >= 0.95)
        print(
            f"| {part} | {1.0 - below - above:.1%} | {below:.1%} | {above:.1%} | {rank.mean():.2f} "
            f"| {rank.std():.2f} | {np.median(error):+.0f} m | {np.median(width):.0f} m |"
        )


def ranks(world: TrueWorld) -> list[tuple[str, Row]]:
    """What each part, given its truth, makes of each path whose true runout lies on it."""
    observations = build_observations(world.records if world.told is None else world.told)
    specification, facts = with_effects(observations, Specification(), world.effects)
    model = calibrate_model(
        observations, specification, facts, n_chains=CHAINS, n_draws=DRAWS, seed=world.seed
    ).model
    if world.told is not None:
        model = model.on(build_observations(world.records))
    frequencies = volume_frequencies(known_volumes(world.records), world.seed)
    found: list[tuple[str, Row]] = []
    for k, site in enumerate(world.sites):
        truth = exceeded_once(world, k, true_runouts(world, k, run_path(world, k)), YEARS)
        if not np.isfinite(truth):
            continue
        path_id = site.path.path_id
        path = path_hazard(
            *(model, world.records, path_id, frequencies.of(path_id).volumes()),
            event_columns=False,
            volume_matters=True,
            seed=world.seed,
        )
        for part, given in parts(world, k).items():
            x = exceeded_runout(given(path.avalanches), YEARS)
            rank = 0.5 * float(np.mean(x < truth) + np.mean(x <= truth))
            low, middle, high = np.quantile(np.where(np.isfinite(x), x, 1e6), [0.05, 0.5, 0.95])
            found.append((part, (rank, float(middle - truth), float(high - low))))
    return found


def parts(world: TrueWorld, k: int) -> dict[str, Callable[[Avalanches], Avalanches]]:
    """What gives avalanches of path k the true part, by its name."""

    def middle(known: Avalanches) -> Avalanches:
        volume = np.exp(known.volumes.log_volume)
        true = world.settings.law.log_friction(volume) + world.offsets[k]
        return replace(known, location=np.broadcast_to(true, known.location.shape).copy())

    def scatter(known: Avalanches) -> Avalanches:
        return replace(known, scatter=np.full_like(known.scatter, world.settings.scatter))

    def rate(known: Avalanches) -> Avalanches:
        same = np.full(known.n_parameters, world.rates[k])
        return replace(known, volumes=replace(known.volumes, rate=same))

    def sizes(known: Avalanches) -> Avalanches:
        share = np.tile(true_shares(world, k, known.volumes.log_volume), (known.n_parameters, 1))
        return replace(known, volumes=replace(known.volumes, share=share))

    return {
        "nothing": lambda known: known,
        "rate": rate,
        "volumes": sizes,
        "rate and volumes": lambda known: rate(sizes(known)),
        "middle of friction": middle,
        "scatter of friction": scatter,
        "friction": lambda known: middle(scatter(known)),
    }


def true_shares(world: TrueWorld, k: int, log_volume: Floats) -> Floats:
    """Shares of the avalanches of path k at nodes of log volume `[n_volumes]`."""
    site = world.sites[k]
    low, high = np.log([site.volume_low_m3, site.volume_high_m3])
    between = np.clip(0.5 * (log_volume[1:] + log_volume[:-1]), low, high)
    ends = np.concatenate([[low], between, [high]])
    under = ndtr((ends - np.log(site.volume_median_m3)) / site.volume_log_sd)
    return np.asarray(np.diff(under) / (under[-1] - under[0]))


if __name__ == "__main__":
    main()
