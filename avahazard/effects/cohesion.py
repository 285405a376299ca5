"""A constant bed resistance per unit mass."""

from __future__ import annotations

from dataclasses import replace

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition, Facts, MotionEffect, Parameter, needs_profile
from avahazard.effects.site import Site
from avahazard.physics.resistance import Resistance


def _resistance(_site: Site, resistance: Resistance, values: Floats) -> Resistance:
    return replace(resistance, constant=resistance.constant + values[0])


def _build(_facts: Facts) -> MotionEffect:
    strength = Parameter("strength", "m/s2", 0.0, 0.0, 1.0, 0.0, 3.5)
    return MotionEffect("cohesion", (strength,), resistance=_resistance)


DEFINITION = Definition(
    key="cohesion",
    meaning="Snow sticks to its bed with a strength that does not depend on the load. It resists "
    "alike on steep and on gentle ground, so steep tracks brake more than friction alone says.",
    needs="profile, speeds",
    build=_build,
    lacking=needs_profile,
    order=40,
)
