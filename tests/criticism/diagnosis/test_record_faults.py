"""What faults of the records explain as well as an effect does, and records hard to believe."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.diagnosis import record_faults, refits
from avahazard.criticism.diagnosis.diagnose import diagnose, unless_speeds_are_off
from avahazard.criticism.diagnosis.naming import Naming
from avahazard.criticism.diagnosis.record_faults import (
    MOST_SCATTERS,
    by_misstated_volumes,
    by_speeds_off,
    by_undetected_stops,
    explained_by_record_faults,
    groups_by_misstated_volumes,
    stand_in_for_volume,
    suspects,
)
from avahazard.criticism.diagnosis.refits import Question, Refit, refit
from avahazard.effects.catalogue import definition
from avahazard.effects.columns import EventColumns, build_columns
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.records.collection import Event, Path
from avahazard.synth.dataset import Settings
from avahazard.synth.making import make_dataset
from tests.criticism.studies import straight
from tests.inference import studies
from tests.inference.sbc_records import Case
from tests.inference.sbc_worlds import world

LAW, SCATTER, SEASON, ERROR = "volume-law", "volume-scatter", "season", "volume-error"
FRONT, DRAG, LIMIT = "leading-edge", "turbulent-drag", "observation-limit"
STATED = 0.3
NOTHING: Any = None


def fit(evidence: float, observations: Observations | None = None) -> Any:
    return SimpleNamespace(
        evidence=evidence,
        log_likelihood=evidence,
        specification=Specification(),
        facts={},
        observations=observations,
        own=(),
        definition=definition,
    )


@pytest.mark.parametrize(
    ("leader", "beside", "overstated", "expected"),
    [
        (LAW, 21.0, 20.0, ERROR),
        (LAW, 27.0, 20.0, None),
        (LAW, 27.0, 26.0, ERROR),
        (SCATTER, 21.0, 20.0, ERROR),
        (SEASON, 21.0, 20.0, None),
        (FRONT, 21.0, 20.0, ERROR),
        (FRONT, 24.0, 20.0, None),
        ("covariate:deposit_length_m", 19.0, 20.0, ERROR),
        ("covariate:deposit_length_m", 22.5, 20.0, ERROR),
        ("covariate:deposit_length_m", 24.0, 20.0, None),
        ("covariate:volume_m3", 21.0, 20.0, ERROR),
        ("covariate:volume_m3", 27.0, 20.0, None),
        ("covariate:volume_m3", 27.0, 26.0, ERROR),
    ],
)
def test_what_is_of_the_volume_must_earn_its_evidence_beside_its_errors(
    monkeypatch: pytest.MonkeyPatch,
    leader: str,
    beside: float,
    overstated: float,
    expected: str | None,
) -> None:
    """`overstated` is the evidence of the errors where many records are over any true volume."""
    records = straight(20)
    events = (
        replace(e, volume_m3=1e4 * (k + 1), deposit_length_m=30.0 + 5.0 * k)
        for k, e in enumerate(records.events)
    )
    observations = build_observations(replace(records, events=tuple(events)))
    screening: Any = SimpleNamespace(
        candidates=[
            SimpleNamespace(key=k, definition=find_definition(k, ())) for k in (leader, ERROR)
        ]
    )
    base, first = fit(0.0, observations), fit(30.0, observations)

    def refitted(*told: Any, **_: Any) -> Any:
        return fit(beside if any(each is first for each in told) else overstated)

    monkeypatch.setattr(refits, "refit", refitted)
    fits = {leader: first, ERROR: fit(20.0)}
    question = Question(base, fits, screening)
    assert by_misstated_volumes(question, leader) == expected
    stated: Any = SimpleNamespace(candidates=[])
    assert by_misstated_volumes(replace(question, screening=stated), leader) is None
    base.specification = Specification(effects=(ERROR,))
    assert by_misstated_volumes(question, leader) is None


@pytest.mark.parametrize(("left", "expected"), [(2.9, ERROR), (3.1, None)])
def test_groups_must_earn_their_evidence_beside_errors_of_volumes(
    monkeypatch: pytest.MonkeyPatch, left: float, expected: str | None
) -> None:
    """`left` is the evidence of the groups where the errors may be misstated too."""
    candidates = [SimpleNamespace(key=k, definition=definition(k)) for k in (SEASON, ERROR)]
    errors = {ERROR: definition(ERROR).build({"highest": 1.0})}
    monkeypatch.setattr(record_faults, "effect_on", lambda entry, _: errors.get(entry.key))
    evidence = {("path-effect", ERROR): 30.0 + left, (ERROR,): 30.0}

    def refitted(_observations: Any, specification: Any, *told: Any, **_: Any) -> Any:
        keys = (*specification.effects, *told[1])
        return model(keys, evidence[keys])

    def model(keys: tuple[str, ...], evidence: float = 0.0) -> Any:
        found = fit(evidence)
        found.specification = Specification(effects=keys)
        return found

    monkeypatch.setattr(refits, "refit", refitted)
    base = model(("path-effect",))
    for tried, told in ((candidates, expected), (candidates[:1], None)):
        screening: Any = SimpleNamespace(candidates=tried)
        question = Question(base, {}, screening)
        assert groups_by_misstated_volumes(question, "path-effect") == told


def test_a_column_stands_in_for_the_volume_where_it_goes_with_it_within_paths() -> None:
    rng = np.random.default_rng(3)
    size = rng.standard_normal(60)
    front = definition(FRONT)

    def columns(noise: float, between: float) -> EventColumns:
        """Lengths that go with volumes as far as `noise` lets them, and `between` paths."""
        away = noise * rng.standard_normal(60)
        events = [
            Event(
                str(k),
                f"P{k % 2}",
                volume_m3=float(np.exp(9.0 + size[k] + between * (k % 2))),
                deposit_length_m=None
                if k < 5
                else float(np.exp(4.0 + 0.3 * size[k] + away[k] + between * (k % 2))),
            )
            for k in range(60)
        ]
        return build_columns(events, {n: Path(n) for n in ("P0", "P1")}, np.full(60, np.nan))

    found = stand_in_for_volume(columns(0.2, 0.0), front)
    assert found is not None
    np.testing.assert_array_equal(np.isfinite(found), np.arange(60) >= 5)
    assert np.nanmean(found) == pytest.approx(4.0, abs=0.3)
    assert stand_in_for_volume(columns(5.0, 0.0), front) is None
    # What differs between paths alone has no information on one avalanche.
    assert stand_in_for_volume(columns(5.0, 3.0), front) is None
    for other in (SEASON, LAW, "snow-type"):
        assert stand_in_for_volume(columns(0.2, 0.0), definition(other)) is None


def fit_with(evidence: float, key: str) -> Any:
    posterior = SimpleNamespace(effects=(definition(key).build({}),))
    return SimpleNamespace(evidence=evidence, posterior=posterior)


def screened(gain: float) -> Any:
    """Both among the candidates, each with this gain."""
    return SimpleNamespace(
        candidates=[
            SimpleNamespace(key=k, definition=definition(k), gain=gain) for k in (DRAG, LIMIT)
        ]
    )


@pytest.mark.parametrize(
    ("leader", "beside", "expected"),
    [(DRAG, 21.0, LIMIT), (DRAG, 27.0, None), (SEASON, 21.0, None)],
)
def test_a_force_must_earn_its_evidence_beside_a_detection_limit(
    monkeypatch: pytest.MonkeyPatch, leader: str, beside: float, expected: str | None
) -> None:
    monkeypatch.setattr(record_faults, "refit_with", lambda *_: fit(beside))
    fits = {leader: fit_with(10.0, leader), LIMIT: fit(20.0)}
    base = fit(0.0)
    question = Question(base, fits, screened(8.0))
    assert by_undetected_stops(question, leader) == expected
    known: Any = SimpleNamespace(candidates=[])
    assert by_undetected_stops(replace(question, screening=known), leader) is None
    base.specification = Specification(effects=(LIMIT,))
    assert by_undetected_stops(question, leader) is None


def test_a_limit_that_gains_too_little_to_take_the_evidence_is_not_fitted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []

    def refitted(start: Any, _key: str) -> Any:
        asked.append(start)
        return fit(20.0 if start is base else 20.5)

    monkeypatch.setattr(record_faults, "refit_with", refitted)
    base = fit(-100.0)
    question = Question(base, {DRAG: fit_with(-40.0, DRAG)}, screened(5.0))
    assert by_undetected_stops(question, DRAG) is None
    assert not asked
    question = replace(question, screening=screened(40.0))
    assert by_undetected_stops(question, DRAG) == LIMIT
    assert asked == [base, question.fits[DRAG]]
    # Fitted by itself it has much less than the force, whatever it gained to first order.
    question = replace(question, fits={DRAG: fit_with(40.0, DRAG)}, screening=screened(120.0))
    assert by_undetected_stops(question, DRAG) is None
    assert asked[2:] == [base]


def test_all_faults_that_explain_it_are_returned(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(record_faults, "by_undetected_stops", lambda *_: LIMIT)
    monkeypatch.setattr(record_faults, "by_misstated_volumes", lambda *_: None)
    question = Question(NOTHING, {}, NOTHING)
    assert explained_by_record_faults(question, "cohesion") == (LIMIT,)
    monkeypatch.setattr(record_faults, "by_misstated_volumes", lambda *_: ERROR)
    assert explained_by_record_faults(question, "cohesion") == (LIMIT, ERROR)


@pytest.mark.slow
def test_short_runouts_that_nobody_recorded_are_named_and_no_force() -> None:
    named = []
    for seed in range(900010, 900014):
        n_events, n_paths = (120, 9) if seed % 2 else (250, 11)
        records, _ = make_dataset(seed, n_events, n_paths, {LIMIT: 1.0})
        named.append(diagnose(build_observations(records), Specification(), {}).result.missing)
    assert sum(LIMIT in missing for missing in named) >= 3
    assert not any(DRAG in missing for missing in named)


OFF = np.array([0.5, MOST_SCATTERS + 2.0, MOST_SCATTERS - 0.1, -MOST_SCATTERS - 5.0, 99.0])
"""By how many scatters each event's log friction is off; the last one ran beyond its profile."""


