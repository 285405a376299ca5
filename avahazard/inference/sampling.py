"""Sampling the posterior of the marginal likelihood: the default method of `calibrate`.

Metropolis-Hastings chains walk side by side, with two kinds of proposals in turn: a jump drawn from
a multivariate Student distribution about a centre, and a random-walk step. Where jumps go does not
depend on where a chain is, so the densities there are computed in large pieces. Proposals are
shaped by the curvature at the mode and then, during warm-up only, by each chain's own draws.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.fitted_model import ESS_LIMIT, Chains, FittedModel, fitted_model
from avahazard.inference.fitting.mode import Mode, find_mode
from avahazard.inference.fitting.star import improved, search_mode, star_among
from avahazard.inference.likelihood.assemble import assemble, definitions_of
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.choices import DEFAULT_METHOD, METHODS, MethodName
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.calibration import calibrate_paper
from avahazard.inference.seeds import generator

FREEDOM = 6.0
"""Degrees of freedom of the jumps: tails heavier than the posterior's."""
WIDEN = 1.2
"""Widening of the jumps' covariance."""
DISPERSION = 2.0
"""Chains start that many posterior standard deviations from the mode."""
PIECE = 100
"""Steps whose jumps are prepared together."""


@dataclass(slots=True, eq=False)
class State:
    """Where the chains are `[n_chains, n_slots]`, the log densities there, their generators."""

    u: Floats
    value: Floats
    generators: Sequence[np.random.Generator]


def dispersed_state(
    posterior: Posterior, mode: Mode, generators: Sequence[np.random.Generator]
) -> State:
    """Starts of the chains, dispersed about the mode where the density is not zero."""
    factor = np.asarray(np.linalg.cholesky(mode.covariance), dtype=np.float64)

    def start(rng: np.random.Generator) -> tuple[Floats, float]:
        for scale in np.repeat((DISPERSION, 1.0, 0.3, 0.1, 0.03), 20).tolist():
            u = mode.u + scale * factor @ rng.standard_normal(len(mode.u))
            value = posterior.log_density(u)
            if np.isfinite(value):
                return u, value
        return mode.u, posterior.log_density(mode.u)

    u, value = zip(*map(start, generators), strict=True)
    return State(np.array(u), np.array(value), generators)


