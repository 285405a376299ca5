"""Friction by the levels of a column."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.effects.effect import FrictionEffect
from avahazard.effects.levels import level_effect, level_facts, level_lacking, level_words
from tests.effects.event_table import event_table

ROCK = ["gneiss"] * 7 + ["lime"] * 5 + ["slate"] * 4


def test_the_commonest_level_is_the_reference_and_rare_ones_have_none() -> None:
    facts = level_facts(event_table(rock=ROCK), "rock")
    assert (facts["reference"], facts["levels"]) == ("gneiss", ["lime"])
    effect = level_effect("covariate:rock", "rock", facts)
    assert isinstance(effect, FrictionEffect)
    columns = effect.design(event_table(rock=ROCK))
    assert columns[:, 0].tolist() == [0.0] * 7 + [1.0] * 5 + [0.0] * 4
    assert "gneiss" in effect.parameters[0].unit


def test_equal_counts_go_by_name() -> None:
    assert level_facts(event_table(rock=["b"] * 5 + ["a"] * 5), "rock")["reference"] == "a"


def test_a_level_unseen_in_the_calibration_and_a_missing_column_change_nothing() -> None:
    effect = level_effect("k", "rock", {"reference": "gneiss", "levels": ["lime"]})
    assert isinstance(effect, FrictionEffect)
    assert effect.design(event_table(rock=["new", "lime"])).tolist() == [[0.0], [1.0]]
    assert np.array_equal(effect.design(event_table()), np.zeros((6, 1)))


def test_numbers_are_levels_too_where_they_are_known() -> None:
    table = event_table(kind=[1.0] * 5 + [2.5] * 5 + [np.nan] * 3)
    assert level_lacking(table, "kind") is None
    facts = level_facts(table, "kind")
    assert (facts["reference"], facts["levels"]) == ("1", ["2.5"])


@pytest.mark.parametrize("rock", [["a"] * 9, ["a"] * 9 + ["b"] * 4])
def test_one_level_tells_nothing(rock: list[str]) -> None:
    lack = level_lacking(event_table(rock=rock), "rock")
    assert lack is not None
    assert "rock" in lack
    assert level_lacking(event_table(rock=rock), "other") is not None


def test_where_a_column_has_its_levels_is_said() -> None:
    words = level_words(event_table(rock=ROCK), "rock")
    assert words == "rock of the 16 events: 7 gneiss, 5 lime, 4 slate."
    assert level_words(event_table(), "rock") is None
