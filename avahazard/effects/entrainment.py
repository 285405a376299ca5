"""Momentum lost to snow taken up above an elevation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Facts, MotionEffect, Parameter, needs_profile
from avahazard.effects.site import Site
from avahazard.physics.resistance import Resistance

EDGE_M = 40.0
"""The snow line is blurred over this height, so that the likelihood is smooth in it."""


def _resistance(site: Site, resistance: Resistance, values: Floats) -> Resistance:
    y = site.terrain_for(resistance).middle_y
    above = np.clip((y - values[1]) / EDGE_M + 0.5, 0.0, 1.0)
    return replace(resistance, drag=resistance.drag + values[0] * above)


def _facts(_columns: EventColumns, sites: Sequence[Site]) -> Facts:
    # A line below most paths would be drag by another name.
    top = max(float(s.heights()[0]) for s in sites)
    bottom = float(np.median([np.min(s.heights()) for s in sites]))
    return {"bottom_m": bottom, "top_m": top}


def _build(facts: Facts) -> MotionEffect:
    bottom, top = float(facts["bottom_m"]), float(facts["top_m"])
    length = top - bottom
    low, middle, high = bottom + 0.125 * length, 0.5 * (bottom + top), top - 0.125 * length
    return MotionEffect(
        "entrainment",
        (
            Parameter("rate", "1/m", 0.0, 0.0, 0.005, 0.0, 0.025),
            Parameter("above", "m", middle, middle, 0.5 * length, low, high),
        ),
        resistance=_resistance,
    )


DEFINITION = Definition(
    key="entrainment",
    meaning="Snow taken up from the track must be brought to the avalanche's speed, which costs "
    "momentum; it happens above the elevation where loose snow lies. Avalanches that start high "
    "above that elevation lose more than those that start near it.",
    needs="profile, varied release",
    build=_build,
    lacking=needs_profile,
    facts=_facts,
    order=50,
)
