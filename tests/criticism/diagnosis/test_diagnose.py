from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.diagnosis.diagnose import Findings, diagnose, hidden_by_nuisances
from avahazard.effects.catalogue import definition
from avahazard.effects.effect import Definition
from avahazard.effects.own_file import definition_from
from avahazard.inference.likelihood.assemble import with_effects
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.synth.making import make_dataset
from tests.criticism.lengths import lengths
from tests.criticism.studies import slopes
from tests.inference.misstated import misstated

POWER = Specification(law="power")
OWN = """
from avahazard.effects.effect import Parameter
KEY = "first-column"
MEANING = "Friction rises with the first column."
NEEDS = ["column_1"]
PARAMETERS = [Parameter("slope", "", 0.0, 0.0, 0.2)]
def friction(columns):
    return [columns.numbers["column_1"]]
"""


def on_lengths(
    slope: float, seed: int = 1, own: tuple[Definition, ...] = (), n_columns: int = 3
) -> Findings:
    observations = build_observations(lengths(90, slope, seed, n_columns))
    return diagnose(observations, POWER, {}, own)


def test_a_column_that_matters_is_named_as_an_axis() -> None:
    found = on_lengths(0.12, n_columns=1)
    assert found.result.verdict == "unexplained"
    assert found.result.missing == ("covariate:column_1",)
    best = found.result.candidates[0]
    assert best.effect == "covariate:column_1"
    assert best.effect in found.fits
    assert best.error_after_m is not None
    assert best.error_after_m < best.error_before_m
    assert best.held_out_gain is not None
    assert best.held_out_gain > 0.0


def on_few_paths(offset: float, seed: int = 1) -> Observations:
    """Three paths; log friction on P1 is another."""
    records, rng = slopes(3, 12, "x"), np.random.default_rng(seed)
    own = np.array([event.path_id == "P1" for event in records.events])
    mu = 0.68 * np.exp(0.04 * rng.standard_normal(len(own)) + offset * own)
    stops = zip(records.events, (1.0 - mu) / 2.5e-4, strict=True)
    events = tuple(replace(event, runout_x_m=float(x)) for event, x in stops)
    return build_observations(replace(records, events=events))


def test_of_few_paths_the_one_that_differs_is_named() -> None:
    observations, constant = on_few_paths(0.12), Specification(law="constant")
    found = diagnose(observations, constant, {}).result
    assert (found.verdict, found.missing) == ("unexplained", ("path:P1",))
    best = found.candidates[0]
    assert best.effect == "path:P1"
    assert best.error_after_m is not None
    assert best.error_after_m < 0.8 * best.error_before_m
    wider, facts = with_effects(observations, constant, ("path:P1",))
    after = diagnose(observations, wider, facts)
    assert after.result.missing == ()
    assert after.base.parameters("path:P1")["path:P1.offset"] == pytest.approx(0.12, abs=0.04)
    assert diagnose(on_few_paths(0.0), constant, {}).result.missing == ()


def test_nothing_is_missing_where_nothing_is() -> None:
    found = on_lengths(0.0, seed=3)
    assert found.result.verdict == "adequate"
    assert found.result.missing == ()
    assert all(c.p_value > 0.05 for c in found.result.candidates)
    assert not found.result.heavy_tails
    assert found.result.detectable_m > 0.0
    assert 0.02 < (found.result.detectable_share or 0.0) < 0.3
    assert not found.result.notes


def test_few_records_could_miss_what_moves_most_of_them() -> None:
    found = diagnose(build_observations(lengths(12, 0.0, 3)), POWER, {})
    assert found.result.verdict == "adequate"
    assert (found.result.detectable_share or 0.0) > 0.5


def test_the_users_own_effect_is_named_before_a_smooth_of_its_column() -> None:
    found = on_lengths(0.12, own=(definition_from(OWN, "own.py"),), n_columns=1)
    assert found.result.missing == ("first-column",) or set(found.result.missing) == {
        "first-column",
        "covariate:column_1",
    }
    assert found.result.missing[0] == "first-column"
    smooth = next(c for c in found.result.candidates if c.effect == "covariate:column_1")
    assert "first-column" in smooth.confounded_with


