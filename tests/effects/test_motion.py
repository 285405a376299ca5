"""Effects on the motion against their own formula, cell by cell."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from avahazard.effects import motion
from avahazard.effects.effect import Definition, MotionEffect
from avahazard.effects.site import Site
from avahazard.physics.cells import SPEEDS, Resistance, no_resistance
from avahazard.physics.runout_curve import RunoutCurve
from tests.effects.examples import columns, sites


@cache
def site() -> Site:
    """The bowl with its forest."""
    return sites()[0]


def table(resistance: Resistance) -> RunoutCurve:
    """F(μ) in the bowl."""
    return site().table(site().cells(resistance))


def _added(entry: Definition, *values: float) -> Resistance:
    """The resistance with the effect on top of some of every kind."""
    effect = entry.build(entry.facts(columns(), sites()))
    assert isinstance(effect, MotionEffect)
    n = site().terrain.n_cells
    before = Resistance(np.full(n, 1.1), np.full(n, 0.02), np.full(n, 0.3), np.full(n, 0.001))
    return effect.resistance(site(), before, np.array(values))


def test_drag_is_the_same_everywhere() -> None:
    after = _added(motion.TURBULENT_DRAG, 0.003)
    assert after.drag == pytest.approx(np.full(site().terrain.n_cells, 0.004))
    assert np.all(after.constant == 0.3)
    assert np.all(after.factor == 1.1)


def test_cohesion_is_a_constant() -> None:
    after = _added(motion.COHESION, 0.8)
    assert after.constant == pytest.approx(np.full(site().terrain.n_cells, 1.1))
    assert np.all(after.drag == 0.001)


def test_forest_brakes_in_its_cells_only() -> None:
    after = _added(motion.FOREST_DRAG, 0.02)
    middle = site().terrain.middle_x
    forest = (middle > 800.0) & (middle < 1400.0)
    assert forest.any()
    assert not forest.all()
    assert after.drag == pytest.approx(np.where(forest, 0.021, 0.001))


def test_snow_is_taken_up_above_its_line() -> None:
    after = _added(motion.ENTRAINMENT, 0.004, 500.0)
    y = site().terrain.middle_y
    assert after.drag[y > 520.0] == pytest.approx(0.005)
    assert after.drag[y < 480.0] == pytest.approx(0.001)
    between = (y > 480.0) & (y < 520.0)
    assert between.any()
    assert after.drag[between] == pytest.approx(0.001 + 0.004 * (y[between] - 480.0) / 40.0)


def test_friction_falls_with_speed() -> None:
    after = _added(motion.SPEED_WEAKENING, 0.4, 8.0)
    assert after.speed_factor[0] == 1.0
    # At its own speed half of the fall is done; far above, nearly all.
    assert np.interp(8.0, SPEEDS, after.speed_factor) == pytest.approx(0.7)
    assert after.speed_factor[-1] == pytest.approx(0.4 + 0.6 / (1.0 + 150.0 / 8.0))
    assert np.all(np.diff(after.speed_factor) < 0.0)


def test_two_effects_on_speed_multiply() -> None:
    once = _added(motion.SPEED_WEAKENING, 0.4, 8.0)
    effect = motion.SPEED_WEAKENING.build({})
    assert isinstance(effect, MotionEffect)
    twice = effect.resistance(site(), once, np.array([0.4, 8.0]))
    assert twice.speed_factor == pytest.approx(once.speed_factor**2)


@pytest.mark.parametrize(
    ("entry", "values"),
    [
        (motion.TURBULENT_DRAG, [0.004]),
        (motion.COHESION, [0.6]),
        (motion.FOREST_DRAG, [0.02]),
        (motion.ENTRAINMENT, [0.004, 500.0]),
    ],
)
def test_what_resists_shortens_every_run(entry: Definition, values: list[float]) -> None:
    effect = entry.build(entry.facts(columns(), sites()))
    assert isinstance(effect, MotionEffect)
    plain = no_resistance(site().terrain)
    base, held = table(plain), table(effect.resistance(site(), plain, np.array(values)))
    both = (base.status == 0) & (held.status == 0)
    assert both.any()
    assert np.all(held.x[both] <= base.x[both] + 1e-3)
    assert np.min((held.x - base.x)[both]) < -20.0
    assert not np.any(held.left & ~base.left)


def test_a_bed_that_weakens_with_speed_lengthens_runs() -> None:
    effect = motion.SPEED_WEAKENING.build({})
    assert isinstance(effect, MotionEffect)
    fine = no_resistance(site().fine_terrain)
    base, held = table(fine), table(effect.resistance(site(), fine, np.array([0.5, 8.0])))
    # Not those that hardly start: there F is not straight between every fourth friction.
    started = base.x > site().release_x[:, None] + 30.0
    both = (base.status == 0) & (held.status == 0) & started
    assert np.all(held.x[both] >= base.x[both] - 1e-9)
    assert np.max((held.x - base.x)[both]) > 100.0
