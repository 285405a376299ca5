"""Friction by the levels of a column, and how wide the prior of a level is."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns, build_columns
from avahazard.effects.covariate import (
    LEAST_SD,
    PATH_SECTION,
    SCATTERS,
    SNOW_TYPE,
    level_counts,
    level_effect,
    level_facts,
    level_lacking,
    level_text,
)
from avahazard.effects.effect import Definition, FrictionEffect
from avahazard.inference.fitting.mode import find_mode, log_evidence
from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Event
from tests.criticism.studies import levelled, slopes, straight
from tests.effects.event_table import event_table
from tests.effects.examples import columns, sites

ROCK = ["gneiss"] * 7 + ["lime"] * 5 + ["slate"] * 4


def test_the_commonest_level_is_the_reference_and_rare_ones_have_none() -> None:
    facts = level_facts("rock", event_table(rock=ROCK))
    assert (facts["reference"], facts["levels"]) == ("gneiss", ["lime"])
    effect = level_effect("covariate:rock", "rock", facts)
    assert isinstance(effect, FrictionEffect)
    columns = effect.design(event_table(rock=ROCK))
    assert columns[:, 0].tolist() == [0.0] * 7 + [1.0] * 5 + [0.0] * 4
    assert "gneiss" in effect.parameters[0].unit


def test_equal_counts_go_by_name() -> None:
    assert level_facts("rock", event_table(rock=["b"] * 5 + ["a"] * 5))["reference"] == "a"


def test_a_level_unseen_in_the_calibration_and_a_missing_column_change_nothing() -> None:
    effect = level_effect("k", "rock", {"reference": "gneiss", "levels": ["lime"], "prior_sd": 0.2})
    assert isinstance(effect, FrictionEffect)
    assert effect.design(event_table(rock=["new", "lime"])).tolist() == [[0.0], [1.0]]
    assert np.array_equal(effect.design(event_table()), np.zeros((6, 1)))


def test_numbers_are_levels_too_where_they_are_known() -> None:
    table = event_table(kind=[1.0] * 5 + [2.5] * 5 + [np.nan] * 3)
    assert level_lacking("kind", table) is None
    facts = level_facts("kind", table)
    assert (facts["reference"], facts["levels"]) == ("1", ["2.5"])


@pytest.mark.parametrize("rock", [["a"] * 9, ["a"] * 9 + ["b"] * 4])
def test_one_level_tells_nothing(rock: list[str]) -> None:
    lack = level_lacking("rock", event_table(rock=rock))
    assert lack is not None
    assert "rock" in lack
    assert level_lacking("other", event_table(rock=rock)) is not None


def test_where_a_column_has_its_levels_is_said() -> None:
    words = level_text("rock", event_table(rock=ROCK))
    assert words == "rock of the 16 events: 7 gneiss, 5 lime, 4 slate."
    assert level_text("rock", event_table()) is None


CONSTANT = Specification(law="constant")


def test_the_width_is_that_of_the_records_in_log_friction() -> None:
    observations = build_observations(levelled(0.0, 40))
    facts = level_facts("rock", observations.columns)
    spread = np.std(np.log(observations.columns.height_over_length))
    assert facts["prior_sd"] == pytest.approx(SCATTERS * spread, abs=1e-3)
    (parameter,) = level_effect("k", "rock", facts).parameters
    assert parameter.prior_sd == facts["prior_sd"]


def test_no_narrower_than_before_where_nothing_tells_it() -> None:
    rock = ["a"] * 9 + ["b"] * 9
    assert level_facts("rock", event_table(rock=rock))["prior_sd"] == LEAST_SD


def test_the_line_to_the_stop_is_the_same_for_either_kind_of_record() -> None:
    by_x = build_observations(slopes(kind="x")).columns.height_over_length
    by_height = build_observations(slopes(kind="elevation")).columns.height_over_length
    assert by_x == pytest.approx(by_height, rel=0.02)
    stops = np.array([e.runout_x_m for e in slopes(kind="x").events], float)
    assert by_x == pytest.approx((stops - 2.5e-4 * stops**2) / stops, rel=0.01)
    lines = build_observations(straight())
    assert lines.columns.height_over_length == pytest.approx(1000.0 / lines.observed)


def fit(shift: float, n_level: int, seed: int) -> tuple[float, float, float]:
    """Shift at the mode, its standard deviation, and the evidence (nats) that the level adds."""
    observations = build_observations(levelled(shift, n_level, seed))
    base = assemble(observations, CONSTANT, {})
    specification, facts = with_effects(observations, CONSTANT, ("covariate:rock",))
    posterior = assemble(observations, specification, facts)
    mode, plain = find_mode(posterior), find_mode(base)
    gain = log_evidence(posterior, mode).value - log_evidence(base, plain).value
    scale = posterior.layout.slots[-1].scale
    assert scale == facts["covariate:rock"]["prior_sd"]
    return scale * mode.u[-1], scale * float(np.sqrt(mode.covariance[-1, -1])), gain


def test_a_shift_of_a_half_comes_back_whole_from_few_events() -> None:
    found = np.array([fit(0.5, 6, seed) for seed in range(8)])
    middle, sd = found[:, 0], found[:, 1]
    # With a prior of 0 ± 0.2 the mean fell short by a tenth.
    assert np.mean(middle) == pytest.approx(0.5, abs=2.0 * np.mean(sd) / np.sqrt(8))
    assert np.mean(np.abs(middle - 0.5) < 1.64 * sd) >= 0.7
    assert np.all(found[:, 2] > 3.0)


def test_a_level_that_does_nothing_costs_its_price() -> None:
    gains = np.array([fit(0.0, 20, seed)[2] for seed in range(8)])
    # E exp(gain) = 1 where nothing is there: odds of 20 to 1 come once in 20 at most.
    assert np.mean(gains) < -0.7
    assert np.sum(gains > np.log(20.0)) <= 1


def test_missing_values_are_no_level() -> None:
    assert level_counts(np.array(["b", "", "a", "b", ""])) == {"a": 1, "b": 2}


def _design(entry: Definition, table=None) -> Floats:
    """The design columns; what the effect takes from the data is from all the events."""
    effect = entry.build(entry.facts(columns(), sites()))
    assert isinstance(effect, FrictionEffect)
    return effect.design(columns() if table is None else table)


def test_snow_types_are_told_from_the_most_common() -> None:
    entry, table = SNOW_TYPE, columns()
    facts = entry.facts(table, sites())
    assert facts == {"reference": "dry", "levels": ["mixed", "wet"], "prior_sd": 0.2}
    names = [p.name for p in entry.build(facts).parameters]
    assert names == ["mixed", "wet"]
    kinds = table.texts["snow_type"]
    expected = np.column_stack([kinds == "mixed", kinds == "wet"])
    assert np.array_equal(_design(entry), expected)


def test_a_level_not_seen_before_has_no_effect() -> None:
    new = columns((Event("n", "P0", covariates={"snow_type": "slush"}),))
    assert np.array_equal(_design(SNOW_TYPE, new), [[0.0, 0.0]])
    none = columns((Event("n", "P0"),))
    assert np.array_equal(_design(SNOW_TYPE, none), [[0.0, 0.0]])


def test_open_paths_are_told_from_channelled_ones() -> None:
    design = _design(PATH_SECTION)
    assert np.array_equal(design[:, 0], columns().path_index % 2 == 1)


def test_levels_of_another_file_may_be_spelled_otherwise() -> None:
    def spelled(*texts: str) -> EventColumns:
        events = [Event(str(k), covariates={"layer": text}) for k, text in enumerate(texts)]
        return build_columns(events, {}, np.full(len(texts), np.nan))

    learnt = spelled(*["powder"] * 6, *["Depth hoar"] * 3, *["depth-hoar"] * 2)
    facts = level_facts("layer", learnt)
    assert (facts["reference"], facts["levels"]) == ("powder", ["Depth hoar"])
    effect = level_effect("covariate:layer", "layer", facts)
    found = effect.design(spelled("DEPTH HOAR", "Powder", "graupel"))
    assert found[:, 0].tolist() == [1.0, 0.0, 0.0]
