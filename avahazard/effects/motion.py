"""Effects on the motion: drag, friction that falls with speed, cohesion, snow taken up, trees.

And the load of curvature, which the base model has.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import (
    Definition,
    Effect,
    Facts,
    MotionEffect,
    Parameter,
    Setting,
    Sites,
    needs_profile,
)
from avahazard.effects.site import Site
from avahazard.notes import Note
from avahazard.physics.cells import SPEEDS, Resistance

EDGE_M = 40.0
"""The snow line is blurred over this height, so that the likelihood is smooth in it."""


def _drag(_site: Site, resistance: Resistance, values: Floats) -> Resistance:
    return replace(resistance, drag=resistance.drag + values[0])


DRAG = Parameter("drag", "1/m", 0.0, 0.0, 0.005, 0.0, 0.03)
TURBULENT_DRAG = Definition(
    key="turbulent-drag",
    meaning="The flow churns and pushes air and snow aside, which costs a force that grows with "
    "the square of speed (Voellmy). Fast avalanches are held back more than slow ones, so that "
    "long steep tracks need less friction at the bed than a Coulomb block says.",
    needs="profile; speeds help",
    build=lambda _: MotionEffect("turbulent-drag", (DRAG,), _drag),
    lacking=needs_profile,
    limits_speed=True,
    order=20,
)


def _weakening(_site: Site, resistance: Resistance, values: Floats) -> Resistance:
    ratio, speed = values
    factor = ratio + (1.0 - ratio) / (1.0 + SPEEDS / speed)
    if resistance.speed_factor is not None:
        factor = factor * resistance.speed_factor
    return replace(resistance, speed_factor=np.asarray(factor))


WEAKENING = (
    Parameter("ratio", "", 1.0, 1.0, 0.4, 0.2, 1.0),
    Parameter("speed", "m/s", 8.0, 10.0, 8.0, 4.0, 32.0),
)
SPEED_WEAKENING = Definition(
    key="speed-weakening",
    meaning="Friction is full at rest and falls towards a part of it, `ratio`, as the avalanche "
    "speeds up; `speed` is where half of the fall is done. Fast avalanches run on as if on a "
    "lubricated bed, yet stop abruptly once they are slow.",
    needs="profile, speeds",
    build=lambda _: MotionEffect("speed-weakening", WEAKENING, _weakening, speed_dependent=True),
    lacking=needs_profile,
    order=30,
)


def _cohesion(_site: Site, resistance: Resistance, values: Floats) -> Resistance:
    return replace(resistance, constant=resistance.constant + values[0])


STRENGTH = Parameter("strength", "m/s2", 0.0, 0.0, 1.0, 0.0, 3.5)
COHESION = Definition(
    key="cohesion",
    meaning="Snow sticks to its bed with a strength that does not depend on the load. It resists "
    "alike on steep and on gentle ground, so steep tracks brake more than friction alone says.",
    needs="profile, speeds",
    build=lambda _: MotionEffect("cohesion", (STRENGTH,), _cohesion),
    lacking=needs_profile,
    order=40,
)


def _taken_up(site: Site, resistance: Resistance, values: Floats) -> Resistance:
    y = site.terrain_for(resistance).middle_y
    above = np.clip((y - values[1]) / EDGE_M + 0.5, 0.0, 1.0)
    return replace(resistance, drag=resistance.drag + values[0] * above)


def _heights(_columns: EventColumns, sites: Sites) -> Facts:
    # A line below most paths would be drag by another name.
    top = max(float(s.heights()[0]) for s in sites)
    bottom = float(np.median([np.min(s.heights()) for s in sites]))
    return {"bottom_m": bottom, "top_m": top}


def _entrainment(facts: Facts) -> MotionEffect:
    bottom, top = float(facts["bottom_m"]), float(facts["top_m"])
    length = top - bottom
    low, middle, high = bottom + 0.125 * length, 0.5 * (bottom + top), top - 0.125 * length
    parameters = (
        Parameter("rate", "1/m", 0.0, 0.0, 0.005, 0.0, 0.025),
        Parameter("above", "m", middle, middle, 0.5 * length, low, high),
    )
    return MotionEffect("entrainment", parameters, _taken_up)


ENTRAINMENT = Definition(
    key="entrainment",
    meaning="Snow taken up from the track must be brought to the avalanche's speed, which costs "
    "momentum; it happens above the elevation where loose snow lies. Avalanches that start high "
    "above that elevation lose more than those that start near it.",
    needs="profile, varied release",
    build=_entrainment,
    lacking=needs_profile,
    facts=_heights,
    order=50,
)


FOREST = "forest"


def _in_forest(site: Site, resistance: Resistance, values: Floats) -> Resistance:
    inside = site.cover(site.terrain_for(resistance)) == FOREST
    return replace(resistance, drag=resistance.drag + values[0] * inside)


def _no_forest(columns: EventColumns, sites: Sites) -> str | None:
    forested = any(s.land_cover is not None and FOREST in s.land_cover for s in sites)
    return needs_profile(columns, sites) or (
        None if forested else "no profile has land_cover `forest` anywhere"
    )


def _seen_in(columns: EventColumns, sites: Sites) -> Note | None:
    """The paths with forest, by name."""
    wooded = [s.path.path_id for s in sites if s.land_cover is not None and FOREST in s.land_cover]
    if not wooded:
        return None
    events = int(np.isin(np.array([*columns.paths, ""])[columns.path_index], wooded).sum())
    return Note("forested", paths=wooded, n=len(wooded), events=events, total=len(columns))


BY_TREES = Parameter("drag", "1/m", 0.0, 0.0, 0.02, 0.0, 0.1)
FOREST_DRAG = Definition(
    key="forest-drag",
    meaning="Trees brake the flow while it runs through forest (Feistl and others 2014: snow is "
    "left behind stems). Only the forested part of a path is slowed, so stops gather in or just "
    "below the forest.",
    needs="land_cover",
    build=lambda _: MotionEffect("forest-drag", (BY_TREES,), _in_forest),
    lacking=_no_forest,
    seen_in=_seen_in,
    trees=True,
    order=60,
)


CENTRIFUGAL = Definition(
    key="centrifugal",
    meaning="In a hollow the path turns under the block and presses on it, so that friction "
    "grows with speed and curvature; over a crest it is lighter. It is in the base model and can "
    "be left out.",
    needs="profile",
    build=lambda _: Effect("centrifugal", ()),
    lacking=needs_profile,
    changes=Setting("centrifugal", "the motion", value=True, without=False),
    order=10,
)
"""A setting of the model: nothing is built for it."""
