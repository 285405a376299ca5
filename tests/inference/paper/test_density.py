"""Holy's density solves (2.4), integrates to one, and beats a histogram."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import minimize

from avahazard.inference.paper.apparent import HolyDensity, choose_kappa, holy_density
from avahazard.records.errors import AvahazardError


def _bimodal(n: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    second = rng.random(n) < 0.4
    return np.where(second, rng.normal(0.62, 0.05, n), rng.normal(0.41, 0.06, n))


def integral(density: HolyDensity) -> float:
    """∫ψ² in closed form; the test after next asks quadrature."""
    d = density.kappa * np.abs(density.mu[:, None] - density.mu)
    return float(density.a @ ((1.0 + d) * np.exp(-d)) @ density.a)


@pytest.mark.parametrize("kappa", [0.1, 5.0, 40.0, 3000.0])
def test_the_equations_hold(kappa: float) -> None:
    mu = np.append(_bimodal(300, 1), [0.5] * 20)
    density = holy_density(mu, kappa)
    multiplier = density.a * density.psi(density.mu)
    np.testing.assert_allclose(multiplier, multiplier[0], rtol=1e-9)
    assert integral(density) == pytest.approx(1.0, abs=1e-10)


@pytest.mark.parametrize(("n", "kappa"), [(1, 5.0), (2, 5.0), (23, 5.0), (23, 60.0)])
def test_integral_is_one_by_quadrature(n: int, kappa: float) -> None:
    density = holy_density(_bimodal(n, 2), kappa)
    knots = [density.mu.min() - 20 / kappa, *np.unique(density.mu), density.mu.max() + 20 / kappa]
    total = sum(
        quad(lambda x: float(density.pdf(np.array([x]))[0]), lo, hi, epsabs=1e-11)[0]
        for lo, hi in pairwise(knots)
    )
    assert total == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("kappa", [5.0, 30.0])
def test_solution_is_the_maximum_of_the_penalised_likelihood(kappa: float) -> None:
    """The slow twin: a general optimiser over the coefficients, started elsewhere.

    ∫ψ'² + κ²∫ψ² = 2κ² aᵀKa, so for given κ the sources maximise Σ log ψ² at a fixed aᵀKa.
    """
    mu = np.sort(np.append(_bimodal(15, 3), [0.5, 0.5]))
    kernel = np.exp(-kappa * np.abs(mu[:, None] - mu))

    def loss(log_a):
        psi = kernel @ np.exp(log_a)
        energy = np.exp(log_a) @ psi
        value = -2 * np.sum(np.log(psi)) + mu.size * np.log(energy)
        gradient = -2 * kernel @ (1 / psi) + 2 * mu.size * psi / energy
        return value, gradient * np.exp(log_a)

    found = minimize(loss, np.zeros(17), jac=True, method="BFGS", options={"gtol": 1e-10})
    slow = kernel @ np.exp(found.x)
    ours = holy_density(mu, kappa).psi(mu)
    np.testing.assert_allclose(ours / ours[0], slow / slow[0], rtol=1e-5)


@settings(deadline=None)
@given(st.lists(st.floats(0.05, 1.5), min_size=1, max_size=30), st.floats(0.01, 1e4))
def test_any_records_and_any_kappa(mu: list[float], kappa: float) -> None:
    density = holy_density(np.array(mu), kappa)
    assert integral(density) == pytest.approx(1.0, abs=1e-8)
    assert np.all(density.a > 0)


def test_it_beats_a_histogram_on_new_records() -> None:
    """Mean log density of 2000 new values, 30 times; the histogram is spared empty bins."""
    wins = 0
    for seed in range(30):
        train, test = _bimodal(60, seed), _bimodal(2000, 1000 + seed)
        ours = np.mean(np.log(holy_density(train, choose_kappa(train)).pdf(test)))
        edges = np.histogram_bin_edges(train, "auto")
        edges = np.concatenate([[0.0], edges, [1.5]])
        share = (np.histogram(train, edges)[0] + 0.5) / (train.size + 0.5 * (edges.size - 1))
        pdf = share / np.diff(edges)
        theirs = np.mean(np.log(pdf[np.searchsorted(edges, test) - 1]))
        wins += ours > theirs
    assert wins >= 27


def test_kappa_follows_the_data() -> None:
    narrow, wide = _bimodal(200, 5), np.random.default_rng(1).normal(0.5, 0.1, 200)
    assert choose_kappa(narrow) > choose_kappa(wide)
    assert choose_kappa(np.array([0.4, 0.4, 0.5])) == 5.0


def test_rounded_records_do_not_drive_kappa_up() -> None:
    rounded = np.round(_bimodal(200, 6), 2)
    assert choose_kappa(rounded) < 200 / np.ptp(rounded)


def test_extrapolated_parts_are_marked() -> None:
    density = holy_density(np.array([0.3, 0.5, np.nan]))
    marked = density.extrapolated(np.array([0.2, 0.3, 0.4, 0.51]))
    np.testing.assert_array_equal(marked, [True, False, False, True])


def test_bad_input_is_refused() -> None:
    with pytest.raises(AvahazardError, match="no apparent friction"):
        holy_density(np.array([np.nan]))
    with pytest.raises(AvahazardError, match="κ is -1"):
        holy_density(np.array([0.4]), -1.0)
