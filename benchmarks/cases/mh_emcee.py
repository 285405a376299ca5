"""Metropolis-Hastings of section 2c against emcee, on the twin's 173 events."""

from __future__ import annotations

import time

import emcee
import numpy as np
from numba import njit

from avahazard.inference.fitted_model import diagnose_chains
from avahazard.inference.model.laws import law
from avahazard.inference.paper.metropolis import runout_records, squared_residuals, walk
from benchmarks.cases.twin import twin
from benchmarks.measuring import Result, alternate

N_WALKERS = 32
N_STEPS = 3000
N_BURN = 500
N_DRAWS = 25_000


@njit
def log_density(points, records, mean, precision, place):  # type: ignore[no-untyped-def]
    """Our posterior at points `[n_walkers, 3]`: coordinates of the law and log σ, flat on σ."""
    out = np.empty(len(points))
    for i in range(len(points)):
        u, log_sigma = points[i, :2], points[i, 2]
        squares = squared_residuals(u, records, place)
        out[i] = -0.5 * np.sum((u - mean) ** 2 * precision) - 0.5 * squares * np.exp(-2 * log_sigma)
        out[i] += (1 - len(records.y)) * log_sigma
    return out


def measure() -> Result:
    """Smallest effective sample size per second."""
    exponential = law("exponential")
    data = twin()
    records = runout_records(exponential, *data[:6])
    mean, sd = exponential.prior_mean, exponential.prior_sd
    start = exponential.start(data.volume, data.mu)
    spread = np.diag([0.03, 0.15])
    seeds = iter(range(1, 1000))
    place = np.empty(len(records.y))
    means = {}

    def ours() -> float:
        begin = time.perf_counter()
        draws, sigma, _ = walk(
            records, mean, sd, (-0.5, 0.0), start, spread, next(seeds), 4, N_DRAWS, 2400
        )
        taken = time.perf_counter() - begin
        both = np.concatenate([draws, np.log(sigma)[..., None]], axis=2)
        means["ours"] = both.mean(axis=(0, 1)), both.std(axis=(0, 1))
        return diagnose_chains(both).ess_bulk_min / taken

    def theirs() -> float:
        rng = np.random.default_rng(next(seeds))
        first = np.append(start, np.log(150.0)) + rng.normal(size=(N_WALKERS, 3)) * 0.05
        sampler = emcee.EnsembleSampler(
            N_WALKERS,
            3,
            lambda p: log_density(p, records, mean, sd**-2.0, place),
            vectorize=True,
        )
        state = sampler.run_mcmc(first, N_BURN)
        sampler.reset()
        begin = time.perf_counter()
        sampler.run_mcmc(state, N_STEPS)
        taken = time.perf_counter() - begin
        chain = np.swapaxes(sampler.get_chain(), 0, 1)
        means["theirs"] = chain.mean(axis=(0, 1)), chain.std(axis=(0, 1))
        by_time = N_WALKERS * N_STEPS / np.max(sampler.get_autocorr_time(quiet=True))
        return max(diagnose_chains(chain).ess_bulk_min, by_time) / taken

    a, b, inverse = alternate(ours, theirs, 7)
    off = np.max(np.abs(means["ours"][0] - means["theirs"][0]) / means["theirs"][1])
    if off > 0.15:
        raise SystemExit(f"mh_emcee: the two posteriors differ by {off:.2f} sd.")
    return Result(
        1.0 / inverse,
        a,
        b,
        "smallest ESS per second",
        47.0,
        False,
        "our smallest ESS per second over emcee's",
        f"means of the two posteriors agree within {off:.2f} sd. Our time holds four chains with "
        "their warm-up; emcee's burn-in is not counted. emcee calls our compiled log density once "
        "for all walkers of a half step, and is given the better of two estimates of its ESS.",
    )
