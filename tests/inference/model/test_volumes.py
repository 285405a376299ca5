"""Recorded volumes: their population, nodes and errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm, truncnorm

from avahazard.effects.columns import build_columns
from avahazard.effects.record import MIN_SPREAD
from avahazard.inference.model.volumes import (
    MOST_PULL,
    WIDEST,
    VolumeNodes,
    bounded,
    cut_normals,
    drawn_log_volumes,
    even_nodes,
    largest_volume,
    rescaled,
    told_by,
    volume_nodes,
)
from avahazard.records.collection import Event, Path

SPREAD, SIGMA = 1.2, 0.6


def _world(n: int, n_paths: int, seed: int) -> tuple[list[Event], np.ndarray]:
    """Events with lognormal volumes around the centre of their path, and their true log volumes."""
    rng = np.random.default_rng(seed)
    centre = rng.normal(10.0, 0.8, n_paths)
    path = rng.integers(0, n_paths, n)
    truth = centre[path] + SPREAD * rng.standard_normal(n)
    recorded = truth + SIGMA * rng.standard_normal(n)
    events = [
        Event(str(i), f"P{path[i]}", volume_m3=float(np.exp(v)), volume_rel_sigma=SIGMA)
        for i, v in enumerate(recorded)
    ]
    return events, truth


def _nodes(events: list[Event], population: VolumeNodes | None = None) -> VolumeNodes:
    names = {e.path_id for e in events if e.path_id}
    columns = build_columns(events, {n: Path(n) for n in names}, np.full(len(events), np.nan))
    return volume_nodes(events, columns, population)


def _mean(nodes: VolumeNodes) -> np.ndarray:
    return np.sum(nodes.weight * nodes.log_volume, axis=1)


def test_records_are_drawn_to_the_centre_as_far_as_is_right() -> None:
    events, truth = _world(4000, 8, 1)
    recorded = np.log([e.volume_m3 for e in events])
    nodes = _nodes(events)
    mean = _mean(nodes)
    # True volumes scatter about the nodes' mean without any slope; about the records they have one.
    assert np.polyfit(mean, truth, 1)[0] == pytest.approx(1.0, abs=0.03)
    assert np.polyfit(recorded, truth, 1)[0] < 0.92
    assert np.std(truth - mean) == pytest.approx(nodes.sd.mean(), rel=0.04)
    assert nodes.population.spread == pytest.approx(SPREAD, rel=0.05)
    assert np.mean((truth - mean) ** 2) < 0.85 * np.mean((truth - recorded) ** 2)


def test_nodes_have_the_moments_of_the_normal() -> None:
    nodes = _nodes(_world(50, 3, 2)[0])
    assert nodes.weight.sum(axis=1) == pytest.approx(1.0)
    assert _mean(nodes) == pytest.approx(nodes.mean)
    for power, moment in ((2, 1.0), (3, 0.0), (4, 3.0)):
        z = (nodes.log_volume - nodes.mean[:, None]) / nodes.sd[:, None]
        got = np.sum(nodes.weight * z**power, axis=1)
        assert got == pytest.approx(np.full(50, moment), abs=1e-9)


@pytest.mark.parametrize(("width", "error"), [(0.3, 0.06), (0.5, 0.01), (2.0, 1e-3)])
def test_nodes_bear_narrow_bells(width: float, error: float) -> None:
    """A record is normal in log V with that width; the error is of its log mean (nats)."""
    z, weight = even_nodes(11, 0.65)
    for middle in np.linspace(-2.5, 2.5, 41):
        found = np.sum(weight * np.exp(-0.5 * ((z - middle) / width) ** 2))
        variance = 1.0 + width**2
        exact = width / np.sqrt(variance) * np.exp(-0.5 * middle**2 / variance)
        assert abs(np.log(found / exact)) < error


def test_an_event_without_a_volume_has_the_whole_population() -> None:
    events, _ = _world(400, 2, 3)
    nodes = _nodes([*events, Event("bare", "P1"), Event("stranger", "elsewhere")])
    assert nodes.mean[-2] == pytest.approx(nodes.population.centre["P1"])
    assert nodes.sd[-2] == pytest.approx(nodes.population.spread)
    centres = [nodes.population.centre[p] for p in ("P0", "P1", "elsewhere")]
    assert nodes.mean[-1] == pytest.approx(nodes.population.centre["elsewhere"])
    assert min(centres) <= nodes.mean[-1] <= max(centres)


def test_few_records_pull_a_centre_less_than_many() -> None:
    rng = np.random.default_rng(4)

    def event(name: str, path: str, level: float, away: float) -> Event:
        return Event(name, path, volume_m3=float(np.exp(level + away)))

    common = [event(f"c{i}", f"P{i % 4}", 10.0, rng.standard_normal()) for i in range(200)]
    few = [Event("few", "few", volume_m3=float(np.exp(13.0)))]
    away = rng.standard_normal(40)
    many = [event(f"m{i}", "many", 13.0, a) for i, a in enumerate(away - away.mean())]
    centre = _nodes([*common, *few, *many]).population.centre
    assert centre["few"] < centre["many"] < 13.05
    assert centre["many"] == pytest.approx(13.0, abs=0.1)


def test_exact_records_keep_their_volume() -> None:
    events = [
        Event(str(i), "P", volume_m3=float(v), volume_rel_sigma=1e-6)
        for i, v in enumerate(np.geomspace(1e3, 1e6, 20))
    ]
    nodes = _nodes(events)
    assert _mean(nodes) == pytest.approx(np.log([e.volume_m3 for e in events]), abs=1e-4)


def test_a_population_from_elsewhere_is_used_as_it_is() -> None:
    past = _nodes(_world(300, 2, 5)[0])
    new = _nodes([Event("a", "P0", volume_m3=1e4), Event("b", "unknown")], past)
    assert (new.population.centre, new.population.spread) == (
        past.population.centre,
        past.population.spread,
    )
    assert new.mean[1] == pytest.approx(np.mean(list(past.population.centre.values())))


def test_without_any_volume_that_is_said() -> None:
    nodes = _nodes([Event("a", "P"), Event("b", "Q")])
    assert nodes.population.known is False
    assert np.all(np.isfinite(nodes.log_volume))
    assert _nodes([Event("a", "P", volume_m3=5e3)]).population.known is True


def test_volumes_more_alike_than_their_error_keep_a_spread() -> None:
    alike = [Event(str(i), "P", volume_m3=1e4 + i) for i in range(30)]
    assert _nodes(alike).population.spread == MIN_SPREAD


def test_errors_of_another_size_are_as_if_they_were_stated() -> None:
    events, _ = _world(300, 4, 6)
    new = [Event("a", "P0", volume_m3=1e4, volume_rel_sigma=0.4), Event("b", "unknown")]

    def told(factor: float, some: list[Event]) -> list[Event]:
        return [replace(e, volume_rel_sigma=factor * e.volume_rel_sigma) for e in some]

    for factor in (0.3, 1.7):
        past = _nodes(told(factor, events))
        scaled = rescaled(_nodes(events), factor)
        assert np.array_equal(scaled.log_volume, past.log_volume)
        # What is predicted sees the population of the past with the same factor.
        to_come = rescaled(_nodes(new, _nodes(events)), factor)
        assert np.array_equal(to_come.log_volume, _nodes(told(factor, new), past).log_volume)


def test_no_true_volume_is_over_the_largest() -> None:
    events, _ = _world(300, 4, 3)
    free = _nodes(events)
    largest = float(np.exp(np.quantile(free.records.log_volume, 0.9)))
    cut = bounded(free, largest)
    assert np.all(cut.volume < largest)
    top = (np.log(largest) - free.mean) / free.sd
    law = truncnorm(-np.inf, top, free.mean, free.sd)
    np.testing.assert_allclose(_mean(cut), law.mean(), atol=0.01)
    squares = np.sum(cut.weight * (cut.log_volume - _mean(cut)[:, None]) ** 2, axis=1)
    np.testing.assert_allclose(squares, law.var(), rtol=0.1)
    # Where the bound is far above, nothing is cut.
    np.testing.assert_allclose(_mean(bounded(free, 1e30)), free.mean, atol=0.01)
    assert rescaled(cut, 2.0).largest == largest


def test_a_record_far_over_the_largest_is_next_to_it() -> None:
    events, _ = _world(40, 2, 4)
    cut = bounded(_nodes(events), 10.0)
    assert np.all((cut.volume > 0.0) & (cut.volume < 10.0))
    assert np.all(np.isfinite(cut.log_volume))


def test_a_stand_in_tells_of_true_volumes_what_is_right() -> None:
    """Errors of the records are three times those stated, and a length goes with the true ones."""
    events, truth = _world(4000, 8, 1)
    stated = [replace(e, volume_rel_sigma=SIGMA / 3.0) for e in events]
    length = 3.0 + truth / 3.0 + 0.2 * np.random.default_rng(2).standard_normal(len(truth))
    length[:40] = np.nan
    stated[100] = replace(stated[100], volume_m3=None)
    nodes = rescaled(told_by(_nodes(stated), length), 3.0)
    mean, error = _mean(nodes), truth - _mean(nodes)
    assert np.polyfit(mean, truth, 1)[0] == pytest.approx(1.0, abs=0.03)
    np.testing.assert_allclose(np.std(error[101:]), nodes.sd[101:].mean(), rtol=0.04)
    # Better than by the records, or without the lengths, alone.
    without = rescaled(_nodes(stated), 3.0)
    assert np.std(error[101:]) < 0.85 * np.std((truth - _mean(without))[101:])
    np.testing.assert_allclose(mean[:40], _mean(without)[:40], rtol=1e-12)
    assert nodes.sd[0] > nodes.sd[200]
    # A volume that is not recorded is informed by its length alone.
    assert without.sd[100] > nodes.sd[100] > nodes.sd[200]
    assert abs(error[100]) < 3.0 * nodes.sd[100]
    assert nodes.population.known is True


@pytest.mark.parametrize("length", [np.full(30, 2.0), np.full(30, np.nan)])
def test_a_stand_in_that_tells_nothing_changes_nothing(length: np.ndarray) -> None:
    events, _ = _world(30, 2, 5)
    nodes = _nodes(events)
    np.testing.assert_array_equal(told_by(nodes, length).log_volume, nodes.log_volume)


N, N_PATHS, ERROR, TOP = 4000, 200, 0.4, 13.0


def _nodes_of(true: np.ndarray, path: np.ndarray, sigma: float, seed: int = 1) -> VolumeNodes:
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


@pytest.mark.parametrize(
    ("n", "sigma"),
    [
        (40, 0.3),
        (240, 0.8),
        *(pytest.param(*x, marks=pytest.mark.slow) for x in [(240, 0.3), (240, 2.5), (2000, 0.5)]),
    ],
)
def test_lognormal_volumes_are_told_to_be(n: int, sigma: float) -> None:
    for seed in range(8):
        population = _nodes_of(*_lognormal_world(n, seed), sigma, seed).population
        assert population.largest == np.inf


def test_under_a_largest_volume_large_records_are_drawn_back_as_far_as_is_right() -> None:
    true, path = _cut_world()
    nodes = _nodes_of(true, path, ERROR)
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
    nodes = _nodes_of(true, path, ERROR)
    drawn = drawn_log_volumes(nodes, np.random.default_rng(5).standard_normal((50, N)))
    assert drawn.max() <= nodes.population.largest
    np.testing.assert_allclose(drawn.mean(axis=0), _mean(nodes), atol=0.35)
    for share in (0.05, 0.5, 0.95, 0.99):
        assert np.quantile(drawn, share) == pytest.approx(np.quantile(true, share), abs=0.06)


def test_without_a_largest_they_are_drawn_from_normals() -> None:
    nodes = _nodes_of(*_lognormal_world(60, 1), 0.3)
    z = np.random.default_rng(6).standard_normal(60)
    assert np.array_equal(drawn_log_volumes(nodes, z), nodes.mean + nodes.sd * z)


def test_errors_of_another_size_leave_the_largest_volume() -> None:
    nodes = _nodes_of(*_cut_world(), ERROR)
    near, larger = rescaled(nodes, 1.0001), rescaled(nodes, 1.5)
    np.testing.assert_allclose(near.log_volume, nodes.log_volume, atol=0.01)
    assert larger.largest == nodes.largest
    assert larger.population.spread < nodes.population.spread
    assert np.all(larger.sd > nodes.sd)
    np.testing.assert_array_equal(rescaled(larger, 1.0).log_volume, nodes.log_volume)


def test_a_stand_in_tells_of_them_too() -> None:
    true, path = _power_world()
    nodes = _nodes_of(true, path, 0.8)
    length = true / 3.0 + 0.1 * np.random.default_rng(7).standard_normal(N)
    length[: N // 2] = np.nan
    told = told_by(nodes, length)
    np.testing.assert_array_equal(told.mean[: N // 2], nodes.mean[: N // 2])
    later = slice(N // 2, None)
    assert np.std((true - told.mean)[later]) < 0.8 * np.std((true - nodes.mean)[later])


def test_exact_records_keep_their_volume_whatever_the_population() -> None:
    true, path = _power_world()
    nodes = _nodes_of(true, path, 0.8)
    exact = replace(nodes.records, sigma=np.zeros(N))
    mean, sd = nodes.population.given(exact)
    np.testing.assert_allclose(mean, nodes.records.log_volume)
    assert np.all(sd == 0.0)


def _cut_records(
    n: int, n_paths: int, top: float, error: float, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """Records of normals of spread 1, cut at `top`, as `largest_volume` takes them."""
    rng = np.random.default_rng(seed)
    path = np.arange(n) % n_paths
    middle = rng.normal(0.0, 0.4, n_paths)[path]
    true = middle + truncnorm.rvs(-np.inf, top - middle, random_state=rng)
    recorded = true + error * rng.standard_normal(n)
    centre = np.bincount(path, recorded) / np.bincount(path)
    spread2 = np.sum((recorded - centre[path]) ** 2) / (n - n_paths) - error**2
    return recorded, np.full(n, error), path, centre, float(np.sqrt(spread2))


def test_cut_normals_have_the_moments_asked_for() -> None:
    centre, count = np.array([-0.4, 0.1, 0.5]), np.array([10, 30, 20])
    centres, width = cut_normals(centre, count, 0.8, 1.6)
    laws = [truncnorm(-np.inf, (1.6 - c) / width, c, width) for c in centres]
    np.testing.assert_allclose([law.mean() for law in laws], centre, atol=1e-4)
    variance = np.average([law.var() for law in laws], weights=count)
    assert np.sqrt(variance) == pytest.approx(0.8, abs=1e-4)


def test_without_an_end_they_are_what_is_recorded() -> None:
    centre = np.array([-0.4, 0.1])
    for largest in (np.inf, 40.0):
        centres, width = cut_normals(centre, np.array([1, 1]), 0.8, largest)
        np.testing.assert_allclose([*centres, width], [-0.4, 0.1, 0.8], rtol=1e-9)


def test_where_no_normal_is_so_skewed_it_is_as_wide_as_it_may_be() -> None:
    centres, width = cut_normals(np.array([0.0, 0.0]), np.array([5, 5]), 1.0, 0.2)
    assert 1.0 < width <= WIDEST
    assert np.all(centres > 0.2)


def test_records_of_one_path_that_crowd_at_the_end_do_not_carry_its_centre_away() -> None:
    centre = np.array([0.0, 2.0])
    centres, width = cut_normals(centre, np.array([500, 5]), 1.0, 2.05)
    assert centres[1] - centre[1] == pytest.approx(MOST_PULL * width, rel=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_it_is_found_where_records_lie_beyond_it(seed: int) -> None:
    largest, ratio = largest_volume(*_cut_records(4000, 200, 2.0, 0.3, seed))
    assert largest == pytest.approx(2.0, abs=0.12)
    assert ratio > 10.0


@pytest.mark.parametrize(("n", "n_paths", "error"), [(60, 4, 0.5), (240, 9, 0.3), (4000, 200, 0.8)])
def test_where_there_is_none_it_is_not(n: int, n_paths: int, error: float) -> None:
    ratios = [largest_volume(*_cut_records(n, n_paths, 40.0, error, seed))[1] for seed in range(20)]
    assert max(ratios) < 2.0


def test_the_ratio_is_that_of_the_densities() -> None:
    recorded, sigma, path, centre, spread = _cut_records(60, 3, 0.8, 0.4, 1)
    largest, ratio = largest_volume(recorded, sigma, path, centre, spread)
    centres, width = cut_normals(centre, np.bincount(path), spread, largest)
    free = norm.logpdf(recorded, centre[path], np.hypot(spread, sigma)).sum()
    told = 0.0
    for r, e, k in zip(recorded, sigma, path, strict=True):
        law = truncnorm(-np.inf, (largest - centres[k]) / width, centres[k], width)
        told += np.log(
            quad(lambda v, r=r, e=e, f=law: f.pdf(v) * norm.pdf(r, v, e), -8, largest)[0]
        )
    assert ratio == pytest.approx(told - free - 0.5 * np.log(60), abs=1e-5)
