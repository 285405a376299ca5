"""Where a block must stop for its friction to count in the likelihood of the records.

What records leave of friction is a small part of the tables: blocks that stop many errors away say
nothing. So where parameters move the block, it is run near the records alone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import Effect, LimitEffect, of_kind
from avahazard.effects.site import Site
from avahazard.inference.likelihood.block_runs import BlockRuns, Values
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import LEFT, Observations
from avahazard.physics.block import LEFT_PROFILE, STOPPED
from avahazard.physics.near_stops import Asked
from avahazard.physics.runout_curve import MU, RunoutCurve

FAR = 9.0
"""Errors of a record beyond which nothing counts: more than `record_density.REACH`, so that what
tails have at the ends of the tables is nought there too."""


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
        mine = np.flatnonzero(observations.columns.path_index == k)
        low = ground.x[0, np.maximum(first[mine] - 1, 0)]
        high = ground.x[0, np.minimum(last[mine] + 1, len(MU) - 1)]
        # Speeds tell apart the frictions that left.
        high[left[mine] & with_speeds[mine]] = np.inf
        release, n = observations.release[mine], len(site.release_x)
        lowest, highest = np.full(n, np.inf), np.full(n, -np.inf)
        np.minimum.at(lowest, release, low)
        np.maximum.at(highest, release, high)
        asked.append(Asked(lowest, highest, np.full(n, len(MU) // 4)))
    return tuple(asked)


def sight_is_limited(observations: Observations, effects: Sequence[Effect]) -> bool:
    """Whether stops may not be seen: then frictions count that stop a block far from the record."""
    return bool(np.any(np.isfinite(observations.limit)) or of_kind(effects, LimitEffect))


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
    """First and last place `[n_events]` between which records are within `FAR`; else the nearest.

    `z` `[n_events, n_places]` are, in errors, the records of blocks at rest there.
    """
    low, high = np.minimum(z[:, 1:], z[:, :-1]), np.maximum(z[:, 1:], z[:, :-1])
    near = (low <= FAR) & (high >= -FAR)
    some = near.any(axis=1)
    nearest = np.argmin(np.where(np.isnan(z), np.inf, np.abs(z)), axis=1)
    first = np.where(some, np.argmax(near, axis=1), nearest)
    last = np.where(some, z.shape[1] - 1 - np.argmax(near[:, ::-1], axis=1), nearest)
    return first, last
