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

from avahazard.inference.chains import Chains, chains
from avahazard.inference.mode import Mode, find_mode
from avahazard.inference.posterior import Posterior
from avahazard.inference.seeds import generator

Floats = NDArray[np.float64]

FREEDOM = 6.0
"""Degrees of freedom of the jumps: tails heavier than the posterior's."""
WIDEN = 1.2
"""Widening of the jumps' covariance."""
WARM_UP_ROUNDS = 3
DISPERSION = 2.0
"""Chains start that many posterior standard deviations from the mode."""


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """Draws of the coordinates `[n_chains, n_draws, n_slots]` and what is read from them.

    `chains` holds the readable parameters with their diagnostics; `offsets` are draws of the
    path offsets `[n_chains, n_draws, n_groups]`, None without path effect.
    """

    coordinates: Floats
    chains: Chains
    mode: Mode
    offsets: Floats | None


def sample(
    posterior: Posterior,
    *,
    n_chains: int = 4,
    n_draws: int = 1000,
    seed: int = 0,
    mode: Mode | None = None,
    progress: Callable[[float], None] | None = None,
) -> Sample:
    """Draw from the posterior with several chains from dispersed starts.

    `progress` is told the share done. Equal seeds give equal draws.
    """
    mode = find_mode(posterior) if mode is None else mode
    warm_up = max(100, n_draws // 4)
    total = n_chains * (WARM_UP_ROUNDS * warm_up + n_draws)
    draws = np.empty((n_chains, n_draws, len(mode.u)))
    acceptance = np.empty(n_chains)
    for c in range(n_chains):
        rng = generator(seed, "marginal", c)
        done = c * total // n_chains

        def tell(steps: int, done: int = done) -> None:
            if progress is not None:
                progress((done + steps) / total)

        draws[c], acceptance[c] = _chain(posterior, mode, rng, warm_up, n_draws, tell)
    offsets = _offset_draws(posterior, draws, seed) if posterior.groups is not None else None
    readable = posterior.layout.readable(draws)
    return Sample(
        coordinates=draws,
        chains=chains(
            tuple(readable),
            tuple(unit for _, unit in readable.values()),
            np.stack([np.broadcast_to(v, draws.shape[:2]) for v, _ in readable.values()], axis=-1),
            acceptance,
        ),
        mode=mode,
        offsets=offsets,
    )


def _chain(
    posterior: Posterior,
    mode: Mode,
    rng: np.random.Generator,
    warm_up: int,
    n_draws: int,
    tell: Callable[[int], None],
) -> tuple[Floats, float]:
    """One chain: rounds of warm-up that reshape the proposals, then draws with them frozen."""
    u, value = _dispersed_start(posterior, mode, rng)
    centre, covariance = mode.u, mode.covariance
    for round_ in range(WARM_UP_ROUNDS):
        kept, u, value, _ = _walk(posterior, u, value, centre, covariance, rng, warm_up)
        if round_ > 0:
            centre = kept.mean(axis=0)
            covariance = _shrunk_covariance(kept, mode.covariance)
        tell((round_ + 1) * warm_up)
    kept, _, _, accepted = _walk(
        posterior, u, value, centre, covariance, rng, n_draws, lambda k: tell(3 * warm_up + k)
    )
    return kept, accepted / n_draws


def _shrunk_covariance(draws: Floats, prior: Floats) -> Floats:
    """Covariance of the draws, drawn a little to the one at the mode so that it stays positive."""
    share = len(draws) / (len(draws) + 10.0 * draws.shape[1])
    return np.asarray(share * np.cov(draws.T).reshape(prior.shape) + (1.0 - share) * prior)


def _dispersed_start(
    posterior: Posterior, mode: Mode, rng: np.random.Generator
) -> tuple[Floats, float]:
    factor = np.linalg.cholesky(mode.covariance)
    for scale in (DISPERSION, 1.0, 0.3, 0.1, 0.03):
        for _ in range(20):
            u = mode.u + scale * factor @ rng.standard_normal(len(mode.u))
            value = posterior.log_density(u)
            if np.isfinite(value):
                return u, value
    return mode.u.copy(), mode.log_density


def _walk(
    posterior: Posterior,
    u: Floats,
    value: float,
    centre: Floats,
    covariance: Floats,
    rng: np.random.Generator,
    n_steps: int,
    tell: Callable[[int], None] = lambda _steps: None,
) -> tuple[Floats, Floats, float, int]:
    """`n_steps` steps; returns the states after each, the last state, its value, acceptances."""
    d = len(u)
    factor: Floats = np.linalg.cholesky(covariance)
    kept = np.empty((n_steps, d))
    accepted = 0
    weight = _jump_log_density(u, centre, factor)
    for k in range(n_steps):
        if k % 2 == 0:
            z = rng.standard_normal(d)
            stretch = np.sqrt(WIDEN * FREEDOM / rng.chisquare(FREEDOM))
            candidate = centre + stretch * (factor @ z)
        else:
            # Mostly the size that is best for a normal target, now and then a small one.
            size = 2.38 / np.sqrt(d) * (0.2 if rng.random() < 0.25 else 1.0)
            candidate = u + size * (factor @ rng.standard_normal(d))
        candidate_value = posterior.log_density(candidate)
        candidate_weight = _jump_log_density(candidate, centre, factor)
        log_ratio = candidate_value - value
        if k % 2 == 0:
            log_ratio += weight - candidate_weight
        if np.log(rng.random()) < log_ratio:
            u, value, weight = candidate, candidate_value, candidate_weight
            accepted += 1
        kept[k] = u
        if k % 100 == 0:
            tell(k)
    return kept, u, value, accepted


def _jump_log_density(u: Floats, centre: Floats, factor: Floats) -> float:
    """Log density of the jumps up to a constant: multivariate t."""
    z = np.linalg.solve(factor, u - centre)
    d = len(u)
    return float(-0.5 * (FREEDOM + d) * np.log1p(float(z @ z) / (WIDEN * FREEDOM)))


def _offset_draws(posterior: Posterior, draws: Floats, seed: int) -> Floats:
    """Path offsets for every draw, from their (nearly normal) conditional distribution."""
    assert posterior.groups is not None
    n_groups = int(np.max(posterior.groups)) + 1
    result = np.empty((*draws.shape[:2], n_groups))
    for c in range(draws.shape[0]):
        rng = generator(seed, "offsets", c)
        for k in range(draws.shape[1]):
            if k and np.array_equal(draws[c, k], draws[c, k - 1]):
                pass
            else:
                offsets = posterior.path_offsets(draws[c, k])
            result[c, k] = offsets.mode + offsets.sd * rng.standard_normal(n_groups)
    return result
