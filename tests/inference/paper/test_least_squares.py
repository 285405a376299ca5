"""Least squares gives the constants of exact points back, and honest errors for noisy ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.optimize import curve_fit

from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.laws import LAWS, law
from avahazard.inference.model.observations import build_observations
from avahazard.inference.paper.apparent import back_calculate
from avahazard.inference.paper.least_squares import fit_every_law, fit_law
from avahazard.records.errors import AvahazardError
from avahazard.records.reading import read_records

ROOT = Path(__file__).resolve().parents[3]
FIGURE_1 = {
    "exponential": [0.695, 1 / 106925],
    "power": [1.07, 0.065],
    "rational": [0.555, 0.814, 68883.0, 1.85],
    "asymptotic": [0.6, 0.25, 2e-5],
    "constant": [0.5],
}
FORMULA = {
    "exponential": lambda v, a, n: a * np.exp(-n * v),
    "power": lambda v, a, b: a * v**-b,
    "asymptotic": lambda v, a, least, n: least + (a - least) * np.exp(-n * v),
    "constant": lambda v, a: a + 0 * v,
}


def _points(name: str, n: int = 11, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    volume = np.geomspace(2e3, 1.6e5, n)
    mu = law(name).friction(np.array(FIGURE_1[name]), volume)
    return volume, mu + noise * rng.normal(size=n)


@pytest.mark.parametrize("name", FIGURE_1)
def test_exact_points_give_the_constants_of_figure_1_back(name: str) -> None:
    fit = fit_law(law(name), *_points(name))
    np.testing.assert_allclose(fit.parameters, FIGURE_1[name], rtol=1e-6)
    np.testing.assert_array_less(fit.standard_errors, 1e-5 * np.array(FIGURE_1[name]))
    if name != "constant":
        assert fit.r2 == pytest.approx(1.0)


@pytest.mark.parametrize("name", FORMULA)
def test_noisy_points_agree_with_curve_fit(name: str) -> None:
    volume, mu = _points(name, 40, 0.03)
    fit = fit_law(law(name), volume, mu)
    unit = np.array(FIGURE_1[name])
    theirs, covariance = curve_fit(
        lambda v, *p: FORMULA[name](v, *(np.array(p) * unit)), volume, mu, p0=np.ones(unit.size)
    )
    np.testing.assert_allclose(fit.parameters, theirs * unit, rtol=1e-5)
    np.testing.assert_allclose(fit.covariance, covariance * np.outer(unit, unit), rtol=1e-3)


def test_the_rational_law_is_the_best_of_its_ridge() -> None:
    """As good as any other point of the ridge, nearest to figure 1, its curve's errors right."""
    volume, mu = _points("rational", 60, 0.02)
    item = law("rational")
    fit = fit_law(item, volume, mu)
    theirs, covariance = curve_fit(
        lambda v, a, c, n: a / (1 + (v / c) ** n), volume, mu, p0=[0.68, 6e4, 1.8],
        x_scale=[1, 1e4, 1], method="trf",
    )  # fmt: skip
    a, b, c, n = fit.parameters
    np.testing.assert_allclose([a / b, c * b ** (1 / n), n], theirs, rtol=1e-4)
    moves = [np.array([a * k, b * k, c * k ** (-1 / n), n]) for k in (0.99, 1.0, 1.01)]
    away = [np.linalg.norm(np.log(m) - np.log(FIGURE_1["rational"])) for m in moves]
    assert away[1] < min(away[0], away[2])
    assert fit.standard_errors[3] == pytest.approx(np.sqrt(covariance[2, 2]), rel=0.01)
    ridge = np.array([1.0, 1.0, -1 / n, 0.0]) * fit.parameters / fit.parameters**2
    np.testing.assert_allclose(fit.covariance @ ridge / fit.standard_errors, 0.0, atol=1e-6)


def test_aic_prefers_the_law_that_made_the_points() -> None:
    volume, mu = _points("rational", 60, 0.01)
    aic = {fit.law.name: fit.aic for fit in fit_every_law(volume, mu)[0]}
    assert min(aic, key=lambda name: aic[name]) == "rational"
    squares = np.sum((mu - mu.mean()) ** 2)
    assert aic["constant"] == pytest.approx(60 * np.log(squares / 60) + 4)


def test_events_without_friction_are_left_out() -> None:
    volume, mu = _points("power", 20, 0.02)
    with_gaps = fit_law(law("power"), np.append(volume, [1e4, 2e4]), np.append(mu, [np.nan, -1]))
    np.testing.assert_array_equal(
        with_gaps.parameters, fit_law(law("power"), volume, mu).parameters
    )


def test_too_few_events_are_refused() -> None:
    with pytest.raises(AvahazardError, match="at least 4 events"):
        fit_law(law("rational"), *_points("rational", 3))


def test_equal_volumes_leave_the_constant_law_alone() -> None:
    """No constant of 6e35, and it is said why."""
    mu = np.array([0.5, 0.42, 0.61, 0.47, 0.55])
    fits, notes = fit_every_law(np.full(5, 2e4) * [1, 1, 1.001, 1, 1], mu)
    assert [fit.law.name for fit in fits] == ["constant"]
    assert fits[0].parameters == pytest.approx([mu.mean()])
    assert len(notes) == len(LAWS) - 1
    assert all("all volumes are equal" in note for note in notes)


def test_a_law_that_the_points_do_not_fix_is_left_out_alone() -> None:
    """Friction that rises with volume has no volume that halves it."""
    volume = np.geomspace(1e3, 1e6, 30)
    mu = 0.4 * volume**0.05 + 0.02 * np.random.default_rng(0).normal(size=30)
    fits, notes = fit_every_law(volume, mu)
    assert {"exponential", "power", "constant"} <= {fit.law.name for fit in fits}
    assert any("rational law is left out" in note for note in notes)


@pytest.fixture(scope="module")
def twin_points() -> tuple[np.ndarray, np.ndarray]:
    """Give volumes and apparent frictions of the demo's events."""
    twin = build_observations(read_records([ROOT / "data"]))
    mu = back_calculate(twin, predict_records(twin, (), {})).mu
    return np.exp(twin.columns.log_volume), mu


def _sound(volume: np.ndarray, mu: np.ndarray) -> None:
    fits, notes = fit_every_law(volume, mu)
    assert len(fits) + len(notes) == len(LAWS)
    for fit in fits:
        assert np.isfinite([*fit.parameters, *fit.standard_errors, fit.r2, fit.aic]).all()
        assert fit.r2 < 1.0 + 1e-9


@given(chosen=st.lists(st.integers(0, 172), min_size=1, max_size=40))
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_any_of_the_demos_events_give_sound_fits(
    twin_points: tuple[np.ndarray, np.ndarray], chosen: list[int]
) -> None:
    volume, mu = twin_points
    _sound(volume[chosen], mu[chosen])


@given(
    points=st.lists(
        st.tuples(st.floats(1e-320, 1e308, allow_subnormal=True), st.floats(0.01, 5.0)),
        min_size=1,
        max_size=12,
    )
)
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_any_volumes_give_sound_fits(points: list[tuple[float, float]]) -> None:
    """Warnings are errors here, so nothing overflows."""
    volume, mu = np.array(points).T
    _sound(volume, mu)
