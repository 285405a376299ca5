"""Priors on the law that come from other records."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from avahazard.inference.fitting.mode import log_prior_mass
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.laws import LAWS, Law, law
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import (
    GivenPrior,
    LawPrior,
    Specification,
    free_parameters,
    given_law_prior,
    law_prior,
    positive_parameters,
    prior_of_fit,
    require_possible,
)
from avahazard.inference.paper.least_squares import fit_law
from avahazard.records.collection import Event, Records
from avahazard.records.errors import AvahazardError
from avahazard.results.base import reader_of
from tests.inference.new_law import halving

EXPONENTIAL = law("exponential")
MEAN, COVARIANCE = np.array([np.log(0.52), 0.4]), np.array([[0.01, 0.012], [0.012, 0.04]])
PRIOR = law_prior("other", EXPONENTIAL, MEAN, COVARIANCE)


def posterior(specification: Specification) -> Posterior:
    events = tuple(
        Event(f"e{k}", fall_height_m=500.0, runout_length_m=900.0 + 30.0 * k, volume_m3=1e4 * k)
        for k in range(1, 6)
    )
    return Posterior(build_observations(Records(events=events)), specification, ())


def test_the_prior_is_the_joint_normal() -> None:
    layout = posterior(Specification(prior=PRIOR)).layout
    plain = posterior(Specification()).layout
    u = np.random.default_rng(0).normal(size=(50, 3)) * 0.3
    # What the scatter adds is that of the model without a prior from others.
    scatter = plain.log_prior(np.column_stack([np.tile(EXPONENTIAL.prior_mean, (50, 1)), u[:, 2]]))
    exact = multivariate_normal(MEAN, COVARIANCE)
    expected = exact.logpdf(u[:, :2]) - exact.logpdf(MEAN) + scatter
    assert layout.log_prior(u) == pytest.approx(expected)
    assert layout.log_prior(u[3]) == pytest.approx(expected[3])


def test_its_slopes_are_those_of_the_joint_normal() -> None:
    for prior in (PRIOR, None):
        layout = posterior(Specification(prior=prior)).layout
        u, steps = np.array([-0.4, 0.9, -2.2]), 1e-5 * np.eye(3)
        apart = layout.log_prior(u + steps) - layout.log_prior(u - steps)
        assert layout.prior_slopes(u) == pytest.approx(apart / 2e-5, rel=1e-6)


def test_evidence_counts_its_whole_mass() -> None:
    """∫ exp(log_prior) of the law's coordinates by a sum over a grid."""
    told, plain = posterior(Specification(prior=PRIOR)), posterior(Specification())
    axes = [np.linspace(m - 8 * s, m + 8 * s, 201) for m, s in zip(MEAN, PRIOR.sd, strict=True)]
    grid = np.stack([*(g.ravel() for g in np.meshgrid(*axes)), np.zeros(201**2)], axis=1)
    grid[:, 2] = told.layout.slots[2].mean
    cell = np.prod([axis[1] - axis[0] for axis in axes])
    of_law = np.log(np.sum(np.exp(told.layout.log_prior(grid))) * cell)
    weak = np.sum(np.log(EXPONENTIAL.prior_sd)) + np.log(2.0 * np.pi)
    assert log_prior_mass(told) - log_prior_mass(plain) == pytest.approx(of_law - weak, abs=1e-6)


def test_another_law_has_its_own_prior() -> None:
    other = posterior(Specification(law="power", prior=PRIOR)).layout
    assert other.law_correlation is None
    assert [s.mean for s in other.slots[:2]] == law("power").prior_mean.tolist()


def test_it_comes_back_from_the_store() -> None:
    given = (GivenPrior("sigma", 0.2, 0.1),)
    for made in (Specification(prior=PRIOR), Specification(given=given, effects=("season",))):
        kept = json.loads(json.dumps(asdict(made)))
        assert reader_of(Specification)(kept) == made


@pytest.mark.parametrize(
    ("name", "natural"), [("exponential", [0.5, 2e-6]), ("power", [1.0, 0.07])]
)
def test_of_a_fit_it_has_the_spread_of_fits_to_other_records(
    name: str, natural: list[float]
) -> None:
    item, rng = law(name), np.random.default_rng(2)
    volume = np.geomspace(2e3, 4e5, 40)
    exact = item.friction(np.array(natural), volume)
    fits = [fit_law(item, volume, exact + 0.04 * rng.standard_normal(40)) for _ in range(400)]
    spread = np.cov([item.from_natural(fit.parameters) for fit in fits], rowvar=False)
    told = [prior_of_fit("fit:P", item, f.parameters, f.covariance, 40).covariance for f in fits]
    # The t of 38 degrees of freedom is wider by 38/36.
    np.testing.assert_allclose(np.mean(told, axis=0) * 36 / 38, spread, rtol=0.2)


