"""Avalanches beyond their profile from a release that is not known well.

The slow twin starts blocks by another integrator from many places, asks with which friction each
reaches the end, and takes the mean of the chances.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy import stats

from avahazard.criticism.scoring.scores import expected_records
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Event, Path, Records
from avahazard.synth.dataset import make_track, run_track
from tests.inference.studies import profile

Z0, SIGMA_Z, SCATTER = 900.0, 40.0, 0.05
GROUND = profile(0)
TRACK = make_track(GROUND.x_m, GROUND.y_m)
N_RELEASES = 101


@cache
def frictions_to_the_end(sigma_z: float) -> np.ndarray:
    """The friction under which blocks leave that start at as likely places, by bisection."""
    z = Z0 + sigma_z * stats.norm.ppf((np.arange(N_RELEASES) + 0.5) / N_RELEASES)
    start = TRACK.place(np.minimum(z, GROUND.y_m[0]))
    low, high = np.full(N_RELEASES, 0.2), np.full(N_RELEASES, 0.6)
    for _ in range(20):
        middle = 0.5 * (low + high)
        stopped = run_track(TRACK, start, middle)[0] == 0
        low, high = np.where(stopped, low, middle), np.where(stopped, middle, high)
    return low


def posterior(sigma_z: float, n: int = 1, distribution: str = "lognormal") -> Posterior:
    events = tuple(
        Event(
            f"e{k}",
            "P0",
            left_profile=True,
            release_elevation_m=Z0,
            covariates={"release_sigma_m": sigma_z} if sigma_z else {},
        )
        for k in range(n)
    )
    specification = Specification(law="constant", distribution=distribution)  # type: ignore[arg-type]
    records = Records((Path("P0"),), (GROUND,), events)
    return Posterior(build_observations(records), specification, ())


def at(model: Posterior, mu: float, scatter: float = SCATTER) -> np.ndarray:
    u = np.zeros(len(model.layout.slots))
    u[0], u[model.layout.scatter] = np.log(mu), np.log(scatter)
    return u


@pytest.mark.parametrize("distribution", ["lognormal", "normal"])
def test_the_chance_to_leave_is_that_over_all_releases(distribution: str) -> None:
    model = posterior(SIGMA_Z, distribution=distribution)
    known = posterior(0.0, distribution=distribution)
    edges = frictions_to_the_end(SIGMA_Z)
    middle = float(np.median(edges))
    scatter = SCATTER if distribution == "lognormal" else SCATTER * middle
    moved = []
    for mu in middle * np.array([0.9, 0.97, 1.03, 1.1, 1.16]):
        away = np.log(edges / mu) if distribution == "lognormal" else edges - mu
        slow = float(np.log(np.mean(stats.norm.cdf(away / scatter))))
        u = at(model, float(mu), scatter)
        assert model.log_likelihood(u) == pytest.approx(slow, abs=0.1 + 0.03 * abs(slow))
        moved.append(abs(known.log_likelihood(u) - slow))
    # It matters here: without it some of these would be far off.
    assert max(moved) > 0.5


def test_records_are_drawn_as_often_beyond_the_end() -> None:
    n = 400
    model = posterior(SIGMA_Z, n)
    mu = float(np.median(frictions_to_the_end(SIGMA_Z))) * 1.1
    u = at(model, mu)
    chance = float(np.exp(model.log_likelihood(u) / n))
    sharp = float(np.exp(posterior(0.0).log_likelihood(u)))
    assert chance > 1.4 * sharp
    rng = np.random.default_rng(5)
    drawn = expected_records(fitted_model(model, np.repeat(u[None], 60, 0), {}), 60, rng)
    error = 4.0 * np.sqrt(chance / drawn.left.size)
    assert drawn.left.mean() == pytest.approx(chance, abs=error)