@pytest.mark.parametrize(("in_log", "n_volumes"), [(True, 2), (False, 2), (True, 1)])
def test_the_far_ones_are_named_worst_first(in_log: bool, n_volumes: int) -> None:
    scatter, middle = 0.02, (-0.8 if in_log else 0.5)
    location = np.full((5, 2), middle)
    if n_volumes == 1:  # and two kinds: one suits none of the events
        location[:, 0] += 200.0 * scatter
    place = middle + scatter * OFF
    nodes = SimpleNamespace(
        place=place[:, None], weight=np.ones((5, 1)), is_probability=np.arange(5) == 4
    )
    base: Any = SimpleNamespace(
        mode=SimpleNamespace(u=np.zeros(1)),
        posterior=SimpleNamespace(
            location_and_scatter=lambda _u: (location, np.full((5, 2), scatter)),
            nodes=SimpleNamespace(at=lambda _u: nodes),
            layout=SimpleNamespace(log_scatter=in_log),
            observations=SimpleNamespace(
                columns=SimpleNamespace(
                    event_id=np.array(["a", "b", "c", "d", "e"]),
                    log_volume=np.log([1e3, 2e3, 4e6, 1e4, 3e3]),
                ),
                volumes=SimpleNamespace(volume=np.ones((5, n_volumes))),
            ),
        ),
    )
    assert suspects(base) == ("c", "d", "b")


