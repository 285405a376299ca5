"""Simulation-based calibration of the paper's methods, each by its own model.

Parameters are drawn from the prior that the method is given and frictions or runouts from its
model; the ranks of the truth among the draws are uniform. `fit` has no prior: that the truth lies
within its standard errors as often as Student's t says is asked of it in the same way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.laws import Law, law
from avahazard.inference.paper.calibration import WEAK_ON_SIGMA, gibbs, metropolis, runout_records
from avahazard.inference.paper.least_squares import fit_law
from avahazard.inference.seeds import generator
from avahazard.physics.runout_curve import EVEN, MU, MU_STEP
from tests.inference.sbc import LEVEL, N_DRAWS, least_p, rank
from tests.inference.studies import observations

N_EVENTS = 30
SQUARE = (5.0, 1600.0)
"""Shape and scale of the inverse gamma of σ² (m²) about (20 m)²."""
NARROW = {
    "exponential": ([np.log(0.55), 1.0], [0.1, 1.0]),
    "power": ([np.log(0.55) + 0.05 * 10.5, 0.05], [0.1, 0.03]),
    "rational": ([np.log(0.55), 0.5, 0.0], [0.1, 0.5, 0.3]),
}
"""Means and standard deviations by which blocks stop on the bowls, of the law's coordinates."""
Rng = np.random.Generator
World = Callable[[Law, int, Rng, float], np.ndarray]


def _volumes(rng: Rng) -> np.ndarray:
    return np.asarray(np.exp(10.5 + rng.standard_normal(N_EVENTS)))


def gibbs_ranks(chosen: Law, seed: int, rng: Rng, fault: float) -> np.ndarray:
    """Apparent frictions about the law; with a fault they scatter more than stated."""
    u = chosen.prior_mean + chosen.prior_sd * rng.standard_normal(len(chosen.prior_mean))
    sigma = np.sqrt(WEAK_ON_SIGMA[1] / rng.standard_gamma(WEAK_ON_SIGMA[0]))
    volume = _volumes(rng)
    scatter = (1.0 + fault) * sigma * rng.standard_normal(N_EVENTS)
    mu = np.exp(chosen.log_friction(u, volume) + scatter)
    found = gibbs(chosen, volume, mu, seed=seed, n_chains=2, n_draws=500).pooled()
    return rank(found, np.append(chosen.to_natural(u), sigma))


def metropolis_ranks(chosen: Law, seed: int, rng: Rng, fault: float) -> np.ndarray:
    """Elevations of stops about those of the law; with a fault they scatter more than stated."""
    table = predict_records(observations(), (), {}).elevation[:6, EVEN]
    mean, sd = (np.array(values) for values in NARROW[chosen.name])
    u = mean + sd * rng.standard_normal(len(mean))
    sigma = np.sqrt(SQUARE[1] / rng.standard_gamma(SQUARE[0]))
    volume, row = _volumes(rng), np.arange(N_EVENTS) % len(table)
    mu = np.exp(chosen.log_friction(u, volume))
    stop = np.array([np.interp(m, MU[EVEN], table[k]) for m, k in zip(mu, row, strict=True)])
    runout = stop + (1.0 + fault) * sigma * rng.standard_normal(N_EVENTS)
    records = runout_records(chosen, volume, runout, row, table, float(MU[EVEN][0]), MU_STEP)
    narrow = replace(chosen, prior_mean=mean, prior_sd=sd)
    drawn = metropolis(narrow, volume, records, mean, seed=seed, n_chains=2, sigma_prior=SQUARE)
    found = drawn.pooled()
    truth, free = chosen.to_natural(u), np.ones(len(chosen.names) + 1, dtype=bool)
    if chosen.name == "rational":
        free[1] = False  # b is 1
    return rank(found, np.append(truth, sigma))[free]


def fit_ranks(chosen: Law, _seed: int, rng: Rng, fault: float) -> np.ndarray:
    """Frictions about the law; with a fault they err in pairs, which the fit takes as single."""
    mean, sd = (np.array(values) for values in NARROW.get(chosen.name, ([np.log(0.55)], [0.1])))
    u = mean + sd * rng.standard_normal(len(mean))
    volume, error = _volumes(rng), 0.03 * rng.standard_normal(N_EVENTS)
    if fault:
        error, volume = np.repeat(error[::2], 2), np.repeat(volume[::2], 2)
    found = fit_law(chosen, volume, np.exp(chosen.log_friction(u, volume)) + error)
    z = (chosen.to_natural(u) - found.parameters) / found.standard_errors
    below = stats.t.cdf(z, N_EVENTS - len(mean))
    return np.asarray(np.minimum((N_DRAWS + 1) * below, N_DRAWS).astype(int))


METHODS: dict[str, tuple[World, tuple[str, ...], int]] = {
    "gibbs": (gibbs_ranks, ("exponential", "power", "constant"), 200),
    "metropolis": (metropolis_ranks, ("exponential", "power", "rational"), 400),
    "fit": (fit_ranks, ("exponential", "power", "constant"), 400),
}


def _least_p(method: str, name: str, fault: float = 0.0) -> float:
    world, _, n_worlds = METHODS[method]
    ranks = [world(law(name), w, generator(20051, method, name, w), fault) for w in range(n_worlds)]
    return least_p([f"{method} {name} {k}" for k in range(len(ranks[0]))], np.array(ranks))


@pytest.mark.slow
@pytest.mark.parametrize(("method", "name"), [(m, n) for m in METHODS for n in METHODS[m][1]])
def test_ranks_of_the_papers_methods_are_uniform(method: str, name: str) -> None:
    assert _least_p(method, name) > LEVEL


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_a_fault_of_the_model_is_seen(method: str) -> None:
    assert _least_p(method, "exponential", fault=0.4) < LEVEL
