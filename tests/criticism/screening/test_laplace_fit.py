from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import minimize

from avahazard.criticism.diagnosis.refits import refit, without_groups
from avahazard.criticism.screening.laplace_fit import (
    SCATTER_MEAN,
    SCATTER_SD,
    Design,
    Edges,
    laplace_fit,
)
from avahazard.criticism.screening.record_moments import RecordMoments
from avahazard.criticism.screening.screen import screen
from avahazard.effects.groups import SPREAD
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.synth.making import make_world

PATH_EFFECT = "path-effect"

N, N_PATHS = 90, 6


def moments_and_design(n_paths: int, student: bool = False) -> tuple[RecordMoments, Design]:
    rng = np.random.default_rng(4)
    path = np.arange(N) % N_PATHS
    x = np.column_stack([np.ones(N), rng.standard_normal((N, 2))])
    variance = rng.uniform(0.001, 0.01, N)
    unit = rng.standard_t(4, N) if student else rng.standard_normal(N)
    shift = 0.15 * rng.standard_normal(N_PATHS)[path] if n_paths else np.zeros(N)
    mean = x @ [-0.8, 0.1, 0.0] + shift + 0.2 * unit + np.sqrt(variance) * rng.standard_normal(N)
    design = Design(
        x=x,
        constant=np.full(N, 0.05),
        prior_mean=np.zeros(3),
        prior_precision=np.array([1.0, 25.0, 25.0]),
        of=np.zeros(n_paths, dtype=np.int64),
        places=path[None] if n_paths else np.empty((0, N), dtype=np.int64),
        alone=np.zeros((1 if n_paths else 0, N), dtype=bool),
        rest=np.full(n_paths, -1),
        spread_scale=np.full(1 if n_paths else 0, SPREAD),
        extra=rng.uniform(0.0, 0.002, N),
        multiplier=np.exp(0.2 * rng.standard_normal(N)),
        log_wrong=np.where(path == 0, -np.inf, -8.0),
    )
    return RecordMoments(mean, variance, rng.normal(-4.0, 1.0, N)), design


def first_tau(design: Design) -> np.ndarray:
    return np.full(len(design.places), 0.1)


def no_edges() -> Edges:
    never = np.full(N, -9.0)
    return Edges(never, np.zeros(N), np.full(N, 9.0), np.zeros(N), np.zeros(N, dtype=bool))


def log_density(theta, moments, left, edges, design, student):  # type: ignore[no-untyped-def]
    """The same objective, plainly; path offsets are integrated out exactly."""
    beta, log_scatter = theta[:3], theta[3]
    m = design.constant + design.x @ beta
    own = (np.exp(log_scatter) * design.multiplier) ** 2
    s = own + moments.variance + design.extra
    value = -0.5 * np.sum(design.prior_precision * (beta - design.prior_mean) ** 2)
    value -= 0.5 * ((log_scatter - SCATTER_MEAN) / SCATTER_SD) ** 2
    value += 0.0 if student else moments.log_mass[~left].sum()
    gone = np.sqrt((own + design.extra)[left])
    value += stats.norm.logcdf((edges.leave[left] - m[left]) / gone).sum()
    near = edges.has_limit
    never_sharper = np.maximum(edges.detected_sd**2, moments.variance)
    blur = np.sqrt((own + never_sharper + design.extra)[near])
    shape = stats.t(4) if student else stats.norm
    seen = np.zeros(N)
    seen[near] = shape.logcdf((edges.detected[near] - m[near]) / blur)
    e = (moments.mean - m)[~left]
    s = s[~left]
    if student:
        right = shape.logpdf(e / np.sqrt(s)) - 0.5 * np.log(s) + moments.log_mass[~left]
        right -= seen[~left]
        return value + np.logaddexp(right, design.log_wrong[~left]).sum()
    value -= seen.sum()
    if not len(design.of):
        return value + stats.norm.logpdf(e, 0.0, np.sqrt(s)).sum()
    tau = np.exp(theta[4])
    together = design.places[0][:, None] == design.places[0]
    covariance = np.diag(s) + tau**2 * together
    value += stats.multivariate_normal(np.zeros(N), covariance).logpdf(e)
    return value - 0.5 * (tau / SPREAD) ** 2


