"""The measured force confirms effects that are present, and contradicts others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from avahazard.criticism.diagnosis.force_witness import (
    Course,
    ForceTrack,
    ForceWitness,
    course_of,
    force_witness,
    linear_about,
)
from avahazard.effects.site import Site, build_site
from avahazard.inference.fitting.mode import Mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import SpeedRecord, build_observations
from avahazard.physics.cells import GRAVITY, SPEEDS, Resistance, no_resistance
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Path, Profile, Records
from avahazard.synth.dataset import Settings
from avahazard.synth.making import make_dataset
from tests.inference.studies import near, posterior

MOTION = {
    "turbulent-drag": {"turbulent-drag.drag": 0.003},
    "cohesion": {"cohesion.strength": 0.8},
    "speed-weakening": {"speed-weakening.ratio": 0.5, "speed-weakening.speed": 8.0},
}

TRUE = {"turbulent-drag": 0.003, "cohesion": 0.8}
"""What the datasets are made with."""


def world(seed: int, *effects: str, n: int = 60) -> Records:
    settings = Settings(speeds=0.6)
    records, _ = make_dataset(seed, n, 4, dict.fromkeys(effects, 1.0), settings)
    return records


def mode_of(model: Posterior, **values: float) -> Mode:
    layout = model.layout
    scale = {s.name: s.scale for s in layout.slots}
    u = near(model, **{k: v / scale[k] for k, v in values.items()})
    return Mode(u, 0.0, np.eye(len(u)))


@pytest.mark.parametrize("key", MOTION)
def test_a_force_that_is_not_there_is_denied(key: str) -> None:
    model = posterior(build_observations(world(11)), key)
    found = force_witness(model, mode_of(model, **MOTION[key]), key)
    assert found is not None
    assert abs(found.value) < 3.0 * found.se
    assert found.denies


@pytest.mark.parametrize("key", MOTION)
def test_a_force_that_is_there_is_borne_out(key: str) -> None:
    model = posterior(build_observations(world(12, key)), key)
    found = force_witness(model, mode_of(model, **MOTION[key]), key)
    assert found is not None
    assert not found.denies
    if key in TRUE:
        assert found.value == pytest.approx(TRUE[key], abs=3.0 * found.se)
    assert found.value / found.fitted > 3.0 * found.se / abs(found.fitted)


@pytest.mark.parametrize(("key", "more_m_s"), [("turbulent-drag", 0.0), ("cohesion", 6.0)])
def test_neither_wide_spacing_nor_errors_of_the_speeds_bias_it(key: str, more_m_s: float) -> None:
    away = []
    for seed in (100, 101, 102):
        records, rng = world(seed, key, n=100), np.random.default_rng(seed)
        speeds = tuple(
            replace(
                s,
                speed_m_s=max(0.0, s.speed_m_s + more_m_s * rng.standard_normal()),
                speed_sigma_m_s=float(np.hypot(s.speed_sigma_m_s, more_m_s)),
            )
            for s in records.speeds
        )
        model = posterior(build_observations(replace(records, speeds=speeds)), key)
        found = force_witness(model, mode_of(model, **MOTION[key]), key)
        assert found is not None
        away.append((found.value - TRUE[key]) / found.se)
    assert abs(np.mean(away)) < 3.0 / np.sqrt(3)


def test_friction_and_too_few_speeds_have_no_witness() -> None:
    records = world(11)
    model = posterior(build_observations(records), "season", "turbulent-drag")
    mode = mode_of(model, **MOTION["turbulent-drag"])
    assert force_witness(model, mode, "season") is None
    assert force_witness(model, mode_of(model), "turbulent-drag") is None
    few = replace(records, speeds=records.speeds[:3])
    model = posterior(build_observations(few), "turbulent-drag")
    assert force_witness(model, mode, "turbulent-drag") is None


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("key", MOTION)
def test_speeds_that_are_no_track_make_no_noise(key: str, seed: int) -> None:
    rng, records = np.random.default_rng(seed), world(11)
    speeds = tuple(
        replace(s, speed_m_s=float(rng.choice([0.0, 1.0, 149.0])), speed_sigma_m_s=0.01)
        for s in records.speeds
    )
    model = posterior(build_observations(replace(records, speeds=speeds)), key)
    found = force_witness(model, mode_of(model, **MOTION[key]), key)
    assert found is None or np.isfinite(found).all()


@pytest.mark.parametrize(
    ("value", "se", "denies"),
    [
        (0.0, 0.3, True),
        (0.0, 0.6, False),  # could not have shown it
        (0.6, 0.3, False),  # shows it
        (1.0, 2.0, False),
        (-0.3, 0.3, True),
    ],
)
def test_denial_takes_a_witness_that_could_have_seen_it(
    value: float, se: float, denies: bool
) -> None:
    assert ForceWitness(value, se, 1.0).denies is denies
    assert ForceWitness(-value, se, -1.0).denies is denies


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
    return course_of(site, SpeedRecord(0, x, speed, np.ones(len(x)), 50.0, 1500.0))


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
    of = ForceTrack(course, site, plain, whole, course.measured_energy(), MU)
    for _ in range(30):
        linear = linear_about(of, share)
        start = of.energy[0] * linear.start
        of.energy = linear.fixed + start + MU * linear.load + share * linear.effect
    exact = solved(site, course, share, weakens=weakens)
    assert of.energy == pytest.approx(exact, abs=0.002 * np.ptp(exact))


def test_the_share_moves_the_course_as_its_derivative_says(site: Site) -> None:
    course, plain = track(site), no_resistance(site.terrain)
    exact = solved(site, course, 0.5, weakens=False)
    whole = with_effect(plain, weakens=False)
    linear = linear_about(ForceTrack(course, site, plain, whole, exact, MU), 0.5)
    by_scipy = (
        solved(site, course, 0.51, weakens=False) - solved(site, course, 0.49, weakens=False)
    ) / 0.02
    assert linear.effect == pytest.approx(by_scipy, abs=0.01 * np.ptp(by_scipy))
