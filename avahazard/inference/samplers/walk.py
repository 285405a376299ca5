"""Metropolis-Hastings chains that walk side by side.

Two kinds of proposals in turn: a jump drawn from a multivariate Student distribution about a
centre (Hastings' independence proposal, which forgets at once where the posterior is nearly
normal), and a random-walk step, which moves wherever it is not. Where jumps go does not depend on
where a chain is, so the densities there are computed in large pieces; steps of all chains are
taken together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.fitting.mode import Mode
from avahazard.inference.likelihood.posterior import Posterior

FREEDOM = 6.0
"""Degrees of freedom of the jumps: tails heavier than the posterior's."""
WIDEN = 1.2
"""Widening of the jumps' covariance."""
DISPERSION = 2.0
"""Chains start that many posterior standard deviations from the mode."""
PIECE = 100
"""Steps whose jumps are prepared together."""


class Proposal(NamedTuple):
    """What the proposals of a chain are shaped by: `[n_slots]` and `[n_slots, n_slots]`."""

    centre: Floats
    covariance: Floats


@dataclass(slots=True, eq=False)
class State:
    """Where the chains are `[n_chains, n_slots]`, the log densities there, their generators."""

    u: Floats
    value: Floats
    generators: Sequence[np.random.Generator]


class _Moves(NamedTuple):
    """What chance decides of some pairs of steps, a jump and a random-walk step each.

    `jump`, `step` `[n_chains, n_pairs, n_slots]` are where jumps lead to and how far steps go;
    `log_uniform` `[n_chains, n_pairs, 2]` decides on both.
    """

    jump: Floats
    step: Floats
    log_uniform: Floats


def dispersed_state(
    posterior: Posterior, mode: Mode, generators: Sequence[np.random.Generator]
) -> State:
    """Starts of the chains, dispersed about the mode where the density is not nought."""
    factor = np.asarray(np.linalg.cholesky(mode.covariance), dtype=np.float64)
    starts = [_dispersed(posterior, mode, factor, rng) for rng in generators]
    return State(np.array([u for u, _ in starts]), np.array([v for _, v in starts]), generators)


def _dispersed(
    posterior: Posterior, mode: Mode, factor: Floats, rng: np.random.Generator
) -> tuple[Floats, float]:
    for scale in (DISPERSION, 1.0, 0.3, 0.1, 0.03):
        for _ in range(20):
            u = mode.u + scale * factor @ rng.standard_normal(len(mode.u))
            value = posterior.log_density(u)
            if np.isfinite(value):
                return u, value
    return mode.u.copy(), posterior.log_density(mode.u)


def walk(
    posterior: Posterior,
    state: State,
    proposals: Sequence[Proposal],
    n_draws: int,
    keep_every: int,
    progress: Callable[[float], None] = lambda _share: None,
) -> tuple[Floats, Floats]:
    """Move the chains on by `n_draws` times `keep_every` steps (an even number), and `state`.

    Returns the draws that are kept `[n_chains, n_draws, n_slots]` and the shares of the steps that
    were accepted `[n_chains]`. There is a proposal for each chain. `progress` is told the share
    done.
    """
    u, value = state.u, state.value
    n_chains, n_slots = u.shape
    centre = np.array([p.centre for p in proposals])
    factor = np.array([np.linalg.cholesky(p.covariance) for p in proposals])
    inverse = np.linalg.inv(factor)
    kept = np.empty((n_chains, n_draws, n_slots))
    accepted = np.zeros(n_chains)
    n_pairs = n_draws * keep_every // 2
    for first in range(0, n_pairs, PIECE):
        size = min(PIECE, n_pairs - first)
        moves = _moves(state.generators, centre, factor, size)
        jump_value = posterior.log_densities(moves.jump.reshape(-1, n_slots))
        jump_value = jump_value.reshape(n_chains, size)
        jump_weight = _jump_log_density(moves.jump, centre, inverse)
        for j in range(size):
            weight = _jump_log_density(u[:, None], centre, inverse)[:, 0]
            log_ratio = jump_value[:, j] - value + weight - jump_weight[:, j]
            takes = moves.log_uniform[:, j, 0] < log_ratio
            u = np.where(takes[:, None], moves.jump[:, j], u)
            value = np.where(takes, jump_value[:, j], value)
            accepted += takes
            candidate = u + moves.step[:, j]
            candidate_value = posterior.log_densities(candidate)
            takes = moves.log_uniform[:, j, 1] < candidate_value - value
            u = np.where(takes[:, None], candidate, u)
            value = np.where(takes, candidate_value, value)
            accepted += takes
            kept[:, 2 * (first + j) // keep_every] = u
        progress((first + size) / n_pairs)
    state.u, state.value = u, value
    return kept, accepted / (2 * n_pairs)


def _moves(
    generators: Sequence[np.random.Generator], centre: Floats, factor: Floats, n_pairs: int
) -> _Moves:
    n_chains, n_slots = centre.shape
    jump, step = np.empty((2, n_chains, n_pairs, n_slots))
    log_uniform = np.empty((n_chains, n_pairs, 2))
    for c, rng in enumerate(generators):
        stretch = np.sqrt(WIDEN * FREEDOM / rng.chisquare(FREEDOM, n_pairs))
        jump[c] = centre[c] + stretch[:, None] * (
            rng.standard_normal((n_pairs, n_slots)) @ factor[c].T
        )
        # Mostly the size that is best for a normal target, now and then a small one.
        size = 2.38 / np.sqrt(n_slots) * np.where(rng.random(n_pairs) < 0.25, 0.2, 1.0)
        step[c] = size[:, None] * (rng.standard_normal((n_pairs, n_slots)) @ factor[c].T)
        log_uniform[c] = np.log(rng.random((n_pairs, 2)))
    return _Moves(jump, step, log_uniform)


def _jump_log_density(u: Floats, centre: Floats, inverse: Floats) -> Floats:
    """Log density `[n_chains, n]` of the jumps at u `[n_chains, n, n_slots]`, up to a constant."""
    z = (u - centre[:, None]) @ inverse.swapaxes(1, 2)
    d = u.shape[-1]
    return np.asarray(-0.5 * (FREEDOM + d) * np.log1p(np.sum(z * z, axis=-1) / (WIDEN * FREEDOM)))
