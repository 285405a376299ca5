"""At their neutral values effects, alone and together, are the base model bit for bit."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avahazard.effects.catalogue import catalogue, definition
from avahazard.inference.likelihood.posterior import Posterior
from tests.inference.studies import near, observations, posterior

KEYS = tuple(catalogue())

ADDED = tuple(k for k in KEYS if definition(k).changes is None)
KEYS_WITH_NEUTRAL = (*ADDED, "volume-scatter", "centrifugal", "covariate:wind")
SETTINGS = (
    {},
    {"distribution": "normal"},
    {"tails": "student"},
    {"law": "power"},
    {"scatter": "volume"},
)


@cache
def _base(choice: int) -> Posterior:
    return posterior(observations(), **SETTINGS[choice])


@given(
    keys=st.lists(st.sampled_from(KEYS_WITH_NEUTRAL), unique=True, min_size=1, max_size=6),
    choice=st.integers(0, len(SETTINGS) - 1),
    seed=st.integers(0, 50),
)
@settings(max_examples=20, deadline=None, derandomize=True)
def test_neutral_effects_are_the_base_model(keys: list[str], choice: int, seed: int) -> None:
    base = _base(choice)
    model = posterior(observations(), *keys, **SETTINGS[choice])
    u = near(base, 0.1, seed)
    # The speeds have their own grid: between its points both models blend alike.
    with_effects = _with_neutral(model, base, u)
    _assert_same(model, with_effects, base, u)


def test_every_effect_alone_is_the_base_model() -> None:
    base = _base(0)
    u = near(base, 0.1, 3)
    for key in KEYS_WITH_NEUTRAL:
        model = posterior(observations(), key)
        _assert_same(model, _with_neutral(model, base, u), base, u)


def _with_neutral(model: Posterior, base: Posterior, u: np.ndarray) -> np.ndarray:
    """The base model's coordinates, and neutral ones for what the effects add."""
    known = {s.name: float(value) for s, value in zip(base.layout.slots, u, strict=True)}
    neutral = {s.name: s.neutral for s in model.layout.slots} | {"sigma_n": 0.0}
    neutral |= {model.layout.slots[k].name: 0.0 for k in model.layout.spreads.values()}
    return np.array([known.get(s.name, neutral[s.name]) for s in model.layout.slots])


def _assert_same(model: Posterior, u: np.ndarray, base: Posterior, base_u: np.ndarray) -> None:
    offsets = np.zeros(len(model.plan.names)) if model.plan else None
    events, expected_events = (
        model.pinned(u).event_log_likelihood(u, offsets),
        base.pinned(base_u).event_log_likelihood(base_u),
    )
    if model.nodes.panels().tobytes() == base.nodes.panels().tobytes():
        assert np.array_equal(events, expected_events)
        assert model.exact_log_likelihood(u) == base.exact_log_likelihood(base_u)
    else:  # an effect on the records' errors needs other nodes for some of them
        assert events == pytest.approx(expected_events, abs=2e-3)
    tables, expected = model.nodes.predicted_at(u), base.nodes.predicted_at(base_u)
    for name in ("record", "elevation", "status"):
        _assert_bits(getattr(tables, name), getattr(expected, name))
    for block, expected_block in zip(tables.speeds, expected.speeds, strict=True):
        _assert_bits(block.speed, expected_block.speed)


def _assert_bits(a: Any, b: Any) -> None:
    assert a.tobytes() == b.tobytes()


def test_off_their_neutral_values_effects_change_the_likelihood() -> None:
    base = _base(0)
    u = near(base, 0.1, 3)
    for key in (*ADDED, "volume-scatter", "covariate:wind"):
        model = posterior(observations(), key)
        moved = _with_neutral(model, base, u)
        added = [s.name not in {b.name for b in base.layout.slots} for s in model.layout.slots]
        moved[added] += np.where(moved[added] >= model.layout.high[added], -0.5, 0.5)
        assert abs(model.log_likelihood(moved) - base.log_likelihood(u)) > 1e-3, key
