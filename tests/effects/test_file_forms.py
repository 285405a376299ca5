"""What each function of an effect file does to a model."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from avahazard.effects.effect import Effect, FrictionEffect, MotionEffect
from avahazard.effects.file_forms import FORMS, track_of
from avahazard.effects.from_file import definition_from
from avahazard.effects.site import Site, build_site
from avahazard.physics.resistance import SPEEDS, no_resistance
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.errors import AvahazardError
from avahazard.records.path import Path, Profile
from tests.effects.event_table import event_table

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
        ("def friction(columns):\n    return np.nan\n", "number 1 is nan"),
        (
            "def friction(columns):\n    return [[1, 2, np.inf, 4, 5, 6]]\n",
            "number 3 is inf",
        ),
        ("def friction(columns):\n    raise SystemExit(0)\n", "fails: SystemExit"),
    ],
)
def test_what_a_function_gives_wrong(body: str, message: str) -> None:
    effect = effect_of(body)
    assert isinstance(effect, FrictionEffect)
    with pytest.raises(AvahazardError, match=message):
        effect.design(event_table())


def test_every_form_is_in_the_template() -> None:
    from avahazard.effects.file_template import TEMPLATE  # noqa: PLC0415

    for form in FORMS:
        assert f"def {form.name}({form.argument}" in TEMPLATE
