"""AvaFrame's α-β on points as they are, against a plain twin step by step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.hazard.alpha_beta import (
    AVAFRAME,
    Regression,
    alpha_beta,
    alpha_beta_on_points,
    parabola,
    steps_of_points,
)
from avahazard.physics.smooth_profile import legendre_profile

Points = tuple[np.ndarray, np.ndarray]


def made_line(seed: int) -> Points:
    """Points of uneven distances on a path of straight pieces, most of them with benches and a
    runout zone, some that end soon below the first flat place, some without any."""
    rng = np.random.default_rng([seed, 5])
    lengths, angles = rng.uniform(20.0, 400.0, 12), rng.uniform(-5.0, 40.0, 12)
    if seed % 4 == 0:
        angles = rng.uniform(12.0, 40.0, 12)
    elif seed % 4 == 1:
        lengths, angles = np.append(lengths, 60.0), np.append(rng.uniform(15.0, 40.0, 12), 8.0)
    else:
        angles[9:] = rng.uniform(0.0, 9.0, 3)
    slopes = np.tan(np.radians(angles))
    ends = np.append(0.0, np.cumsum(lengths))
    y = 2500.0 - np.append(0.0, np.cumsum(lengths * slopes))
    x = np.unique(np.append(rng.uniform(0.0, ends[-1], 150), ends))
    return x + 30.0, np.interp(x, ends, y)


def twin(x: np.ndarray, y: np.ndarray, release_x: float, by: Regression) -> dict[str, float | None]:
    """The same with interpolation, a fit and a search by numpy."""
    n = int(np.ceil(round((x[-1] - release_x) / 10.0, 6)))
    s = np.linspace(0.0, x[-1] - release_x, n + 1)
    z = np.interp(release_x + s, x, y)
    angle = np.degrees(np.arctan(-np.diff(z) / np.diff(s)))
    more = int(np.ceil(round(30.0 / s[1], 6)))
    steep = next((k for k in range(n) if angle[k] > 10.0), n)
    flat = [k for k in range(steep, n - more) if np.all(angle[k : k + more + 1] <= 10.0)]
    if not flat:
        return {"beta_x": None, "beta_deg": None, "alpha_deg": None, "runout_x": None}
    beta = flat[0] + 1
    beta_deg = float(np.degrees(np.arctan2(z[0] - z[beta], s[beta])))
    fit = np.polynomial.Polynomial.fit(s, z, 2)
    alpha = by.slope * beta_deg + by.intercept_deg
    alpha += by.bend * float(fit.deriv(2)(0.0)) + by.drop * float(np.ptp(fit(s)))
    high = z[0] - np.tan(np.radians(alpha)) * s - z
    if high[beta] > 0.0:
        below = [k for k in range(beta, n + 1) if high[k] <= 0.0]
        pair = (below[0] - 1, below[0]) if below else None
    else:
        above = [k for k in range(1, beta + 1) if high[k] > 0.0]
        pair = (above[-1], above[-1] + 1) if above else (1, 1)
    reached = None
    if pair is not None:
        a, b = pair
        share = 0.0 if a == b else high[a] / (high[a] - high[b])
        reached = release_x + float(s[a] + share * (s[b] - s[a]))
    places = {"beta_x": release_x + float(s[beta]), "runout_x": reached}
    return {**places, "beta_deg": beta_deg, "alpha_deg": float(alpha)}


@pytest.mark.parametrize("regression", AVAFRAME)
def test_lines_by_a_plain_twin(regression: Regression) -> None:
    statuses = set()
    for seed in range(60):
        x, y = made_line(seed)
        release_x = float(x[seed % 7])
        found = alpha_beta_on_points(x, y, release_x, regression)
        statuses.add(found.status)
        for name, value in twin(x, y, release_x, regression).items():
            assert getattr(found, name) == pytest.approx(value, abs=1e-6), (seed, name)
        assert found.release_y == pytest.approx(np.interp(release_x, x, y))
        if found.runout_low_x is not None and found.runout_high_x is not None:
            assert found.runout_low_x <= found.runout_x <= found.runout_high_x
    # On large paths the α of small avalanches is over β: no line of it leaves the profile.
    leaves = {"left_profile"} if regression.bend else set()
    assert statuses == {"stopped", "no_beta_point"} | leaves


def test_the_spread_is_that_of_angles_a_deviation_apart() -> None:
    x, y = made_line(3)
    by = AVAFRAME[0]
    found = alpha_beta_on_points(x, y, float(x[0]), by)
    for shift, place in ((1.0, found.runout_low_x), (-1.0, found.runout_high_x)):
        moved = replace(by, intercept_deg=by.intercept_deg + shift * by.sd_deg)
        assert place == alpha_beta_on_points(x, y, float(x[0]), moved).runout_x


def test_points_on_smooth_ground_say_what_the_ground_does() -> None:
    x = np.linspace(0.0, 2400.0, 241)
    y = 2000.0 - x + 2.5e-4 * x**2
    smooth = legendre_profile(x, y, penalty=0.0)
    of_points = alpha_beta_on_points(x, y, 0.0, AVAFRAME[0])
    of_ground = alpha_beta(smooth, 0.0, AVAFRAME[0])
    assert of_points.beta_x == of_ground.beta_x
    assert of_points.alpha_deg == pytest.approx(of_ground.alpha_deg, abs=1e-6)
    assert of_points.runout_x == pytest.approx(of_ground.runout_x, abs=1e-4)


@pytest.mark.parametrize(("length", "n"), [(4000.0, 400), (4000.1, 401), (3999.9, 400), (4.0, 1)])
def test_steps_are_equal_and_of_ten_metres_at_most(length: float, n: int) -> None:
    x = np.array([0.0, 0.3 * length, length])
    y = np.array([100.0, 40.0, 0.0])
    at_steps, step = steps_of_points(x, y, 0.0, 10.0)
    assert len(at_steps) == n + 1
    assert step == pytest.approx(length / n)
    np.testing.assert_allclose(at_steps, np.interp(np.linspace(0.0, length, n + 1), x, y))


@pytest.mark.parametrize("n", [1, 2, 3, 50])
def test_the_parabola_is_that_of_least_squares(n: int) -> None:
    y = 1e3 + np.random.default_rng(n).normal(0.0, 50.0, n + 1)
    s = 8.0 * np.arange(n + 1)
    fit = np.polynomial.Polynomial.fit(s, y, min(n, 2))
    second, fall = parabola(y, 8.0)
    assert second == pytest.approx(float(fit.deriv(2)(0.0)), abs=1e-9)
    assert fall == pytest.approx(float(np.ptp(fit(s))))
