"""Sampling the posterior of the marginal likelihood: the default method of `calibrate`.

Metropolis-Hastings with two kinds of proposals in turn, both shaped by the curvature at the mode
and then, during warm-up only, by the chain's own draws: a jump drawn from a multivariate Student
distribution about the centre (Hastings' independence proposal, which forgets at once where the
posterior is nearly normal), and a random-walk step, which moves wherever it is not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.fitting.mode import Mode
from avahazard.inference.fitting.mode_search import search_mode
from avahazard.inference.fitting.refinement import sharpened
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.samplers.chains import Chains, chains
from avahazard.inference.seeds import generator

Floats = NDArray[np.float64]

FREEDOM = 6.0
"""Degrees of freedom of the jumps: tails heavier than the posterior's."""
WIDEN = 1.2
"""Widening of the jumps' covariance."""
KEEP_EVERY = 2
"""Steps for each draw that is kept: one jump and one random-walk step."""
MAX_ROUNDS = 4
EDGE_SHARE = 0.005
WARM_UP_ROUNDS = 3
DISPERSION = 2.0
"""Chains start that many posterior standard deviations from the mode."""


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """Draws of the coordinates `[n_chains, n_draws, n_slots]` and what is read from them.

    `chains` holds the readable parameters with their diagnostics; `offsets` are draws of the
    offsets of groups `[n_chains, n_draws, n_offsets]`, None without groups. `posterior` is the
    one that was sampled, with grids fit to it.
    """

    coordinates: Floats
    chains: Chains
    mode: Mode
    offsets: Floats | None
    posterior: Posterior

    def offsets_by_group(self) -> dict[str, Floats]:
        """Draws of the offsets `[n_chains * n_draws]` by group; none without groups."""
        if self.offsets is None:
            return {}
        names = self.posterior.plan.names
        return {name: self.offsets[..., k].ravel() for k, name in enumerate(names)}


@dataclass(slots=True, eq=False)
class _State:
    """Where one chain is, and the generator that moves it."""

    u: Floats
    value: float
    rng: np.random.Generator


def sample(
    posterior: Posterior,
    *,
    n_chains: int = 4,
    n_draws: int = 1000,
    seed: int = 0,
    start: Floats | None = None,
    progress: Callable[[float], None] = lambda _share: None,
) -> Sample:
    """Draw from the posterior with several chains from dispersed starts.

    Where the chains have not converged, what they found so far reshapes the proposals and they
    run on, twice as long each time, `MAX_ROUNDS` times at most; only the last round is kept.
    `start` `[n_slots]` is where the mode is sought from; `progress` is told the share done.
    Equal seeds give equal draws.
    """
    posterior, mode = search_mode(posterior, start)
    fine, fine_mode = sharpened(posterior, mode)
    if fine is not posterior:
        tried = _rounds(fine, fine_mode, n_chains, n_draws, seed, progress)
        if not _at_edges(tried.coordinates, fine, posterior):
            return tried
    return _rounds(posterior, mode, n_chains, n_draws, seed, progress)


