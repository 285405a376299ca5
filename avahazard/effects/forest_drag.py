"""Drag inside forest cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Facts, MotionEffect, Parameter, needs_profile
from avahazard.effects.site import Site
from avahazard.notes import Note
from avahazard.physics.cells import Resistance

FOREST = "forest"


def _resistance(site: Site, resistance: Resistance, values: Floats) -> Resistance:
    inside = site.cover(site.terrain_for(resistance)) == FOREST
    return replace(resistance, drag=resistance.drag + values[0] * inside)


def _lacking(columns: EventColumns, sites: Sequence[Site]) -> str | None:
    forested = any(s.land_cover is not None and FOREST in s.land_cover for s in sites)
    return needs_profile(columns, sites) or (
        None if forested else "no profile has land_cover `forest` anywhere"
    )


def _seen_in(columns: EventColumns, sites: Sequence[Site]) -> Note | None:
    """The paths with forest, by name."""
    wooded = [s.path.path_id for s in sites if s.land_cover is not None and FOREST in s.land_cover]
    if not wooded:
        return None
    events = int(np.isin(np.array([*columns.paths, ""])[columns.path_index], wooded).sum())
    return Note("forested", paths=wooded, n=len(wooded), events=events, total=len(columns))


def _build(_facts: Facts) -> MotionEffect:
    drag = Parameter("drag", "1/m", 0.0, 0.0, 0.02, 0.0, 0.1)
    return MotionEffect("forest-drag", (drag,), resistance=_resistance)


DEFINITION = Definition(
    key="forest-drag",
    meaning="Trees brake the flow while it runs through forest (Feistl and others 2014: snow is "
    "left behind stems). Only the forested part of a path is slowed, so stops gather in or just "
    "below the forest.",
    needs="land_cover",
    build=_build,
    lacking=_lacking,
    seen_in=_seen_in,
    trees=True,
    order=60,
)
