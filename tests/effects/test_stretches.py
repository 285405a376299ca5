"""Stretches of single paths: found where measured speeds fall, and the block on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.arrays import Floats
from avahazard.effects.catalogue import definition
from avahazard.effects.columns import EventColumns, MeasuredTrack
from avahazard.effects.effect import MotionEffect
from avahazard.effects.stretches import all_parts, stretch_facts
from avahazard.physics.cells import GRAVITY, no_resistance
from avahazard.physics.speed import speeds_along
from tests.effects.examples import columns, sites

KEY = "force:distance"
LOW_M, HIGH_M = 480.0, 620.0


def tracks(rng: np.random.Generator, drag: float, friction: float) -> EventColumns:
    """Speeds along twelve avalanches of the first path, whose stretch adds to what resists."""
    given, site = columns(), sites()[0]
    terrain = site.terrain
    middle = terrain.middle_x
    inside = (middle >= LOW_M) & (middle < HIGH_M)
    still = no_resistance(terrain)
    resistance = replace(still, drag=drag * inside, offset=friction * inside)
    cells = site.cells(resistance)
    events = np.flatnonzero(given.path_index == 0)
    found = []
    for k in range(12):
        start = float(site.release_x[k % len(site.release_x)])
        x = np.sort(rng.uniform(start + 40.0, 850.0, 10))
        mu = rng.uniform(0.25, 0.33, 1)
        speed = speeds_along(cells, int(np.searchsorted(cells.x, start)), mu, x)[0]
        sigma = np.full(len(x), 1.0)
        measured = np.maximum(speed + rng.normal(size=len(x)), 0.0)
        event, end = int(events[k % len(events)]), site.smooth.x_max
        found.append(MeasuredTrack(event, x, measured, sigma, start, end, left=True))
    return replace(given, tracks=tuple(found))


@pytest.mark.parametrize(("drag", "friction"), [(0.004, 0.0), (0.0, 0.5)])
def test_a_stretch_that_brakes_is_found_where_it_is(drag: float, friction: float) -> None:
    facts = stretch_facts(tracks(np.random.default_rng(1), drag, friction), sites())
    assert facts is not None
    path, start, end = facts["stretches"][0]
    assert path == sites()[0].path.path_id
    if friction:  # a drag over so short a stretch does much the same
        assert facts["kind"] == "friction"
    # Speeds are some 60 m apart: so well are its ends known.
    assert abs(start - LOW_M) < 60.0
    assert abs(end - HIGH_M) < 60.0


@pytest.mark.parametrize("seed", range(5))
def test_nothing_is_found_where_friction_alone_resists(seed: int) -> None:
    assert stretch_facts(tracks(np.random.default_rng(seed), 0.0, 0.0), sites()) is None


def test_without_speeds_it_is_a_curve_along_all_paths() -> None:
    assert stretch_facts(columns(), sites()) is None
    assert all_parts(columns(), sites()) is None
    entry = definition(KEY)
    facts = entry.facts(columns(), sites())
    assert "degree" in facts
    assert entry.alternatives is not None
    assert entry.alternatives(columns(), sites()) == [facts]


def block(values: Floats, x: Floats) -> Floats:
    """Speeds of a block on the first path with stretches on two."""
    names = [site.path.path_id for site in sites()]
    stretches = [[names[0], LOW_M, HIGH_M], [names[1], LOW_M, HIGH_M]]
    made = definition(KEY).build({"kind": "friction", "stretches": stretches, "ends": [0.0, 900.0]})
    assert isinstance(made, MotionEffect)
    assert made.paths == tuple(names[:2])
    site = sites()[0]
    cells = site.cells(made.resistance(site, no_resistance(site.terrain), values))
    start = int(np.searchsorted(cells.x, site.release_x[0]))
    return np.asarray(speeds_along(cells, start, np.array([0.3]), x)[0])


def test_a_stretch_acts_on_its_path_alone() -> None:
    x = np.array([LOW_M - 60.0, HIGH_M + 60.0])
    bare = block(np.zeros(2), x)
    np.testing.assert_array_equal(block(np.array([0.0, 0.4]), x), bare)
    braked = block(np.array([0.2, 0.0]), x)
    assert braked[0] == pytest.approx(bare[0], abs=0.05)
    # The work of 0.2 g over its length, by hand.
    lost = bare[1] ** 2 - braked[1] ** 2
    assert lost == pytest.approx(2.0 * 0.2 * GRAVITY * (HIGH_M - LOW_M), rel=0.15)


def test_where_it_is_stands_in_a_sentence_and_a_curve() -> None:
    given = tracks(np.random.default_rng(1), 0.0, 0.5)
    entry = definition(KEY)
    facts = entry.facts(given, sites())
    path, start, end = facts["stretches"][0]
    said = str(entry.seen_in(given, sites()))
    assert f"{path} ({start:.0f} m – {end:.0f} m)" in said
    assert entry.seen_in(columns(), sites()) is None
    curve = entry.curve(facts)
    assert curve is not None
    assert curve.path == path
    inside = curve.columns[:, 0] > 0.0
    assert curve.x[inside][0] == start
    assert curve.x[np.flatnonzero(inside)[-1] + 1] == end


def test_one_speed_of_each_avalanche_shows_no_stretch() -> None:
    """It goes to the friction of its track."""
    given = tracks(np.random.default_rng(1), 0.0, 0.5)
    few = [replace(t, x=t.x[-1:], speed=t.speed[-1:], sigma=t.sigma[-1:]) for t in given.tracks]
    assert stretch_facts(replace(given, tracks=tuple(few)), sites()) is None
