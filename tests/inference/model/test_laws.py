"""The laws against their formulas."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.model.laws import LAWS, law
from avahazard.records.errors import AvahazardError

V = np.array([1e3, 2e4, 1.5e5, 1.2e6])
NATURAL = {
    "exponential": np.array([0.695, 1 / 106925]),
    "power": np.array([1.07, 0.065]),
    "rational": np.array([0.555, 0.814, 68883.0, 1.85]),
    "constant": np.array([0.5]),
}
FORMULA = {
    "exponential": 0.695 * np.exp(-V / 106925),
    "power": 1.07 * V**-0.065,
    "rational": 0.555 / (0.814 + (V / 68883) ** 1.85),
    "constant": np.full(4, 0.5),
}


@pytest.mark.parametrize("name", LAWS)
def test_friction_is_the_formula(name: str) -> None:
    np.testing.assert_allclose(law(name).friction(NATURAL[name], V), FORMULA[name], rtol=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_coordinates_round_trip_over_many_draws(name: str) -> None:
    item = law(name)
    u = np.random.default_rng(0).normal(item.prior_mean, item.prior_sd, (50, len(item.coordinates)))
    np.testing.assert_allclose(item.from_natural(item.to_natural(u)), u, atol=1e-9)
    assert item.to_natural(u).shape == (50, len(item.names)) == (50, len(item.units))
    assert item.log_friction(u, V).shape == (50, 4)
    np.testing.assert_allclose(item.log_friction(u, V)[7], item.log_friction(u[7], V))


def test_the_rational_law_has_a_ridge() -> None:
    item, k = law("rational"), 3.7
    a, b, c, n = NATURAL["rational"]
    moved = np.array([a * k, b * k, c * k ** (-1 / n), n])
    np.testing.assert_allclose(item.friction(moved, V), FORMULA["rational"], rtol=1e-12)
    np.testing.assert_allclose(item.from_natural(moved), item.from_natural(NATURAL["rational"]))


def test_n_and_beta_may_be_negative() -> None:
    assert np.all(np.diff(law("exponential").friction(np.array([0.5, -1e-6]), V)) > 0)
    assert np.all(np.diff(law("power").friction(np.array([0.5, -0.1]), V)) > 0)


@pytest.mark.parametrize("name", ["exponential", "power", "constant"])
def test_start_of_exact_points_is_the_law(name: str) -> None:
    item = law(name)
    np.testing.assert_allclose(item.start(V, FORMULA[name]), item.from_natural(NATURAL[name]))


@pytest.mark.parametrize("name", LAWS)
def test_start_is_finite_on_poor_data(name: str) -> None:
    item = law(name)
    for v, mu in [(V[:1], [0.4]), (V[:2] * 0 + 5e3, [0.4, 0.5]), (V, [np.nan] * 4), (V[:0], [])]:
        assert np.isfinite(item.start(v, np.array(mu))).all()


@pytest.mark.parametrize("name", LAWS)
def test_priors_allow_what_the_paper_found(name: str) -> None:
    item = law(name)
    z = (item.from_natural(NATURAL[name]) - item.prior_mean) / item.prior_sd
    assert np.all(np.abs(z) < 2)


def test_an_unknown_law_is_named() -> None:
    with pytest.raises(AvahazardError, match="no law 'cubic'"):
        law("cubic")


@pytest.mark.parametrize("name", list(LAWS))
@pytest.mark.parametrize("volume", [1e-300, 1e-3, 1e15, 1.7e308])
def test_friction_is_a_number_for_every_volume(name: str, volume: float) -> None:
    law_ = LAWS[name]
    for scale in (-1.0, 0.0, 1.0):
        u = law_.prior_mean + 3.0 * scale * law_.prior_sd
        log_mu = law_.log_friction(u, np.array([volume]))
        assert np.all(np.isfinite(log_mu))
        assert np.all(np.isfinite(np.exp(log_mu)))