def test_a_source_that_does_not_fix_the_law_is_no_prior() -> None:
    singular = np.array([[1.0, 1.0], [1.0, 1.0]])
    for covariance in (singular, np.zeros((2, 2)), np.full((2, 2), np.nan)):
        with pytest.raises(AvahazardError, match="does not fix"):
            law_prior("other", EXPONENTIAL, MEAN, covariance)
    with pytest.raises(AvahazardError, match="4 events"):
        prior_of_fit("fit:P", EXPONENTIAL, np.array([0.5, 1e-6]), np.eye(2), 4)
    assert replace(Specification(), prior=PRIOR).prior == PRIOR


NUMBERS = {
    "exponential": {"a": (0.6, 0.06), "n": (3e-6, 2e-6)},
    "power": {"alpha": (1.1, 0.3), "beta": (0.06, 0.03)},
    "rational": {"a": (0.6, 0.06), "c": (7e4, 5e4), "n": (1.8, 0.5)},
    "asymptotic": {"a": (0.6, 0.06), "mu_inf": (0.2, 0.04), "n": (2e-6, 1e-6)},
    "constant": {"a": (0.4, 0.1)},
    "halving": {"a": (0.6, 0.06), "c": (7e4, 5e4)},
}


def items() -> list[Law]:
    return [*LAWS.values(), halving()]


def natural(item: Law, prior: LawPrior) -> dict[str, np.ndarray]:
    """Draws of the parameters from the prior of the coordinates."""
    u = np.random.default_rng(0).multivariate_normal(prior.mean, prior.covariance, 200_000)
    values = item.to_natural(u)
    return {name: values[:, k] for k, name in enumerate(item.names)}


@pytest.mark.parametrize("item", items(), ids=lambda item: item.name)
def test_parameters_have_the_mean_and_the_sd_that_were_given(item: Law) -> None:
    told = NUMBERS[item.name]
    prior = given_law_prior(item, [GivenPrior(name, *pair) for name, pair in told.items()])
    assert prior is not None
    drawn = natural(item, prior)
    for name, (mean, sd) in told.items():
        assert drawn[name].mean() == pytest.approx(mean, abs=0.01 * sd), name
        assert drawn[name].std() == pytest.approx(sd, rel=0.03), name
    independent = np.corrcoef(np.array([drawn[name] for name in told]))
    assert np.abs(independent - np.eye(len(told))).max() < 0.02


def test_what_is_positive_is_told_from_what_has_either_sign() -> None:
    assert {item.name: positive_parameters(item) for item in items()} == {
        "exponential": ("a",),
        "power": ("alpha",),
        "rational": ("a", "c", "n"),
        "asymptotic": ("a", "mu_inf", "n"),
        "constant": ("a",),
        "halving": ("a", "c"),
    }
    assert free_parameters(law("rational")) == ("a", "c", "n")


def test_what_is_not_given_keeps_the_weak_prior_of_its_coordinate() -> None:
    item = law("asymptotic")
    of_a = given_law_prior(item, [GivenPrior("a", 0.6, 0.06)])
    assert of_a is not None
    np.testing.assert_allclose(of_a.mean[1:], item.prior_mean[1:], atol=1e-12)
    np.testing.assert_allclose(of_a.sd[1:], item.prior_sd[1:])
    np.testing.assert_allclose(of_a.correlation, np.eye(3), atol=1e-12)
    # μ∞ alone: a keeps its own, without information on μ∞.
    of_limit = given_law_prior(item, [GivenPrior("mu_inf", 0.2, 0.04)])
    assert of_limit is not None
    drawn = natural(item, of_limit)
    assert drawn["mu_inf"].mean() == pytest.approx(0.2, rel=0.01)
    assert np.log(drawn["a"]).std() == pytest.approx(0.5, rel=0.01)
    assert abs(np.corrcoef(drawn["a"], drawn["mu_inf"])[0, 1]) < 0.02


def test_without_a_parameter_of_the_law_there_is_none() -> None:
    assert given_law_prior(law("power"), [GivenPrior("sigma", 0.2, 0.1)]) is None


@pytest.mark.parametrize(
    ("told", "positive", "message"),
    [
        (GivenPrior("n", 1e-6, 0.0), False, "standard deviation over 0"),
        (GivenPrior("n", 1e-6, -1.0), False, "standard deviation over 0"),
        (GivenPrior("n", float("nan"), 1.0), False, "standard deviation over 0"),
        (GivenPrior("n", 0.0, float("inf")), False, "standard deviation over 0"),
        (GivenPrior("a", -0.5, 0.1), True, "a is positive"),
        (GivenPrior("a", 0.0, 0.1), True, "a is positive"),
    ],
)
def test_what_is_no_prior(told: GivenPrior, positive: bool, message: str) -> None:
    with pytest.raises(AvahazardError, match=message):
        require_possible(told, positive)


@pytest.mark.parametrize(("mean", "sd"), [(0.5, 1e-9), (0.5, 1e300)])
def test_widths_that_leave_the_records_no_word_or_are_none(mean: float, sd: float) -> None:
    item = law("exponential") if sd < 1.0 else law("power")
    name = "a" if sd < 1.0 else "beta"
    with pytest.raises(AvahazardError, match="times that of the weak"):
        given_law_prior(item, [GivenPrior(name, mean, sd)])