def walk(
    posterior: Posterior,
    state: State,
    proposals: Sequence[Mode],
    n_draws: int,
    keep_every: int,
    progress: Callable[[float], None] = lambda _share: None,
) -> tuple[Floats, Floats]:
    """Move the chains on by `n_draws` times `keep_every` steps (an even number), and `state`.

    Returns the draws that are kept `[n_chains, n_draws, n_slots]` and the shares of the steps that
    were accepted `[n_chains]`. The proposals of each chain are shaped by one of `proposals`.
    `progress` receives the share done.
    """
    u, value = state.u, state.value
    n_chains, n_slots = u.shape
    centre = np.array([p.u for p in proposals])
    factor = np.array([np.linalg.cholesky(p.covariance) for p in proposals])
    inverse = np.linalg.inv(factor)
    kept = np.empty((n_chains, n_draws, n_slots))
    accepted = np.zeros(n_chains)
    n_pairs = n_draws * keep_every // 2
    for first in range(0, n_pairs, PIECE):
        size = min(PIECE, n_pairs - first)
        jump, step, log_uniform = _moves(state.generators, centre, factor, size)
        jump_value = posterior.log_densities(jump.reshape(-1, n_slots)).reshape(n_chains, size)
        jump_weight = _jump_log_density(jump, centre, inverse)
        for j in range(size):
            weight = _jump_log_density(u[:, None], centre, inverse)[:, 0]
            log_ratio = jump_value[:, j] - value + weight - jump_weight[:, j]
            takes = log_uniform[:, j, 0] < log_ratio
            u = np.where(takes[:, None], jump[:, j], u)
            value = np.where(takes, jump_value[:, j], value)
            accepted += takes
            candidate = u + step[:, j]
            candidate_value = posterior.log_densities(candidate)
            takes = log_uniform[:, j, 1] < candidate_value - value
            u = np.where(takes[:, None], candidate, u)
            value = np.where(takes, candidate_value, value)
            accepted += takes
            kept[:, 2 * (first + j) // keep_every] = u
        progress((first + size) / n_pairs)
    state.u, state.value = u, value
    return kept, accepted / (2 * n_pairs)


def _moves(
    generators: Sequence[np.random.Generator], centre: Floats, factor: Floats, n_pairs: int
) -> tuple[Floats, Floats, Floats]:
    """Jumps and steps `[n_chains, n_pairs, n_slots]`, and the logs `[…, 2]` that decide on them."""
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
    return jump, step, log_uniform


def _jump_log_density(u: Floats, centre: Floats, inverse: Floats) -> Floats:
    """Log density `[n_chains, n]` of the jumps at u `[n_chains, n, n_slots]`, up to a constant."""
    z = (u - centre[:, None]) @ inverse.swapaxes(1, 2)
    d = u.shape[-1]
    return np.asarray(-0.5 * (FREEDOM + d) * np.log1p(np.sum(z * z, axis=-1) / (WIDEN * FREEDOM)))


KEEP_EVERY = 2
"""Steps for each draw that is kept: one jump and one random-walk step."""
MAX_ROUNDS = 4
WARM_UP_ROUNDS = 3
PILOT_DRAWS, MOST_BETTER = 90, 5
"""Draws of each chain in the walks by which a star is made fit, and how often it is made anew."""
FEW_AXES = 2
"""Axes up to which a star has points enough to be held against tables at its draws alone."""
N_WALKERS, WALKED = 12, 4
"""Draws from which a few pairs of steps are walked by exact tables, and how many pairs."""
OFF, MOST_OFF = 2.0, 0.2
"""A star holds that is off by more nats than that, from the middle, at no more than a share of the
ends."""


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

    Chains that have not converged run on, twice as long each time, `MAX_ROUNDS` times at most; only
    the last round is kept. Of fewer draws than `ESS_LIMIT` in all, which never pass, there is one
    round. The model has the posterior on a star fit to it; where no star holds, tables are made for
    each step, and the star is one about the draws. `start` `[n_slots]` is where the mode is sought
    from; `progress` receives the share done. Equal seeds give equal draws.
    """
    fine, mode = search_mode(posterior, start)
    # Short walks show where a star falls short: a long one on such a star would be in vain.
    for n in (min(PILOT_DRAWS, n_draws), n_draws) if fine.nodes.varies else (n_draws,):
        found = _rounds(fine, mode, n_chains, n, seed, progress)
        for _ in range(MOST_BETTER):
            if (better := improved(fine, found.draws)) is None:
                break
            fine, mode = better, find_mode(better, mode.u)
            found = _rounds(fine, mode, n_chains, n, seed, progress)
    if len(fine.layout.axes) <= FEW_AXES:
        return found
    exact, spread = posterior.exactly(), _following(found.draws, mode)
    if _holds(fine, exact, found.draws, spread, seed):
        return found
    found = _rounds(exact, spread, n_chains, n_draws, seed, progress)
    # Each later evaluation by exact tables would cost runs of all blocks.
    among = star_among(posterior, found.draws)
    return replace(found, friction=among.friction, likelihood=among)


def _holds(star: Posterior, exact: Posterior, draws: Floats, spread: Mode, seed: int) -> bool:
    """Whether a star holds at its `draws` `[n, n_slots]` and beyond, but for a constant."""
    u = draws[np.linspace(0, len(draws) - 1, N_WALKERS).astype(np.int64)]
    state = State(u, exact.log_densities(u), [generator(seed, "held", k) for k in range(len(u))])
    middle = np.median(state.value - star.log_densities(u))
    walk(exact, state, [spread] * len(u), WALKED, 2)
    off = np.abs(state.value - star.log_densities(state.u) - middle)
    return bool(np.mean(off <= OFF) >= 1.0 - MOST_OFF)


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
    proposals = [mode] * n_chains
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
    return Chains(
        tuple(readable),
        tuple(unit for _, unit in readable.values()),
        np.stack([np.broadcast_to(v, draws.shape[:2]) for v, _ in readable.values()], axis=-1),
        acceptance,
    )


def _following(draws: Floats, mode: Mode) -> Mode:
    """The normal by draws `[n, n_slots]`, its covariance drawn a little to the mode's."""
    share = len(draws) / (len(draws) + 10.0 * draws.shape[1])
    found = np.cov(draws.T).reshape(mode.covariance.shape)
    return Mode(draws.mean(axis=0), np.nan, share * found + (1.0 - share) * mode.covariance)


def _offsets(posterior: Posterior, draws: Floats, seed: int) -> dict[str, Floats]:
    """Offsets by group `[n_chains * n_draws]`, given the draws `[n_chains, n_draws, n_slots]`."""
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


N_CHAINS = 4


def calibrate_model(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    *,
    method: MethodName = DEFAULT_METHOD,
    n_chains: int = N_CHAINS,
    n_draws: int = METHODS[DEFAULT_METHOD].n_draws,
    seed: int = 0,
    own: Sequence[Definition] = (),
    start: Floats | None = None,
    progress: Callable[[float], None] = lambda _share: None,
) -> FittedModel:
    """Calibrate a model on observations; nothing is stored.

    `specification` and `facts` are those of `with_effects`, `own` the user's definitions among
    its effects; `start` `[n_slots]` is where the mode is sought from. Raises `AvahazardError`
    where the method cannot do it.
    """
    if method != DEFAULT_METHOD:
        return calibrate_paper(
            observations, specification, method, n_chains=n_chains, n_draws=n_draws, seed=seed
        )
    posterior = assemble(observations, specification, facts, own)
    model = sample(
        posterior,
        n_chains=n_chains,
        n_draws=n_draws,
        seed=seed,
        start=start,
        progress=lambda share: progress(0.2 + 0.65 * share),
    )
    # What the draws came from is in the nodes; the runs of all blocks hold much memory.
    model.posterior.nodes.forget_runs()
    return replace(model, definitions=definitions_of(specification, own), facts=facts)
