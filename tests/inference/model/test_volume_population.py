"""Populations of true volumes that are not lognormal, and what records then tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import truncnorm

from avahazard.effects.columns import build_columns
from avahazard.inference.model.volumes import (
    VolumeNodes,
    drawn_log_volumes,
    rescaled,
    told_by,
    volume_nodes,
)
from avahazard.records.event import Event
from avahazard.records.path import Path

N, N_PATHS, SIGMA, TOP = 4000, 200, 0.4, 13.0


def _nodes(true: np.ndarray, path: np.ndarray, sigma: float, seed: int = 1) -> VolumeNodes:
    """Nodes of records of these true log volumes."""
    recorded = true + sigma * np.random.default_rng(seed).standard_normal(len(true))
    events = [
        Event(str(i), f"P{k}", volume_m3=float(np.exp(v)), volume_rel_sigma=sigma)
        for i, (v, k) in enumerate(zip(recorded, path, strict=True))
    ]
    names = {e.path_id for e in events if e.path_id}
    paths = {name: Path(name) for name in names}
    return volume_nodes(events, build_columns(events, paths, np.full(len(events), np.nan)))


def _cut_world() -> tuple[np.ndarray, np.ndarray]:
    """True log volumes under `TOP`, and their paths."""
    rng = np.random.default_rng(3)
    path = np.arange(N) % N_PATHS
    middle = rng.normal(11.0, 0.5, N_PATHS)[path]
    return middle + truncnorm.rvs(-np.inf, TOP - middle, random_state=rng), path


def _power_world() -> tuple[np.ndarray, np.ndarray]:
    """True log volumes that fall off as a power above a least one of each path."""
    rng = np.random.default_rng(4)
    path = np.arange(N) % N_PATHS
    return rng.normal(9.0, 0.5, N_PATHS)[path] + rng.exponential(1.0, N), path


def _lognormal_world(n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    path = np.arange(n) % 9
    return rng.normal(10.0, 0.5, 9)[path] + rng.standard_normal(n), path


def _mean(nodes: VolumeNodes) -> np.ndarray:
    return np.sum(nodes.weight * nodes.log_volume, axis=1)


@pytest.mark.parametrize(
    ("n", "sigma"), [(40, 0.3), (240, 0.3), (240, 0.8), (240, 2.5), (2000, 0.5)]
)
def test_lognormal_volumes_are_told_to_be(n: int, sigma: float) -> None:
    for seed in range(8):
        population = _nodes(*_lognormal_world(n, seed), sigma, seed).population
        assert population.shape is None
        assert population.largest == np.inf


def test_under_a_largest_volume_large_records_are_drawn_back_as_far_as_is_right() -> None:
    true, path = _cut_world()
    nodes = _nodes(true, path, SIGMA)
    assert nodes.population.largest == pytest.approx(TOP, abs=0.1)
    assert nodes.largest == pytest.approx(np.exp(nodes.population.largest))
    recorded = nodes.records.log_volume
    plain = replace(nodes.population, largest=np.inf)
    for low, high in ((0.0, 1.0), (0.9, 0.97), (0.97, 1.0)):
        some = (recorded >= np.quantile(recorded, low)) & (recorded <= np.quantile(recorded, high))
        assert abs(np.mean((true - _mean(nodes))[some])) < 0.08
    # What a lognormal without an end would say of the largest.
    assert np.mean((true - plain.given(nodes.records)[0])[some]) < -0.15


def test_volumes_are_drawn_under_the_largest_and_scatter_as_true_ones() -> None:
    true, path = _cut_world()
    nodes = _nodes(true, path, SIGMA)
    drawn = drawn_log_volumes(nodes, np.random.default_rng(5).standard_normal((50, N)))
    assert drawn.max() <= nodes.population.largest
    np.testing.assert_allclose(drawn.mean(axis=0), _mean(nodes), atol=0.35)
    for share in (0.05, 0.5, 0.95, 0.99):
        assert np.quantile(drawn, share) == pytest.approx(np.quantile(true, share), abs=0.06)


def test_without_a_largest_they_are_drawn_from_normals() -> None:
    nodes = _nodes(*_lognormal_world(60, 1), 0.3)
    z = np.random.default_rng(6).standard_normal(60)
    assert np.array_equal(drawn_log_volumes(nodes, z), nodes.mean + nodes.sd * z)


def test_volumes_that_fall_off_as_a_power_are_read_by_their_own_shape() -> None:
    true, path = _power_world()
    nodes = _nodes(true, path, 0.8)
    assert nodes.population.shape is not None
    plain = replace(nodes.population, shape=None).given(nodes.records)[0]
    recorded = nodes.records.log_volume
    top = recorded > np.quantile(recorded, 0.97)
    assert abs(np.mean((true - nodes.mean)[top])) < 0.4 * abs(np.mean((true - plain)[top]))
    assert np.mean((true - nodes.mean) ** 2) < np.mean((true - plain) ** 2)
    assert np.std(true - nodes.mean) == pytest.approx(np.sqrt(np.mean(nodes.sd**2)), rel=0.05)


@pytest.mark.parametrize("world", [_cut_world, _power_world])
def test_errors_of_another_size_leave_the_kind_of_population(world) -> None:  # type: ignore[no-untyped-def]
    nodes = _nodes(*world(), SIGMA)
    near, larger = rescaled(nodes, 1.0001), rescaled(nodes, 1.5)
    np.testing.assert_allclose(near.log_volume, nodes.log_volume, atol=0.01)
    assert larger.population.shape is nodes.population.shape
    assert larger.largest == nodes.largest
    assert larger.population.spread < nodes.population.spread
    assert np.all(larger.sd > nodes.sd)
    np.testing.assert_array_equal(rescaled(larger, 1.0).log_volume, nodes.log_volume)


def test_a_stand_in_tells_of_them_too() -> None:
    true, path = _power_world()
    nodes = _nodes(true, path, 0.8)
    length = true / 3.0 + 0.1 * np.random.default_rng(7).standard_normal(N)
    length[: N // 2] = np.nan
    told = told_by(nodes, length)
    np.testing.assert_array_equal(told.mean[: N // 2], nodes.mean[: N // 2])
    later = slice(N // 2, None)
    assert np.std((true - told.mean)[later]) < 0.8 * np.std((true - nodes.mean)[later])


def test_exact_records_keep_their_volume_whatever_the_shape() -> None:
    true, path = _power_world()
    nodes = _nodes(true, path, 0.8)
    exact = replace(nodes.records, sigma=np.zeros(N))
    mean, sd = nodes.population.given(exact)
    np.testing.assert_allclose(mean, nodes.records.log_volume)
    assert np.all(sd == 0.0)