def _rounds(
    posterior: Posterior,
    mode: Mode,
    n_chains: int,
    n_draws: int,
    seed: int,
    progress: Callable[[float], None],
) -> Sample:
    """Warm up every chain, then rounds of draws until they have converged."""
    warm_up = max(100, n_draws // 4)
    states, proposals = [], []
    done, first = WARM_UP_ROUNDS * KEEP_EVERY * warm_up, KEEP_EVERY * n_draws
    for c in range(n_chains):
        state, proposal = _warm(posterior, mode, generator(seed, "marginal", c), warm_up)
        states.append(state)
        proposals.append(proposal)
        progress(done / (done + first) * (c + 1) / n_chains)
    for round_ in range(MAX_ROUNDS):
        results, steps = [], first * 2**round_
        for c, (state, proposal) in enumerate(zip(states, proposals, strict=True)):
            results.append(_walk(posterior, state, *proposal, n_draws, KEEP_EVERY * 2**round_))
            progress((done + steps * (c + 1) / n_chains) / (done + steps))
        done += steps
        draws = np.stack([kept for kept, _ in results])
        acceptance = np.array([share for _, share in results])
        drawn = _read(posterior, draws, acceptance)
        if drawn.diagnostics.converged:
            break
        pooled = draws.reshape(-1, draws.shape[2])
        proposals = [(pooled.mean(axis=0), _shrunk_covariance(pooled, mode.covariance))] * n_chains
    offsets = _offset_draws(posterior, draws, seed) if posterior.plan else None
    return Sample(draws, drawn, mode, offsets, posterior)


def _read(posterior: Posterior, draws: Floats, acceptance: Floats) -> Chains:
    readable = posterior.layout.readable(draws)
    return chains(
        tuple(readable),
        tuple(unit for _, unit in readable.values()),
        np.stack([np.broadcast_to(v, draws.shape[:2]) for v, _ in readable.values()], axis=-1),
        acceptance,
    )


def _at_edges(draws: Floats, fine: Posterior, coarse: Posterior) -> bool:
    """Whether draws gather at an edge that only the refined grid has."""
    for k, (slot, whole) in enumerate(zip(fine.layout.slots, coarse.layout.slots, strict=True)):
        margin = 0.02 * (slot.high - slot.low)
        near_low = slot.low > whole.low and np.mean(draws[..., k] < slot.low + margin) > EDGE_SHARE
        near_high = (
            slot.high < whole.high and np.mean(draws[..., k] > slot.high - margin) > EDGE_SHARE
        )
        if near_low or near_high:
            return True
    return False


def _warm(
    posterior: Posterior, mode: Mode, rng: np.random.Generator, warm_up: int
) -> tuple[_State, tuple[Floats, Floats]]:
    """Rounds of warm-up that reshape the proposals of one chain by its own draws."""
    state = _dispersed_start(posterior, mode, rng)
    centre, covariance = mode.u, mode.covariance
    for round_ in range(WARM_UP_ROUNDS):
        kept, _ = _walk(posterior, state, centre, covariance, warm_up, KEEP_EVERY)
        if round_ > 0:
            centre = kept.mean(axis=0)
            covariance = _shrunk_covariance(kept, mode.covariance)
    return state, (centre, covariance)


def _shrunk_covariance(draws: Floats, prior: Floats) -> Floats:
    """Covariance of the draws, drawn a little to the one at the mode so that it stays positive."""
    share = len(draws) / (len(draws) + 10.0 * draws.shape[1])
    return np.asarray(share * np.cov(draws.T).reshape(prior.shape) + (1.0 - share) * prior)


def _dispersed_start(posterior: Posterior, mode: Mode, rng: np.random.Generator) -> _State:
    factor = np.linalg.cholesky(mode.covariance)
    for scale in (DISPERSION, 1.0, 0.3, 0.1, 0.03):
        for _ in range(20):
            u = mode.u + scale * factor @ rng.standard_normal(len(mode.u))
            value = posterior.log_density(u)
            if np.isfinite(value):
                return _State(u, value, rng)
    return _State(mode.u.copy(), posterior.log_density(mode.u), rng)


def _walk(
    posterior: Posterior,
    state: _State,
    centre: Floats,
    covariance: Floats,
    n_draws: int,
    keep_every: int,
) -> tuple[Floats, float]:
    """Move the chain on; returns the draws kept `[n_draws, n_slots]` and the share accepted."""
    u, value, rng = state.u, state.value, state.rng
    d = len(u)
    factor = np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
    kept = np.empty((n_draws, d))
    accepted = 0
    weight = _jump_log_density(u, centre, factor)
    for k in range(keep_every * n_draws):
        jumps = k % 2 == 0
        if jumps:
            stretch = np.sqrt(WIDEN * FREEDOM / rng.chisquare(FREEDOM))
            candidate = centre + stretch * (factor @ rng.standard_normal(d))
        else:
            # Mostly the size that is best for a normal target, now and then a small one.
            size = 2.38 / np.sqrt(d) * (0.2 if rng.random() < 0.25 else 1.0)
            candidate = u + size * (factor @ rng.standard_normal(d))
        candidate_value = posterior.log_density(candidate)
        candidate_weight = _jump_log_density(candidate, centre, factor)
        log_ratio = candidate_value - value
        if jumps:
            log_ratio += weight - candidate_weight
        if np.log(rng.random()) < log_ratio:
            u, value, weight = candidate, candidate_value, candidate_weight
            accepted += 1
        kept[k // keep_every] = u
    state.u, state.value = u, value
    return kept, accepted / (keep_every * n_draws)


def _jump_log_density(u: Floats, centre: Floats, factor: Floats) -> float:
    """Log density of the jumps up to a constant: multivariate t."""
    z = np.linalg.solve(factor, u - centre)
    d = len(u)
    return float(-0.5 * (FREEDOM + d) * np.log1p(float(z @ z) / (WIDEN * FREEDOM)))


def _offset_draws(posterior: Posterior, draws: Floats, seed: int) -> Floats:
    """Offsets for every draw, from their (nearly normal) conditional distribution."""
    result = np.empty((*draws.shape[:2], len(posterior.plan.names)))
    for c in range(draws.shape[0]):
        rng = generator(seed, "offsets", c)
        for k in range(draws.shape[1]):
            if k and np.array_equal(draws[c, k], draws[c, k - 1]):
                pass
            else:
                offsets = posterior.offsets(draws[c, k])
            result[c, k] = offsets.draw(rng)
    return result
