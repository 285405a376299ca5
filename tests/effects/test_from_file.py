"""Effect files: what they must hold, and what they become."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avahazard.effects.effect import FrictionEffect, Parameter
from avahazard.effects.from_file import (
    declared_key,
    definition_from,
    known_values,
    read_effect_file,
)
from avahazard.records.errors import AvahazardError
from tests.effects.event_table import event_table

GOOD = """
from avahazard.effects.effect import Parameter
KEY = "aspect"
MEANING = "Shade keeps snow cold."
NEEDS = ["dust"]
PARAMETERS = [Parameter("north", "log friction", neutral=0.0, prior_mean=0.0, prior_sd=0.2)]
def friction(columns):
    return columns.numbers["dust"]
"""


def test_a_file_becomes_a_definition() -> None:
    found = definition_from(GOOD, "aspect.py")
    assert (found.key, found.meaning, found.needs) == ("aspect", "Shade keeps snow cold.", "dust")
    columns = event_table(dust=[0.0, 1.0, 2.0, np.nan, 4.0, 5.0])
    assert found.lacking(columns, ()) is None
    assert found.facts(columns, ()) == {}
    effect = found.build({})
    assert effect.key == "aspect"
    assert isinstance(effect, FrictionEffect)
    # A missing number has no effect.
    np.testing.assert_array_equal(
        effect.design(columns), [[0.0], [1.0], [2.0], [0.0], [4.0], [5.0]]
    )


def test_what_the_data_lack() -> None:
    found = definition_from(GOOD, "aspect.py")
    assert found.lacking(event_table(dust=[1.0] * 4), ()) == "4 events have a value of dust"
    assert found.lacking(event_table(), ()) == "0 events have a value of dust"
    profile = definition_from(GOOD.replace('["dust"]', '["profile", "land_cover"]'), "a.py")
    assert "profile" in str(profile.lacking(event_table(dust=[1.0]), ()))
    columns = event_table(dust=[1.0, np.nan])
    assert [known_values(columns, name) for name in ("dust", "date", "nothing")] == [1, 0, 0]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('KEY = "aspect"', "", "KEY is missing"),
        ('"aspect"', '"snow-type"', "KEY = 'snow-type' cannot"),
        ('"aspect"', '"two words"', "KEY = 'two words' cannot"),
        ('MEANING = "Shade keeps snow cold."', "MEANING = 3", "MEANING is missing"),
        ('NEEDS = ["dust"]', 'NEEDS = "dust"', "NEEDS is missing or no list"),
        ("PARAMETERS = [", "THOSE = [", "PARAMETERS is missing"),
        ("def friction", "def fraction", "exactly one function"),
        ("def friction", "drag = len\ndef friction", "has friction and drag"),
        ("(columns):", "(columns, north):", "Begin it with: def friction(columns):"),
        ("neutral=0.0", "neutral=1.0", "neutral must be 0"),
        ("prior_sd=0.2", "prior_sd=0.0", "prior_sd > 0"),
        ("prior_sd=0.2", "prior_sd=0.2, low=1.0", "must lie in"),
        ('"north"', '"to the north"', "one word"),
        ("KEY =", "KEY ==", "does not run, line 3: NameError"),
        ("def friction(columns):", "def friction(columns)", "does not run, line 7: SyntaxError"),
        ("friction(columns)", "drag(track, north)", "needs low < high"),
    ],
)
def test_what_is_wrong_with_a_file(old: str, new: str, message: str) -> None:
    assert old in GOOD
    with pytest.raises(AvahazardError) as found:
        definition_from(GOOD.replace(old, new), "aspect.py")
    assert message in f"{found.value.message} {found.value.hint}"
    assert "aspect.py" in found.value.message


def test_a_file_that_ends_the_program_is_told_as_one_that_does_not_run() -> None:
    with pytest.raises(AvahazardError, match=r"does not run, line 9: SystemExit: 0"):
        definition_from(GOOD + "raise SystemExit(0)\n", "aspect.py")


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (GOOD, "aspect"),
        ('KEY, MEANING = "own", "Mine."', "own"),
        ("KEY = 'a' + 'b'", None),
        ("def (", None),
        ("", None),
    ],
)
def test_the_key_of_a_text_is_known_without_running_it(text: str, key: str | None) -> None:
    assert declared_key(text) == key


def test_a_tabulated_parameter_gets_a_grid_with_its_neutral_value() -> None:
    text = GOOD.replace("friction(columns)", "record_shift(columns, north)").replace(
        "prior_sd=0.2", "prior_sd=0.2, low=-1.0, high=1.5"
    )
    (parameter,) = definition_from(text, "a.py").build({}).parameters
    assert parameter.grid == pytest.approx(sorted([*np.linspace(-1.0, 1.5, 9), 0.0]))
    assert (parameter.low, parameter.high) == (-1.0, 1.5)
    given = definition_from(text.replace("high=1.5", "high=1.5, grid=(-1.0, 1.5)"), "a.py")
    assert given.build({}).parameters[0].grid == (-1.0, 0.0, 1.5)


def test_a_file_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="cannot be read"):
        read_effect_file(tmp_path / "nothing.py")
    file = tmp_path / "aspect.py"
    file.write_text(GOOD, encoding="utf-8")
    found = read_effect_file(file)
    assert found.text == GOOD
    assert isinstance(found.definition.build({}).parameters[0], Parameter)
