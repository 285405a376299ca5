"""Which candidate effects the data ask for, against what chance alone would show.

The gain of a candidate is what the Laplace fit's log likelihood rises when it is added, law,
scatter and path offsets fitted again. Its null distribution comes from worlds made on the user's
own design in which the model is true.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

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
from avahazard.criticism.screening.laplace_fit import Design
from avahazard.criticism.screening.parametric_bootstrap import (
    BootstrapRecords,
    make_world,
    real_world,
)
from avahazard.criticism.screening.significance import LEVEL, PATH_LEVEL, Screening, judge
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted, predict_records, run_blocks
from avahazard.inference.seeds import generator
from avahazard.workers import ordered_map

Floats = NDArray[np.float64]

BATCH = 40
"""Worlds made before it is asked whether more are needed."""
MAKING_READY = 0.3
"""Share of the time that it takes to spell out the candidates."""


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
    tested = _what_is_tested(posterior, u, tau, candidates, lambda s: progress(MAKING_READY * s))
    records = real_world(posterior)
    real = _gains_on(tested, records, records)
    null, null_paths = np.empty((0, len(candidates))), np.empty(0)
    while len(null) < n_worlds:
        made = _gains_by_chance(tested, seed, range(len(null), min(len(null) + BATCH, n_worlds)))
        null = np.concatenate([null, [gains.of_candidates for gains in made]])
        null_paths = np.concatenate([null_paths, [gains.of_paths for gains in made]])
        found = judge(candidates, real.of_candidates, null, real.of_paths, null_paths)
        progress(MAKING_READY + (1.0 - MAKING_READY) * len(null) / n_worlds)
        if _chance_plainly_does_as_well(found, n_worlds):
            break
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Tested:
    """A model at its mode `u`, what it predicts, and the gains of every candidate on any records.

    Path offsets of spread `tau` are granted; `without_paths` is the design that grants none.
    """

    posterior: Posterior
    u: Floats
    tau: float
    speed_scatter: float
    predicted: Predicted
    gains: Gains
    without_paths: Design


class _WorldGains(NamedTuple):
    """What candidates `[n_candidates]`, and offsets of paths, gain on the records of one world."""

    of_candidates: Floats
    of_paths: float


def _what_is_tested(
    posterior: Posterior,
    u: Floats,
    tau: float,
    candidates: Sequence[Definition],
    progress: Callable[[float], None],
) -> _Tested:
    """The model's tables and design, and each candidate spelled out."""
    observations, layout = posterior.observations, posterior.layout
    speed_scatter = 0.0 if layout.speed_scatter is None else float(np.exp(u[layout.speed_scatter]))
    values, curvature = layout.effect_values(u), float(posterior.specification.centrifugal)
    runs = run_blocks(observations, posterior.effects, values, curvature)
    predicted = predict_records(observations, posterior.effects, values, curvature, runs)
    base = make_tables(observations, predicted, observations.limit, speed_scatter)
    design = base_design(posterior, u, path_offsets=tau > 0.0)
    coefficients = base_coordinates(posterior, u)
    alternatives: list[Alternative] = []
    for k, entry in enumerate(candidates):
        alternatives += alternatives_of(
            entry, posterior, u, base, design, coefficients, speed_scatter, runs
        )
        progress((k + 1) / len(candidates))
    gains = Gains(
        base,
        design,
        alternatives,
        [c.key for c in candidates],
        coefficients,
        float(u[layout.scatter]),
        tau,
        posterior.specification.tails == "student",
        observations,
    )
    bare = design._replace(n_paths=0)
    return _Tested(posterior, u, tau, speed_scatter, predicted, gains, bare)


def _gains_on(
    tested: _Tested, records: BootstrapRecords, records_of_paths: BootstrapRecords
) -> _WorldGains:
    """Gains of the candidates on records, and of path offsets, where granted, on the others."""
    of_paths = 0.0
    if tested.tau > 0.0:
        of_paths = tested.gains.of_paths(records_of_paths, tested.without_paths)
    return _WorldGains(tested.gains.of_candidates(records), of_paths)


def _gains_by_chance(tested: _Tested, seed: int, worlds: Iterable[int]) -> list[_WorldGains]:
    """Gains on worlds in which the model is true, each by its own seed."""
    return list(ordered_map(partial(_gains_on_made_world, tested, seed), worlds))


def _gains_on_made_world(tested: _Tested, seed: int, world: int) -> _WorldGains:
    """Gains in one made world; that of path offsets where there are none."""
    rng = generator(seed, "screening", world)

    def made(tau: float) -> BootstrapRecords:
        return make_world(
            tested.posterior, tested.predicted, tested.u, tau, tested.speed_scatter, rng
        )

    records = made(tested.tau)
    return _gains_on(tested, records, made(0.0) if tested.tau > 0.0 else records)


def _chance_plainly_does_as_well(found: Screening, n_worlds: int) -> bool:
    """Whether chance is plainly enough.

    Twice as many made worlds have exceeded the records as could in all of them if these were to be
    significant.
    """
    best = found.candidates[0].p_family if found.candidates else 1.0
    return all(
        p * (found.n_worlds + 1) > 1.0 + 2.0 * level * (n_worlds + 1)
        for p, level in ((best, LEVEL), (found.path_p, PATH_LEVEL))
    )
