"""The measured force bears out effects that are there, and denies those that are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.diagnosis.force_witness import ForceWitness, force_witness
from avahazard.inference.fitting.mode import Mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.records.collection import Records
from avahazard.synth.making import make_world
from avahazard.synth.settings import Settings
from tests.inference.studies import near, posterior

MOTION = {
    "turbulent-drag": {"turbulent-drag.drag": 0.003},
    "cohesion": {"cohesion.strength": 0.8},
    "speed-weakening": {"speed-weakening.ratio": 0.5, "speed-weakening.speed": 8.0},
}

TRUE = {"turbulent-drag": 0.003, "cohesion": 0.8}
"""What the worlds are made with."""


def world(seed: int, *effects: str, n: int = 60) -> Records:
    settings = Settings(speeds=0.6)
    records, _ = make_world(seed, n, 4, dict.fromkeys(effects, 1.0), settings)
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
        (0.0, 0.6, False),  # could not have told
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
