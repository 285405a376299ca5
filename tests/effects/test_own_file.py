"""Effect files: what they must hold, what they become, and their template."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np
import pytest

from avahazard.effects.effect import Effect, FrictionEffect, MotionEffect
from avahazard.effects.own_file import (
    FORMS,
    TEMPLATE,
    declared_key,
    definition_from,
    known_values,
    read_text,
    track_of,
)
from avahazard.effects.site import Site, build_site
from avahazard.physics.cells import SPEEDS, no_resistance
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Path, Profile
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


def test_a_file_that_is_none(tmp_path: pathlib.Path) -> None:
    with pytest.raises(AvahazardError, match="cannot be read"):
        read_text(tmp_path / "nothing.py")
    file = tmp_path / "aspect.py"
    file.write_text(GOOD, encoding="utf-8")
    assert read_text(file) == GOOD


HEAD = """
import numpy as np
from avahazard.effects.effect import Parameter
KEY, MEANING, NEEDS = "own", "It is my own.", {needs}
PARAMETERS = [Parameter("k", "1", neutral={neutral}, prior_mean=0.5, prior_sd=1.0, low=0, high=2)]
"""


def effect_of(body: str, needs: str = "[]", neutral: float = 0.0) -> Effect:
    text = HEAD.format(needs=needs, neutral=neutral) + body
    return definition_from(text, "own.py").build({})


def site() -> Site:
    x = np.linspace(0.0, 1000.0, 51)
    profile = Profile("P", x, 1000.0 - 0.6 * x, tuple("open" if v < 500 else "rock" for v in x))
    return build_site(Path("P", section="open"), profile, smooth_profile(x, profile.y_m), [0.0])


def test_what_a_track_shows() -> None:
    place = site()
    track = track_of(place, place.terrain)
    np.testing.assert_allclose(track.y, 1000.0 - 0.6 * track.x, atol=0.1)
    np.testing.assert_allclose(track.slope, np.degrees(np.arctan(0.6)), atol=0.5)
    np.testing.assert_array_equal(track.land_cover == "rock", track.x >= 500.0)
    assert (track.path_id, track.section) == ("P", "open")


@pytest.mark.parametrize(
    ("form", "field", "by_hand"),
    [
        ("drag", "drag", lambda rock: 0.5 * rock),
        ("resistance", "constant", lambda rock: 0.5 * rock),
        ("friction_factor", "factor", lambda rock: 0.5 * rock),
    ],
)
def test_on_the_track(form: str, field: str, by_hand: Any) -> None:
    effect = effect_of(f"def {form}(track, k):\n    return k * (track.land_cover == 'rock')\n")
    place = site()
    assert isinstance(effect, MotionEffect)
    before = no_resistance(place.terrain)
    after = effect.resistance(place, before, np.array([0.5]))
    rock = track_of(place, place.terrain).land_cover == "rock"
    np.testing.assert_array_equal(getattr(after, field), by_hand(rock))
    for other in {"drag", "constant", "factor", "offset"} - {field}:
        np.testing.assert_array_equal(getattr(after, other), getattr(before, other))
    assert not effect.speed_dependent


def test_on_speed() -> None:
    place = site()
    before = no_resistance(place.fine_terrain)
    factor = effect_of("def speed_factor(speeds, k):\n    return 1 / (1 + k * speeds)\n")
    force = effect_of("def speed_resistance(speeds, k):\n    return k * speeds\n")
    assert factor.speed_dependent
    assert isinstance(factor, MotionEffect)
    assert isinstance(force, MotionEffect)
    once = factor.resistance(place, before, np.array([0.1]))
    twice = factor.resistance(place, once, np.array([0.1]))
    np.testing.assert_allclose(twice.speed_factor, (1.0 + 0.1 * SPEEDS) ** -2)
    both = force.resistance(place, force.resistance(place, once, np.array([0.2])), np.array([0.3]))
    np.testing.assert_allclose(both.speed_constant, 0.5 * SPEEDS)
    np.testing.assert_array_equal(both.speed_factor, once.speed_factor)


def test_on_the_record_and_nothing_at_neutral() -> None:
    columns = event_table(dust=[1.0, 2.0])
    for form, field in (("record_shift", "shift"), ("front", "advance")):
        body = f"def {form}(columns, k):\n    return 7.0 + k * columns.numbers['dust']\n"
        metres = getattr(effect_of(body), field)
        np.testing.assert_allclose(metres(columns, np.array([2.0])), [9.0, 11.0])
        np.testing.assert_array_equal(metres(columns, np.array([0.0])), [0.0, 0.0])


def test_data_without_the_column_are_not_touched() -> None:
    body = "def friction(columns):\n    return columns.numbers['dust']\n"
    effect = effect_of(body, "['dust']")
    assert isinstance(effect, FrictionEffect)
    np.testing.assert_array_equal(effect.design(event_table()), np.zeros((6, 1)))


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("def friction(columns):\n    return [1, 2]\n", "gives 2 columns for 1 parameters"),
        ("def friction(columns):\n    return columns.snow\n", "fails: AttributeError"),
        ("def friction(columns):\n    return np.zeros(3)\n", "must give 6 numbers"),
        ("def friction(columns):\n    return 'wet'\n", "must give 6 numbers"),
        ("def friction(columns):\n    return None\n", "it gives None"),
        ("def friction(columns):\n    return np.nan\n", "that of event 1 is nan"),
        ("def friction(columns):\n    return [[1, 2, np.inf, 4, 5, 6]]\n", "of event 3 is inf"),
        ("def friction(columns):\n    raise SystemExit(0)\n", "fails: SystemExit"),
    ],
)
def test_what_a_function_gives_wrong(body: str, message: str) -> None:
    effect = effect_of(body)
    assert isinstance(effect, FrictionEffect)
    with pytest.raises(AvahazardError, match=message):
        effect.design(event_table())


def test_every_form_is_in_the_template() -> None:
    for form, (argument, _) in FORMS.items():
        assert f"def {form}({argument}" in TEMPLATE


def test_it_runs_as_it_is() -> None:
    found = definition_from(TEMPLATE, "template.py")
    assert found.key == "my-effect"
    columns = event_table(snow_type=["wet", "dry", "wet", "dry", "mixed"])
    assert found.lacking(columns, ()) is None
    effect = found.build({})
    assert isinstance(effect, FrictionEffect)
    np.testing.assert_array_equal(effect.design(columns)[:, 0], [1.0, 0.0, 1.0, 0.0, 0.0])


def test_it_is_short_enough_to_be_read() -> None:
    lines = [line.strip() for line in TEMPLATE.splitlines()]
    code = [line for line in lines if line and not line.startswith(("#", '"""'))]
    assert len(code) <= 25
    assert max(map(len, TEMPLATE.splitlines())) <= 100


def test_its_second_example_runs_too() -> None:
    start = TEMPLATE.index("# PARAMETERS = [")
    example = "\n".join(line.removeprefix("# ") for line in TEMPLATE[start:].splitlines())
    head = TEMPLATE[: TEMPLATE.index("# Exactly one function")]
    found = definition_from(head + example, "template.py")
    assert isinstance(found.build({}), MotionEffect)


def test_whole_numbers_at_neutral_can_be_moved_by_parts() -> None:
    found = effect_of("def speed_resistance(speeds, k):\n    return k * speeds\n", neutral=0)
    moved = found.neutral
    moved[0] += 0.25
    assert moved.tolist() == [0.25]
