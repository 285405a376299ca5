"""The evidence of one candidate of `diagnose` against nested sampling of the same density."""

from __future__ import annotations

import time

import numpy as np
from dynesty import NestedSampler
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.inference.fitting.mode import log_prior_mass
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.synth.making import make_dataset
from benchmarks.measuring import Row, alternate

Floats = NDArray[np.float64]

CANDIDATE = "turbulent-drag"
N_LIVE = 250
ALLOWED = 1.0
"""Nats by which the two may differ."""


def evidence() -> Row:
    """Seconds of an evidence; ours with the search for the mode, from the model without."""
    records, _ = make_dataset(70, 240, 9, {CANDIDATE: 1.0})
    observations = build_observations(records)
    base = refit(observations, Specification(), {}, ("path-effect",))
    fit = _refit(observations, base)
    # What both sum over: on our grids as they are once the mode has converged.
    posterior = fit.posterior
    exact = posterior.exact_log_likelihood(fit.mode.u) - posterior.log_likelihood(fit.mode.u)
    found: dict[str, list[float]] = {"ours": [], "theirs": [], "calls": []}
    seeds = iter(range(1, 100))

    def ours() -> float:
        start = time.perf_counter()
        found["ours"].append(_refit(observations, base).evidence)
        return time.perf_counter() - start

    def theirs() -> float:
        start = time.perf_counter()
        value, calls = nested(posterior, next(seeds))
        found["theirs"].append(value + exact)
        found["calls"].append(calls)
        return time.perf_counter() - start

    times = alternate(ours, theirs, 2)
    off = abs(float(np.mean(found["ours"]) - np.mean(found["theirs"])))
    if off > ALLOWED:
        raise SystemExit(f"evidence: the two differ by {off:.2f} nats.")
    return (
        *times,
        f"`{CANDIDATE}` on 240 events of 9 paths that may differ, {len(fit.mode.u)} parameters. "
        f"They agree within {off:.2f} nats (dynesty's own runs within "
        f"{np.ptp(found['theirs']):.2f}). Ours includes the search for the mode and its tables; "
        f"dynesty ({N_LIVE} live points, {np.mean(found['calls']):,.0f} densities) is given our "
        "compiled density and precomputed tables.",
    )


def _refit(observations: Observations, base: Refit) -> Refit:
    return refit(observations, base.specification, base.facts, (CANDIDATE,), (), base)


def nested(posterior: Posterior, seed: int) -> tuple[float, int]:
    """Log evidence by nested sampling over the priors' own ranges, and the densities it took."""
    slots = posterior.layout.slots
    mean, sd = (np.array([getattr(slot, name) for slot in slots]) for name in ("mean", "sd"))
    low, high = posterior.layout.low, posterior.layout.high
    first, last = ndtr((low - mean) / sd), ndtr((high - mean) / sd)
    # Grids refined about a mode narrow the ranges; the prior stays what it was.
    narrowed = float(np.sum(np.log(sd) + 0.5 * np.log(2.0 * np.pi) + np.log(last - first)))

    def from_cube(cube: Floats) -> Floats:
        inside = mean + sd * ndtri(first + cube * (last - first))
        return np.clip(inside, low, high)

    sampler = NestedSampler(
        posterior.log_likelihood,
        from_cube,
        len(slots),
        nlive=N_LIVE,
        rstate=np.random.default_rng(seed),
    )
    sampler.run_nested(dlogz=0.1, print_progress=False)
    results = sampler.results
    value = float(results.logz[-1]) + narrowed - log_prior_mass(posterior)
    return value, int(np.sum(results.ncall))
