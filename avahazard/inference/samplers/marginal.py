"""Sampling the posterior of the marginal likelihood: the default method of `calibrate`.

Metropolis-Hastings (`walk`) with proposals shaped by the curvature at the mode and then, during
warm-up only, by each chain's own draws.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.fitting.mode import Mode, find_mode
from avahazard.inference.fitting.mode_search import search_mode
from avahazard.inference.fitting.refinement import continued, settled, sharpened
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.prediction.fitted_model import FittedModel, fitted_model
from avahazard.inference.samplers.chains import Chains, chains
from avahazard.inference.samplers.convergence import ESS_LIMIT
from avahazard.inference.samplers.walk import Proposal, dispersed_state, walk
from avahazard.inference.seeds import generator

KEEP_EVERY = 2
"""Steps for each draw that is kept: one jump and one random-walk step."""
MAX_ROUNDS = 4
WARM_UP_ROUNDS = 3


def sample(
    posterior: Posterior,
    *,
    n_chains: int = 4,
    n_draws: int = 1000,
    seed: int = 0,
    start: Floats | None = None,
    progress: Callable[[float], None] = lambda _share: None,
) -> FittedModel:
    """Draw from the posterior with several chains from dispersed starts.

    Where the chains have not converged, what they found so far reshapes the proposals and they
    run on, twice as long each time, `MAX_ROUNDS` times at most; only the last round is kept. Of
    fewer draws than `ESS_LIMIT` in all, which never pass, there is one round.
    The model that is returned has the posterior that was sampled, with grids fit to it.
    `start` `[n_slots]` is where the mode is sought from; `progress` is told the share done.
    Equal seeds give equal draws.
    """
    posterior, mode = search_mode(posterior, start)
    fine, mode = sharpened(posterior, mode)
    found = _rounds(fine, mode, n_chains, n_draws, seed, progress)
    # Never back to the grids before: they are held against exact tables at the mode alone.
    while (wider := continued(fine, posterior, found.draws)) is not None:
        fine, mode = settled(wider, find_mode(wider, mode.u))
        found = _rounds(fine, mode, n_chains, n_draws, seed, progress)
    return found


def _rounds(
    posterior: Posterior,
    mode: Mode,
    n_chains: int,
    n_draws: int,
    seed: int,
    progress: Callable[[float], None],
) -> FittedModel:
    """Warm up every chain, then rounds of draws until they have converged."""
    warm_up = max(100, n_draws // 4)
    done, first = WARM_UP_ROUNDS * KEEP_EVERY * warm_up, KEEP_EVERY * n_draws
    state = dispersed_state(
        posterior, mode, [generator(seed, "marginal", c) for c in range(n_chains)]
    )
    proposals = [Proposal(mode.u, mode.covariance)] * n_chains
    for round_ in range(WARM_UP_ROUNDS):
        kept, _ = walk(posterior, state, proposals, warm_up, KEEP_EVERY)
        if round_ > 0:
            proposals = [_following(draws, mode) for draws in kept]
        progress(done / (done + first) * (round_ + 1) / WARM_UP_ROUNDS)
    for round_ in range(MAX_ROUNDS if n_chains * n_draws >= ESS_LIMIT else 1):
        steps = first * 2**round_

        def tell(share: float, done: int = done, steps: int = steps) -> None:
            progress((done + steps * share) / (done + steps))

        draws, acceptance = walk(posterior, state, proposals, n_draws, KEEP_EVERY * 2**round_, tell)
        done += steps
        drawn = _read(posterior, draws, acceptance)
        if drawn.diagnostics.converged:
            break
        proposals = [_following(draws.reshape(-1, draws.shape[2]), mode)] * n_chains
    flat = draws.reshape(-1, draws.shape[2])
    return replace(fitted_model(posterior, flat, _offsets(posterior, draws, seed)), sampled=drawn)


def _read(posterior: Posterior, draws: Floats, acceptance: Floats) -> Chains:
    readable = posterior.layout.readable(draws)
    return chains(
        tuple(readable),
        tuple(unit for _, unit in readable.values()),
        np.stack([np.broadcast_to(v, draws.shape[:2]) for v, _ in readable.values()], axis=-1),
        acceptance,
    )


def _following(draws: Floats, mode: Mode) -> Proposal:
    """What the draws `[n, n_slots]` found shapes the next proposals.

    Their covariance is drawn a little to the one at the mode, so that it stays positive.
    """
    share = len(draws) / (len(draws) + 10.0 * draws.shape[1])
    found = np.cov(draws.T).reshape(mode.covariance.shape)
    return Proposal(draws.mean(axis=0), share * found + (1.0 - share) * mode.covariance)


def _offsets(posterior: Posterior, draws: Floats, seed: int) -> dict[str, Floats]:
    """Offsets by group, each `[n_chains * n_draws]`, from their (nearly normal) distribution.

    That is the conditional one given the draws `[n_chains, n_draws, n_slots]`.
    """
    if not posterior.plan:
        return {}
    result = np.empty((*draws.shape[:2], len(posterior.plan.names)))
    for c in range(draws.shape[0]):
        rng = generator(seed, "offsets", c)
        for k in range(draws.shape[1]):
            if not (k and np.array_equal(draws[c, k], draws[c, k - 1])):
                offsets = posterior.offsets(draws[c, k])
            result[c, k] = offsets.draw(rng)
    return {name: result[..., k].ravel() for k, name in enumerate(posterior.plan.names)}
