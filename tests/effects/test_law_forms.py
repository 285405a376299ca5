"""Forms of laws: the effect files that they make are what the forms say."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.effects.catalogue import catalogue, definition
from avahazard.effects.covariate import covariate
from avahazard.effects.effect import Curve, FrictionEffect, MotionEffect
from avahazard.effects.law_forms import FORMULAS, LawForm, forms_of, free_curve
from avahazard.effects.motion import STATES
from avahazard.effects.own_file import definition_from
from avahazard.physics.cells import SPEEDS, no_resistance
from tests.effects.event_table import event_table
from tests.effects.examples import columns, sites

KEYS = ("force:speed", *(f"force:{state}" for state in STATES))
SPREAD = 0.3


def curve_of(key: str) -> Curve:
    entry = definition(key)
    found = entry.curve(entry.facts(columns(), sites()))
    assert found is not None
    return found


def likely(form: LawForm) -> np.ndarray:
    return np.array([0.5 * SPREAD, *(p.prior_mean for p in form.parameters[1:])])


def added(effect: MotionEffect, values: np.ndarray) -> np.ndarray:
    """What an effect adds to friction or force, by cell or by speed."""
    terrain = sites()[0].terrain
    after = effect.resistance(sites()[0], no_resistance(terrain), values)
    return after.speed_constant if effect.speed_dependent else after.offset


@pytest.mark.parametrize("key", KEYS)
def test_the_file_of_a_form_is_the_form(key: str) -> None:
    curve, terrain = curve_of(key), sites()[0].terrain
    states = SPEEDS if key == "force:speed" else STATES[curve.of][2](terrain)
    for form in forms_of(curve, SPREAD):
        values = likely(form)
        entry = definition_from(form.text("What it means.", values[1:]), "law.py")
        assert entry.key == form.key
        assert entry.key not in catalogue()
        effect = entry.build({})
        assert isinstance(effect, MotionEffect)
        assert [p.name for p in effect.parameters] == [p.name for p in form.parameters]
        by_hand = values[0] * form.shape(states, values[1:])
        # The slope of a cell is that of the profile in its middle, or of its ends.
        np.testing.assert_allclose(added(effect, values), by_hand, atol=1e-3 * SPREAD, rtol=3e-3)
        neutral = np.concatenate([[0.0], values[1:]])
        np.testing.assert_array_equal(added(effect, neutral), 0.0)


def test_a_law_of_friction_has_its_shape_as_constants() -> None:
    x = np.linspace(-2.0, 3.0, 30)
    table = event_table(**{"wind m/s": x.tolist()})
    entry = covariate("wind m/s")
    curve = entry.curve(entry.facts(table, ()))
    assert curve is not None
    assert np.mean(curve.columns, axis=0) == pytest.approx(0.0, abs=1e-12)
    forms = {form.name: form for form in forms_of(curve, SPREAD)}
    assert forms.keys() == {f.__name__ for f in FORMULAS} - {"constant", "power"}
    for form in forms.values():
        made = definition_from(form.text("Wind packs.", likely(form)[1:]), "law.py")
        assert made.key == f"wind-m-s-{form.name}"
        effect = made.build({})
        assert isinstance(effect, FrictionEffect)
        (change,) = effect.parameters
        assert (change.name, change.prior_sd) == ("change", SPREAD)
        by_hand = form.shape(x, likely(form)[1:])
        np.testing.assert_allclose(effect.design(table)[:, 0], by_hand, rtol=1e-4, atol=1e-4)


def test_a_free_curve_goes_straight_between_its_places() -> None:
    curve = curve_of("force:elevation")
    places = np.linspace(curve.x[0], curve.x[-1], 5)
    heights = np.array([0.1, -0.2, 0.05, 0.0, 0.3])
    effect = definition_from(free_curve(curve, places, SPREAD), "curve").build({})
    assert isinstance(effect, MotionEffect)
    by_hand = np.interp(sites()[0].terrain.middle_y, places, heights)
    np.testing.assert_allclose(added(effect, heights), by_hand)


def test_what_has_levels_is_no_curve() -> None:
    assert covariate("weather").curve({"levels": ["a", "b"]}) is None
    assert definition("turbulent-drag").curve({}) is None
