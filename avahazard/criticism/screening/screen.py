"""Which candidate effects the data ask for, against what chance alone would show.

The gain of a candidate is what the quick fit's log likelihood rises when it is added, law,
scatter and path offsets fitted again. Its null distribution comes from worlds made on the user's
own design in which the model is true.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.screening.alternatives import (
    Alternative,
    alternatives_of,
    base_coordinates,
    base_design,
    make_tables,
)
from avahazard.criticism.screening.gains import Gains
from avahazard.criticism.screening.parametric_bootstrap import make_world, real_world
from avahazard.criticism.screening.significance import LEVEL, PATH_LEVEL, Screening, judge
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import predict_records, run_blocks
from avahazard.inference.seeds import generator
from avahazard.workers import ordered_map

Floats = NDArray[np.float64]

BATCH = 40
"""Worlds made before it is asked whether more are needed."""


def screen(
    posterior: Posterior,
    u: Floats,
    tau: float,
    candidates: Sequence[Definition],
    *,
    n_worlds: int = 199,
    seed: int = 0,
    progress: Callable[[float], None] = lambda _share: None,
) -> Screening:
    """Screen the candidates on a model at its mode u (without path effect).

    `tau` is the spread of path offsets that is granted as a nuisance (0: none granted).

    At most `n_worlds` worlds are made, fewer where it is soon plain that chance does as well
    (the sequential test of Besag and Clifford 1991, whose p-values stay valid). Equal seeds give
    equal results for any number of workers.
    """
    observations = posterior.observations
    speed_slot = posterior.layout.speed_scatter
    speed_scatter = 0.0 if speed_slot is None else float(np.exp(u[speed_slot]))
    values, curvature = (
        posterior.layout.effect_values(u),
        float(posterior.specification.centrifugal),
    )
    runs = run_blocks(observations, posterior.effects, values, curvature)
    predicted = predict_records(observations, posterior.effects, values, curvature, runs)
    base = make_tables(observations, predicted, observations.limit, speed_scatter)
    design = base_design(posterior, u, path_offsets=tau > 0.0)
    bare = design._replace(n_paths=0)
    coefficients = base_coordinates(posterior, u)
    alternatives: list[Alternative] = []
    for k, entry in enumerate(candidates):
        alternatives += alternatives_of(
            entry, posterior, u, base, design, coefficients, speed_scatter, runs
        )
        progress(0.3 * (k + 1) / len(candidates))
    keys = [c.key for c in candidates]
    log_scatter = float(u[posterior.layout.scatter])
    student = posterior.specification.tails == "student"
    gains = Gains(
        base, design, alternatives, keys, coefficients, log_scatter, tau, student, observations
    )

    real = gains.of_candidates(real_world(posterior))
    real_path = 0.0
    if tau > 0.0:
        real_path = gains.of_paths(real_world(posterior), bare)

    def one(b: int) -> tuple[Floats, float]:
        rng = generator(seed, "screening", b)
        gained = gains.of_candidates(make_world(posterior, predicted, u, tau, speed_scatter, rng))
        path = 0.0
        if tau > 0.0:
            flat = make_world(posterior, predicted, u, 0.0, speed_scatter, rng)
            path = gains.of_paths(flat, bare)
        return gained, path

    null, null_path = np.empty((0, len(keys))), np.empty(0)
    while len(null) < n_worlds:
        batch = range(len(null), min(len(null) + BATCH, n_worlds))
        made = list(ordered_map(one, batch))
        null = np.concatenate([null, [gained for gained, _ in made]])
        null_path = np.concatenate([null_path, [path for _, path in made]])
        found = judge(candidates, real, null, real_path, null_path)
        progress(0.3 + 0.7 * len(null) / n_worlds)
        if _plain(found, n_worlds):
            break
    return found


def _plain(found: Screening, n_worlds: int) -> bool:
    """Whether chance is plainly enough.

    Twice as many made worlds have exceeded the records as could in all of them if these were to be
    significant.
    """
    best = found.candidates[0].p_family if found.candidates else 1.0
    return all(
        p * (found.n_worlds + 1) > 1.0 + 2.0 * level * (n_worlds + 1)
        for p, level in ((best, LEVEL), (found.path_p, PATH_LEVEL))
    )
