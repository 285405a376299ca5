"""A force growing with the square of speed (Voellmy 1955)."""

from __future__ import annotations

from dataclasses import replace

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition, Facts, MotionEffect, Parameter, needs_profile
from avahazard.effects.site import Site
from avahazard.physics.resistance import Resistance


def _resistance(_site: Site, resistance: Resistance, values: Floats) -> Resistance:
    return replace(resistance, drag=resistance.drag + values[0])


def _build(_facts: Facts) -> MotionEffect:
    drag = Parameter("drag", "1/m", 0.0, 0.0, 0.005, 0.0, 0.03)
    return MotionEffect("turbulent-drag", (drag,), resistance=_resistance)


DEFINITION = Definition(
    key="turbulent-drag",
    meaning="The flow churns and pushes air and snow aside, which costs a force that grows with "
    "the square of speed (Voellmy). Fast avalanches are held back more than slow ones, so that "
    "long steep tracks need less friction at the bed than a Coulomb block says.",
    needs="profile; speeds help",
    build=_build,
    lacking=needs_profile,
    limits_speed=True,
    order=20,
)
