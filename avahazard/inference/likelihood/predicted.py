"""Runs of the block on every site, and what the model says would be recorded of each event."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import repeat
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import (
    Effect,
    FrontEffect,
    MotionEffect,
    RecordEffect,
    RecordErrorEffect,
    ShiftEffect,
    of_kind,
)
from avahazard.effects.site import ALL, KEPT_TERRAINS, Site
from avahazard.inference.model.observations import LEFT, LENGTH, PLACE, Observations, SpeedRecord
from avahazard.physics.block import LEFT_PROFILE, STOPPED, Asked
from avahazard.physics.cells import Cells, Resistance, no_resistance
from avahazard.physics.runout_curve import MU, NearStops, RunoutCurve, as_near_stops
from avahazard.physics.speed import squares_to_rest
from avahazard.physics.terrain import node_of
from avahazard.workers import ordered_map

SITES_AT_ONCE = KEPT_TERRAINS // 2
"""Sites whose blocks are run together: their terrains are made once."""
Values = dict[str, Floats]
"""Parameter values by effect key."""


class TrackSpeeds(NamedTuple):
    """Speeds (m/s) of the block at the places of a `SpeedRecord`, `[n_friction, n_speeds]`.

    In `cell` F jumps across the recorded stop (-1 for none): no friction that is the same all
    along stops the block there. `at_jump` `[n_speeds]` is u² with the friction that, on the mean
    of the way, brings it to rest at the record; it can be below 0.
    """

    speed: Floats
    cell: int
    at_jump: Floats


def resistance_of(
    site: Site, effects: tuple[Effect, ...], values: Values, curvature: float
) -> Resistance:
    """The resistance on a site with the effects on the motion at these values.

    Bit for bit the base model's with effects at their neutral values.
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
    """Tables of every site, and the `speeds` at each `SpeedRecord`.

    `middle` are the middles of the frictions run from each release of each site.
    """

    tables: tuple[RunoutCurve, ...]
    speeds: tuple[TrackSpeeds, ...]
    middle: tuple[Ints, ...]


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
    path, tracks = observations.columns.path_index, observations.speeds
    site_of = np.array([path[track.event] for track in tracks], np.int64)
    tables: list[NearStops] = []
    speeds: dict[int, TrackSpeeds] = {}
    moved = bool(of_kind(effects, MotionEffect))
    # Some at a time: cells are large, and gone when their tables are made.
    for first in range(0, len(observations.sites), SITES_AT_ONCE):
        sites = observations.sites[first : first + SITES_AT_ONCE]
        resistances = [resistance_of(site, effects, values, curvature) for site in sites]
        if moved:
            for site, resistance in zip(sites, resistances, strict=True):
                site.keep_terrain(resistance)
        cells = list(ordered_map(Site.cells, sites, resistances))
        near = list(
            ordered_map(_table, sites, cells, repeat(None) if asked is None else asked[first:])
        )
        tables += near
        here = np.flatnonzero((site_of >= first) & (site_of < first + len(sites))).tolist()
        found = ordered_map(
            partial(_speeds_of, observations, asked is None),
            [tracks[k] for k in here],
            [cells[k] for k in site_of[here] - first],
            [near[k] for k in site_of[here] - first],
        )
        speeds |= zip(here, found, strict=True)
    return BlockRuns(
        tables=tuple(found.curve for found in tables),
        speeds=tuple(speeds[k] for k in range(len(tracks))),
        middle=tuple((found.first + found.end) // 2 for found in tables),
    )


def _table(site: Site, cells: Cells, asked: Asked | None) -> NearStops:
    return as_near_stops(site.table(cells)) if asked is None else site.table_near(cells, asked)


def _speeds_of(
    observations: Observations, whole: bool, track: SpeedRecord, cells: Cells, near: NearStops
) -> TrackSpeeds:
    """The speeds of a track, at the frictions that were run."""
    release = int(observations.release[track.event])
    site = observations.sites[int(observations.columns.path_index[track.event])]
    release_x = float(site.release_x[release])
    some = slice(int(near.first[release]), int(near.end[release]))
    speeds = site.speeds(cells, release_x, track.x, ALL if whole else some)
    over: list[int] = []
    if observations.kind[track.event] != LEFT:
        curve = near.curve[release]
        passes = curve.left | (curve.x > track.stop_x)
        ends = np.flatnonzero(passes[:-1] & ~passes[1:])
        over = ends[curve.discontinuous[ends]].tolist()
    if not over:
        return TrackSpeeds(speeds, -1, np.zeros(len(track.x)))
    square = squares_to_rest(cells, node_of(cells.x, release_x), track.stop_x, track.x)
    return TrackSpeeds(speeds, over[-1], square)


@dataclass(frozen=True, slots=True, eq=False)
class Predicted:
    """The record to be expected, `[n_events, n_friction]` over `runout_curve.MU`.

    `record` is in the coordinate of each event's record; `x`, `elevation` (m) are its place in
    any case (nan without a profile), `status` that of `block.Stops`; where the block left, they
    are those of the profile's end. `speeds` are those at each `SpeedRecord`. `sigma` `[n_events]`
    (m): the error of the records, as stated or as an effect scales it; `leaving_sigma` likewise
    that of the log of the friction under which the block leaves. `raised` `[n_events]` (m) is by
    how much records lie too high, which is in `elevation`.
    """

    record: Floats
    x: Floats
    elevation: Floats
    status: NDArray[np.int8]
    speeds: tuple[TrackSpeeds, ...]
    sigma: Floats
    leaving_sigma: Floats
    raised: Floats

    @property
    def curve(self) -> RunoutCurve:
        """F(μ) of every event, by x and elevation."""
        return RunoutCurve(self.x, self.elevation, self.status)


def predict_records(
    observations: Observations,
    effects: tuple[Effect, ...],
    values: Values,
    curvature: float = 1.0,
    runs: BlockRuns | None = None,
) -> Predicted:
    """Gather what each event would have left as its record, from runs of every site's block.

    `runs` may be given where the effects on the motion are those of an earlier call.
    """
    runs = run_blocks(observations, effects, values, curvature) if runs is None else runs
    raised = raised_by(observations, effects, values)
    stops = _stops(observations, runs, front_ahead(observations.columns, effects, values), raised)
    sigma = record_sigma(observations, effects, values)
    return Predicted(
        record=_recorded(observations, stops.x, stops.y),
        x=stops.x,
        elevation=stops.y,
        status=stops.status,
        speeds=runs.speeds,
        sigma=sigma,
        leaving_sigma=observations.leaving_sigma * (sigma / observations.sigma),
        raised=raised,
    )


def _stops(
    observations: Observations, runs: BlockRuns, advance: Floats, raised: Floats
) -> RunoutCurve:
    """Where the front of each event stops, its elevation `raised`; nan without a profile."""
    shape, path = (observations.n_events, len(MU)), observations.columns.path_index
    if not observations.sites:  # one number stands for all places
        nowhere = np.broadcast_to(np.nan, shape)
        return RunoutCurve(nowhere, nowhere, np.broadcast_to(np.int8(STOPPED), shape))
    x, y = np.full(shape, np.nan), np.full(shape, np.nan)
    status = np.full(shape, STOPPED, np.int8)
    for k, site in enumerate(observations.sites):
        selected = np.flatnonzero(path == k)
        front = fronts(site, runs.tables[k][observations.release[selected]], advance[selected])
        x[selected], y[selected], status[selected] = front.x, front.y, front.status
    y += raised[:, None]
    return RunoutCurve(x, y, status)


def _recorded(observations: Observations, x: Floats, y: Floats) -> Floats:
    """Of places (x, y) `[n_events, n_friction]` what is recorded of each event."""
    in_x, straight = observations.kind == PLACE, observations.kind == LENGTH
    if in_x.all():
        return x
    record = np.where(in_x[:, None], x, y)
    # Without a profile the block runs on the energy line: L = H / μ.
    record[straight] = observations.fall_height[straight, None] / MU
    return record


def record_sigma(observations: Observations, effects: tuple[Effect, ...], values: Values) -> Floats:
    """Error of the records `[n_events]` (m), with the factors of effects on it."""
    sigma = observations.sigma
    for effect in of_kind(effects, RecordErrorEffect):
        sigma = float(np.exp(values[effect.key][0])) * sigma
    return sigma


def raised_by(observations: Observations, effects: tuple[Effect, ...], values: Values) -> Floats:
    """Metres by which effects raise the recorded elevations `[n_events]`."""
    shifts = of_kind(effects, ShiftEffect)
    each = (e.shift(observations.columns, values[e.key]) for e in shifts)
    return sum(each, start=np.zeros(observations.n_events))


def front_ahead(columns: EventColumns, effects: tuple[Effect, ...], values: Values) -> Floats:
    """Metres `[n_events]` along the path by which the records are ahead of the block."""
    each = (e.advance(columns, values[e.key]) for e in of_kind(effects, FrontEffect))
    return sum(each, start=np.zeros(len(columns)))


def fronts(site: Site, block: RunoutCurve, advance: Floats) -> RunoutCurve:
    """Where fronts stop that are `advance` `[n_rows]` (m) ahead of the block `[n_rows, …]`.

    A runout beyond the profile passed at least its end, and counts there.
    """
    x = np.where(block.left, site.smooth.x_max, block.x)
    y = np.where(block.left, site.end_y, block.y)
    status = block.status.copy()
    ahead = advance != 0.0
    if ahead.any():
        terrain = site.terrain
        s = np.interp(x[ahead], terrain.x, terrain.s) + advance[ahead, None]
        beyond = np.maximum(s - terrain.s[-1], 0.0)
        front = np.interp(s, terrain.s, terrain.x) + beyond
        # The front may have passed the end of the profile where the block did not.
        status[ahead] = np.where(front > site.smooth.x_max, LEFT_PROFILE, status[ahead])
        x[ahead] = np.minimum(front, site.smooth.x_max)
        y[ahead] = site.smooth.height(x[ahead])
    return RunoutCurve(x, y, status)


Key = TypeVar("Key")
T = TypeVar("T")

MOST_BYTES, LEAST_KEPT = 64_000_000, 2
"""Memory of what is kept of one kind, and how many are kept whatever they take."""


def keep(kept: dict[Key, T], key: Key, value: T, most: int, size: int = 0) -> T:
    """Keep a value of `size` bytes beside `most` - 1 others, fewer where they are large.

    The oldest goes first.
    """
    room = max(LEAST_KEPT, min(most, MOST_BYTES // max(size, 1)))
    while len(kept) >= room:
        del kept[next(iter(kept))]
    kept[key] = value
    return value


FAR = 7.5
"""Errors of a record beyond which nothing counts: more than `record_nodes.REACH`, so that what
tails have at the ends of the tables is zero there too."""


def stops_asked(
    observations: Observations, effects: tuple[Effect, ...], values: Values
) -> tuple[Asked, ...]:
    """The stops asked for on each site, from each release those of all its events."""
    grounds = [_at_rest(site) for site in observations.sites]
    at_rest = predict_records(observations, effects, values, runs=BlockRuns(tuple(grounds), (), ()))
    z = (at_rest.record - observations.observed[:, None]) / at_rest.sigma[:, None]
    first, last = _within(z)
    left = observations.kind == LEFT
    # The front of a block that rests short of the end may have left.
    gone = at_rest.status == LEFT_PROFILE
    gone[:, -1] = True
    first = np.where(left, np.argmax(gone, axis=1), first)
    last = np.where(left, len(MU) - 1, last)
    with_speeds = np.zeros(observations.n_events, dtype=np.bool_)
    with_speeds[[track.event for track in observations.speeds]] = True
    asked = []
    for k, (site, ground) in enumerate(zip(observations.sites, grounds, strict=True)):
        selected = np.flatnonzero(observations.columns.path_index == k)
        low = ground.x[0, np.maximum(first[selected] - 1, 0)]
        high = ground.x[0, np.minimum(last[selected] + 1, len(MU) - 1)]
        # Speeds distinguish the frictions beyond the profile.
        high[left[selected] & with_speeds[selected]] = np.inf
        release, n = observations.release[selected], len(site.release_x)
        lowest, highest = np.full(n, np.inf), np.full(n, -np.inf)
        np.minimum.at(lowest, release, low)
        np.maximum.at(highest, release, high)
        asked.append(Asked(lowest, highest, np.full(n, len(MU) // 4)))
    return tuple(asked)


def _at_rest(site: Site) -> RunoutCurve:
    """Blocks at rest all along the path instead of those at each friction, for every release."""
    x = np.linspace(site.smooth.x_min, site.smooth.x_max, len(MU))
    shape = len(site.release_x), len(MU)
    return RunoutCurve(
        np.broadcast_to(x, shape),
        np.broadcast_to(site.smooth.height(x), shape),
        np.broadcast_to(np.int8(STOPPED), shape),
    )


def _within(z: Floats) -> tuple[Ints, Ints]:
    """First and last place `[n_events]` with records within `FAR` errors z `[n_events, n_places]`.

    The nearest place where there is none.
    """
    low, high = np.minimum(z[:, 1:], z[:, :-1]), np.maximum(z[:, 1:], z[:, :-1])
    near = (low <= FAR) & (high >= -FAR)
    some = near.any(axis=1)
    nearest = np.argmin(np.where(np.isnan(z), np.inf, np.abs(z)), axis=1)
    first = np.where(some, np.argmax(near, axis=1), nearest)
    last = np.where(some, z.shape[1] - 1 - np.argmax(near[:, ::-1], axis=1), nearest)
    return first, last


KEPT_RUNS = 64
"""Runs of the block (several MB each)."""
KEPT_ASKED = 16
"""Values of effects on the record for which it is kept where blocks must stop."""
RUN_BYTES = 17 * len(MU)
"""Bytes of one curve of a run (x, elevation, status)."""


class KeptRuns:
    """Runs on the sites of observations; `curvature` is that of `run_blocks`.

    Without a motion among the effects, or with a detection limit (not `in_sight`), blocks are run
    over all frictions wherever their records lie, else `near` these.
    """

    def __init__(
        self,
        observations: Observations,
        effects: tuple[Effect, ...],
        curvature: float,
        in_sight: bool,
    ) -> None:
        self.observations = observations
        self._effects = effects
        self._curvature = curvature
        self._moving = of_kind(effects, MotionEffect)
        # What sight is limited of is looked at over all frictions.
        self.near = in_sight and len(self._moving) > 0
        self._runs: dict[tuple[bytes, ...], BlockRuns] = {}
        self._asked: dict[tuple[bytes, ...], tuple[Asked, ...]] = {}

    def forget(self) -> None:
        """Give back the memory of the runs kept so far."""
        self._runs.clear()

    def records(self, values: Values, moved: Values | None = None) -> Predicted:
        """Tables of expected records at these values, of a block that moves as at `moved`."""
        return self._predicted(values, self._block_runs(values if moved is None else moved))

    def fresh_records(self, values: Values) -> Predicted:
        """The same; where blocks move by the values, they are run afresh and not kept."""
        return self._predicted(values, None if self._moving else self._block_runs(values))

    def near_records(self, values: Values) -> Predicted:
        """Tables of expected records, which nodes are made of: right near the records alone."""
        return self._predicted(
            values, self._near_runs(values) if self.near else self._block_runs(values)
        )

    def _block_runs(self, values: Values) -> BlockRuns:
        """Runs of the block, kept: effects on the record alone leave them as they are."""
        key = tuple(values[effect.key].tobytes() for effect in self._moving)
        if key not in self._runs:
            n_curves = sum(len(site.release_x) for site in self.observations.sites)
            n_speeds = sum(len(track.x) for track in self.observations.speeds)
            size = n_curves * RUN_BYTES + n_speeds * 8 * len(MU)
            runs = run_blocks(self.observations, self._effects, values, self._curvature)
            keep(self._runs, key, runs, KEPT_RUNS, size)
        return self._runs[key]

    def _predicted(self, values: Values, runs: BlockRuns | None) -> Predicted:
        return predict_records(self.observations, self._effects, values, self._curvature, runs)

    def _near_runs(self, values: Values) -> BlockRuns:
        """Runs of the block near the records; not kept, as nodes are."""
        on_record = of_kind(self._effects, RecordEffect)
        key = tuple(values[e.key].tobytes() for e in on_record)
        if key not in self._asked:
            found = stops_asked(self.observations, self._effects, values)
            keep(self._asked, key, found, KEPT_ASKED)
        runs = run_blocks(
            self.observations, self._effects, values, self._curvature, self._asked[key]
        )
        # The next place is near this one, and so are its frictions.
        self._asked[key] = tuple(
            asked._replace(middle=middle)
            for asked, middle in zip(self._asked[key], runs.middle, strict=True)
        )
        return runs
