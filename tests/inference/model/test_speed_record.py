"""The square of speed under a friction that is uneven along the track, by an integrator."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.model.speed_record import (
    FRICTION_CORRELATION_M,
    speed_record,
    track_spread,
)
from avahazard.physics.constants import GRAVITY

WAY = np.array([0.0, 40.0, 150.0, 300.0, 480.0])
LENGTH = 500.0


def integrated(n: int, seed: int) -> np.ndarray:
    """r at `WAY` for `n` tracks `[n, n_places]`: uneven friction added up step by step."""
    rng = np.random.default_rng(seed)
    step = 2.0
    fade = np.exp(-step / FRICTION_CORRELATION_M)
    n_steps = int(LENGTH / step)
    friction = np.empty((n, n_steps))
    friction[:, 0] = rng.standard_normal(n)
    for k in range(1, n_steps):
        fresh = rng.standard_normal(n) * np.sqrt(1.0 - fade**2)
        friction[:, k] = fade * friction[:, k - 1] + fresh
    friction -= friction.mean(axis=1, keepdims=True)
    work = np.concatenate([np.zeros((n, 1)), np.cumsum(friction, axis=1) * step], axis=1)
    return -2.0 * GRAVITY * work[:, (WAY / step).astype(int)]


def test_the_spread_is_that_of_friction_added_up() -> None:
    made = np.cov(integrated(20_000, 1).T)
    spread = track_spread(WAY, LENGTH)
    scale = np.sqrt(np.maximum(np.diag(spread), 1.0))
    assert np.max(np.abs(made - spread) / np.outer(scale, scale)) < 0.05


def test_speeds_are_certain_at_the_release_and_at_the_stop() -> None:
    spread = track_spread(np.array([0.0, 250.0, LENGTH]), LENGTH)
    assert spread[1, 1] > 1e6
    assert np.max(np.abs(spread[[0, 2]])) < 1e-6 * spread[1, 1]


def test_the_root_is_one_of_the_spread() -> None:
    speed = np.full(5, 10.0)
    one = speed_record(3, 100.0 + WAY, speed, np.ones(5), 100.0, 100.0 + LENGTH)
    np.testing.assert_allclose(one.root @ one.root.T, one.spread, atol=1e-6 * one.spread.max())
    assert one.share == pytest.approx(WAY / LENGTH)


def test_a_place_above_the_release_or_below_the_stop_is_borne() -> None:
    x = np.array([-50.0, 10.0, 700.0])
    one = speed_record(0, x, np.zeros(3), np.ones(3), 0.0, 500.0)
    assert one.share[0] == 0.0
    assert np.all(np.isfinite(one.root))
    held = speed_record(0, x, np.zeros(3), np.ones(3), 600.0, 500.0)
    assert np.all(np.isfinite(held.spread))
