"""The laws against their formulas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avahazard.inference.model.laws import LAWS, MOST_LOG, law
from avahazard.records.errors import AvahazardError

V = np.array([1e3, 2e4, 1.5e5, 1.2e6])
NATURAL = {
    "exponential": np.array([0.695, 1 / 106925]),
    "power": np.array([1.07, 0.065]),
    "rational": np.array([0.555, 0.814, 68883.0, 1.85]),
    "asymptotic": np.array([0.6, 0.25, 2e-6]),
    "constant": np.array([0.5]),
}
FORMULA = {
    "exponential": 0.695 * np.exp(-V / 106925),
    "power": 1.07 * V**-0.065,
    "rational": 0.555 / (0.814 + (V / 68883) ** 1.85),
    "asymptotic": 0.25 + (0.6 - 0.25) * np.exp(-2e-6 * V),
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


def test_the_asymptotic_law_goes_to_its_limit() -> None:
    """Neither to nothing nor beyond all bounds, whichever way friction goes."""
    item = law("asymptotic")
    far = np.array([1e9, 1e200])
    np.testing.assert_allclose(item.friction(NATURAL["asymptotic"], far), 0.25, rtol=1e-12)
    rising = item.friction(np.array([0.3, 0.5, 2e-6]), np.append(V, far))
    assert np.all(np.diff(rising[:5]) > 0)
    np.testing.assert_allclose(rising[4:], 0.5)
    np.testing.assert_allclose(item.friction(np.array([0.4, 0.4, 2e-6]), V), 0.4)


def test_the_asymptotic_law_begins_as_the_exponential_one() -> None:
    """With a limit far below, and small volumes, it is a exp(-nV)."""
    u = np.array([np.log(0.6), -49.0, np.log(0.5)])
    expected = law("exponential").friction(np.array([0.6, 0.5e-6]), V)
    np.testing.assert_allclose(np.exp(law("asymptotic").log_friction(u, V)), expected, rtol=1e-9)


VOLUMES = st.lists(
    st.floats(1e-320, 1e308, allow_subnormal=True) | st.floats(1.0, 1e9), min_size=1, max_size=12
)


@pytest.mark.parametrize("name", LAWS)
@given(
    volume=VOLUMES,
    u=st.lists(st.floats(-1e4, 1e4), min_size=3, max_size=3),
    mu=st.lists(st.floats(1e-3, 5.0), min_size=12, max_size=12),
)
@settings(max_examples=60, deadline=None)
def test_any_volume_gives_a_friction_and_a_start(
    name: str, volume: list[float], u: list[float], mu: list[float]
) -> None:
    """No overflow either: warnings are errors here."""
    item, v = law(name), np.array(volume)
    coordinates = np.array(u[: len(item.coordinates)])
    assert np.all(np.abs(item.log_friction(coordinates, v)) <= MOST_LOG)
    begun = item.start(v, np.array(mu[: len(v)]))
    assert np.isfinite(begun).all()
    assert np.isfinite(item.log_friction(begun, v)).all()


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


WIDE_V = np.array([1.0, 1e3, 2e4, 1.5e5, 1.2e6])


@pytest.mark.parametrize("name", LAWS)
def test_they_are_what_differences_go_to(name: str) -> None:
    item = law(name)
    rng = np.random.default_rng(1)
    for u in rng.normal(item.prior_mean, item.prior_sd, (20, len(item.coordinates))):
        steps = 1e-5 * np.eye(len(u))
        apart = [item.log_friction(u + d, WIDE_V) - item.log_friction(u - d, WIDE_V) for d in steps]
        np.testing.assert_allclose(
            item.slopes(u, WIDE_V), np.array(apart) / 2e-5, atol=1e-8, rtol=1e-6
        )


@pytest.mark.parametrize("name", LAWS)
def test_a_law_at_its_bounds_goes_nowhere(name: str) -> None:
    item = law(name)
    far = item.prior_mean.copy()
    far[0] = 3.0 * MOST_LOG
    assert np.all(item.slopes(far, np.array([1.0, 1e300])) == 0.0)
