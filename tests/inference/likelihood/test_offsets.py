"""Offsets of groups: their system against the whole matrix, the kernel against an optimiser."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar

from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.likelihood.offsets import (
    Offsets,
    by_offset,
    newton_offsets,
    offset_system,
    solved,
)
from avahazard.inference.likelihood.terms import event_terms
from avahazard.kernels import kernel

N_CROSSED = 40


@kernel
def found(index, rest, h, keep, prior, slope):  # type: ignore[no-untyped-def]
    """All that the system gives."""
    bend, cross, back = offset_system(index, rest, h, keep, prior)
    step = solved(rest, bend, cross, back, slope)
    return bend, cross, back, step


@kernel
def summed(index, keep, g, n_offsets):  # type: ignore[no-untyped-def]
    return by_offset(index, keep, g, n_offsets)


def crossed(seed: int) -> tuple[np.ndarray, ...]:
    """Five paths, the largest grouping, and three winters; some events have no winter."""
    rng = np.random.default_rng(seed)
    winter = np.where(rng.uniform(size=N_CROSSED) < 0.3, -1, 5 + rng.integers(0, 3, N_CROSSED))
    index = np.stack([rng.integers(0, 5, N_CROSSED), winter])
    rest = np.array([-1] * 5 + [0, 1, 2])
    keep = rng.uniform(size=N_CROSSED) < 0.8
    return index, rest, rng.uniform(0.0, 9.0, N_CROSSED), keep, rng.uniform(1.0, 20.0, 8)


def whole(index: np.ndarray, h: np.ndarray, keep: np.ndarray, prior: np.ndarray) -> np.ndarray:
    """The precision of all offsets, event by event."""
    matrix = np.diag(prior)
    for i in np.flatnonzero(keep):
        selected = index[:, i][index[:, i] >= 0]
        matrix[np.ix_(selected, selected)] += h[i]
    return matrix


@pytest.mark.parametrize("seed", range(4))
def test_steps_and_determinant_are_those_of_the_whole_matrix(seed: int) -> None:
    index, rest, h, keep, prior = crossed(seed)
    slope = np.random.default_rng(seed).standard_normal(8)
    bend, cross, back, step = found(index, rest, h, keep, prior, slope)
    matrix = whole(index, h, keep, prior)
    np.testing.assert_allclose(bend, np.diag(matrix))
    np.testing.assert_allclose(step, np.linalg.solve(matrix, slope), atol=1e-12)
    offsets = Offsets(step, rest, bend, cross, back)
    assert offsets.log_determinant == pytest.approx(np.linalg.slogdet(matrix)[1])
    # Variances of all offsets, and of each event's sum of them.
    inverse = np.linalg.inv(matrix)
    of_offsets, of_events = offsets.variances(index)
    np.testing.assert_allclose(of_offsets, np.diag(inverse), rtol=1e-10)
    design = np.array([np.isin(np.arange(8), some) for some in index.T], dtype=float)
    np.testing.assert_allclose(of_events, np.diag(design @ inverse @ design.T), rtol=1e-10)


def test_one_grouping_is_a_diagonal() -> None:
    index, _, h, keep, prior = crossed(1)
    index, prior, slope = index[:1].copy(), prior[:5].copy(), np.arange(5.0)
    bend, cross, back, step = found(index, np.full(5, -1), h, keep, prior, slope)
    assert back.size == 0
    own = np.diag(whole(index, h, keep, prior))
    np.testing.assert_allclose(bend, own)
    np.testing.assert_allclose(step, slope / own)
    offsets = Offsets(step, np.full(5, -1), bend, cross, back)
    assert offsets.log_determinant == pytest.approx(np.sum(np.log(own)))


def test_where_an_event_has_no_likelihood_the_step_is_nan() -> None:
    index, rest, h, keep, prior = crossed(2)
    h[np.flatnonzero(keep & (index[1] >= 0))[0]] = np.nan
    *_, back, step = found(index, rest, h, keep, prior, np.ones(8))
    assert np.all(np.isnan(back))
    assert np.any(np.isnan(step))


def test_sums_by_offset_are_over_the_events_that_count() -> None:
    index, _, h, keep, _ = crossed(2)
    expected = [
        sum(h[i] for i in np.flatnonzero(keep) for a in range(2) if index[a, i] == k)
        for k in range(8)
    ]
    np.testing.assert_allclose(summed(index, keep, h, 8), expected)


N_EVENTS, N_VOLUMES, N_GROUPS = 30, 3, 4


def setting(seed: int) -> tuple[Nodes, np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    nodes = Nodes(
        place=np.log(0.4) + 0.1 * rng.standard_normal((N_EVENTS, 5)),
        weight=rng.uniform(0.1, 1.0, (N_EVENTS, 5)),
        used=np.full(N_EVENTS, 5),
        tail_place=np.zeros((N_EVENTS, 2)),
        tail=np.zeros((N_EVENTS, 2)),
        log_scale=np.zeros(N_EVENTS),
        is_probability=rng.uniform(size=N_EVENTS) < 0.2,
        floor=np.zeros(N_EVENTS),
        seen_place=np.zeros((N_EVENTS, 5)),
        seen_weight=np.zeros((N_EVENTS, 5)),
        seen_floor=np.zeros(N_EVENTS),
        has_limit=np.zeros(N_EVENTS, dtype=np.bool_),
        log_wrong=np.full(N_EVENTS, -np.inf),
    )
    location = np.log(0.45) + 0.05 * rng.standard_normal((N_EVENTS, N_VOLUMES))
    return nodes, location, np.full_like(location, 0.15), np.full(location.shape, 1 / N_VOLUMES)


@pytest.mark.parametrize("in_log", [True, False])
def test_offsets_are_where_a_plain_optimiser_finds_them(in_log: bool) -> None:
    nodes, location, scatter, weight = setting(1)
    if not in_log:
        nodes = nodes._replace(place=np.exp(nodes.place))
        location = np.exp(location)
    group = np.arange(N_EVENTS) % (N_GROUPS + 1) - 1
    keep = np.arange(N_EVENTS) % 7 != 0
    precision = 0.1**-2.0
    index, rest = group[None], np.full(N_GROUPS, -1)
    prior = np.full(N_GROUPS, precision)
    found, bend, cross, _, value = newton_offsets(
        nodes, location, scatter, weight, False, in_log, index, rest, keep, prior
    )
    assert cross.size == 0
    for k in range(N_GROUPS):
        selected = (group == k) & keep

        def cost(offset: float, selected: np.ndarray = selected) -> float:
            moved = location + offset if in_log else location * np.exp(offset)
            total = event_terms(nodes, moved, scatter, weight).value[selected].sum()
            return float(0.5 * precision * offset**2 - total)

        best = minimize_scalar(cost, bounds=(-1.0, 1.0), method="bounded", options={"xatol": 1e-9})
        # On log μ the steps leave out the bend of the exponential, and end a little short.
        assert found[k] == pytest.approx(best.x, abs=2e-6 if in_log else 1e-3)
        h = 1e-3
        curvature = (cost(best.x + h) - 2.0 * cost(best.x) + cost(best.x - h)) / h**2
        assert bend[k] == pytest.approx(curvature, rel=1e-2 if in_log else 0.3)
        there = location + best.x if in_log else location * np.exp(best.x)
        given = event_terms(nodes, there, scatter, weight).value
        np.testing.assert_allclose(value[selected], given[selected], atol=1e-4 if in_log else 5e-3)
    assert np.all(value[~keep] == 0.0)


@pytest.mark.parametrize("in_log", [True, False])
def test_crossed_offsets_are_those_of_a_plain_optimiser(in_log: bool) -> None:
    nodes, location, scatter, weight = setting(2)
    if not in_log:
        nodes = nodes._replace(place=np.exp(nodes.place))
        location = np.exp(location)
        scatter = 0.4 * scatter
    many, few = np.arange(N_EVENTS) % 6, np.arange(N_EVENTS) // 8 - 1
    of = np.array([0] * 6 + [1] * 3)
    index = np.array([many, np.where(few >= 0, few + 6, -1)])
    rest = np.array([-1] * 6 + [0, 1, 2])
    precision = np.where(of == 0, 0.1**-2.0, 0.15**-2.0)
    keep = np.ones(N_EVENTS, dtype=np.bool_)
    mode, bend, cross, back, value = newton_offsets(
        nodes, location, scatter, weight, False, in_log, index, rest, keep, precision
    )

    def cost(offsets: np.ndarray) -> float:
        shift = np.append(offsets, 0.0)[index].sum(axis=0)[:, None]
        moved = location + shift if in_log else location * np.exp(shift)
        total = event_terms(nodes, moved, scatter, weight).value.sum()
        return float(0.5 * np.sum(precision * offsets**2) - total)

    best = minimize(cost, np.zeros(9), method="BFGS", options={"gtol": 1e-7})
    np.testing.assert_allclose(mode, best.x, atol=2e-5 if in_log else 3e-3)
    assert value.sum() - 0.5 * np.sum(precision * mode**2) == pytest.approx(-best.fun, abs=1e-3)
    if in_log:
        h, unit = 1e-3, np.eye(9)
        hessian = np.array(
            [
                [
                    cost(mode + h * (a + b)) - cost(mode + h * (a - b))
                    - cost(mode - h * (a - b)) + cost(mode - h * (a + b))
                    for b in unit
                ]
                for a in unit
            ]
        ) / (4.0 * h * h)  # fmt: skip
        found = Offsets(mode, rest, bend, cross, back)
        sign, log_det = np.linalg.slogdet(hessian)
        assert sign == 1.0
        assert found.log_determinant == pytest.approx(log_det, abs=0.2)
        rng = np.random.default_rng(1)
        draws = np.array([found.draw(rng) for _ in range(20000)])
        covariance = np.linalg.inv(hessian)
        sd = np.sqrt(np.diag(covariance))
        np.testing.assert_allclose(draws.mean(axis=0), mode, atol=4e-3)
        np.testing.assert_allclose(
            np.cov(draws.T) / np.outer(sd, sd), covariance / np.outer(sd, sd), atol=0.1
        )
