"""Log likelihood of events and its derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.likelihood.quadrature import N_NODES
from avahazard.inference.likelihood.terms import event_terms

N = 8
"""Events: every other one ran beyond its profile, the second half has a detection limit."""
ENDS = np.tile([[True, False], [True, False], [False, True], [True, True]], (2, 1))
"""The ends of the grid beyond which a record has anything."""


def _nodes(seed: int = 1) -> Nodes:
    rng = np.random.default_rng(seed)

    def weights() -> np.ndarray:
        w = rng.random((N, N_NODES))
        w[:, 7:] = 0.0  # unused nodes
        return w / w.sum(axis=1, keepdims=True)

    half = np.arange(N) >= N // 2
    left = np.arange(N) % 2 == 1
    return Nodes(
        place=rng.normal(-0.7, 0.3, (N, N_NODES)),
        weight=weights(),
        used=np.full(N, N_NODES),
        tail_place=np.tile([-1.2, 0.1], (N, 1)),
        tail=np.where(left[:, None] | ~ENDS, 0.0, rng.uniform(0.0, 0.5, (N, 2))),
        log_scale=np.where(left, 0.0, rng.normal(-5.0, 1.0, N)),
        is_probability=left,
        floor=np.where(left, 0.2, 0.0),
        seen_place=rng.normal(-0.2, 0.2, (N, N_NODES)),
        seen_weight=0.7 * weights(),
        seen_floor=np.where(half, 0.3, 1.0),
        has_limit=half,
        log_wrong=np.where(left, -np.inf, rng.normal(-7.0, 2.0, N)),
    )


def _setting(seed: int = 2) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    location = rng.normal(-0.7, 0.2, (N, 3))
    scatter = rng.uniform(0.1, 0.4, (N, 3))
    volume_weight = np.tile([0.2, 0.5, 0.3], (N, 1))
    return location, scatter, volume_weight


def _slow(nodes: Nodes, location, scatter, volume_weight, student: bool) -> np.ndarray:
    """The sums as they are written, event by event."""
    law = stats.t(4) if student else stats.norm()
    value = np.empty(N)
    for i in range(N):
        chance, seen = float(nodes.floor[i]), float(nodes.seen_floor[i])
        for q in range(location.shape[1]):
            z = (nodes.place[i] - location[i, q]) / scatter[i, q]
            part = law.cdf(z) if nodes.is_probability[i] else law.pdf(z) / scatter[i, q]
            chance += volume_weight[i, q] * np.sum(nodes.weight[i] * part)
            edge = (nodes.tail_place[i] - location[i, q]) / scatter[i, q]
            beyond = np.array([law.cdf(edge[0]), law.sf(edge[1])])
            chance += volume_weight[i, q] * np.sum(nodes.tail[i] * beyond)
            z = (nodes.seen_place[i] - location[i, q]) / scatter[i, q]
            seen += volume_weight[i, q] * np.sum(nodes.seen_weight[i] * law.cdf(z))
        value[i] = np.log(chance) + nodes.log_scale[i]
        if nodes.has_limit[i]:
            value[i] -= np.log(seen)
        if student:
            value[i] = np.log(np.exp(value[i]) + np.exp(nodes.log_wrong[i]))
    return value


@pytest.mark.parametrize("student", [False, True])
def test_values_are_the_sums_as_written(student: bool) -> None:
    nodes, setting = _nodes(), _setting()
    fast = event_terms(nodes, *setting, student).value
    assert fast == pytest.approx(_slow(nodes, *setting, student), abs=1e-12)


@pytest.mark.parametrize("student", [False, True])
def test_derivatives_are_the_differences(student: bool) -> None:
    nodes = _nodes()
    location, scatter, volume_weight = _setting()
    terms = event_terms(nodes, location, scatter, volume_weight, student)
    step = 1e-5

    def value(location, scatter):
        return event_terms(nodes, location, scatter, volume_weight, student).value

    for q in range(3):
        nudge = step * (np.arange(3) == q)
        by_m = (value(location + nudge, scatter) - value(location - nudge, scatter)) / (2 * step)
        assert terms.by_location[:, q] == pytest.approx(by_m, abs=1e-7)
        wide, narrow = scatter * np.exp(nudge), scatter * np.exp(-nudge)
        by_s = (value(location, wide) - value(location, narrow)) / (2 * step)
        assert terms.by_scatter[:, q] == pytest.approx(by_s, abs=1e-7)
    step = 1e-4
    bend = value(location + step, scatter) + value(location - step, scatter)
    bend -= 2 * value(location, scatter)
    assert terms.curvature == pytest.approx(bend / step**2, abs=1e-4)


def test_far_from_every_node_nothing_underflows() -> None:
    nodes = _nodes()._replace(tail=np.zeros((N, 2)))
    location, scatter, volume_weight = _setting()
    near = event_terms(nodes, location - 30.0, scatter, volume_weight)
    records = ~nodes.is_probability
    # There log p falls as -z²/2, and its slope is z/σ.
    assert np.all(np.isfinite(near.value))
    assert np.all(near.value[records] < -1000.0)
    assert np.all(near.by_location[records].sum(axis=1) > 50.0)


def test_one_certain_node_is_the_density_itself() -> None:
    nodes = _nodes()._replace(tail=np.zeros((N, 2)))
    nodes.weight[:], nodes.weight[:, 0] = 0.0, 1.0
    location, scatter, _ = _setting()
    one = np.ones((N, 1))
    terms = event_terms(nodes, location[:, :1].copy(), scatter[:, :1].copy(), one)
    plain = ~nodes.is_probability & ~nodes.has_limit
    expected = stats.norm.logpdf(nodes.place[:, 0], location[:, 0], scatter[:, 0])
    assert (terms.value - nodes.log_scale)[plain] == pytest.approx(expected[plain])


@pytest.mark.parametrize("student", [False, True])
@pytest.mark.parametrize("away", [0.0, 40.0])
def test_values_alone_are_those_of_the_terms(student: bool, away: float) -> None:
    nodes, (location, scatter, weight) = _nodes(), _setting()
    terms = event_terms(nodes, location + away, scatter, weight, student)
    values = event_terms(nodes, location + away, scatter, weight, student, slopes=False).value
    np.testing.assert_allclose(values, terms.value, rtol=1e-14)


def test_a_record_that_is_all_but_surely_wrong_has_the_density_of_wrong_ones() -> None:
    nodes = _nodes()
    records = ~nodes.is_probability
    nodes.log_scale[records], nodes.log_wrong[records] = -2000.0, -5.0
    terms = event_terms(nodes, *_setting(), True)
    assert terms.value[records] == pytest.approx(-5.0)
    assert terms.by_location[records] == pytest.approx(0.0)
