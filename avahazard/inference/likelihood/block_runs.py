"""Runs of the block on every site, over all frictions of the grid or near records alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import Effect, MotionEffect, of_kind
from avahazard.effects.site import ALL_FRICTIONS, KEPT_TERRAINS, Site
from avahazard.inference.model.observations import LEFT, Observations, SpeedRecord
from avahazard.physics.cells import Cells
from avahazard.physics.near_stops import Asked, NearStops
from avahazard.physics.resistance import Resistance, no_resistance
from avahazard.physics.runout_curve import RunoutCurve
from avahazard.workers import ordered_map

SITES_AT_ONCE = KEPT_TERRAINS // 2
"""Sites whose blocks are run together: their terrains are made once."""
Values = dict[str, Floats]
"""Parameter values by effect key."""


class JumpedStop(NamedTuple):
    """The cell of frictions over which F jumps across the recorded stop of a track; -1 for none.

    No friction that is the same all along stops the block there. `square` `[n_speeds]` is u² with
    the friction that, on the mean of the way, brings it to rest at the record; it can be below 0.
    """

    cell: int
    square: Floats


def resistance_of(
    site: Site, effects: tuple[Effect, ...], values: Values, curvature: float
) -> Resistance:
    """The resistance on a site with the effects on the motion at these values.

    An effect at its neutral value is left out, so that the result is the base model's bit for
    bit.
    """
    active = [
        effect
        for effect in of_kind(effects, MotionEffect)
        if not np.array_equal(values[effect.key], effect.neutral)
    ]
    fine = any(e.speed_dependent for e in active)
    base = no_resistance(site.fine_terrain if fine else site.terrain)
    resistance = Resistance(base.factor, base.offset, base.constant, base.drag, curvature)
    for effect in active:
        resistance = effect.resistance(site, resistance, values[effect.key])
    return resistance


@dataclass(frozen=True, slots=True, eq=False)
class BlockRuns:
    """Tables of every site, and of each `SpeedRecord` what `Predicted` has of it.

    `middle` are, for runs near some stops, the middles of the frictions run from each release of
    each site.
    """

    tables: tuple[RunoutCurve, ...]
    speeds: tuple[Floats, ...]
    jumped: tuple[JumpedStop, ...]
    middle: tuple[Ints, ...] | None = None


def run_blocks(
    observations: Observations,
    effects: tuple[Effect, ...],
    values: Values,
    curvature: float = 1.0,
    asked: Sequence[Asked] | None = None,
) -> BlockRuns:
    """Run every site's block; only effects on the motion matter here.

    With stops `asked` for from each release of each site, near these alone.
    """
    path = observations.columns.path_index
    of_path: dict[int, list[SpeedRecord]] = {}
    for track in observations.speeds:
        of_path.setdefault(int(path[track.event]), []).append(track)
    tables: list[RunoutCurve] = []
    middle: list[Ints] = []
    told: dict[int, tuple[Floats, JumpedStop]] = {}
    moved = bool(of_kind(effects, MotionEffect))
    # Some at a time: cells are large, and gone when their tables are made.
    for first in range(0, len(observations.sites), SITES_AT_ONCE):
        sites = observations.sites[first : first + SITES_AT_ONCE]
        resistances = [resistance_of(site, effects, values, curvature) for site in sites]
        if moved:
            for site, resistance in zip(sites, resistances, strict=True):
                site.keep_terrain(resistance)
        cells = list(ordered_map(Site.cells, sites, resistances))
        if asked is None:
            tables += ordered_map(Site.table, sites, cells)
            near = None
        else:
            near = list(ordered_map(Site.table_near, sites, cells, asked[first:]))
            tables += [found.curve for found in near]
            middle += [(found.first + found.end) // 2 for found in near]
        tracks = [track for k in range(len(sites)) for track in of_path.get(first + k, ())]
        its = [int(path[track.event]) for track in tracks]
        found = ordered_map(
            partial(_speeds_of, observations),
            tracks,
            [tables[k] for k in its],
            [cells[k - first] for k in its],
            [None if near is None else near[k - first] for k in its],
        )
        told |= zip((track.event for track in tracks), found, strict=True)
    each = [told[track.event] for track in observations.speeds]
    return BlockRuns(
        tables=tuple(tables),
        speeds=tuple(speeds for speeds, _ in each),
        jumped=tuple(jumped for _, jumped in each),
        middle=None if asked is None else tuple(middle),
    )


def _speeds_of(
    observations: Observations,
    track: SpeedRecord,
    table: RunoutCurve,
    cells: Cells,
    near: NearStops | None,
) -> tuple[Floats, JumpedStop]:
    """The speeds of a track, at the frictions that were run, and where F jumps over its stop."""
    release = observations.release[track.event]
    site = observations.sites[int(observations.columns.path_index[track.event])]
    some = ALL_FRICTIONS
    if near is not None:
        some = slice(int(near.first[release]), int(near.end[release]))
    speeds = site.speeds(cells, float(site.release_x[release]), track.x, some)
    return speeds, _jumped(observations, track, table, cells)


def _jumped(
    observations: Observations, track: SpeedRecord, table: RunoutCurve, cells: Cells
) -> JumpedStop:
    """Where F jumps over the stop of a track."""
    i = track.event
    none = JumpedStop(-1, np.zeros(len(track.x)))
    if observations.kind[i] == LEFT:
        return none
    curve = table[int(observations.release[i])]
    passes = curve.left | (curve.x > track.stop_x)
    ends = np.flatnonzero(passes[:-1] & ~passes[1:])
    over = [cell for cell in ends.tolist() if curve.is_broken(cell)]
    if not over:
        return none
    site = observations.sites[int(observations.columns.path_index[i])]
    release_x = float(site.release_x[observations.release[i]])
    square = site.squares_to_rest(cells, release_x, track.stop_x, track.x)
    return JumpedStop(int(over[-1]), square)
