"""The α-β runout."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avahazard.hazard.alpha_beta import REGRESSIONS, Regression, alpha_beta, persistent_flats
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
    found = alpha_beta("P", parabola_of(2400.0), start, regression)
    beta, runout = by_hand(regression, 0.0, start)
    assert found.status == "stopped"
    assert found.beta_deg == pytest.approx(beta, abs=1e-4)
    assert found.beta_x_m == pytest.approx((1 - np.tan(np.radians(10))) / (2 * BEND), abs=0.01)
    assert found.alpha_deg == pytest.approx(regression.slope * beta + regression.intercept_deg)
    assert found.runout_x_m == pytest.approx(runout, abs=0.01)
    assert found.runout_x_low_m == pytest.approx(by_hand(regression, 1.0, start)[1], abs=0.01)
    assert found.runout_x_high_m == pytest.approx(by_hand(regression, -1.0, start)[1], abs=0.01)
    assert found.notes == ()


def test_the_published_coefficients() -> None:
    numbers = {r.name: (r.slope, r.intercept_deg, r.sd_deg) for r in REGRESSIONS}
    assert numbers == {"norway": (0.96, -1.4, 2.3), "austria": (0.946, -0.83, 1.5)}


def test_a_line_that_meets_no_ground_leaves_the_profile() -> None:
    _, runout = by_hand(NORWAY, 0.0)
    found = alpha_beta("P", parabola_of(runout - 20.0), 0.0, NORWAY)
    assert (found.status, found.runout_x_m, found.runout_x_high_m) == ("left_profile", None, None)
    assert found.runout_x_low_m == pytest.approx(by_hand(NORWAY, 1.0)[1], abs=0.01)
    longer = alpha_beta("P", parabola_of(runout + 20.0), 0.0, NORWAY)
    assert (longer.status, longer.runout_x_high_m) == ("stopped", None)


def test_a_path_that_never_flattens_has_no_beta_point() -> None:
    found = alpha_beta("P", parabola_of(1500.0), 0.0, NORWAY)
    assert (found.status, found.beta_deg, found.alpha_deg) == ("no_beta_point", None, None)
    assert (found.runout_x_m, found.runout_x_low_m, found.runout_x_high_m) == (None, None, None)
    assert [note.key for note in found.notes] == ["no_beta_point"]


def test_an_alpha_over_beta_lies_above_the_beta_point() -> None:
    steep = replace(NORWAY, slope=1.0, intercept_deg=2.0)
    found = alpha_beta("P", parabola_of(2400.0), 0.0, steep)
    assert found.runout_x_m == pytest.approx(by_hand(steep, 0.0)[1], abs=0.01)
    assert found.beta_x_m is not None
    assert found.runout_x_m is not None
    assert found.runout_x_m < found.beta_x_m
    # Steeper than any line from the release to the ground: the release itself.
    assert (
        alpha_beta("P", parabola_of(2400.0), 0.0, replace(steep, intercept_deg=40.0)).runout_x_m
        == 1.0
    )


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
    found = alpha_beta("P", smooth, 0.0, AUSTRIA)
    expected = naive_beta(smooth)
    assert len(expected) == n_places
    assert found.beta_x_m == pytest.approx(expected[0], abs=0.5)
    again = [float(x) for note in found.notes for x in note.values["places"]]
    assert again == pytest.approx(expected[1:], abs=1.0)


def test_a_flattening_lies_between_places_by_its_steepness() -> None:
    x = np.array([0.0, 40.0, 60.0, 300.0])
    ten = np.tan(np.radians(10.0))
    # Over 10° by three parts, then under it by one: three quarters of the 20 m.
    steepness = ten + np.array([0.5, 0.3, -0.1, -0.2])
    np.testing.assert_allclose(persistent_flats(x, steepness), [40.0 + 0.75 * 20.0])
    assert not len(persistent_flats(x[:3], steepness[:3] + 0.2))


def test_runout_by_a_plain_search_on_a_stepped_path() -> None:
    smooth = benched(20.0)
    found = alpha_beta("P", smooth, 0.0, AUSTRIA)
    x = np.arange(1.0, smooth.x_max, 0.05)
    angle = np.degrees(np.arctan2(smooth.height(0.0) - smooth.height(x), x))
    assert found.beta_x_m is not None
    assert found.alpha_deg is not None
    place = x[(x > found.beta_x_m) & (angle <= found.alpha_deg)][0]
    assert found.runout_x_m == pytest.approx(place, abs=0.1)


def test_real_terrain_by_a_plain_search(shared_data: Path) -> None:
    profiles = read_records([shared_data / "tyrol-profiles"]).profiles
    assert len(profiles) == 9
    for profile in profiles:
        smooth = smooth_profile(profile.x_m, profile.y_m)
        found = alpha_beta("P", smooth, smooth.x_min, NORWAY)
        assert found.beta_x_m == pytest.approx(naive_beta(smooth)[0], abs=0.5)
        assert found.beta_x_m is not None
        assert found.alpha_deg is not None
        assert 22.0 < found.alpha_deg < 32.0
        x = np.arange(found.beta_x_m, smooth.x_max, 0.1)
        line = smooth.height(smooth.x_min) - np.tan(np.radians(found.alpha_deg)) * (
            x - found.release_x_m
        )
        assert found.runout_x_m == pytest.approx(x[np.argmax(smooth.height(x) >= line)], abs=0.3)
