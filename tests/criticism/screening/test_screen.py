from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from avahazard.criticism.diagnosis.refits import refit, without_groups
from avahazard.criticism.screening.candidates import HeldAlternatives, candidate_definitions
from avahazard.criticism.screening.parametric_bootstrap import actual_records
from avahazard.criticism.screening.record_moments import detection_edges, estimated_limits
from avahazard.criticism.screening.screen import screen
from avahazard.criticism.screening.significance import Screening
from avahazard.criticism.screening.tables import make_tables
from avahazard.engine import set_engine
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import ELEVATION, LEFT, PLACE, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.synth.making import make_world
from avahazard.workers import set_workers
from tests.criticism.lengths import lengths
from tests.inference import studies
from tests.inference.groupings import spreads

PATH_EFFECT = "path-effect"

CHEAP = ("snow-type", "path-section", "season", "volume-scatter", "leading-edge")


def on_lengths(slope: float, seed: int, n_worlds: int) -> Screening:
    observations = build_observations(lengths(80, slope, seed))
    fit = refit(observations, Specification(law="power"), {})
    entries = candidate_definitions(observations, fit.specification)
    return screen(
        fit.posterior, fit.mode.u, spreads(observations), entries, n_worlds=n_worlds, seed=seed
    )


def on_paths(n_worlds: int = 8, seed: int = 2) -> Screening:
    fit = refit(studies.observations(), Specification(), {}, (PATH_EFFECT,))
    bare, u, _ = without_groups(fit, studies.observations(), ())
    entries = [find_definition(key) for key in CHEAP]
    known = spreads(studies.observations(), PATH_EFFECT, tau=0.1)
    return screen(bare, u, known, entries, n_worlds=n_worlds, seed=seed)


def test_a_true_effect_comes_first_and_is_significant() -> None:
    found = on_lengths(0.12, 1, 99)
    best = found.candidates[0]
    assert best.definition.key == "covariate:column_1"
    assert best.p_family == pytest.approx(0.01)
    assert best.gain > best.null_gain
    assert all(c.p_family > 0.05 for c in found.candidates[1:])
    assert found.n_worlds == 99


def test_tables_that_find_no_room_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("avahazard.criticism.screening.screen.BATCH", 2)
    held = on_paths(n_worlds=5)
    nothing = partial(HeldAlternatives, most_bytes=0)
    monkeypatch.setattr("avahazard.criticism.screening.screen.HeldAlternatives", nothing)
    made_anew = on_paths(n_worlds=5)
    assert made_anew.candidates == held.candidates
    assert made_anew.groups == held.groups
    assert made_anew.n_worlds == held.n_worlds


@pytest.mark.slow
@pytest.mark.usefixtures("default_engine")
def test_a_process_of_its_own_gives_the_same() -> None:
    here = on_paths(n_worlds=3)
    set_engine("processes", workers=1)
    there = on_paths(n_worlds=3)
    assert there.candidates == here.candidates
    assert there.groups == here.groups


def test_it_stops_where_chance_plainly_does_as_well() -> None:
    found = on_lengths(0.0, 3, 999)
    assert found.candidates[0].p_family > 0.05
    assert found.n_worlds < 999
    at_most = on_lengths(0.0, 3, 30)
    assert at_most.n_worlds == 30


@pytest.mark.usefixtures("default_engine")
def test_equal_seeds_give_equal_results_for_any_number_of_workers() -> None:
    def numbers(found: Screening) -> list[tuple[str, float, float]]:
        tried = [(c.definition.key, c.gain, c.p_family) for c in found.candidates]
        return [*tried, ("groups", found.groups[0].gain, found.groups[0].p_value)]

    set_workers(3)
    first = numbers(on_paths())
    set_workers(1)
    assert numbers(on_paths()) == first
    assert numbers(on_paths(seed=5))[:-1] != first[:-1]


def test_p_values_are_in_order_and_never_nought() -> None:
    found = on_paths()
    ps = [c.p_single for c in found.candidates]
    assert ps == sorted(ps)
    for c in found.candidates:
        assert 1.0 / 9.0 - 1e-12 <= c.p_family <= 1.0
        assert c.gain >= 0.0
    assert 1.0 / 9.0 - 1e-12 <= found.groups[0].p_value <= 1.0


