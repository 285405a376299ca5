"""Friction that falls with speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition, Facts, MotionEffect, Parameter, needs_profile
from avahazard.effects.site import Site
from avahazard.physics.resistance import SPEEDS, Resistance


def _resistance(_site: Site, resistance: Resistance, values: Floats) -> Resistance:
    ratio, speed = values
    factor = ratio + (1.0 - ratio) / (1.0 + SPEEDS / speed)
    if resistance.speed_factor is not None:
        factor = factor * resistance.speed_factor
    return replace(resistance, speed_factor=np.asarray(factor))


def _build(_facts: Facts) -> MotionEffect:
    return MotionEffect(
        "speed-weakening",
        (
            Parameter("ratio", "", 1.0, 1.0, 0.4, 0.2, 1.0),
            Parameter("speed", "m/s", 8.0, 10.0, 8.0, 4.0, 32.0),
        ),
        resistance=_resistance,
        speed_dependent=True,
    )


DEFINITION = Definition(
    key="speed-weakening",
    meaning="Friction is full at rest and falls towards a part of it, `ratio`, as the avalanche "
    "speeds up; `speed` is where half of the fall is done. Fast avalanches run on as if on a "
    "lubricated bed, yet stop abruptly once they are slow.",
    needs="profile, speeds",
    build=_build,
    lacking=needs_profile,
    order=30,
)