@pytest.mark.parametrize(
    ("suspect", "on"),
    [(("a", "b", "c"), "P1"), (("a", "b"), None), (("a", "b", "e"), None), (("e", "f", "g"), None)],
)
def test_suspects_on_one_path_are_said(
    monkeypatch: pytest.MonkeyPatch, suspect: tuple[str, ...], on: str | None
) -> None:
    """Not those on a path that has most of the records anyway."""
    monkeypatch.setattr(record_faults, "suspects", lambda _: suspect[:2])
    monkeypatch.setattr(record_faults, "impossible_stops", lambda _: suspect[1:])
    columns = SimpleNamespace(
        event_id=np.array(list("abcdefghi")),
        path_index=np.array([1, 1, 1, 2, 0, 0, 0, 0, 0]),
        paths=("P0", "P1", "P2"),
    )
    observations = SimpleNamespace(columns=columns)
    base: Any = SimpleNamespace(posterior=SimpleNamespace(observations=observations))
    found = record_faults.on_one_path(base)
    assert found == (() if on is None else (Note("suspects_on", path=on, n=3),))


def _world(seed: int, effects: dict[str, float], error: float) -> Observations:
    records, _ = make_dataset(seed, 120, 9, effects, Settings(volume_rel_sigma=error))
    events = tuple(replace(e, volume_rel_sigma=STATED) for e in records.events)
    return build_observations(replace(records, events=events))


