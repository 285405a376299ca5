"""Priors as numbers of the parameters that people read."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.model.given_prior import (
    GivenPrior,
    free_parameters,
    given_law_prior,
    positive_parameters,
    require_possible,
)
from avahazard.inference.model.law_prior import LawPrior
from avahazard.inference.model.laws import LAWS, Law, law
from avahazard.records.errors import AvahazardError
from tests.inference.new_law import halving

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
    # μ∞ alone: a keeps its own, and tells nothing of μ∞.
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
