"""Leave one out: the log density of each record given all others."""

from __future__ import annotations

from importlib import import_module
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.scoring.held_out import left_out_log_density
from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.likelihood.posterior import Posterior

Floats = NDArray[np.float64]

MAX_DRAWS = 1000
BAD_K = 0.7
MAX_REFITS = 10


class Loo(NamedTuple):
    """`elpd`, its standard error `se`, and per event `[n_events]` its part and the Pareto k.

    `n_bad` counts events with k over 0.7; those that were refitted (`n_refitted`) are exact.
    """

    elpd: float
    se: float
    by_event: Floats
    pareto_k: Floats
    n_bad: int
    n_refitted: int


def leave_one_out(posterior: Posterior, coordinates: Floats, offsets: Floats | None) -> Loo:
    """Leave-one-out log density by Pareto-smoothed importance sampling (Vehtari et al. 2017).

    `coordinates` `[n_draws, n_slots]` are draws of the posterior; with a path effect, likelihoods
    are those given the path `offsets` `[n_draws, n_groups]`. Where the importance weights are not
    to be trusted (k > 0.7) for ten events or fewer, the model is refitted without each.
    """
    array_stats = import_module("arviz_stats.base").array_stats  # slow to import, so only here
    chosen = np.linspace(0, len(coordinates) - 1, min(MAX_DRAWS, len(coordinates)))
    given = [
        posterior.event_log_likelihood(coordinates[k], None if offsets is None else offsets[k])
        for k in chosen.round().astype(np.int64)
    ]
    by_event, pareto_k, _ = array_stats.loo(np.array(given).T, chain_axis=None, draw_axis=-1)
    by_event = np.array(by_event, dtype=np.float64)
    bad = np.flatnonzero(~(np.asarray(pareto_k) <= BAD_K))
    refits = bad if len(bad) <= MAX_REFITS else bad[:0]
    if len(refits):
        start = find_mode(posterior, np.median(coordinates, axis=0))
    for i in refits:
        out = np.arange(len(by_event)) == i
        by_event[i] = left_out_log_density(posterior, out, start, coordinates)[i]
    return Loo(
        elpd=float(np.sum(by_event)),
        se=float(np.sqrt(len(by_event)) * np.std(by_event, ddof=1)),
        by_event=by_event,
        pareto_k=np.asarray(pareto_k),
        n_bad=len(bad),
        n_refitted=len(refits),
    )
