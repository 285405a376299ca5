"""The marginal likelihood with a path effect, sampled by us and by NumPyro's NUTS."""

from __future__ import annotations

import tempfile
import time

import jax
import jax.numpy as jnp
import numpy as np
import numpyro
from jax.scipy.special import ndtr
from numpyro.distributions import Distribution, Normal, TruncatedNormal
from numpyro.infer import MCMC, NUTS, init_to_value

from avahazard.inference.fitted_model import diagnose_chains
from avahazard.inference.fitting.star import search_mode
from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import Slot
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.sampling import sample
from avahazard.store.records import load_records
from avahazard.store.session import reading
from benchmarks.cases.programs import demo
from benchmarks.measuring import Row, alternate

N_CHAINS, N_DRAWS = 4, 1000
THEIR_CHAINS, N_THEIRS = 2, 300
ALLOWED = 0.2
"""Standard deviations by which the means may differ."""


def marginal_nuts() -> Row:
    """Smallest effective sample size per second of the parameters that both have."""
    numpyro.enable_x64()
    posterior = _posterior()
    slots = [slot.name for slot in posterior.layout.slots]
    nuts = MCMC(
        NUTS(_model(posterior), init_strategy=init_to_value(values=_start(posterior))),
        num_warmup=N_THEIRS,
        num_samples=N_THEIRS,
        num_chains=THEIR_CHAINS,
        chain_method="sequential",
        progress_bar=False,
    )
    seeds = iter(range(1, 100))
    means: dict[str, list[np.ndarray]] = {"ours": [], "theirs": []}
    spread = np.empty(len(slots))

    def ours() -> float:
        begin = time.perf_counter()
        found = sample(posterior, n_chains=N_CHAINS, n_draws=N_DRAWS, seed=next(seeds))
        taken = time.perf_counter() - begin
        draws = found.draws.reshape(N_CHAINS, N_DRAWS, -1)
        means["ours"].append(draws.mean(axis=(0, 1)))
        return diagnose_chains(draws).ess_bulk_min / taken

    def theirs() -> float:
        begin = time.perf_counter()
        nuts.run(jax.random.PRNGKey(next(seeds)))
        drawn = jax.block_until_ready(nuts.get_samples(group_by_chain=True))
        taken = time.perf_counter() - begin
        draws = np.stack([np.asarray(drawn[name]) for name in slots], axis=-1)
        means["theirs"].append(draws.mean(axis=(0, 1)))
        spread[:] = draws.std(axis=(0, 1))
        return diagnose_chains(draws).ess_bulk_min / taken

    inverse, a, b = alternate(ours, theirs, 1)
    away = np.mean(means["ours"], axis=0) - np.mean(means["theirs"], axis=0)
    off = float(np.max(np.abs(away) / spread))
    if off > ALLOWED:
        raise SystemExit(f"marginal_nuts: the two posteriors differ by {off:.2f} sd.")
    note = (
        f"the {posterior.observations.n_events} events of the demo, paths that may differ, "
        f"{len(slots)} parameters; means agree within {off:.2f} sd. Both times include the "
        "warm-up, ours also the search for the mode; compiling is not counted. NUTS is given "
        "our mode to start from (from random points it wanders where the likelihood is flat), and "
        "draws the paths' offsets (non-centred); we integrate over them. nutpie was not run."
    )
    return 1.0 / inverse, a, b, note


def _posterior() -> Posterior:
    """The model of the demo's records with a path effect."""
    with tempfile.TemporaryDirectory() as folder, reading(demo(folder)) as session:
        observations = build_observations(load_records(session))
    specification, facts = with_effects(observations, Specification(), ["path-effect"])
    return assemble(observations, specification, facts)


def _start(posterior: Posterior) -> dict[str, jax.Array]:
    """Where the rival starts: our mode, with paths that hardly differ."""
    u = search_mode(posterior)[1].u.copy()
    (spread,) = posterior.layout.spreads.values()
    u[spread] = max(u[spread], 0.1)  # on its bound of 0 it could not move
    start = {slot.name: jnp.array(v) for slot, v in zip(posterior.layout.slots, u, strict=True)}
    return {**start, "z": jnp.zeros(len(posterior.plan.of))}


def _prior(slot: Slot) -> Distribution:
    """The prior of one coordinate; a side without a bound must not be given one."""
    low, high = (v if np.isfinite(v) else None for v in (slot.low, slot.high))
    if low is None and high is None:
        return Normal(slot.mean, slot.sd)
    return TruncatedNormal(slot.mean, slot.sd, low=low, high=high)


def _model(posterior: Posterior):
    """The same density in JAX: nodes of the records and of sight, volumes, offsets of the paths."""
    layout, plan = posterior.layout, posterior.plan
    nodes = posterior.nodes.at(np.zeros(len(layout.slots)))
    if np.any(nodes.tail) or np.any(plan.alone):
        raise SystemExit("marginal_nuts: these records need more than the model in JAX has.")
    volume = posterior.observations.volumes.volume / 1e6
    weight = posterior.observations.volumes.weight
    (spread,) = layout.spreads.values()
    index = plan.index[0]
    # Columns that no record uses would cost NUTS time.
    used, seen_used = nodes.weight.any(axis=0), nodes.seen_weight.any(axis=0)
    place, node_weight = nodes.place[:, used], nodes.weight[:, used]
    seen_place, seen_weight = nodes.seen_place[:, seen_used], nodes.seen_weight[:, seen_used]

    def summed(nodes: jax.Array, weights: jax.Array) -> jax.Array:
        return jnp.sum(weight * jnp.sum(weights[:, None, :] * nodes, axis=2), axis=1)

    def model() -> None:
        u = [numpyro.sample(s.name, _prior(s)) for s in layout.slots]
        with numpyro.plate("paths", len(plan.of)):
            z = numpyro.sample("z", Normal(0.0, 1.0))
        tau = u[spread] * layout.slots[spread].scale
        location = u[0] - u[1] * volume + (tau * z)[index][:, None]
        sigma = jnp.exp(u[layout.scatter])
        away = (place[:, None, :] - location[:, :, None]) / sigma
        density = jnp.exp(-0.5 * away**2) / (sigma * np.sqrt(2.0 * np.pi))
        each = jnp.where(nodes.is_probability[:, None, None], ndtr(away), density)
        total = nodes.floor + summed(each, node_weight)
        below = ndtr((seen_place[:, None, :] - location[:, :, None]) / sigma)
        seen = nodes.seen_floor + summed(below, seen_weight)
        numpyro.factor("records", jnp.sum(jnp.log(total + 1e-290) - jnp.log(seen)))

    return model