def _asked(observations: Observations) -> tuple[float, str | None]:
    """Evidence of another law over the model's, and what leaves it too little."""
    base = refit(observations, Specification(), {}, ("path-effect",))
    other = refit(observations, base.specification, base.facts, (LAW,), (), base)
    fits: dict[str, Refit] = {LAW: other}
    errors = SimpleNamespace(key=ERROR, definition=definition(ERROR))
    screening: Any = SimpleNamespace(candidates=[errors])
    question = Question(base, fits, screening)
    return other.evidence - base.evidence, by_misstated_volumes(question, LAW)


@pytest.mark.slow
def test_large_records_of_small_volumes_are_no_law_with_a_limit() -> None:
    gain, found = _asked(_world(910001, {}, 1.0))
    assert gain > 6.0
    assert found == ERROR


@pytest.mark.slow
def test_a_true_other_law_keeps_its_evidence() -> None:
    gain, found = _asked(_world(920001, {LAW: 1.0}, STATED))
    assert gain > 6.0
    assert found is None


@pytest.mark.parametrize(
    ("force", "beside", "factor"),
    [(30.0, 30.0, 1.06), (60.0, 30.0, None), (30.0, 60.0, None), (30.0, 48.0, None)],
)
def test_no_force_is_named_where_a_factor_common_to_all_speeds_explains_more(
    monkeypatch: pytest.MonkeyPatch, force: float, beside: float, factor: float | None
) -> None:
    """Speeds are 6 % high: without them the model has 50 nats, less its prior's 1.9."""
    observations = studies.observations()
    measured = np.log(np.concatenate([track.speed for track in observations.speeds]))

    def refitted(model: Any, *, on: Observations, least: float) -> Any:
        off = measured - np.log(np.concatenate([track.speed for track in on.speeds]))
        ratio = on.speeds[0].sigma / on.speeds[0].speed
        np.testing.assert_allclose(
            ratio, observations.speeds[0].sigma / observations.speeds[0].speed
        )
        right = 50.0 - 0.5 * ((off[0] - np.log(1.06)) / 0.005) ** 2
        # Densities of speeds that are smaller by a factor are larger by it.
        found = (right if model is base else beside) + np.sum(off)
        return SimpleNamespace(evidence=found if found > least else -np.inf, log_likelihood=found)

    monkeypatch.setattr(record_faults, "refit_with", refitted)
    base, leader = fit(0.0, observations), fit_with(force, DRAG)
    question = Question(base, {DRAG: leader}, NOTHING)
    assert by_speeds_off(question, DRAG) == (factor and pytest.approx(factor, abs=0.01))
    fits = {SEASON: fit_with(force, SEASON)}
    assert by_speeds_off(replace(question, fits=fits), SEASON) is None


def test_where_speeds_are_off_no_force_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(record_faults, "by_speeds_off", lambda *_: 1.06)
    base = refit(studies.observations(), Specification(), {})
    named = Naming("missing-effect", (DRAG,), {}, {})
    found, notes = unless_speeds_are_off(Question(base, {DRAG: base}, NOTHING), named)
    assert found.verdict == "unexplained"
    assert found.missing[0].startswith("speed:")
    assert notes == (Note("speeds_off", factor=1.06, effect=DRAG),)
    kept = replace(named, missing=(SEASON,))
    assert unless_speeds_are_off(Question(base, {}, NOTHING), kept) == (kept, ())


def test_a_true_force_is_named_beside_a_factor_common_to_all_speeds() -> None:
    case = Case((DRAG,), 48, speeds=(100.0, 200.0, 300.0, 400.0, 500.0), a=0.3)
    base = refit(world(case, generator(3, "speeds"))[0].observations, Specification(), {})
    leader = refits.refit_with(base, DRAG)
    assert leader.evidence > base.evidence + 3.0
    assert by_speeds_off(Question(base, {DRAG: leader}, NOTHING), DRAG) is None