def test_an_effect_of_the_model_is_told_to_be_needed_or_not() -> None:
    observations = build_observations(lengths(90, 0.12))
    keys = ("covariate:column_1", "covariate:column_2")
    specification, facts = with_effects(observations, POWER, keys)
    found = diagnose(observations, specification, facts)
    assert found.result.verdict == "adequate"
    assert found.result.still_needed["covariate:column_1"] > 3.0
    assert found.result.still_needed["covariate:column_2"] < 0.0


def test_wrong_records_become_suspects_not_an_effect() -> None:
    records = lengths(90, 0.0, seed=3)
    wrong = tuple(
        replace(e, runout_length_m=(e.runout_length_m or 0.0) * 3.0) if i in (7, 40) else e
        for i, e in enumerate(records.events)
    )
    found = diagnose(build_observations(replace(records, events=wrong)), POWER, {})
    assert found.result.heavy_tails
    assert set(found.result.suspect_events[:2]) == {"e7", "e40"}
    assert found.result.verdict == "adequate"


@pytest.mark.slow
def test_equal_seeds_give_equal_verdicts() -> None:
    a, b = on_lengths(0.05), on_lengths(0.05)
    assert [c.p_value for c in a.result.candidates] == [c.p_value for c in b.result.candidates]
    assert a.result.verdict == b.result.verdict


@pytest.mark.slow
def test_what_it_could_have_seen_it_mostly_sees() -> None:
    own = (definition_from(OWN, "own.py"),)
    size = on_lengths(0.0, seed=3).result.detectable_log_friction
    assert 0.02 < size < 0.15
    seen = [on_lengths(size, seed, own).result.verdict != "adequate" for seed in range(4, 24)]
    # 80 % of 20 datasets, less three standard deviations.
    assert sum(seen) >= 11


def test_columns_of_pairs_that_nuisances_hide_are_fitted_alone_as_well(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    names = ["interaction:slope*rock", "interaction:slope*age", "interaction:slope*side"]
    names += ["covariate:slope", "covariate:side", "season"]
    found = [
        SimpleNamespace(key=key, definition=definition(key), p_family=p)
        for key, p in zip(names, (0.001, 0.001, 0.001, 0.002, 0.4, 0.01), strict=True)
    ]
    bare = SimpleNamespace(posterior=None, mode=SimpleNamespace(u=None))
    module = "avahazard.criticism.diagnosis.diagnose."
    monkeypatch.setattr(f"{module}nuisances.without_those_asked_for", lambda *_: bare)
    monkeypatch.setattr(f"{module}screen", lambda *_, **__: SimpleNamespace(candidates=found))
    base: Any = None
    assert hidden_by_nuisances(base, Specification(), (), 0) == names[:4]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "strength"), [("season", 1.5), ("turbulent-drag", 1.5), ("path-effect", 1.5)]
)
def test_the_hidden_effect_of_a_world_is_named(key: str, strength: float) -> None:
    records, _ = make_dataset(21, 240, 10, {key: strength})
    found = diagnose(build_observations(records), Specification(), {})
    assert found.result.missing == (key,)
    assert found.result.verdict == "missing-effect"


@pytest.mark.slow
def test_a_world_without_hidden_effect_is_adequate() -> None:
    records, _ = make_dataset(22, 240, 10)
    found = diagnose(build_observations(records), Specification(), {})
    assert found.result.verdict == "adequate"
    assert np.isfinite(found.result.detectable_m)


@pytest.mark.slow
def test_errors_of_the_records_three_times_as_stated_are_named() -> None:
    found = diagnose(misstated(3.0, 1.0, 31, 250), Specification(), {})
    assert (found.result.verdict, found.result.missing) == ("missing-effect", ("record-error",))


@pytest.mark.slow
def test_errors_of_the_volumes_do_not_pass_for_scatter() -> None:
    found = diagnose(misstated(1.0, 2.5, 31, 250), Specification(), {})
    assert found.result.missing[0] == "volume-error"
    # Scatter that grows with volume looks alike: it may be said, never alone.
    assert set(found.result.missing) <= {"volume-error", "volume-scatter"}


def test_two_events_show_nothing() -> None:
    found = diagnose(build_observations(lengths(2)), Specification(), {})
    assert found.result.verdict == "adequate"
    assert found.result.cannot_tell
