"""A resistance that varies smoothly with the state of the block, in a shape the data choose.

Effects with a name (drag, cohesion, entrainment) are members of these families; what no name fits
is still found here, with its shape.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import spline_columns
from avahazard.effects.effect import (
    Curve,
    Definition,
    Facts,
    MotionEffect,
    Parameter,
    Sites,
    needs_profile,
)
from avahazard.effects.site import Site
from avahazard.physics.cells import GRAVITY, SPEEDS, Resistance
from avahazard.physics.terrain import Terrain

QUANTILES = (0.05, 0.35, 0.65, 0.95)
"""Of the states along the paths: the knots of the curve."""
FRICTION_SD, FORCE_SD = 0.1, 0.8
"""Prior standard deviation of the rms of friction, or of force (m/s²), that goes with the state in
a line; half of it for each departure from that."""
LEAST_APART, N_GRID = 0.1, 61
"""Least distance of knots against all of their range, and places at which curves are compared."""
MOST = 4.0
"""Prior standard deviations that a coefficient can be."""
USUAL_FRICTION = 0.4
SPEED = "speed"
"""The state that is the block's own; the others are those of the ground."""


def _angle(terrain: Terrain) -> Floats:
    return np.degrees(0.5 * (terrain.theta[1:] + terrain.theta[:-1]))


def _curvature(terrain: Terrain) -> Floats:
    bend = 0.5 * (terrain.bend[1:] + terrain.bend[:-1])
    return np.asarray(-1000.0 * bend * np.cos(np.radians(_angle(terrain))))


STATES: dict[str, tuple[str, str, Callable[[Terrain], Floats]]] = {
    "slope": ("the slope of the ground", "degrees", _angle),
    "elevation": ("the elevation of the ground", "m", lambda terrain: terrain.middle_y),
    "curvature": ("the curvature of the ground", "1/km", _curvature),
    "distance": (
        "the distance along the path",
        "m",
        lambda terrain: terrain.middle_x - terrain.x[0],
    ),
}
"""State of the ground by name: what it is, its unit, and its value in each cell of a terrain."""


def _along(site: Site) -> slice:
    """Cells of a site that its blocks can come by: from the highest release to its end."""
    return slice(int(np.searchsorted(site.terrain_x, np.min(site.release_x))), None)


def _knots(values: Floats) -> Facts:
    low, *inner, high = np.quantile(values, QUANTILES).tolist()
    least = LEAST_APART * (high - low)
    knots = [low]
    knots += [k for k in inner if low + least < k < high - least and k > knots[-1] + least]
    knots += [high]
    spread = max(float(np.std(values)), 1e-6)
    return {"knots": knots, "centre": float(np.mean(values)), "scale": spread}


def _facts(state: str, _columns: EventColumns, sites: Sites) -> Facts:
    of = STATES[state][2]
    return _knots(np.concatenate([of(site.terrain)[_along(site)] for site in sites]))


def _speed_facts(columns: EventColumns, sites: Sites) -> Facts:
    """Speeds of blocks on the energy line of the usual runout."""
    known = columns.height_over_length[np.isfinite(columns.height_over_length)]
    friction = float(np.median(known)) if len(known) else USUAL_FRICTION
    speeds = []
    for site in sites:
        way = _along(site)
        x, y = site.terrain_x[way], site.heights()[way]
        square = 2.0 * GRAVITY * (y[0] - y - friction * (x - x[0]))
        speeds.append(np.sqrt(square[square > 0.0]))
    return _knots(np.append(np.concatenate(speeds), [1.0, 2.0]))


def _basis(facts: Facts, values: Floats, rest: float | None = None) -> Floats:
    """Columns `[n, n_knots - 1]` at values of the state, orthonormal over the range of the knots.

    Beyond it they stay as they are. Their mean is 0 or, where `rest` is given, they are 0 there.
    """
    knots = np.array(facts["knots"])

    def curve(at: Floats) -> Floats:
        inside = np.clip(at, knots[0] if rest is None else rest, knots[-1])
        return spline_columns(inside, knots, facts["centre"], facts["scale"])

    grid = curve(np.linspace(knots[0] if rest is None else rest, knots[-1], N_GRID))
    zero = np.mean(grid, axis=0) if rest is None else grid[0]
    _, mixed = np.linalg.qr(grid - zero)
    mixed *= np.sign(np.diag(mixed))[:, None] / np.sqrt(N_GRID)
    return np.asarray((curve(values) - zero) @ np.linalg.inv(mixed))


def _by_ground(
    state: str, facts: Facts, site: Site, resistance: Resistance, values: Floats
) -> Resistance:
    terrain = site.terrain_for(resistance)
    friction = _basis(facts, STATES[state][2](terrain)) @ values
    return replace(resistance, offset=resistance.offset + friction)


def _by_speed(facts: Facts, _site: Site, resistance: Resistance, values: Floats) -> Resistance:
    force = _basis(facts, SPEEDS, rest=0.0) @ values
    if resistance.speed_constant is not None:
        force = force + resistance.speed_constant
    return replace(resistance, speed_constant=np.asarray(force))


def _curve(state: str, facts: Facts) -> Curve:
    speed = state == SPEED
    rest = 0.0 if speed else None
    x = np.linspace(facts["knots"][0] if rest is None else rest, facts["knots"][-1], N_GRID)
    return Curve(
        of=state,
        unit="m/s" if speed else STATES[state][1],
        value="force per mass, m/s2" if speed else "friction",
        x=x,
        columns=_basis(facts, x, rest),
        rests=speed,
        form="speed_resistance" if speed else "added_friction",
        state="speeds" if speed else f"track.{state}",
        needs=("profile",),
    )


def _build(state: str, facts: Facts) -> MotionEffect:
    speed = state == SPEED
    unit, sd = ("m/s2, rms", FORCE_SD) if speed else ("friction, rms", FRICTION_SD)
    bends = [(f"bend_{k + 1}", 0.5 * sd) for k in range(len(facts["knots"]) - 2)]
    parameters = tuple(
        Parameter(name, unit, 0.0, 0.0, s, -MOST * s, MOST * s)
        for name, s in [("slope", sd), *bends]
    )
    acts = partial(_by_speed, facts) if speed else partial(_by_ground, state, facts)
    return MotionEffect(f"force:{state}", parameters, acts, speed_dependent=speed)


def _force_by(state: str, meaning: str, order: int) -> Definition:
    return Definition(
        key=f"force:{state}",
        meaning=meaning,
        needs="profile; speeds help",
        build=partial(_build, state),
        lacking=needs_profile,
        facts=_speed_facts if state == SPEED else partial(_facts, state),
        curve=partial(_curve, state),
        beyond=1,
        order=order,
    )


def _of_ground(state: str, order: int) -> Definition:
    what = STATES[state][0]
    meaning = f"Friction varies smoothly with {what}. The data choose the shape."
    return _force_by(state, meaning, order)


BY_SPEED = _force_by(
    SPEED,
    "A force varies smoothly with the speed of the avalanche, in a shape that the data choose: it "
    "is none at rest. Drag and speed-weakening are members of this family.",
    60,
)
BY_SLOPE = _of_ground("slope", 61)
BY_ELEVATION = _of_ground("elevation", 62)
BY_CURVATURE = _of_ground("curvature", 63)
BY_DISTANCE = _of_ground("distance", 64)
