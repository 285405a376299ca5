"""The star of exact tables about a mode, and the highest of several modes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

from avahazard.inference.fitting import star
from avahazard.inference.fitting.arms import REACH, arms_about
from avahazard.inference.fitting.mode import (
    Mode,
    errors_at,
    find_mode,
    held_ascent,
    log_evidence,
    scores_at,
    start_coordinates,
)
from avahazard.inference.fitting.star import gauss_newton, improved, search_mode, surveyed_peak
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import TRACK_SLOT, Arms, with_arms
from avahazard.inference.model.observations import build_observations
from avahazard.physics.runout_curve import MU
from avahazard.synth.dataset import Settings
from avahazard.synth.making import make_dataset
from tests.inference.studies import near, observations, one_path, posterior


def _model(*effects: str) -> Posterior:
    return posterior(build_observations(one_path(40, seed=2, cut_m=1700.0)), *effects)


def _with_speeds(*effects: str) -> Posterior:
    """Tracks of speeds of every event, by which the likelihood is sharp in the motion."""
    records, _ = make_dataset(41_002, 60, 5, {"turbulent-drag": 1.0}, Settings(speeds=1.0))
    return posterior(build_observations(records), *effects)


def _moved(model: Posterior, u: np.ndarray, axis: int, by: float) -> np.ndarray:
    there = u.copy()
    there[axis] = np.clip(u[axis] + by, model.layout.low[axis], model.layout.high[axis])
    return there


def test_the_mode_of_exact_tables_is_a_top_of_the_exact_density() -> None:
    model = _model("turbulent-drag")
    peak = gauss_newton(model, search_mode(model)[1].u + 0.1)
    u, top, sd = peak.u, peak.log_density, np.sqrt(np.diag(peak.covariance))
    for axis in range(len(u)):
        for side in (-0.3, 0.3):
            v = _moved(model, u, axis, side * sd[axis])
            assert model.exact_log_likelihood(v) + float(model.layout.log_prior(v)) < top + 0.05


@pytest.mark.parametrize("promised", [1e-2, 1e2])
def test_the_spread_of_a_peak_is_that_by_which_the_density_falls(promised: float) -> None:
    model = _with_speeds("turbulent-drag")
    peak = gauss_newton(model, near(model))
    axes = [k for k, slot in enumerate(model.layout.slots) if slot.arm]
    scores = scores_at(model, peak.u, np.diag(np.sqrt(np.diag(peak.covariance))))
    found = surveyed_peak(model, replace(peak, covariance=promised * peak.covariance), scores)
    share = np.sqrt(np.diag(found.covariance) / np.diag(peak.covariance))[axes]
    assert np.all((share > 0.6) & (share < 1.6))
    assert found.log_density == pytest.approx(peak.log_density, abs=0.2)


def test_a_survey_goes_to_the_best_place_that_it_sees() -> None:
    model = _with_speeds("turbulent-drag")
    peak = gauss_newton(model, near(model))
    axis = model.layout.places["turbulent-drag"].start
    away = _moved(model, peak.u, axis, 3.0 * np.sqrt(peak.covariance[axis, axis]))
    start = replace(peak, u=away, log_density=model.pinned(away).log_density(away))
    scores = scores_at(model, away, np.diag(np.sqrt(np.diag(peak.covariance))))
    assert surveyed_peak(model, start, scores).log_density > start.log_density + 0.2


def test_a_survey_finds_a_ridge_that_small_steps_hide() -> None:
    """Events of a regression on two columns that go together, each with many small steps."""
    rng = np.random.default_rng(4)
    one, other = rng.standard_normal((2, 200))
    columns = np.column_stack([one, one + 0.03 * other])
    observed = rng.standard_normal(200)
    phase = rng.uniform(0.0, 6.3, 200)

    def events(u: np.ndarray, _offsets: object = None) -> np.ndarray:
        steps = 0.1 * np.sign(np.sin(1000.0 * (columns @ u) + phase))
        return steps - 0.5 * (observed - columns @ u) ** 2

    slot = SimpleNamespace(neutral=np.nan, sd=100.0)
    layout = SimpleNamespace(
        slots=(slot, slot),
        axes=np.arange(2),
        ranges=np.array([[-99.0] * 2, [99.0] * 2]),
        low=np.full(2, -99.0),
        high=np.full(2, 99.0),
        prior_slopes=np.zeros_like,
    )
    model: Any = SimpleNamespace(layout=layout, mode_offsets=lambda _u: None)
    model.pinned = lambda _u: model
    model.event_log_likelihood, model.log_density = events, lambda u: float(np.sum(events(u)))
    best = np.linalg.lstsq(columns, observed, rcond=None)[0]
    values, vectors = np.linalg.eigh(np.linalg.inv(columns.T @ columns))
    along = np.sqrt(values[1])
    u = best + 5.0 * along * vectors[:, 1]
    scores = scores_at(model, u, 0.003 * np.eye(2))
    narrow = np.linalg.inv(scores.T @ scores + 1e-4 * np.eye(2))
    assert np.sqrt(np.max(np.diag(narrow))) < 0.15 * along  # that the steps hide it
    start = Mode(u, model.log_density(u), narrow)
    found = surveyed_peak(model, start, scores)
    assert found.log_density > start.log_density + 2.0
    assert 0.5 < np.sqrt(np.linalg.eigvalsh(found.covariance)[-1]) / along < 2.0


@pytest.mark.parametrize("effects", [("turbulent-drag",), ("leading-edge", "record-error")])
def test_a_star_agrees_with_tables_made_on_the_spot(effects: tuple[str, ...]) -> None:
    model, mode = search_mode(posterior(observations(speeds=False), *effects))
    sd = np.sqrt(np.diag(mode.covariance))
    assert model.log_likelihood(mode.u) == pytest.approx(
        model.exact_log_likelihood(mode.u), abs=0.3
    )
    for axis in model.layout.tables:
        for side in (-2.0, 2.0):
            v = _moved(model, mode.u, axis, side * sd[axis])
            exact = model.exact_log_likelihood(v)
            assert model.log_likelihood(v) == pytest.approx(exact, abs=0.9)


def test_a_star_reaches_some_standard_deviations() -> None:
    whole = _model("turbulent-drag")
    (k,) = whole.layout.tables
    model, mode = search_mode(whole)
    sd = float(np.sqrt(mode.covariance[k, k]))
    for end, bound in zip(model.layout.arm_ends[:, k], whole.layout.ranges[:, k], strict=True):
        reach = abs(end - mode.u[k]) / sd
        assert end == bound or 0.4 * REACH < reach < 4.0 * REACH


def test_a_star_goes_on_where_draws_gather_at_an_end_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(star, "errors_at", lambda _, draws: np.zeros(len(draws)))
    model = _model("turbulent-drag")
    k = model.layout.tables[0]
    whole = model.layout.slots[k]

    def on(*shares: float) -> Posterior:
        return model.on_star(Arms({whole.name: tuple(np.array(shares) * whole.high)}))

    def draws(*shares: float) -> np.ndarray:
        given = np.tile(near(model), (2, 100, 1))
        given[..., k] = np.linspace(*shares, 100) * whole.high
        return given

    fine = on(0.04, 0.03, 0.035, 0.045, 0.05)
    assert improved(fine, draws(0.034, 0.046)) is None
    better = improved(fine, draws(0.034, 0.05))
    assert better is not None
    # About the draws, twice as long, with twice the points.
    assert better.layout.arm_ends[:, k] == pytest.approx(np.array([0.022, 0.062]) * whole.high)
    assert len(better.layout.slots[k].arm) == 9
    # The end of the range itself is no end of the star alone.
    assert improved(on(0.9, 0.8, 0.85, 0.95, 1.0), draws(0.99, 1.0)) is None


def test_a_star_gets_points_where_draws_disagree_with_it() -> None:
    model = _model("turbulent-drag")
    k = model.layout.tables[0]
    whole = model.layout.slots[k]
    coarse = model.on_star(Arms({whole.name: (0.5 * whole.high, 0.0, whole.high)}))
    draws = np.tile(near(model), (2, 100, 1))
    draws[..., k] = np.linspace(0.05, 0.3, 100) * whole.high
    better = improved(coarse, draws)
    assert better is not None
    points = np.array(better.layout.slots[k].beside)
    assert len(points) == star.BESIDE
    assert np.all((points >= 0.05 * whole.high) & (points <= 0.3 * whole.high))
    assert len(better.layout.slots[k].arm) == 5
    before, after = (np.max(np.abs(errors_at(on, draws[0]))) for on in (coarse, better))
    assert after < 0.3 * before


def test_where_an_effect_may_be_none_its_other_parameters_can_be_anything() -> None:
    """The snow line, where little snow is taken up; a rate, where the line is high."""
    model = _model("entrainment")
    rate, above = model.layout.tables
    u = near(model)
    u[rate] = 0.2
    axes = [model.layout.slots[k].name for k in (rate, above)]
    ends = model.layout.ranges[:, [rate, above]]
    wide = arms_about(model, u, np.diag([0.25, 0.01]), np.array([4, 4]))
    narrow = arms_about(model, u, np.diag([0.01, 0.01]), np.array([4, 4]))
    assert [(min(wide.points[a]), max(wide.points[a])) for a in axes] == [*map(tuple, ends.T)]
    assert [len(wide.beside[a]) for a in axes] == [25, 25]
    assert [max(narrow.points[a]) for a in axes] == pytest.approx(u[[rate, above]] + 0.1)
    assert not any(narrow.beside.values())


def test_an_amount_goes_no_farther_than_the_records_let_it() -> None:
    """Speeds say that there is little weakening, at whatever speed it would begin."""
    records, _ = make_dataset(41_002, 24, 3, {}, Settings(speeds=1.0))
    model = posterior(build_observations(records), "speed-weakening")
    peak = gauss_newton(model, start_coordinates(model))
    ratio, _ = model.layout.tables
    name = model.layout.slots[ratio].name
    (ends,) = model.layout.ranges.T[[ratio]]
    about = arms_about(model, peak.u, 1e-4 * np.eye(3), np.full(3, 4))
    assert max(about.points[name]) == ends[1]
    assert ends[0] < min(about.points[name]) < ends[1] - 0.02


def test_a_star_keeps_the_part_of_the_events() -> None:
    model = posterior(observations(speeds=False), "epoch-bias")
    keep = np.arange(model.observations.n_events) % 2 == 0
    fine, mode = search_mode(model.restricted(keep))
    u = mode.u
    assert fine.log_likelihood(u) == pytest.approx(fine.event_log_likelihood(u)[keep].sum())


@pytest.mark.slow
def test_the_truth_is_not_beaten_between_the_points_of_a_star() -> None:
    """Drag made the data: entrainment, which is drag above a line, cannot explain more."""

    def highest(key: str) -> float:
        model, mode = search_mode(_with_speeds(key))
        exact = model.exact_log_likelihood(mode.u)
        assert model.log_likelihood(mode.u) == pytest.approx(exact, abs=1.0)
        return exact

    assert highest("entrainment") < highest("turbulent-drag") + 1.0


@pytest.mark.parametrize("effects", [("turbulent-drag",), ("turbulent-drag", "cohesion")])
def test_runouts_of_the_star_are_those_of_runs_made_for_the_same_effects(
    effects: tuple[str, ...],
) -> None:
    """Within 0.1 m at the mode, 1 m over the 90 % region, wherever F goes on beside a record."""
    records, _ = make_dataset(5, 30, 2, dict.fromkeys(effects, 1.0), Settings(speeds=1.0))
    model, mode = search_mode(posterior(build_observations(records), *effects))
    assert _metres_apart(model, mode.u) < 0.1
    rng, factor = np.random.default_rng(0), np.linalg.cholesky(mode.covariance)
    lowest = mode.log_density - 0.5 * chi2.ppf(0.9, len(mode.u))
    n_inside = 0
    while n_inside < 10:
        u = mode.u + rng.uniform() * factor @ rng.standard_normal(len(mode.u))
        if model.log_density(u) > lowest:
            n_inside += 1
            assert _metres_apart(model, u) < 1.0


def _metres_apart(model: Posterior, u: np.ndarray) -> float:
    """Farthest between stops under the frictions that the star and runs made for u ask for."""
    given, exact = model.nodes.at(u), model.nodes.exact(u)
    curve = model.nodes.predicted_at(u).curve
    mu = np.exp([np.sum(nodes.place * nodes.weight, axis=1) for nodes in (given, exact)]).T
    x = curve.at(mu)[0]
    cell = np.searchsorted(MU, mu[:, 1]) - 1
    goes_on = [
        not row[max(k - 4, 0) : k + 5].any()
        for row, k in zip(curve.discontinuous, cell, strict=True)
    ]
    assert np.mean(goes_on) > 0.8
    return float(np.max(np.abs(x[:, 0] - x[:, 1])[goes_on]))


def test_arms_turn_with_parameters_that_go_together() -> None:
    """Drag takes what friction of the bed and cohesion take: draws lie across all three."""
    records, _ = make_dataset(5, 30, 2, {"turbulent-drag": 1.0}, Settings(speeds=1.0))
    model, mode = search_mode(
        posterior(build_observations(records), "turbulent-drag", "force:speed")
    )
    layout = model.layout
    assert any(layout.arms.along.values())
    # Events without speeds have no scatter along tracks: the rest of the star is the same.
    assert not layout.arms.along.get(TRACK_SLOT)
    bare = replace(layout, slots=layout.slots[:-1])
    assert bare.slots[-1].name != TRACK_SLOT
    again = with_arms(bare, layout.arms)
    np.testing.assert_allclose(again.on_arms(mode.u[:-1]), layout.on_arms(mode.u)[:-1])
    np.testing.assert_allclose(layout.from_arms(layout.on_arms(mode.u)), mode.u, atol=1e-9)
    assert layout.within(mode.u)
    found = log_evidence(model, mode)
    assert np.max(np.abs(errors_at(model, found.sample))) < 2.0
    assert len(np.unique(found.sample, axis=0)) > 50
    (k,) = (k for k in layout.tables if layout.slots[k].name == "force:speed.slope")
    places = layout.on_arms(mode.u)
    places[k] = layout.arm_ends[1, k] + 0.1
    assert not layout.within(layout.from_arms(places))
    assert model.log_density(layout.from_arms(places)) == -np.inf


@pytest.mark.slow
def test_peaks_from_two_starts_are_one() -> None:
    """The exact likelihood has small steps, on which differences along one parameter end."""
    model = _with_speeds("force:speed")
    layout = model.layout
    peaks = []
    for slope in (0.5, 2.0):
        u = near(model)
        u[layout.places["force:speed"].start] = slope
        peaks.append(gauss_newton(model, u).log_density)
    assert peaks[0] == pytest.approx(peaks[1], abs=1.0)


def test_without_tables_it_is_the_plain_climb() -> None:
    model = posterior(observations(speeds=False))
    np.testing.assert_array_equal(search_mode(model)[1].u, find_mode(model).u)


def test_it_gets_over_the_valley_where_a_climb_stays() -> None:
    model = posterior(observations(), "turbulent-drag")
    (drag,) = model.layout.tables
    near_none = gauss_newton(model, near(model))
    _, found = search_mode(model)
    assert found.log_density > near_none.log_density + 2.0
    # From the other end of the range it comes to the same.
    far = near_none.u.copy()
    far[drag] = model.layout.high[drag]
    _, again = search_mode(model, far)
    assert again.log_density == pytest.approx(found.log_density, abs=0.3)
    assert again.u[drag] == pytest.approx(found.u[drag], abs=0.1)


def test_a_held_climb_moves_nothing_that_shapes_the_tables() -> None:
    model = posterior(observations(), "turbulent-drag")
    (drag,) = model.layout.tables
    start = near(model)
    value, u = held_ascent(model, start, [drag], [0.7])
    assert u[drag] == 0.7
    assert u[-1] == start[-1]
    assert value > model.pinned(u).log_density(np.where(np.arange(len(u)) == drag, 0.7, start))
