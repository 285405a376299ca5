"""Moments of likelihoods that must be right where friction is expected."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from scipy.stats import norm

from avahazard.criticism.screening.bell import FLATTEST, WIDTH, bell_of, without_bell
from avahazard.criticism.screening.moments_of_worlds import moments_of
from avahazard.criticism.screening.parametric_bootstrap import real_world
from avahazard.criticism.screening.tables import LOG_MU, make_tables
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import LEFT, build_observations
from avahazard.synth.making import make_world
from tests.inference import studies


# Inner kernels are called by others alone.
@njit
def _taken_out(mean: float, variance: float, log_mass: float, about: float):  # type: ignore[no-untyped-def]
    return without_bell(mean, variance, log_mass, about)


@njit
def _bell_of(about: float):  # type: ignore[no-untyped-def]
    return bell_of(about)


@pytest.mark.parametrize(("place", "sd"), [(-0.7, 0.003), (-1.4, 0.1), (0.3, 0.6)])
def test_what_the_bell_did_to_a_normal_is_undone(place: float, sd: float) -> None:
    about, log_mass = -0.8, -3.2
    precision = sd**-2 + WIDTH**-2
    mean = (place * sd**-2 + about * WIDTH**-2) / precision
    # ∫ N(ν; place, sd²) exp(-(ν - about)² / (2 WIDTH²)) dν
    shared = norm.logpdf(place, about, np.hypot(sd, WIDTH)) + np.log(WIDTH * np.sqrt(2.0 * np.pi))
    found = _taken_out(mean, 1.0 / precision, log_mass + shared, about)
    assert found == pytest.approx((place, sd**2, log_mass), rel=1e-9)


def test_what_says_nothing_stays_finite() -> None:
    mean, variance, _ = _taken_out(-0.6, WIDTH**2, 0.0, -0.8)
    assert variance == pytest.approx(1.0 / FLATTEST)
    assert np.isfinite(mean)


def test_without_a_bell_nothing_changes() -> None:
    assert _taken_out(-0.6, 0.2, -1.0, np.nan) == (-0.6, 0.2, -1.0)
    assert _bell_of(np.nan) == (0.0, 0.0)


def test_where_a_block_is_held_back_whatever_its_friction_that_is_told() -> None:
    """∫ p(record | ν) N(ν; m, 0.25²) dν by the moments and by a plain sum, under much cohesion."""
    observations = build_observations(make_world(1, 400, 20)[0])
    cohesion = find_definition("cohesion")
    effect = cohesion.build(cohesion.facts(observations.columns, observations.sites))
    predicted = predict_records(observations, (effect,), {"cohesion": np.array([2.2])})
    expected = np.full(observations.n_events, -0.8)
    tables = make_tables(observations, predicted, observations.limit, 0.0, expected)
    anywhere = make_tables(observations, predicted, observations.limit, 0.0)
    records = real_world(studies.posterior(observations))
    at = -1.4  # what cohesion does is taken from friction
    nu = np.linspace(LOG_MU[0], LOG_MU[-1], 200_001)
    prior = norm.pdf(nu, at, 0.25) * (nu[1] - nu[0])
    near, free = [], []
    one, other = moments_of(tables, records), moments_of(anywhere, records)
    for i in np.flatnonzero((observations.kind != LEFT) & (other.variance > 0.02)):
        reach = nu >= LOG_MU[max(tables.last_left[i], 0)]
        record = np.interp(nu, LOG_MU, tables.record[i])
        density = norm.pdf(observations.observed[i], record, tables.sigma[i])
        exact = np.log(np.sum((density * prior)[reach]))
        for told, some in ((one, near), (other, free)):
            spread = np.sqrt(0.25**2 + told.variance[i])
            some.append(told.log_mass[i] + norm.logpdf(told.mean[i], at, spread) - exact)
    assert len(near) > 50
    assert np.mean(np.abs(near)) < 0.1 * np.mean(np.abs(free))
    assert np.median(np.abs(near)) < 0.03
