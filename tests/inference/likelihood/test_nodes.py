"""Nodes over friction against brute integration, and what grossly wrong records cost."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from avahazard.criticism.diagnosis.refits import refit
from avahazard.inference.likelihood.nodes import Nodes, build_nodes, log_wrong, wrong_ranges
from avahazard.inference.likelihood.predicted import Predicted, TrackSpeeds
from avahazard.inference.likelihood.quadrature import gauss_nodes
from avahazard.inference.likelihood.record_nodes import FEW
from avahazard.inference.likelihood.terms import event_terms
from avahazard.inference.model.observations import (
    ELEVATION,
    LEFT,
    LENGTH,
    Observations,
    SpeedRecord,
    build_observations,
)
from avahazard.inference.model.specification import Specification
from avahazard.physics.runout_curve import MU
from avahazard.synth.dataset import Settings
from avahazard.synth.making import make_dataset
from tests.inference import naive_nodes

LOG_MU = np.log(MU)
LEAVES = MU < 0.2
PLAIN = 1000.0 + 1200.0 * np.clip((MU - 0.2) / 0.8, 0.0, 1.0)
CURVES = {
    "plain": PLAIN,
    "steep": 1000.0 + 1200.0 * stats.norm.cdf((MU - 0.5) / 0.02),
    "flat": 1000.0 + 0.3 * (PLAIN - 1000.0),
    "jump": PLAIN + 150.0 * (MU > 0.45),
    "twice": PLAIN + 150.0 * (MU > 0.45) - 200.0 * (MU > 0.55),
}
FRICTIONS = [(m, s) for m in np.log([0.35, 0.45, 0.5, 0.6]) for s in (0.07, 0.15, 0.3)]


def _nodes(
    curve: np.ndarray,
    kind: int = ELEVATION,
    observed: float = np.nan,
    sigma: float = 10.0,
    limit: float = np.nan,
    speeds: tuple[SpeedRecord, np.ndarray] | None = None,
    left: np.ndarray = LEAVES,
    in_log: bool = True,
    fall_height: float = np.nan,
    jump: tuple[int, np.ndarray] | None = None,
    leaving_sigma: float = 0.0,
    estimated: float | None = None,
) -> Nodes:
    """Nodes of one event whose block stops on `curve`, its `limit` of sight declared."""
    observations: Any = SimpleNamespace(
        n_events=1,
        sites=(None,),
        speeds=() if speeds is None else (speeds[0],),
        kind=np.array([kind]),
        observed=np.array([observed]),
        sigma=np.array([sigma]),
        fall_height=np.array([fall_height]),
        limit=np.array([limit]),
    )
    predicted = Predicted(
        record=curve[None],
        x=np.full((1, len(MU)), np.nan),
        elevation=curve[None],
        status=left[None].astype(np.int8),
        speeds=()
        if speeds is None
        else (TrackSpeeds(speeds[1], *(jump or (-1, np.zeros(len(speeds[0].x))))),),
        sigma=observations.sigma,
        leaving_sigma=np.array([leaving_sigma]),
        raised=np.zeros(1),
    )
    by_records = None if estimated is None else np.array([estimated])
    return build_nodes(observations, predicted, limit=by_records, in_log=in_log)


def _log_likelihood(nodes: Nodes, m: float, s: float) -> float:
    terms = event_terms(nodes, np.array([[m]]), np.array([[s]]), np.ones((1, 1)))
    return float(terms.value[0])


def _density(m: float, s: float):
    return lambda nu: stats.norm.pdf(nu, m, s)


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("sigma", [3.0, 10.0, 25.0])
@pytest.mark.parametrize("place", [0.1, 0.3, 0.5, 0.8])
def test_a_record_has_its_marginal_likelihood(name: str, sigma: float, place: float) -> None:
    curve = CURVES[name]
    low, high = curve[~LEAVES].min(), curve.max()
    observed = low + place * (high - low)
    nodes = _nodes(curve, observed=observed, sigma=sigma)
    for m, s in FRICTIONS:
        slow = naive_nodes.likelihood(curve, LEAVES, observed, sigma, LOG_MU, _density(m, s))
        # A record that is far less likely than the best needs less care.
        if slow * sigma > 1e-4:
            assert _log_likelihood(nodes, m, s) == pytest.approx(np.log(slow), abs=0.02)


def test_where_f_jumps_over_the_record_the_friction_is_that_of_the_jump() -> None:
    curve = CURVES["jump"]
    before = curve[MU <= 0.45][-1]
    nodes = _nodes(curve, observed=before + 75.0, sigma=10.0)
    mean = float(np.exp(np.sum(nodes.weight * nodes.place)))
    assert mean == pytest.approx(0.45, abs=0.003)


@pytest.mark.parametrize("above", [50.0, 137.0, 203.0, 388.0])
def test_a_jump_of_hundreds_of_standard_deviations(above: float) -> None:
    curve = PLAIN + 400.0 * (MU > 0.45)
    observed = curve[MU <= 0.45][-1] + above
    nodes = _nodes(curve, observed=observed, sigma=1.0)
    density = _density(-0.7, 0.15)
    slow = naive_nodes.likelihood(curve, LEAVES, observed, 1.0, LOG_MU, density, per_cell=1000)
    assert _log_likelihood(nodes, -0.7, 0.15) == pytest.approx(np.log(slow), abs=0.02)


def test_two_places_with_one_elevation_have_two_bumps() -> None:
    curve = CURVES["twice"]
    nodes = _nodes(curve, observed=1630.0, sigma=5.0)
    mu = np.exp(nodes.place[0])
    for crossing in (0.52, 0.653):
        assert nodes.weight[0, np.abs(mu - crossing) < 0.02].sum() > 0.3


def test_nodes_in_friction_itself_for_normal_scatter() -> None:
    nodes = _nodes(PLAIN, observed=1400.0, in_log=False)
    slow = naive_nodes.likelihood(PLAIN, LEAVES, 1400.0, 10.0, MU, _density(0.5, 0.08))
    assert _log_likelihood(nodes, 0.5, 0.08) == pytest.approx(np.log(slow), abs=1e-3)


def test_an_event_that_left_has_the_chance_to_leave() -> None:
    nodes = _nodes(PLAIN, kind=LEFT)
    for m, s in FRICTIONS:
        slow = naive_nodes.leaving(LEAVES, LOG_MU, _density(m, s))
        if slow > 1e-8:
            assert _log_likelihood(nodes, m, s) == pytest.approx(np.log(slow), abs=0.01)


@pytest.mark.parametrize("blur", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("in_log", [True, False])
def test_the_edge_of_leaving_is_blurred_by_the_error_of_the_release(
    blur: float, in_log: bool
) -> None:
    """The slow twin: the chance to leave of each edge that the error leaves open."""
    nodes = _nodes(PLAIN, kind=LEFT, in_log=in_log, leaving_sigma=blur)
    edge = 0.5 * (LOG_MU[LEAVES][-1] + LOG_MU[~LEAVES][0])
    z = np.linspace(-8.0, 8.0, 4001)
    weight = stats.norm.pdf(z) / stats.norm.pdf(z).sum()
    for m, s in ((0.15, 0.015), (0.22, 0.015), (0.25, 0.05), (0.4, 0.07)):
        centre, places = (np.log(m), edge + blur * z) if in_log else (m, np.exp(edge + blur * z))
        slow = float(weight @ stats.norm.cdf((places - centre) / s))
        if slow > 1e-6:
            assert _log_likelihood(nodes, centre, s) == pytest.approx(np.log(slow), abs=0.04)


def test_edges_that_come_and_go_are_blurred_each() -> None:
    twice = LEAVES | ((MU > 0.3) & (MU < 0.4))
    nodes = _nodes(PLAIN, kind=LEFT, left=twice, leaving_sigma=0.05)
    m, s = np.log(0.35), 0.1
    edges = [0.5 * (LOG_MU[j] + LOG_MU[j + 1]) for j in np.flatnonzero(np.diff(twice))]
    low, rise, fall = (stats.norm.cdf((e - m) / np.hypot(s, 0.05)) for e in edges)
    assert _log_likelihood(nodes, m, s) == pytest.approx(np.log(low - rise + fall), abs=0.01)


def test_leaving_where_the_status_changes_twice_or_never() -> None:
    twice = LEAVES | ((MU > 0.3) & (MU < 0.4))
    nodes = _nodes(PLAIN, kind=LEFT, left=twice)
    slow = naive_nodes.leaving(twice, LOG_MU, _density(np.log(0.35), 0.15))
    assert _log_likelihood(nodes, np.log(0.35), 0.15) == pytest.approx(np.log(slow), abs=1e-3)
    always = _nodes(PLAIN, kind=LEFT, left=np.ones_like(LEAVES))
    assert _log_likelihood(always, np.log(0.35), 0.15) == pytest.approx(0.0, abs=1e-12)
    never = _nodes(PLAIN, kind=LEFT, left=np.zeros_like(LEAVES))
    assert _log_likelihood(never, np.log(0.35), 0.15) < -500.0


@pytest.mark.parametrize("limit", [1100.0, 1300.0, 1700.0, 2195.0])
@pytest.mark.parametrize("above", [-150.0, -20.0, 0.0, 30.0])
def test_of_a_declared_limit_stops_below_it_count_alone(limit: float, above: float) -> None:
    """A record may lie above the limit by its error; then friction is that of a stop below."""
    observed = max(limit + above, 1010.0)
    seen = _nodes(PLAIN, observed=observed, sigma=25.0, limit=limit)
    for m, s in FRICTIONS:
        told = LOG_MU, _density(m, s)
        below = naive_nodes.likelihood(PLAIN, LEAVES, observed, 25.0, *told, limit=limit)
        chance = naive_nodes.seen(PLAIN, LEAVES, limit, *told)
        if chance > 1e-6 and below > 1e-8:
            slow = np.log(below) - np.log(chance)
            assert _log_likelihood(seen, m, s) == pytest.approx(slow, abs=0.02)


def test_no_friction_explains_records_above_a_declared_limit_the_better_the_higher() -> None:
    seen = _nodes(PLAIN, observed=1330.0, sigma=25.0, limit=1300.0)
    found = [_log_likelihood(seen, m, 0.1) for m in np.log([0.4, 0.6, 1.0, 1.6])]
    assert found[0] > found[-1] - 3.0
    assert max(found) < np.log(stats.norm.pdf(30.0, 0.0, 25.0))


@pytest.mark.parametrize("limit", [1100.0, 1300.0, 1700.0, 2195.0, 2210.0])
def test_an_estimated_limit_is_one_of_records(limit: float) -> None:
    observed = 1080.0
    seen = _nodes(PLAIN, observed=observed, estimated=limit)
    plain = _nodes(PLAIN, observed=observed)
    for m, s in FRICTIONS:
        chance = naive_nodes.recorded(PLAIN, LEAVES, limit, 10.0, LOG_MU, _density(m, s))
        gain = _log_likelihood(seen, m, s) - _log_likelihood(plain, m, s)
        if chance > 1e-6:
            assert gain == pytest.approx(-np.log(chance), abs=0.01)


@pytest.mark.parametrize("limit", [1300.0, 1500.0, 1700.0])
@pytest.mark.parametrize("declared", [True, False])
def test_what_runs_up_the_other_side_of_a_valley_is_seen(limit: float, declared: bool) -> None:
    bottom = 0.35
    valley = 1200.0 + np.where(bottom > MU, 4000.0, 1500.0) * np.abs(MU - bottom)
    nobody = np.zeros_like(LEAVES)
    of_sight = {"limit" if declared else "estimated": limit}
    seen = _nodes(valley, observed=1250.0, left=nobody, **of_sight)
    plain = _nodes(valley, observed=1250.0, left=nobody)
    one_side = np.where(bottom > MU, 1200.0, valley)
    for m, s in FRICTIONS:
        told = LOG_MU, _density(m, s)
        if declared:
            chance = naive_nodes.seen(one_side, nobody, limit, *told)
        else:
            chance = naive_nodes.recorded(one_side, nobody, limit, 10.0, *told)
        gain = _log_likelihood(seen, m, s) - _log_likelihood(plain, m, s)
        if chance > 1e-6:
            assert gain == pytest.approx(-np.log(chance), abs=0.01)


@pytest.mark.parametrize(("width", "error"), [(1.0, 0.03), (0.5, 3e-4)])
def test_a_narrow_edge_of_sight_needs_few_nodes(width: float, error: float) -> None:
    """Of a normal edge, in scatters of friction, the chance below is known."""
    points = width * np.linspace(-8.0, 8.0, 2001)
    place, weight = np.empty(FEW), np.empty(FEW)
    gauss_nodes(points, stats.norm.pdf(points / width), place, weight)
    m = np.linspace(-5.0, 5.0, 201)
    true = stats.norm.cdf(-m / np.hypot(1.0, width))
    found = stats.norm.cdf(place - m[:, None]) @ weight
    likely = true > 0.01
    np.testing.assert_allclose(found[likely], true[likely], rtol=error)


def test_a_limit_above_every_stop_changes_nothing() -> None:
    seen = _nodes(PLAIN, observed=1400.0, limit=3000.0)
    plain = _nodes(PLAIN, observed=1400.0)
    for m, s in FRICTIONS:
        assert _log_likelihood(seen, m, s) == pytest.approx(_log_likelihood(plain, m, s), abs=1e-9)


def _speeds() -> tuple[SpeedRecord, np.ndarray]:
    """Speeds at two places: 60 m/s falling with friction, measured at μ = 0.4."""
    predicted = np.sqrt(np.maximum(3600.0 * (1.0 - MU[:, None] / np.array([0.9, 0.7])), 0.0))
    measured = predicted[int(np.argmin(np.abs(MU - 0.4)))]
    x = np.array([200.0, 600.0])
    return SpeedRecord(0, x, measured, np.array([3.0, 3.0]), 0.0, 1200.0), predicted


def test_speeds_join_the_record() -> None:
    record, predicted = _speeds()
    log_speed = naive_nodes.speed_log_likelihood(record, predicted, 0.0)
    nodes = _nodes(PLAIN, observed=1350.0, sigma=25.0, speeds=(record, predicted))
    for m, s in FRICTIONS:
        density = _density(m, s)
        slow = naive_nodes.likelihood(PLAIN, LEAVES, 1350.0, 25.0, LOG_MU, density, log_speed)
        if slow > 1e-12:
            assert _log_likelihood(nodes, m, s) == pytest.approx(np.log(slow), abs=0.02)


def test_speeds_of_an_event_that_left() -> None:
    record, predicted = _speeds()
    log_speed = naive_nodes.speed_log_likelihood(record, predicted, 0.0)
    left = MU < 0.42
    nodes = _nodes(PLAIN, kind=LEFT, speeds=(record, predicted), left=left)
    assert not nodes.is_probability[0]
    for m, s in FRICTIONS:
        slow = naive_nodes.leaving(left, LOG_MU, _density(m, s), log_speed)
        if slow > 1e-8:
            assert _log_likelihood(nodes, m, s) == pytest.approx(np.log(slow), abs=0.05)


def test_where_f_jumps_over_the_stop_the_block_is_brought_to_rest() -> None:
    """All the mass is in one cell, in which speeds do not differ."""
    record, predicted = _speeds()
    cell = int(np.flatnonzero(MU > 0.45)[0]) - 1
    slow = record.speed**2 - 200.0
    curve = CURVES["jump"]
    observed = 0.5 * float(curve[cell] + curve[cell + 1])
    with_it = _nodes(curve, observed=observed, speeds=(record, predicted), jump=(cell, slow))
    plain = _nodes(curve, observed=observed)
    log_speed = naive_nodes.speed_log_likelihood(record, np.sqrt(slow)[None], 0.0)[0]
    gain = _log_likelihood(with_it, np.log(0.45), 0.15) - _log_likelihood(plain, np.log(0.45), 0.15)
    assert gain == pytest.approx(log_speed, abs=0.05)


def test_a_record_that_no_friction_reaches_is_unlikely_but_not_lost() -> None:
    far, farther = (_nodes(PLAIN, observed=y) for y in (2400.0, 2500.0))
    values = [_log_likelihood(nodes, np.log(0.5), 0.15) for nodes in (far, farther)]
    assert np.all(np.isfinite(values))
    assert values[1] < values[0] < -100.0
    out_of_reach = _nodes(PLAIN, kind=LEFT, speeds=_speeds(), left=np.zeros_like(LEAVES))
    assert -1e5 < _log_likelihood(out_of_reach, np.log(0.5), 0.15) < -500.0


def test_weights_of_a_record_sum_to_one() -> None:
    for curve in CURVES.values():
        nodes = _nodes(curve, observed=1300.0)
        assert nodes.weight.sum() == pytest.approx(1.0)
        assert np.all(nodes.weight >= 0.0)


def test_a_runout_length_needs_no_table_of_frictions() -> None:
    # H/L = 0.068 lies off the table; what the curve says must not matter.
    nodes = _nodes(PLAIN, LENGTH, 11065.0, 100.0, fall_height=754.0)
    length = np.linspace(10_000.0, 12_000.0, 20_001)
    density = stats.norm.pdf(length, 11065.0, 100.0)
    for m, s in ((np.log(0.07), 0.2), (np.log(0.1), 0.3)):
        along = density * stats.norm.pdf(np.log(754.0 / length), m, s) / length
        expected = np.log(np.sum(along) * (length[1] - length[0]))
        assert _log_likelihood(nodes, m, s) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("in_log", [True, False])
def test_a_blurred_edge_lies_about_the_edge_itself(in_log: bool) -> None:
    nodes = _nodes(PLAIN, kind=LEFT, in_log=in_log, leaving_sigma=0.1)
    edge = 0.5 * (LOG_MU[LEAVES][-1] + LOG_MU[~LEAVES][0])
    weight, place = nodes.weight[0], nodes.place[0]
    assert np.sum(weight) == pytest.approx(1.0)
    if in_log:
        assert np.sum(weight * place) == pytest.approx(edge, abs=1e-4)
        assert np.sum(weight * (place - edge) ** 2) == pytest.approx(0.1**2, rel=0.02)
    else:
        assert np.sum(weight * place) == pytest.approx(np.exp(edge + 0.005), rel=2e-4)


def test_a_wide_edge_of_sight_has_as_many_nodes_as_a_record() -> None:
    wide = _nodes(PLAIN, observed=1400.0, sigma=150.0, estimated=1700.0)
    narrow = _nodes(PLAIN, observed=1400.0, sigma=1.0, estimated=1700.0)
    assert np.count_nonzero(narrow.seen_weight[0]) <= FEW
    assert np.count_nonzero(wide.seen_weight[0]) > FEW


@pytest.fixture(scope="module")
def observations() -> Observations:
    records, _ = make_dataset(11, 60, 5, {}, Settings(speeds=0.1))
    return build_observations(records)


def test_a_wrong_record_lies_anywhere_on_its_path(observations: Observations) -> None:
    """And its speeds anywhere up to free fall."""
    low, high = wrong_ranges(observations)
    density = log_wrong(observations)
    tracks = {m.event: m for m in observations.speeds}
    assert tracks
    for i in range(observations.n_events):
        if observations.kind[i] == LEFT:
            assert density[i] == -np.inf
            continue
        assert high[i] - low[i] > 100.0
        expected = -np.log(high[i] - low[i])
        if i in tracks:
            site = observations.sites[observations.columns.path_index[i]]
            start = float(site.smooth.height(np.array([tracks[i].release_x]))[0])
            for x in tracks[i].x:
                fallen = start - float(site.smooth.height(np.array([x]))[0])
                expected -= np.log(np.sqrt(2.0 * 9.81 * fallen))
        assert density[i] == pytest.approx(expected)


def test_a_record_where_nothing_stops_costs_no_more_than_a_wrong_one(
    observations: Observations,
) -> None:
    """With normal tails it asks for any effect that moves it."""
    i = int(
        np.flatnonzero((observations.kind == ELEVATION) & np.isfinite(log_wrong(observations)))[0]
    )
    top = observations.sites[observations.columns.path_index[i]].terrain.y.max()
    observed = observations.observed.copy()
    observed[i] = top - 30.0
    moved = replace(observations, observed=observed)
    cost, wrong = {}, 0.0
    for tails in ("normal", "student"):
        fit = refit(moved, Specification(tails=tails), {}, ())  # type: ignore[arg-type]
        cost[tails] = fit.posterior.event_log_likelihood(fit.mode.u)[i]
        wrong = fit.posterior.nodes_at(fit.mode.u).log_wrong[i]
    assert cost["student"] == pytest.approx(wrong, abs=0.1)
    assert cost["normal"] < cost["student"] - 5.0


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_share_of_wrong_records_is_found(share: float) -> None:
    records, _ = make_dataset(12, 150, 5, {}, Settings(wrong_share=share))
    fit = refit(build_observations(records), Specification(law="constant", tails="student"), {}, ())
    found = fit.parameters("")
    # Those that lie where a right one may lie are not recognised, and the prior expects few.
    assert found["wrong_share"] < 0.03 if share == 0.0 else 0.5 * share < found["wrong_share"] < 0.4
    assert 0.1 < found["sigma"] < 0.25
