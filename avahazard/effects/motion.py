"""Effects on the motion: drag, friction that falls with speed, cohesion, snow taken up, trees.

And the load of curvature, which the base model has. Effects with a name (drag, cohesion,
entrainment) are members of the families at the end: a resistance that varies smoothly with the
state of the block, in a shape the data choose. What no name fits is found there, with its shape.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.polynomial.legendre import legvander

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import (
    Curve,
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
from avahazard.effects.stretches import (
    all_parts,
    build_stretches,
    stretch_curve,
    stretch_facts,
    stretches_found,
)
from avahazard.notes import Note
from avahazard.physics.cells import GRAVITY, SPEEDS, Resistance
from avahazard.physics.terrain import Terrain
from avahazard.records.errors import AvahazardError

EDGE_M = 40.0
"""The snow line is blurred over this height, so that the likelihood is smooth in it."""


def _added(term: str, _site: Site, resistance: Resistance, values: Floats) -> Resistance:
    """The resistance with the same of one of its terms added everywhere."""
    return replace(resistance, **{term: getattr(resistance, term) + values[0]})


def _square(values: Floats, speeds: Floats) -> Floats:
    return np.asarray(values[0] * speeds**2)


DRAG = Parameter("drag", "1/m", 0.0, 0.0, 0.005, 0.0, 0.03)
TURBULENT_DRAG = Definition(
    key="turbulent-drag",
    meaning="The flow churns and pushes air and snow aside, which costs a force that grows with "
    "the square of speed (Voellmy). Fast avalanches are held back more than slow ones, so that "
    "long steep tracks need less friction at the bed than a Coulomb block says.",
    needs="profile; speeds help",
    build=lambda _: MotionEffect("turbulent-drag", (DRAG,), partial(_added, "drag")),
    lacking=needs_profile,
    member_of=("force:speed", _square),
    limits_speed=True,
    order=20,
)


def _weakening(_site: Site, resistance: Resistance, values: Floats) -> Resistance:
    ratio, speed = values
    factor = ratio + (1.0 - ratio) / (1.0 + SPEEDS / speed)
    return replace(resistance, speed_factor=factor * resistance.speed_factor)


WEAKENING = (
    Parameter("ratio", "", 1.0, 1.0, 0.4, 0.2, 1.0),
    Parameter("speed", "m/s", 8.0, 10.0, 8.0, 4.0, 32.0),
)
SPEED_WEAKENING = Definition(
    key="speed-weakening",
    meaning="Friction is full at rest and falls towards a part of it, `ratio`, as the avalanche "
    "speeds up; `speed` is where half of the fall is done. Fast avalanches run on as if on a "
    "lubricated bed, yet stop abruptly once they are slow.",
    needs="profile; speeds help",
    build=lambda _: MotionEffect("speed-weakening", WEAKENING, _weakening, speed_dependent=True),
    lacking=needs_profile,
    order=30,
)


STRENGTH = Parameter("strength", "m/s2", 0.0, 0.0, 1.0, 0.0, 3.5)
COHESION = Definition(
    key="cohesion",
    meaning="Snow sticks to its bed with a strength that does not depend on the load. It resists "
    "alike on steep and on gentle ground, so steep tracks brake more than friction alone says.",
    needs="profile; speeds help",
    build=lambda _: MotionEffect("cohesion", (STRENGTH,), partial(_added, "constant")),
    lacking=needs_profile,
    # As friction: its force over the load.
    member_of=("force:slope", lambda v, slope: v[0] / (GRAVITY * np.cos(np.radians(slope)))),
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
    inside = site.cover(site.terrain_for(resistance).middle_x) == FOREST
    return replace(resistance, drag=resistance.drag + values[0] * inside)


def _no_forest(columns: EventColumns, sites: Sites) -> str | None:
    covers = {str(cover) for s in sites for cover in s.profile.land_cover or ()}
    translate = "a columns.toml can translate such words by classes"
    there = f" (there is {', '.join(sorted(covers))}; {translate})" if covers else ""
    return needs_profile(columns, sites) or (
        None if FOREST in covers else f"no profile has land_cover `forest` anywhere{there}"
    )


def _seen_in(columns: EventColumns, sites: Sites) -> Note | None:
    """The paths with forest, by name."""
    wooded = [s.path.path_id for s in sites if FOREST in (s.profile.land_cover or ())]
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


ENDS, DEGREE, WITHOUT_SPEEDS = (0.03, 0.97), 4, 2
"""Quantiles of the states along the paths between which a curve varies; its degree, and that where
no speeds were measured: stops say little of a shape."""
FRICTION_SD, FORCE_SD = 0.1, 0.8
"""Prior standard deviation of the rms of friction, or of force (m/s²), that goes with the state in
a line; half of it for each departure from that."""
N_GRID = 61
"""Places at which curves are compared."""
MOST = 6.0
"""Prior standard deviations that a coefficient can be."""
USUAL_FRICTION = 0.4
SPEED, FORCE = "speed", "force per mass, m/s2"
"""The state that is the block's own, and what a curve over it is of; the others are those of the
ground, of friction."""


def _angle(terrain: Terrain) -> Floats:
    return np.degrees(0.5 * (terrain.theta[1:] + terrain.theta[:-1]))


def _curvature(terrain: Terrain) -> Floats:
    bend = 0.5 * (terrain.bend[1:] + terrain.bend[:-1])
    return np.asarray(-1000.0 * bend * np.cos(np.radians(_angle(terrain))))


STATES: dict[str, tuple[str, str, Callable[[Terrain], Floats]]] = {
    "slope": ("the slope of the ground", "degrees", _angle),
    "elevation": ("the elevation of the ground", "m", lambda t: t.middle_y),
    "curvature": ("the curvature of the ground", "1/km", _curvature),
    "distance": ("the distance along the path", "m", lambda t: t.middle_x - t.x[0]),
}
"""State of the ground by name: what it is, its unit, and its value in each cell of a terrain."""


def state_at(state: str, site: Site, x: Floats) -> Floats:
    """A state of the ground at places x (m) of a site."""
    terrain = site.terrain
    return np.asarray(np.interp(x, terrain.middle_x, STATES[state][2](terrain)))


def _along(site: Site) -> slice:
    """Cells of a site that its blocks can come by: from the highest release to its end."""
    return slice(int(np.searchsorted(site.terrain_x, np.min(site.release_x))), None)


def _facts(state: str, columns: EventColumns, sites: Sites) -> Facts:
    """The range of a state where avalanches were recorded, and the degree of its curve."""
    seen = []
    for k, site in enumerate(sites):
        stops = columns.stop_elevation[columns.path_index == k]
        lowest = np.min(stops) if len(stops) else np.nan
        way = _along(site)
        # One that ran beyond its profile has no stop: then all of the path.
        passed = ~(site.terrain.middle_y[way] < lowest)
        seen.append(STATES[state][2](site.terrain)[way][passed])
    low, high = np.quantile(np.concatenate(seen), ENDS).tolist()
    return {"low": low, "high": high, "degree": DEGREE if columns.tracks else WITHOUT_SPEEDS}


def _speed_facts(columns: EventColumns, sites: Sites) -> Facts:
    """Speeds up to the largest that was measured, or of blocks on the line of the usual runout."""
    if columns.tracks:
        largest = max(float(np.max(t.speed)) for t in columns.tracks)
        return {"low": 0.0, "high": largest, "degree": DEGREE}
    known = columns.height_over_length[np.isfinite(columns.height_over_length)]
    friction = float(np.median(known)) if len(known) else USUAL_FRICTION
    speeds = [1.0, 2.0]
    for site in sites:
        way = _along(site)
        x, y = site.terrain_x[way], site.heights()[way]
        square = 2.0 * GRAVITY * (y[0] - y - friction * (x - x[0]))
        speeds += np.sqrt(square[square > 0.0]).tolist()
    return {"low": 0.0, "high": float(np.quantile(speeds, ENDS[1])), "degree": WITHOUT_SPEEDS}


def _basis(facts: Facts, values: Floats, *, rests: bool) -> Floats:
    """Columns `[n, degree]` at values of the state: a line, then bends of ever more turns.

    Polynomials, orthonormal over the range of the facts; beyond it they stay as they are. Their
    mean is 0 or, where the effect `rests`, they are 0 at the low end.
    """
    low, high = facts["low"], facts["high"]

    def curve(at: Floats) -> Floats:
        inside = np.clip((at - low) / max(high - low, 1e-6), 0.0, 1.0)
        return legvander(2.0 * inside - 1.0, facts["degree"])[:, 1:]

    grid = curve(np.linspace(low, high, N_GRID))
    zero = grid[0] if rests else np.mean(grid, axis=0)
    _, mixed = np.linalg.qr(grid - zero)
    mixed *= np.sign(np.diag(mixed))[:, None] / np.sqrt(N_GRID)
    return np.asarray((curve(values) - zero) @ np.linalg.inv(mixed))


def _by_ground(
    state: str, facts: Facts, site: Site, resistance: Resistance, values: Floats
) -> Resistance:
    terrain = site.terrain_for(resistance)
    friction = _basis(facts, STATES[state][2](terrain), rests=False) @ values
    return replace(resistance, offset=resistance.offset + friction)


def _by_speed(facts: Facts, _site: Site, resistance: Resistance, values: Floats) -> Resistance:
    force = _basis(facts, SPEEDS, rests=True) @ values
    return replace(resistance, speed_constant=resistance.speed_constant + force)


def _curve(state: str, facts: Facts) -> Curve:
    speed = state == SPEED
    x = np.linspace(facts["low"], facts["high"], N_GRID)
    return Curve(
        of=state,
        unit="m/s" if speed else STATES[state][1],
        value=FORCE if speed else "friction",
        x=x,
        columns=_basis(facts, x, rests=speed),
        rests=speed,
        form="speed_resistance" if speed else "added_friction",
        state="speeds" if speed else f"track.{state}",
        needs=("profile",),
    )


def _build(state: str, facts: Facts) -> MotionEffect:
    if "knots" in facts:
        raise AvahazardError(
            f"The curve of force:{state} was fitted by an earlier version, in another form.",
            "Add it to its parent again.",
        )
    speed = state == SPEED
    unit, sd = ("m/s2, rms", FORCE_SD) if speed else ("friction, rms", FRICTION_SD)
    bends = [(f"bend_{k + 1}", 0.5 * sd) for k in range(facts["degree"] - 1)]
    parameters = tuple(
        Parameter(name, unit, 0.0, 0.0, s, -MOST * s, MOST * s)
        for name, s in [("slope", sd), *bends]
    )
    acts = partial(_by_speed, facts) if speed else partial(_by_ground, state, facts)
    shapes = (_drag_shape(facts),) if speed else ()
    return MotionEffect(f"force:{state}", parameters, acts, speed_dependent=speed, shapes=shapes)


def _drag_shape(facts: Facts) -> tuple[float, ...]:
    """Values of rms 1 of drag, the most usual force by speed, which has bends of its own."""
    curve = _curve(SPEED, facts)
    values = curve.values_of(_square(np.ones(1), curve.x))
    return tuple((values / np.linalg.norm(values)).tolist())


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


BY_SPEED = _force_by(
    SPEED,
    "A force varies smoothly with the speed of the avalanche, in a shape that the data choose: it "
    "is none at rest. Drag and speed-weakening are members of this family.",
    60,
)
BY_SLOPE, BY_ELEVATION, BY_CURVATURE = (
    _force_by(
        state,
        f"Friction varies smoothly with {STATES[state][0]}. The data choose the shape.",
        order,
    )
    for order, state in enumerate(("slope", "elevation", "curvature"), start=61)
)


def _distance_alternatives(columns: EventColumns, sites: Sites) -> list[Facts]:
    parts = all_parts(columns, sites)
    return [_facts("distance", columns, sites), *([parts] if parts else [])]


BY_DISTANCE = Definition(
    key="force:distance",
    meaning="A stretch of a path holds avalanches back, as a bend or rough ground does; measured "
    "speeds show where. Without them friction varies smoothly with the distance along all paths.",
    needs="profile; speeds help",
    build=lambda facts: (
        build_stretches("force:distance", facts)
        if "stretches" in facts
        else _build("distance", facts)
    ),
    lacking=needs_profile,
    facts=lambda columns, sites: (
        stretch_facts(columns, sites) or _facts("distance", columns, sites)
    ),
    alternatives=_distance_alternatives,
    curve=lambda facts: stretch_curve(facts) if "stretches" in facts else _curve("distance", facts),
    seen_in=stretches_found,
    beyond=1,
    order=64,
)
