"""Runs of the block for a model's effects, kept where they are asked for again.

What records leave of friction is a small part of the tables: blocks that stop many errors away say
nothing. So where parameters move the block, it is run near the records alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import TypeVar

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import Effect, LimitEffect, MotionEffect, RecordEffect, of_kind
from avahazard.effects.site import Site
from avahazard.inference.likelihood.predicted import (
    BlockRuns,
    Predicted,
    Values,
    predict_records,
    run_blocks,
)
from avahazard.inference.model.observations import LEFT, Observations
from avahazard.physics.block import LEFT_PROFILE, STOPPED
from avahazard.physics.runout_curve import MU, Asked, RunoutCurve

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


FAR = 9.0
"""Errors of a record beyond which nothing counts: more than `record_nodes.REACH`, so that what
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


KEPT_RUNS = 64
"""Runs of the block (several MB each)."""
KEPT_ASKED = 16
"""Values of effects on the record for which it is kept where blocks must stop."""
RUN_BYTES = 17 * len(MU)
"""Bytes of one curve of a run (x, elevation, status)."""


class KeptRuns:
    """Runs on the sites of observations; `curvature` is that of `run_blocks`.

    Without a motion among the effects, or with a limit of sight (not `in_sight`), blocks are run
    over all frictions wherever their records lie, else `near` these.
    """

    def __init__(
        self,
        observations: Observations,
        effects: tuple[Effect, ...],
        curvature: float,
        in_sight: bool,
    ) -> None:
        self._observations = observations
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

    def emptied(self) -> KeptRuns:
        """The same without the runs kept so far."""
        other = copy(self)
        other._runs = {}
        return other

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
            n_curves = sum(len(site.release_x) for site in self._observations.sites)
            n_speeds = sum(len(track.x) for track in self._observations.speeds)
            size = n_curves * RUN_BYTES + n_speeds * 8 * len(MU)
            runs = run_blocks(self._observations, self._effects, values, self._curvature)
            keep(self._runs, key, runs, KEPT_RUNS, size)
        return self._runs[key]

    def _predicted(self, values: Values, runs: BlockRuns | None) -> Predicted:
        return predict_records(self._observations, self._effects, values, self._curvature, runs)

    def _near_runs(self, values: Values) -> BlockRuns:
        """Runs of the block near the records; not kept, as nodes are."""
        on_record = of_kind(self._effects, RecordEffect)
        key = tuple(values[e.key].tobytes() for e in on_record)
        if key not in self._asked:
            found = stops_asked(self._observations, self._effects, values)
            keep(self._asked, key, found, KEPT_ASKED)
        runs = run_blocks(
            self._observations, self._effects, values, self._curvature, self._asked[key]
        )
        assert runs.middle is not None
        # The next place is near this one, and so are its frictions.
        self._asked[key] = tuple(
            asked._replace(middle=middle)
            for asked, middle in zip(self._asked[key], runs.middle, strict=True)
        )
        return runs