def plain_optimum(moments, left, edges, design, student):  # type: ignore[no-untyped-def]
    start = np.array([-0.8, 0.0, 0.0, -1.6, -2.0])
    found = minimize(
        lambda v: -log_density(v, moments, left, edges, design, student),
        start if len(design.of) else start[:4],
        method="BFGS",
    )
    return -found.fun, found.x


@pytest.mark.parametrize("case", ["plain", "paths", "student", "left", "limit", "student limit"])
def test_it_reaches_the_optimum_of_a_plain_optimiser(case: str) -> None:
    student = case.startswith("student")
    moments, design = moments_and_design(N_PATHS if case == "paths" else 0, student)
    if case == "student":
        moments.log_mass[::9] = -5000.0  # records where no friction stops a block
        design.log_wrong[::9] = -9.0
    left, edges = np.zeros(N, dtype=bool), no_edges()
    if case == "left":
        left[::7] = True
        moments.mean[left], moments.variance[left], moments.log_mass[left] = 0.0, 0.0, 0.0
        edges = edges._replace(leave=np.full(N, -0.9))
    if case.endswith("limit"):
        edges = edges._replace(
            detected=np.full(N, -0.6), detected_sd=np.full(N, 0.03), has_limit=np.arange(N) % 2 == 0
        )
        keep = (moments.mean < -0.6) | ~edges.has_limit
        edges = edges._replace(has_limit=edges.has_limit & keep)
    found = laplace_fit(
        moments, left, edges, design, np.array([-1.0, 0.0, 0.0]), -1.9, first_tau(design), student
    )
    best, theta = plain_optimum(moments, left, edges, design, student)
    assert found.log_likelihood == pytest.approx(best, abs=0.1)
    assert found.coefficients == pytest.approx(theta[:3], abs=0.02)
    assert found.log_scatter == pytest.approx(theta[3], abs=0.05)


def test_no_friction_is_likely_because_it_is_never_seen() -> None:
    """Student's tails fall slower than a normal chance to be seen: from far off that would win."""
    moments, design = moments_and_design(0, student=True)
    edges = no_edges()._replace(
        detected=np.full(N, np.max(moments.mean)), has_limit=np.ones(N, dtype=bool)
    )
    far = laplace_fit(
        *(moments, np.zeros(N, dtype=bool), edges, design, np.array([50.0, 0.0, 0.0])),
        *(-1.9, first_tau(design), True),
    )
    near = laplace_fit(
        *(moments, np.zeros(N, dtype=bool), edges, design, np.array([-0.8, 0.0, 0.0])),
        *(-1.9, first_tau(design), True),
    )
    assert far.log_likelihood < near.log_likelihood + 0.1
    assert near.coefficients[0] == pytest.approx(-0.8, abs=0.2)


def test_offsets_of_paths_take_what_paths_differ_by() -> None:
    moments, design = moments_and_design(N_PATHS)
    start, left = np.array([-0.8, 0.0, 0.0]), np.zeros(N, dtype=bool)
    _, bare = moments_and_design(0)
    bare = bare._replace(x=design.x, extra=design.extra, multiplier=design.multiplier)
    without = laplace_fit(moments, left, no_edges(), bare, start, -1.6, np.empty(0), False)
    with_ = laplace_fit(moments, left, no_edges(), design, start, -1.6, first_tau(design), False)
    assert with_.log_likelihood > without.log_likelihood + 5.0
    assert 0.05 < with_.tau[0] < 0.4
    assert with_.log_scatter < without.log_scatter


@pytest.mark.slow
@pytest.mark.parametrize("key", ["snow-type", "path-section", "turbulent-drag", "leading-edge"])
def test_gains_are_those_of_the_full_posterior(key: str) -> None:
    records, _ = make_world(5, 160, 8, {key: 1.5})
    observations = build_observations(records)
    base = refit(observations, Specification(), {}, (PATH_EFFECT,))
    bare, u, told = without_groups(base, observations, ())
    screened = screen(bare, u, told, [find_definition(key)], n_worlds=1).candidates[0]
    full = refit(observations, base.specification, base.facts, (key,), (), base)
    # Both with the prior of the parameters.
    gain = full.mode.log_density - base.mode.log_density
    assert gain > 5.0
    assert abs(screened.gain - gain) < max(0.5, 0.1 * gain)
