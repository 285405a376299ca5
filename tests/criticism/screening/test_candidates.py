"""Which candidates there are, and the alternatives to a model that they stand for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.screening.candidates import (
    Alternative,
    Alternatives,
    HeldAlternatives,
    ModelAtMode,
    _told_apart,
    alternatives_of,
    candidate_definitions,
    not_asked,
)
from avahazard.criticism.screening.designs import SCATTER_SLOPES, base_coordinates, base_design
from avahazard.criticism.screening.parametric_bootstrap import actual_records
from avahazard.criticism.screening.record_moments import moments_of
from avahazard.criticism.screening.tables import LOG_MU, Tables, make_tables
from avahazard.effects.effect import Parameter
from avahazard.effects.own_file import TEMPLATE, definition_from
from avahazard.effects.record import VOLUME_ERROR
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import predict_records, run_blocks
from avahazard.inference.model.laws import LAWS, law
from avahazard.inference.model.observations import LEFT, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU
from avahazard.synth.making import make_world
from avahazard.synth.world import Settings
from tests.criticism.lengths import lengths
from tests.inference import studies
from tests.inference.groupings import plan_of
from tests.inference.new_law import NAME, halving


def keys(observations, specification=Specification(), own=()):  # type: ignore[no-untyped-def] # noqa: B008
    return [d.key for d in candidate_definitions(observations, specification, own)]


def test_what_the_model_has_is_no_candidate() -> None:
    observations = studies.observations()
    found = keys(observations)
    assert {"turbulent-drag", "snow-type", "volume-law", "volume-scatter"} <= set(found)
    assert "centrifugal" not in found
    assert "path-effect" not in found
    assert "snow-type" not in keys(observations, Specification(effects=("snow-type",)))
    assert "volume-scatter" not in keys(observations, Specification(scatter="volume"))
    assert "centrifugal" in keys(observations, Specification(centrifugal=False))


def test_every_column_has_a_smooth_but_those_with_an_effect_of_their_own() -> None:
    found = keys(studies.observations())
    assert {"covariate:wind", "covariate:year", "covariate:deposit_length_m"} <= set(found)
    assert "covariate:snow_type" not in found
    assert len(found) == len(set(found))


def test_without_a_profile_no_motion_can_be_told() -> None:
    found = keys(build_observations(lengths()))
    assert set(found) == {
        "volume-law", "volume-scatter", "record-error", "volume-error", "covariate:rock",
        "covariate:column_1", "covariate:column_2", "covariate:column_3",
    }  # fmt: skip


def test_a_limit_that_is_known_everywhere_is_no_candidate() -> None:
    records = studies.records(speeds=False)
    assert "observation-limit" in keys(build_observations(records))
    paths = tuple(replace(p, observed_below_m=600.0) for p in records.paths)
    assert "observation-limit" not in keys(build_observations(replace(records, paths=paths)))


def test_the_users_own_effect_comes_along() -> None:
    own = definition_from(TEMPLATE, "mine.py")
    assert own.key in keys(studies.observations(), own=(own,))
    assert own.key not in keys(build_observations(lengths()), own=(own,))


def test_a_column_that_tells_too_little_is_not_passed_over_in_silence() -> None:
    records = studies.records(speeds=False)
    few = [
        replace(e, covariates={**e.covariates, "snow_type": "wet" if k < 4 else "dry"})
        for k, e in enumerate(records.events)
    ]
    observations = build_observations(replace(records, events=tuple(few)))
    assert "snow-type" not in keys(observations)
    assert not_asked(observations, Specification()) == {
        "snow-type": "snow_type has no two values with at least 5 events each"
    }
    assert not_asked(observations, Specification(effects=("snow-type",))) == {}
    assert not_asked(studies.observations(), Specification()) == {}


TRACK_SCATTER = 0.075


def alternatives(model: Posterior, key: str, near: bool = False) -> list[Alternative]:
    observations, u = model.observations, studies.near(model)
    runs = run_blocks(observations, model.effects, {}, float(model.specification.centrifugal))
    base = make_tables(
        observations, predict_records(observations, (), {}, 1.0), observations.limit, TRACK_SCATTER
    )
    design = base_design(model, u, plan_of(observations, "path-effect"), np.full(1, 0.2))
    at_mode = ModelAtMode(
        model, u, base, design, base_coordinates(model, u), TRACK_SCATTER, runs, near
    )
    tried = alternatives_of(find_definition(key), at_mode)
    return [a for each in tried for a in (each if isinstance(each, list) else each())]


@pytest.mark.parametrize("name", ["exponential", "power", "rational", "constant"])
def test_the_design_is_the_law_near_its_mode(name: str) -> None:
    model = studies.posterior(studies.observations(), "snow-type", law=name)
    u = studies.near(model, spread=0.02, seed=1)
    design, beta = base_design(model, u, model.plan, np.empty(0)), base_coordinates(model, u)

    def mean(v: np.ndarray) -> np.ndarray:
        location, _ = model.location_and_scatter(v)
        return np.sum(location * model.observations.volumes.weight, axis=1)

    assert np.allclose(design.constant + design.x @ beta, mean(u), atol=1e-9)
    n = len(model.layout.law.coordinates)
    moved = u.copy()
    moved[:n] += 0.01
    beta[:n] += 0.01
    assert np.allclose(design.constant + design.x @ beta, mean(moved), atol=2e-3)
    assert len(design.of) == 0
    assert np.exp(np.mean(np.log(design.multiplier))) == pytest.approx(1.0)


def test_the_volumes_error_is_in_the_variance() -> None:
    model = studies.posterior(studies.observations())
    u = studies.near(model)
    design = base_design(model, u, model.plan, np.empty(0))
    sd = model.observations.volumes.sd
    volume = np.exp(model.observations.volumes.mean)
    small = (volume < 3e5) & (sd > 0)
    # n V is lognormal: its variance is (n V)² e^{s²} (e^{s²} - 1), V the median.
    expected = (1e-6 * volume) ** 2 * np.exp(sd**2) * (np.exp(sd**2) - 1.0)
    assert design.extra[small] == pytest.approx(expected[small], rel=0.05)


def test_tables_say_where_events_leave_and_up_to_where_they_are_seen() -> None:
    observations = studies.observations()
    predicted = predict_records(observations, (), {})
    tables = make_tables(observations, predicted, observations.limit, TRACK_SCATTER)
    for i in np.flatnonzero(observations.kind == LEFT):
        last = tables.last_left[i]
        assert np.all(predicted.status[i, : last + 1] == LEFT_PROFILE)
        assert predicted.status[i, last + 1] != LEFT_PROFILE
        assert LOG_MU[last] < tables.edges.leave[i] < LOG_MU[last + 1]
    limited = np.flatnonzero(np.isfinite(observations.limit))
    assert np.array_equal(np.flatnonzero(tables.edges.has_limit), limited)
    for i in limited:
        there = np.interp(tables.edges.detected[i], LOG_MU, predicted.elevation[i])
        assert there == pytest.approx(observations.limit[i], abs=1e-6)
        assert tables.hidden_from[i] == tables.edges.detected[i]
        assert tables.edges.detected_sd[i] == 0.0


def test_the_edge_of_an_estimated_limit_is_blurred_by_the_error_of_records() -> None:
    observations = studies.observations()
    predicted = predict_records(observations, (), {})
    limit = observations.limit
    by_records = replace(observations, limit=np.full(len(limit), np.nan))
    tables = make_tables(by_records, predicted, limit, TRACK_SCATTER)
    for i in np.flatnonzero(np.isfinite(limit)):
        there = np.interp(np.exp(tables.edges.detected[i]), MU, predicted.elevation[i])
        assert there == pytest.approx(limit[i], abs=observations.sigma[i])
        slope = np.gradient(predicted.elevation[i], LOG_MU)
        at = np.interp(tables.edges.detected[i], LOG_MU, slope)
        assert tables.edges.detected_sd[i] == pytest.approx(observations.sigma[i] / at, rel=0.2)
        assert tables.hidden_from[i] == np.inf


def test_the_edge_of_sight_is_on_the_side_of_the_release_where_a_valley_rises_again() -> None:
    observations = studies.observations()
    predicted = predict_records(observations, (), {})
    plain = make_tables(observations, predicted, observations.limit, TRACK_SCATTER)
    limited = plain.edges.has_limit
    assert limited.any()
    # Avalanches of little friction run up the other side, above the limit.
    bottom = np.argmin(predicted.elevation, axis=1)[:, None]
    beyond = np.arange(len(MU)) < bottom + 5
    elevation = np.where(beyond, observations.limit[:, None] + 200.0, predicted.elevation)
    elevation = np.where(limited[:, None], elevation, predicted.elevation)
    staying = replace(predicted, elevation=elevation, status=np.zeros_like(predicted.status))
    tables = make_tables(observations, staying, observations.limit, TRACK_SCATTER)
    assert tables.edges.detected[limited] == pytest.approx(plain.edges.detected[limited], abs=1e-6)
    assert tables.edges.detected_sd[limited] == pytest.approx(
        plain.edges.detected_sd[limited], abs=1e-6
    )


def test_speeds_have_the_errors_of_their_records() -> None:
    observations = studies.observations()
    tables = make_tables(
        observations, predict_records(observations, (), {}), observations.limit, TRACK_SCATTER
    )
    assert (tables.speeds.row >= 0).sum() == len(observations.speeds)
    for r, measured in enumerate(observations.speeds):
        k = len(measured.x)
        np.testing.assert_array_equal(tables.speeds.sigma[r, :k], measured.sigma)
    assert tables.speeds.scatter == TRACK_SCATTER


@pytest.mark.parametrize("key", ["turbulent-drag", "epoch-bias", "leading-edge", "forest-drag"])
def test_effects_on_tables_are_tried_away_from_neutral(key: str) -> None:
    model = studies.posterior(studies.observations(speeds=False))
    base = make_tables(
        model.observations,
        predict_records(model.observations, (), {}),
        model.observations.limit,
        0.0,
    )
    tried = alternatives(model, key)
    assert len(tried) >= 5
    for v in tried:
        assert v.key == key
        assert not np.array_equal(v.tables.record, base.record)


def test_a_design_column_needs_no_tables() -> None:
    model = studies.posterior(studies.observations())
    (only,) = alternatives(model, "snow-type")
    assert only.design.x.shape[1] == 2 + 2
    assert only.log_prior == 0.0


def test_other_laws_are_tried_linear_about_the_present_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(LAWS, NAME, halving())
    model = studies.posterior(studies.observations(), law="power")
    tried = alternatives(model, "volume-law")
    assert len(tried) == len(LAWS) - 2  # not itself, not the constant
    assert tried[-1].design.x.shape == (model.observations.n_events, 2)
    exponential = tried[0]
    volume = np.exp(model.observations.volumes.mean)
    exact = law("exponential").log_friction(np.array([-0.8, 1.0]), volume)
    fitted = exponential.design.constant + exponential.design.x @ np.array([-0.8, 1.0])
    small = volume < 3e5
    assert np.allclose(fitted[small], exact[small], atol=0.05)


def test_scatter_is_tried_both_ways() -> None:
    tried = alternatives(studies.posterior(studies.observations()), "volume-scatter")
    assert len(tried) == len(SCATTER_SLOPES)
    volume = studies.observations().volumes.mean
    directions = [np.corrcoef(v.design.multiplier, volume)[0, 1] for v in tried]
    assert min(directions) < 0.0 < max(directions)


def test_centrifugal_is_the_load_of_curvature() -> None:
    model = studies.posterior(studies.observations(speeds=False), centrifugal=False)  # type: ignore[arg-type]
    (only,) = alternatives(model, "centrifugal")
    loaded = predict_records(model.observations, (), {}, 1.0)
    assert np.array_equal(only.tables.record, loaded.record.astype(np.float32))


def _misstated(field: str, factor: float) -> Posterior:
    """The model on the same events with these errors stated `factor` times as large."""
    records = studies.records()
    events = tuple(replace(e, **{field: factor * getattr(e, field)}) for e in records.events)
    return studies.posterior(build_observations(replace(records, events=events)))


def test_errors_of_volumes_are_read_as_if_they_were_stated() -> None:
    model = studies.posterior(studies.observations())
    tried = alternatives(model, "volume-error")
    (parameter,) = VOLUME_ERROR.build(
        VOLUME_ERROR.facts(model.observations.columns, model.observations.sites)
    ).parameters
    assert 0.0 < parameter.high < 2.08
    told = _misstated("volume_rel_sigma", float(np.exp(parameter.high)))
    plan = plan_of(told.observations, "path-effect")
    expected = base_design(told, studies.near(told), plan, np.full(1, 0.2))
    for name in ("x", "constant", "extra", "multiplier"):
        np.testing.assert_allclose(
            getattr(tried[-1].design, name), getattr(expected, name), rtol=1e-9, atol=1e-12
        )
    half = [a for a in tried if a.log_prior == pytest.approx(-0.5)]
    assert len(half) == 2  # of the factors two and a half


def test_errors_of_records_are_in_their_tables() -> None:
    model = studies.posterior(studies.observations())
    stated = model.observations.sigma
    found = {round(float(np.log2(a.tables.sigma[0] / stated[0])), 6) for a in
             alternatives(model, "record-error")}  # fmt: skip
    assert min(found) < 0.0 < max(found)
    told = _misstated("runout_sigma_m", 8.0)
    limited = np.isfinite(told.observations.limit)
    expected = make_tables(
        told.observations, predict_records(told.observations, (), {}, 1.0),
        told.observations.limit, TRACK_SCATTER,
    )  # fmt: skip
    most = [a.tables for a in alternatives(model, "record-error")
            if np.allclose(a.tables.sigma, told.observations.sigma)]  # fmt: skip
    assert most
    assert np.any(limited)
    np.testing.assert_allclose(most[0].edges.detected_sd, expected.edges.detected_sd)


@pytest.mark.parametrize("key", ["turbulent-drag", "entrainment"])
def test_tables_near_the_records_say_the_same_of_these(key: str) -> None:
    records = make_world(5, 24, 2, {}, Settings(speeds=0.4))[0]
    model = studies.posterior(build_observations(records))
    measured = actual_records(model)
    for one, other in zip(
        alternatives(model, key, near=True), alternatives(model, key), strict=True
    ):
        assert not np.array_equal(one.tables.record, other.tables.record)
        for found, expected in zip(
            moments_of(one.tables, measured), moments_of(other.tables, measured), strict=True
        ):
            np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-9)


def test_what_is_tried_is_as_close_to_neutral_as_the_records_tell_apart() -> None:
    drag = Parameter("drag", "1/m", 0.0, 0.0, 0.005, 0.0, 0.03)
    vague, sharp = _told_apart(drag, 0.004), _told_apart(drag, 2e-5)
    assert max(vague) == max(sharp) == 0.03
    assert len(vague) < len(sharp)
    assert min(sharp) == pytest.approx(2e-5, rel=0.6)
    both = _told_apart(replace(drag, low=-0.03), 0.004)
    np.testing.assert_allclose(sorted(both), sorted([*vague, *(-v for v in vague)]))


def alternative(key: str, tables: Tables) -> Alternative:
    model = studies.posterior(studies.observations())
    design = base_design(model, studies.near(model), model.plan, np.empty(0))
    return Alternative(key, tables, design, 0.0)


def tables() -> Tables:
    observations = studies.observations()
    predicted = predict_records(observations, (), {})
    return make_tables(observations, predicted, observations.limit, 0.0)


def looks(most_bytes: int) -> tuple[list[list[str]], list[str], bool]:
    """Keys of two looks, the keys whose tables were made, and whether all were held."""
    base, made = tables(), []

    def anew(key: str) -> list[Alternative]:
        made.append(key)
        return [alternative(key, tables())]

    tried: list[Alternatives] = [
        [alternative("precomputed", base)],
        lambda: anew("first"),
        lambda: anew("second"),
    ]
    held = HeldAlternatives(tried, most_bytes)
    keys = [[a.key for each in held for a in each] for _ in range(2)]
    return keys, made, held.all_held


def test_tables_are_made_again_only_where_there_is_no_room() -> None:
    one = tables()
    size = one.record.nbytes + one.bounds.nbytes
    order = ["precomputed", "first", "second"]
    assert looks(10 * size) == ([order, order], ["first", "second"], True)
    assert looks(int(1.5 * size)) == ([order, order], ["first", "second", "second"], False)
    assert looks(0) == ([order, order], ["first", "second"] * 2, False)