def test_the_gain_of_paths_tells_whether_paths_differ() -> None:
    rng = np.random.default_rng(2)
    records = studies.records(60, 6, speeds=False)
    found = {}
    for size in (0.0, 120.0):
        shift = {p.path_id: size * rng.standard_normal() for p in records.paths}
        moved = tuple(
            replace(e, runout_elevation_m=e.runout_elevation_m + shift[e.path_id or ""])
            if e.runout_elevation_m is not None
            else e
            for e in records.events
        )
        observations = build_observations(replace(records, events=moved))
        fit = refit(observations, Specification(), {}, (PATH_EFFECT,))
        bare, u, told = without_groups(fit, observations, ())
        found[size] = screen(bare, u, told, [find_definition("season")], n_worlds=40)
    assert found[120.0].groups[0].gain > found[0.0].groups[0].gain + 2.0
    assert found[120.0].groups[0].p_value < 0.05


def test_detection_moves_with_the_highest_stop_of_each_path() -> None:
    observations = studies.observations(speeds=False)
    model = studies.posterior(observations)
    predicted = predict_records(observations, (), {})
    tables = make_tables(observations, predicted, observations.limit, 0.0)
    measured = actual_records(model)
    edges = {}
    for margin in (0.0, 100.0):
        edges[margin] = detection_edges(tables, margin, measured, observations)
    assert np.all(edges[0.0].has_limit == (observations.columns.path_index >= 0))
    free = edges[0.0].has_limit & np.isnan(observations.limit)
    # Higher stops need more friction.
    assert np.all(edges[100.0].detected[free] > edges[0.0].detected[free])


def test_limits_are_those_of_each_path_and_kind_of_record() -> None:
    rng = np.random.default_rng(11)
    observations = studies.observations(speeds=False)
    n = observations.n_events
    kind = rng.choice([PLACE, ELEVATION, LEFT], n)
    declared = np.where(rng.random(n) < 0.2, 1500.0, np.nan)
    measured = actual_records(studies.posterior(observations))
    observations = replace(observations, kind=kind, limit=declared)
    stops = rng.normal(1000.0, 100.0, n)
    measured = replace(measured, observed=stops, left=rng.random(n) < 0.3)
    wanted = declared.copy()
    paths = observations.columns.path_index
    for i in np.flatnonzero(np.isnan(declared) & (paths >= 0)):
        beside = (paths == paths[i]) & np.isnan(declared) & ((kind == PLACE) == (kind[i] == PLACE))
        known = stops[beside & ~measured.left]
        if len(known):
            wanted[i] = known.min() - 60.0 if kind[i] == PLACE else known.max() + 30.0
    found = estimated_limits(observations, measured, 30.0)
    np.testing.assert_allclose(found, wanted)
    assert np.isfinite(found).sum() > np.isfinite(declared).sum()


@pytest.mark.slow
def test_p_values_of_nulls_are_uniform() -> None:
    best = np.array([on_lengths(0.0, seed, 59).candidates[0].p_family for seed in range(100, 220)])
    for level in (0.05, 0.1, 0.2):
        # Three standard deviations of a count of 120.
        most = level * 120 + 3.0 * np.sqrt(120 * level * (1.0 - level))
        assert np.sum(best <= level) <= most
    assert 0.35 < np.mean(best) < 0.65


@pytest.mark.slow
def test_p_values_of_paths_that_are_alike_are_uniform() -> None:
    p_values = []
    for seed in range(720_000, 720_040):
        observations = build_observations(make_world(seed, 120, 9)[0])
        fit = refit(observations, Specification(), {}, (PATH_EFFECT,))
        bare, u, told = without_groups(fit, observations, ())
        found = screen(bare, u, told, [find_definition("season")], n_worlds=59)
        p_values.append(found.groups[0].p_value)
    for level in (0.05, 0.1, 0.2):
        most = level * 40 + 3.0 * np.sqrt(40 * level * (1.0 - level))
        assert np.sum(np.array(p_values) <= level) <= most
