"""Leave one out: the log density of each record given all others."""

from importlib import import_module
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.held_out import left_out_log_density
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.seeds import generator

ALIKE = 1e-9
"""Log densities (nats) that differ by less are those of one weight."""
MAX_DRAWS = 1000
BAD_K = 0.7
MAX_REFITS = 10
EVENTS_AT_ONCE = 500
"""Events whose weights are smoothed together: it takes several copies of their draws."""


class Loo(NamedTuple):
    """Log density of each event given the others, and the Pareto k, `[n_events]`.

    `n_bad` counts events with k over 0.7; those that were refitted (`n_refitted`) are exact.
    """

    by_event: Floats
    pareto_k: Floats
    n_bad: int
    n_refitted: int


def leave_one_out(model: FittedModel) -> Loo:
    """Leave-one-out log density by Pareto-smoothed importance sampling (Vehtari et al. 2017).

    With groups of events, likelihoods are those given their offsets. Where the importance
    weights are not to be trusted (k > 0.7) for ten events or fewer, the model is refitted without
    each.
    """
    posterior, coordinates = model.posterior, model.draws
    offsets = model.group_offsets(generator(0, "leave one out"))
    chosen = model.thinned(min(MAX_DRAWS, len(coordinates)))
    given = np.empty((len(chosen), posterior.observations.n_events))
    for row, k in enumerate(chosen):
        shift = None if offsets is None else offsets[k]
        given[row] = posterior.event_log_likelihood(coordinates[k], shift)
    by_event, pareto_k = smoothed_loo(given)
    bad = np.flatnonzero(~(pareto_k <= BAD_K))
    refits = bad if len(bad) <= MAX_REFITS else bad[:0]
    if len(refits):
        start = find_mode(posterior, np.median(coordinates, axis=0))
    for i in refits:
        out = np.arange(len(by_event)) == i
        by_event[i] = left_out_log_density(posterior, out, start, coordinates)[i]
    return Loo(by_event, pareto_k, len(bad), len(refits))


STACKING_STEPS = 10_000
STACKED = 1e-12
"""Weights that change by less have converged."""


def stacking_weights(log_density: Floats) -> Floats:
    """Weights of models `[n_models]` whose mixture gives left-out records the highest density.

    `log_density` `[n_events, n_models]` of each record given the others (Yao et al. 2018). The sum
    of log Σ w p is concave in the weights, and expectation-maximisation maximises it.
    """
    density = np.exp(log_density - log_density.max(axis=1, keepdims=True))
    weights = np.full(density.shape[1], 1.0 / density.shape[1])
    for _ in range(STACKING_STEPS):
        share = density * weights
        before, weights = weights, np.mean(share / share.sum(axis=1, keepdims=True), axis=0)
        if np.max(np.abs(weights - before)) < STACKED:
            break
    return np.asarray(weights)


def smoothed_loo(log_likelihood: Floats) -> tuple[Floats, Floats]:
    """Left-out log density and Pareto k `[n_events]` of draws `[n_draws, n_events]`.

    An event that is as likely by most draws (one that is certain to run beyond the profile) has
    weights without a tail that a Pareto distribution could be fitted to: its plain weights serve,
    and its k is nan, or 0 where they are all equal.
    """
    n_parts = -(-log_likelihood.shape[1] // EVENTS_AT_ONCE)
    parts = [_pareto_loo_each(some) for some in np.array_split(log_likelihood, n_parts, axis=1)]
    by_event, pareto_k = np.concatenate(parts, axis=1)
    equal = np.ptp(log_likelihood, axis=0) <= ALIKE
    pareto_k[equal] = 0.0
    plain = equal | ~np.isfinite(by_event)
    less = -log_likelihood[:, plain]
    # 1 / p(y_i | the others) is the mean of 1 / p(y_i | draw).
    by_event[plain] = np.log(len(less)) - np.logaddexp.reduce(less, axis=0)
    return by_event, pareto_k


def _pareto_loo_each(log_likelihood: Floats) -> Floats:
    """The smoothed log density and Pareto k `[2, n_events]`, nan for events without a tail."""
    array_stats = import_module("arviz_stats.base").array_stats  # slow to import, so only here
    try:
        with np.errstate(divide="ignore", invalid="ignore"):
            found, k, _ = array_stats.loo(log_likelihood.T, chain_axis=None, draw_axis=-1)
    except ValueError:  # one event without a tail is enough
        if log_likelihood.shape[1] == 1:
            return np.full((2, 1), np.nan)
        columns = log_likelihood.T[..., None]
        return np.concatenate([_pareto_loo_each(column) for column in columns], axis=1)
    return np.array([found, k], dtype=np.float64)
