"""The course of energy along a track is that of the differential equation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from avahazard.criticism.diagnosis.track_energy import Course, course_of, linear_about
from avahazard.effects.site import Site, build_site
from avahazard.inference.model.observations import SpeedRecord
from avahazard.physics.constants import GRAVITY
from avahazard.physics.resistance import SPEEDS, Resistance, no_resistance
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.path import Path, Profile

X = np.linspace(0.0, 1900.0, 96)
Y = 1000.0 - 0.8 * X + 2e-4 * X**2
MU, DRAG, START_M_S = 0.3, 0.004, 15.0
WEAKENED = 0.6 + 0.4 / (1.0 + SPEEDS / 10.0)


@pytest.fixture(scope="module")
def site() -> Site:
    return build_site(Path("B"), Profile("B", X, Y, None), smooth_profile(X, Y), [990.0])


def track(site: Site, places: tuple[float, ...] = (100.0, 300.0, 700.0, 1100.0)) -> Course:
    x = np.array(places)
    speed = np.full(len(x), START_M_S)
    spread = np.eye(len(x))
    return course_of(
        site,
        SpeedRecord(0, x, speed, np.ones(len(x)), 50.0, 1500.0, x / 1500.0, spread, spread),
    )


def solved(site: Site, course: Course, share: float, *, weakens: bool) -> np.ndarray:
    """Energy along the course by scipy, of a block on the same ground."""

    def slope(x: float, square: np.ndarray) -> np.ndarray:
        _, tangent, bend = (v[0] for v in site.smooth.derivatives(np.array([x])))
        stretch = np.hypot(1.0, tangent)
        load = max(0.0, GRAVITY / stretch + bend / stretch**3 * square[0])
        friction = MU * load
        if weakens:
            weakened = np.interp(np.sqrt(square[0]), SPEEDS, WEAKENED)
            force = friction * (1.0 + share * (weakened - 1.0))
        else:
            force = friction + share * DRAG * square[0]
        return np.array([-2.0 * (GRAVITY * tangent + force * stretch)])

    run = solve_ivp(
        slope, course.x[[0, -1]], [START_M_S**2], "DOP853", course.x, rtol=1e-9, max_step=5.0
    )
    return np.asarray(0.5 * run.y[0] + GRAVITY * course.height)


def with_effect(plain: Resistance, *, weakens: bool) -> Resistance:
    if weakens:
        return replace(plain, speed_factor=WEAKENED)
    return replace(plain, drag=plain.drag + DRAG)


@pytest.mark.parametrize("weakens", [False, True])
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_steps_end_on_the_solution(site: Site, share: float, weakens: bool) -> None:
    course, plain = track(site), no_resistance(site.terrain)
    if weakens:
        plain = no_resistance(site.fine_terrain)
    whole = with_effect(plain, weakens=weakens)
    energy = course.measured_energy()
    for _ in range(30):
        linear = linear_about(course, site, plain, whole, energy, MU, share)
        energy = linear.fixed + energy[0] * linear.start + MU * linear.load + share * linear.effect
    exact = solved(site, course, share, weakens=weakens)
    assert energy == pytest.approx(exact, abs=0.002 * np.ptp(exact))


def test_the_share_moves_the_course_as_its_derivative_says(site: Site) -> None:
    course, plain = track(site), no_resistance(site.terrain)
    exact = solved(site, course, 0.5, weakens=False)
    whole = with_effect(plain, weakens=False)
    linear = linear_about(course, site, plain, whole, exact, MU, 0.5)
    by_scipy = (
        solved(site, course, 0.51, weakens=False) - solved(site, course, 0.49, weakens=False)
    ) / 0.02
    assert linear.effect == pytest.approx(by_scipy, abs=0.01 * np.ptp(by_scipy))
