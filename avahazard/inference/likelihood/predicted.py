"""What the model says would be recorded, for every event and friction of the grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Effect, FrontEffect, RecordErrorEffect, ShiftEffect, of_kind
from avahazard.effects.site import Site
from avahazard.inference.likelihood.block_runs import BlockRuns, JumpedStop, Values, run_blocks
from avahazard.inference.model.observations import LENGTH, PLACE, Observations
from avahazard.physics.block import LEFT_PROFILE, STOPPED
from avahazard.physics.runout_curve import MU, RunoutCurve


@dataclass(frozen=True, slots=True, eq=False)
class Predicted:
    """The record to be expected, `[n_events, n_friction]` over `runout_curve.MU`.

    `record` is in the coordinate of each event's record; `x`, `elevation` (m) are its place in
    any case (nan without a profile), `status` that of `block.Stops`; where the block left, they
    are those of the profile's end. `speeds`: for each
    `SpeedRecord` the speeds at its places, `[n_friction, n_speeds]`; `jumped` likewise. `sigma`
    `[n_events]` (m): the error of the records, as stated or as an effect scales it;
    `leaving_sigma` likewise that of the log of the friction under which the block leaves. `raised`
    `[n_events]` (m) is by how much records lie too high, which is in `elevation`.
    """

    record: Floats
    x: Floats
    elevation: Floats
    status: NDArray[np.int8]
    speeds: tuple[Floats, ...]
    jumped: tuple[JumpedStop, ...]
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
    n = observations.n_events
    if not observations.sites:
        return _straight(observations, effects, values)
    x, y = np.empty((n, len(MU))), np.empty((n, len(MU)))
    status = np.empty((n, len(MU)), dtype=np.int8)
    nowhere = observations.columns.path_index < 0
    x[nowhere] = y[nowhere] = np.nan
    status[nowhere] = STOPPED
    runs = run_blocks(observations, effects, values, curvature) if runs is None else runs
    advance = front_ahead(observations.columns, effects, values)
    for k, site in enumerate(observations.sites):
        mine = np.flatnonzero(observations.columns.path_index == k)
        front = fronts(site, runs.tables[k][observations.release[mine]], advance[mine])
        x[mine], y[mine], status[mine] = front.x, front.y, front.status
    raised = raised_by(observations, effects, values)
    y += raised[:, None]
    record = _recorded(observations, x, y)
    sigma = record_sigma(observations, effects, values)
    return Predicted(
        record=record,
        x=x,
        elevation=y,
        status=status,
        speeds=runs.speeds,
        jumped=runs.jumped,
        sigma=sigma,
        leaving_sigma=observations.leaving_sigma * (sigma / observations.sigma),
        raised=raised,
    )


def _recorded(observations: Observations, x: Floats, y: Floats) -> Floats:
    """Of places (x, y) `[n_events, n_friction]` what is recorded of each event."""
    in_x, straight = observations.kind == PLACE, observations.kind == LENGTH
    if in_x.all():
        return x
    record = np.where(in_x[:, None], x, y)
    record[straight] = _lengths(observations.fall_height[straight])
    return record


def _straight(observations: Observations, effects: tuple[Effect, ...], values: Values) -> Predicted:
    """The same without any profile, where one number stands for all places."""
    shape = observations.n_events, len(MU)
    nowhere = np.broadcast_to(np.nan, shape)
    return Predicted(
        record=_lengths(observations.fall_height),
        x=nowhere,
        elevation=nowhere,
        status=np.broadcast_to(np.int8(STOPPED), shape),
        speeds=(),
        jumped=(),
        sigma=record_sigma(observations, effects, values),
        leaving_sigma=np.zeros(observations.n_events),
        raised=np.zeros(observations.n_events),
    )


def _lengths(fall_height: Floats) -> Floats:
    """Without a profile the block runs on the energy line: L = H / μ."""
    return np.asarray(fall_height[:, None] / MU)


def record_sigma(observations: Observations, effects: tuple[Effect, ...], values: Values) -> Floats:
    """Error of the records `[n_events]` (m), with the factors of effects on it."""
    sigma = observations.sigma
    for effect in of_kind(effects, RecordErrorEffect):
        sigma = effect.scale(values[effect.key]) * sigma
    return sigma


def raised_by(observations: Observations, effects: tuple[Effect, ...], values: Values) -> Floats:
    """Metres by which effects raise the recorded elevations `[n_events]`."""
    total = np.zeros(observations.n_events)
    for effect in of_kind(effects, ShiftEffect):
        total = total + effect.shift(observations.columns, values[effect.key])
    return total


def front_ahead(columns: EventColumns, effects: tuple[Effect, ...], values: Values) -> Floats:
    """Metres `[n_events]` along the path by which the records are ahead of the block."""
    total = np.zeros(len(columns))
    for effect in of_kind(effects, FrontEffect):
        total = total + effect.advance(columns, values[effect.key])
    return total


def fronts(site: Site, block: RunoutCurve, advance: Floats) -> RunoutCurve:
    """Where fronts stop that are `advance` `[n_rows]` (m) ahead of the block `[n_rows, …]`.

    What left the profile passed its end at least, and is there.
    """
    x = np.where(block.left, site.smooth.x_max, block.x)
    y = np.where(block.left, site.end_y, block.y)
    status = block.status.copy()
    ahead = advance != 0.0
    if ahead.any():
        front = _ahead(site, x[ahead], advance[ahead])
        # The front may have passed the end of the profile where the block did not.
        status[ahead] = np.where(front > site.smooth.x_max, LEFT_PROFILE, status[ahead])
        x[ahead] = np.minimum(front, site.smooth.x_max)
        y[ahead] = site.smooth.height(x[ahead])
    return RunoutCurve(x, y, status)


def _ahead(site: Site, x: Floats, distance: Floats) -> Floats:
    """x of places `distance` metres along the path ahead of x `[n, n_friction]`."""
    terrain = site.terrain
    s = np.interp(x, terrain.x, terrain.s) + distance[:, None]
    beyond = np.maximum(s - terrain.s[-1], 0.0)
    return np.asarray(np.interp(s, terrain.s, terrain.x) + beyond)
