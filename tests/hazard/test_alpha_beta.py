"""The α-β runout."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from avahazard.hazard.alpha_beta import (
    AVAFRAME,
    REGRESSIONS,
    AlphaBeta,
    Regression,
    alpha_beta,
    alpha_beta_on_points,
    lasting_flats,
    parabola,
    steps_of_points,
)
from avahazard.physics.smooth_profile import SmoothProfile, legendre_profile, smooth_profile
from avahazard.records.reading import read_records
from tests.physics.paths import spline_profile

NORWAY, AUSTRIA = REGRESSIONS
FALL, BEND = 1.0, 2.5e-4
"""The parabola y = 2000 - x + 2.5e-4 x²."""


def parabola_of(length: float) -> SmoothProfile:
    x = np.linspace(0.0, length, 101)
    # Without its penalty the polynomial is the parabola itself.
    return legendre_profile(x, 2000.0 - FALL * x + BEND * x**2, penalty=0.0)


def by_hand(regression: Regression, shift: float, start: float = 0.0) -> tuple[float, float]:
    """β in degrees and the runout on the parabola: from x0, tan(angle) = c - b (x + x0)."""
    beta_x = (FALL - np.tan(np.radians(10.0))) / (2 * BEND)
    beta = np.degrees(np.arctan(FALL - BEND * (beta_x + start)))
    alpha = np.radians(regression.slope * beta + regression.intercept_deg)
    alpha += shift * np.radians(regression.sd_deg)
    return float(beta), float((FALL - np.tan(alpha)) / BEND - start)


@pytest.mark.parametrize("regression", REGRESSIONS)
@pytest.mark.parametrize("start", [0.0, 300.0])
def test_a_parabola(regression: Regression, start: float) -> None:
    found = alpha_beta(parabola_of(2400.0), start, regression)
    beta, runout = by_hand(regression, 0.0, start)
    assert found.status == "stopped"
    assert found.beta_deg == pytest.approx(beta, abs=1e-4)
    assert found.beta_x == pytest.approx((1 - np.tan(np.radians(10))) / (2 * BEND), abs=0.01)
    assert found.alpha_deg == pytest.approx(regression.slope * beta + regression.intercept_deg)
    assert found.runout_x == pytest.approx(runout, abs=0.01)
    assert found.runout_low_x == pytest.approx(by_hand(regression, 1.0, start)[1], abs=0.01)
    assert found.runout_high_x == pytest.approx(by_hand(regression, -1.0, start)[1], abs=0.01)
    assert found.further_beta_x == ()


def test_the_published_coefficients() -> None:
    numbers = {r.name: (r.slope, r.intercept_deg, r.sd_deg) for r in REGRESSIONS}
    assert numbers == {"norway": (0.96, -1.4, 2.3), "austria": (0.946, -0.83, 1.5)}


def test_a_line_that_meets_no_ground_leaves_the_profile() -> None:
    _, runout = by_hand(NORWAY, 0.0)
    found = alpha_beta(parabola_of(runout - 20.0), 0.0, NORWAY)
    assert (found.status, found.runout_x, found.runout_high_x) == ("left_profile", None, None)
    assert found.runout_low_x == pytest.approx(by_hand(NORWAY, 1.0)[1], abs=0.01)
    longer = alpha_beta(parabola_of(runout + 20.0), 0.0, NORWAY)
    assert (longer.status, longer.runout_high_x) == ("stopped", None)


def test_a_path_that_never_flattens_has_no_beta_point() -> None:
    found = alpha_beta(parabola_of(1500.0), 0.0, NORWAY)
    assert found == AlphaBeta(NORWAY, "no_beta_point", 0.0, found.release_y)


def test_an_alpha_over_beta_lies_above_the_beta_point() -> None:
    steep = replace(NORWAY, slope=1.0, intercept_deg=2.0)
    found = alpha_beta(parabola_of(2400.0), 0.0, steep)
    assert found.runout_x == pytest.approx(by_hand(steep, 0.0)[1], abs=0.01)
    assert found.beta_x is not None
    assert found.runout_x is not None
    assert found.runout_x < found.beta_x
    # Steeper than any line from the release to the ground: the release itself.
    assert alpha_beta(parabola_of(2400.0), 0.0, replace(steep, intercept_deg=40.0)).runout_x == 1.0


def benched(bench_m: float) -> SmoothProfile:
    """A flat top, 30° slopes with a bench of `bench_m` between them, and a runout at 5°."""
    lengths = [200.0, 800.0, bench_m, 600.0, 1500.0]
    slopes = np.tan(np.radians([3.0, 35.0, 5.0, 30.0, 5.0]))
    x = np.concatenate([[0.0], np.cumsum(lengths)])
    y = 2000.0 - np.concatenate([[0.0], np.cumsum(lengths * slopes)])
    fine = np.arange(0.0, x[-1] + 1.0, 10.0)
    return spline_profile(fine, np.interp(fine, x, y), 0.1, block_m=20.0)


def naive_beta(smooth: SmoothProfile) -> list[float]:
    """Every place, metre by metre, where 10° is reached and kept for 100 m, once it was steep."""
    x = np.arange(0.0, smooth.x_max, 0.25)
    slope = np.degrees(np.arctan(-smooth.derivatives(x)[1]))
    found = []
    was_steep = False
    for k in range(len(x)):
        if slope[k] > 10.0:
            was_steep = True
        elif was_steep:
            ahead = slope[k : k + 401]
            if (ahead <= 10.0).all():
                found.append(float(x[k]))
            was_steep = False
    return found


@pytest.mark.parametrize(("bench_m", "n_places"), [(60.0, 1), (300.0, 2)])
def test_the_first_flattening_that_lasts_and_the_others_told(bench_m: float, n_places: int) -> None:
    smooth = benched(bench_m)
    found = alpha_beta(smooth, 0.0, AUSTRIA)
    expected = naive_beta(smooth)
    assert len(expected) == n_places
    assert found.beta_x == pytest.approx(expected[0], abs=0.5)
    assert found.further_beta_x == pytest.approx(expected[1:], abs=0.5)


def test_a_flattening_lies_between_places_by_its_steepness() -> None:
    x = np.array([0.0, 40.0, 60.0, 300.0])
    ten = np.tan(np.radians(10.0))
    # Over 10° by three parts, then under it by one: three quarters of the 20 m.
    steepness = ten + np.array([0.5, 0.3, -0.1, -0.2])
    np.testing.assert_allclose(lasting_flats(x, steepness), [40.0 + 0.75 * 20.0])
    assert not len(lasting_flats(x[:3], steepness[:3] + 0.2))


def test_runout_by_a_plain_search_on_a_stepped_path() -> None:
    smooth = benched(20.0)
    found = alpha_beta(smooth, 0.0, AUSTRIA)
    x = np.arange(1.0, smooth.x_max, 0.05)
    angle = np.degrees(np.arctan2(smooth.height(0.0) - smooth.height(x), x))
    assert found.beta_x is not None
    assert found.alpha_deg is not None
    place = x[(x > found.beta_x) & (angle <= found.alpha_deg)][0]
    assert found.runout_x == pytest.approx(place, abs=0.1)


def test_real_terrain_by_a_plain_search(shared_data: Path) -> None:
    profiles = read_records([shared_data / "tyrol-profiles"]).profiles
    assert len(profiles) == 9
    for profile in profiles:
        smooth = smooth_profile(profile.x_m, profile.y_m)
        found = alpha_beta(smooth, smooth.x_min, NORWAY)
        assert found.beta_x == pytest.approx(naive_beta(smooth)[0], abs=0.5)
        assert found.beta_x is not None
        assert found.alpha_deg is not None
        assert 22.0 < found.alpha_deg < 32.0
        x = np.arange(found.beta_x, smooth.x_max, 0.1)
        line = found.release_y - np.tan(np.radians(found.alpha_deg)) * (x - found.release_x)
        assert found.runout_x == pytest.approx(x[np.argmax(smooth.height(x) >= line)], abs=0.3)


def test_avaframes_published_coefficients() -> None:
    """k1 to k4 and SD of com2ABCfg.ini."""
    numbers = {r.name: (r.slope, r.bend, r.drop, r.intercept_deg, r.sd_deg) for r in AVAFRAME}
    assert numbers == {
        "avaframe": (1.05, -3130.0, 0.0, -2.38, 1.25),
        "avaframe-small": (0.933, 0.0, 0.0088, -5.02, 2.36),
    }


@pytest.mark.parametrize("regression", AVAFRAME)
@pytest.mark.parametrize("start", [0.0, 300.0])
def test_avaframes_angles_on_a_parabola(regression: Regression, start: float) -> None:
    """The parabola fitted is the path itself: y'' is twice its bend, H0 its fall."""
    smooth = parabola_of(2400.0)
    found = alpha_beta(smooth, start, regression)
    beta_x = (1 - np.tan(np.radians(10))) / (2 * BEND)
    # A step of 10 m is flat if its middle is.
    step = start + 10.0 * np.ceil((beta_x - 5.0 - start) / 10.0) + 10.0
    assert found.beta_x == pytest.approx(step)
    beta = np.degrees(np.arctan(FALL - BEND * (step + start)))
    assert found.beta_deg == pytest.approx(beta, abs=1e-4)
    y = 2000.0 - FALL * np.array([start, 2000.0]) + BEND * np.array([start, 2000.0]) ** 2
    expected = regression.slope * beta + regression.intercept_deg
    expected += regression.bend * 2 * BEND + regression.drop * (y[0] - y[1])
    assert found.alpha_deg == pytest.approx(expected, abs=0.01)


def naive_first_step(smooth: SmoothProfile) -> float | None:
    """Step by step of 10 m: once it was steep, the first that is flat with the next three."""
    places = [10.0 * k for k in range(int(smooth.x_max // 10.0) + 1)]
    angles = [
        np.degrees(np.arctan((smooth.height(a) - smooth.height(b)) / 10.0))
        for a, b in pairwise(places)
    ]
    was_steep = False
    for k, angle in enumerate(angles):
        was_steep = was_steep or bool(angle > 10.0)
        if was_steep and k + 3 < len(angles) and max(angles[k : k + 4]) <= 10.0:
            return places[k + 1]
    return None


@pytest.mark.parametrize(("bench_m", "at_bench"), [(20.0, False), (60.0, True), (300.0, True)])
def test_avaframes_point_is_on_the_first_bench_of_30_m(bench_m: float, at_bench: bool) -> None:
    smooth = benched(bench_m)
    found = alpha_beta(smooth, 0.0, AVAFRAME[0])
    assert found.beta_x == naive_first_step(smooth)
    assert found.beta_x is not None
    assert (found.beta_x < 1100.0) == at_bench
    # Ours passes by what is no runout zone.
    ours = alpha_beta(smooth, 0.0, AUSTRIA)
    assert ours.beta_x is not None
    assert (ours.beta_x < 1100.0) == (bench_m >= 100.0)


def test_avaframes_point_needs_a_flattening() -> None:
    assert alpha_beta(parabola_of(1500.0), 0.0, AVAFRAME[0]).status == "no_beta_point"


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
