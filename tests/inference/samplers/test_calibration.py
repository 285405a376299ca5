"""Simulation-based calibration of the marginal method (Talts et al. 2018).

Parameters are drawn from the prior, records from the model, and the rank of each true parameter
among its posterior draws is uniform if prior, simulation, likelihood and sampler agree. Ranks are
judged by the greatest departure of their distribution function (Säilynoja et al. 2022).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import ELEVATION, LEFT, Observations, build_observations
from avahazard.inference.samplers.marginal import sample
from avahazard.inference.seeds import generator
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from tests.inference.studies import posterior, profile

N_WORLDS, N_DRAWS = 100, 99
VOLUME_MEDIAN, VOLUME_SPREAD = np.exp(10.5), 1.0

PRIORS = {
    "n in 1e-6/m3": (1.0, 1.0),
    "log sigma": (np.log(0.15), 0.3),
}
"""Narrower than the product's, so that frictions stay where blocks move and stop on the bowl;
log a likewise has its case's centre and a standard deviation of 0.1."""


@dataclass(frozen=True)
class Case:
    """A model, the paths of its worlds, its a, and the relative error of recorded volumes."""

    effects: tuple[str, ...]
    n_events: int
    n_paths: int
    a: float = 0.55
    volume_error: float = 1e-6


CASES = {
    "law": Case((), 40, 2),
    "volume error": Case((), 80, 2, volume_error=0.3),
    "path effect": Case(("path-effect",), 48, 8),
    "drag": Case(("turbulent-drag",), 40, 2, a=0.3),
}


@cache
def _ground(n_paths: int) -> tuple[tuple[Path, ...], tuple[Profile, ...]]:
    """Bowls, every other one cut short, so that some events leave it."""
    whole = [profile(k % 6) for k in range(n_paths)]
    cut = [np.where(p.x_m <= (1450.0, 1900.0)[k % 2])[0] for k, p in enumerate(whole)]
    names = [f"P{k}" for k in range(n_paths)]
    return (
        tuple(Path(name) for name in names),
        tuple(
            Profile(name, p.x_m[c], p.y_m[c]) for name, p, c in zip(names, whole, cut, strict=True)
        ),
    )


def _narrowed(observations: Observations, case: Case) -> Posterior:
    """The model with the priors of this test."""
    model = posterior(observations, *case.effects)
    priors = PRIORS | {"log a": (np.log(case.a), 0.1)}
    slots = tuple(
        replace(s, mean=priors[s.name][0], sd=priors[s.name][1]) if s.name in priors else s
        for s in model.layout.slots
    )
    model.layout = replace(model.layout, slots=slots)
    return model


def _from_prior(model: Posterior, rng: np.random.Generator) -> np.ndarray:
    """Coordinates drawn from the prior, cut to its bounds."""
    layout = model.layout
    while True:
        u = np.array([rng.normal(s.mean, s.sd) for s in layout.slots])
        if np.all((u >= layout.low) & (u <= layout.high)):
            return u


def _world(case: Case, rng: np.random.Generator) -> tuple[Observations, np.ndarray]:
    """Records of a world drawn from prior and model, and its true coordinates."""
    paths, profiles = _ground(case.n_paths)
    volume = VOLUME_MEDIAN * np.exp(VOLUME_SPREAD * rng.standard_normal(case.n_events))
    recorded = volume * np.exp(case.volume_error * rng.standard_normal(case.n_events))
    bare = tuple(
        Event(
            f"e{i}",
            paths[i % case.n_paths].path_id,
            left_profile=True,
            volume_m3=float(v),
            volume_rel_sigma=case.volume_error,
        )
        for i, v in enumerate(recorded)
    )
    given = build_observations(Records(paths, profiles, bare))
    model = _narrowed(given, case)
    u = _from_prior(model, rng)
    tables = model.nodes.predicted_at(u)
    law, layout = model.layout.law, model.layout
    nu = law.log_friction(u[: len(law.coordinates)], volume)
    nu = nu + np.exp(u[layout.scatter]) * rng.standard_normal(case.n_events)
    if layout.spreads:
        offsets = 0.2 * u[layout.spreads["path-effect"]] * rng.standard_normal(case.n_paths)
        nu = nu + offsets[np.arange(case.n_events) % case.n_paths]
    sigma = rng.uniform(10.0, 25.0, case.n_events)
    nearest = np.searchsorted(0.5 * (np.log(MU[1:]) + np.log(MU[:-1])), nu)
    left = tables.status[np.arange(case.n_events), nearest] == LEFT_PROFILE
    stop = np.array(
        [np.interp(v, np.log(MU), row) for v, row in zip(nu, tables.record, strict=True)]
    )
    observed = np.where(left, np.nan, stop + sigma * rng.standard_normal(case.n_events))
    observations = replace(
        given, kind=np.where(left, LEFT, ELEVATION), observed=observed, sigma=sigma
    )
    return observations, u


def _ranks(name: str) -> tuple[list[str], np.ndarray, float]:
    """Ranks `[n_worlds, n_slots]` of the truth among draws, and the share that left."""
    case = CASES[name]
    ranks, left, names = [], [], []
    for w in range(N_WORLDS):
        observations, u = _world(case, generator(20050, name, w))
        model = _narrowed(observations, case)
        found = sample(model, n_chains=2, n_draws=500, seed=w)
        draws = found.coordinates.reshape(-1, len(u))
        thinned = draws[np.linspace(0, len(draws) - 1, N_DRAWS).round().astype(int)]
        ranks.append(np.sum(thinned < u, axis=0))
        left.append(np.mean(observations.kind == LEFT))
        names = [s.name for s in model.layout.slots]
    return names, np.array(ranks), float(np.mean(left))


def _departure(ranks: np.ndarray) -> float:
    """The least likely count of ranks up to any value, as a tail probability."""
    n, values = len(ranks), np.arange(N_DRAWS)
    counts = np.sum(ranks[:, None] <= values, axis=0)
    share = (values + 1.0) / (N_DRAWS + 1.0)
    tails = np.minimum(stats.binom.cdf(counts, n, share), stats.binom.sf(counts - 1, n, share))
    return float(tails.min())


@cache
def _null() -> np.ndarray:
    """Departures of ranks that are uniform indeed."""
    rng = np.random.default_rng(1)
    return np.array([_departure(rng.integers(0, N_DRAWS + 1, N_WORLDS)) for _ in range(2000)])


def _p_value(ranks: np.ndarray) -> float:
    return float(np.mean(_null() <= _departure(ranks)))


def test_the_judge_tells_uniform_ranks_from_others() -> None:
    rng = np.random.default_rng(2)
    assert _p_value(rng.integers(0, N_DRAWS + 1, N_WORLDS)) > 0.01
    narrow = np.clip(rng.normal(50.0, 18.0, N_WORLDS), 0, N_DRAWS).astype(int)
    assert _p_value(narrow) < 0.01
    assert _p_value(np.minimum(rng.integers(0, N_DRAWS + 1, N_WORLDS) + 18, N_DRAWS)) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_ranks_are_uniform(name: str) -> None:
    names, ranks, left = _ranks(name)
    assert left > 0.02, "events that leave the profile belong to the test"
    p_values = {s: _p_value(ranks[:, k]) for k, s in enumerate(names)}
    print(name, f"left {left:.2f}", {s: round(p, 3) for s, p in p_values.items()})
    assert min(p_values.values()) > 0.01 / len(names)
