"""Speeds of all tracks, and what blocks do near their records, end to end as kernels want them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.block_runs import JumpedStop
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.sight import hidden_from
from avahazard.inference.likelihood.speed_bounds import rows_left
from avahazard.inference.model.observations import LEFT, Observations, SpeedRecord
from avahazard.physics.block import LEFT_PROFILE


class MeasuredSpeeds(NamedTuple):
    """Speeds of all tracks end to end.

    `speed`, `sigma` `[n_speeds]`; those of `event[k]` begin at `first[k]` and end before `end[k]`.
    `spread` is that of each `SpeedRecord`, row by row, and begins at `first_spread[k]`; `cell[k]`
    and `jumped` `[n_speeds]` are what each `JumpedStop` has.
    """

    event: NDArray[np.int64]
    first: NDArray[np.int64]
    end: NDArray[np.int64]
    first_spread: NDArray[np.int64]
    speed: Floats
    sigma: Floats
    spread: Floats
    cell: NDArray[np.int64]
    jumped: Floats


class TrackTables(NamedTuple):
    """What blocks do near the records of the tracks, rows of frictions of all tracks end to end.

    Those of track k begin at row `begin[k]`, friction `first[k]` of the tables, and end before row
    `begin[k + 1]`; `record`, `left` `[n_rows]`, `speeds` `[n_rows, n_places]` (m/s). `event`,
    `observed_left`, `observed`, `error` `[n_tracks]` are those of the record; `hidden_from` is the
    friction from which on stops are not seen.
    """

    measured: MeasuredSpeeds
    begin: NDArray[np.int64]
    first: NDArray[np.int64]
    record: Floats
    left: NDArray[np.bool_]
    speeds: Floats
    observed_left: NDArray[np.bool_]
    observed: Floats
    error: Floats
    hidden_from: Floats

    @property
    def nbytes(self) -> int:
        """Memory of what differs from place to place."""
        return self.speeds.nbytes + self.record.nbytes + self.left.nbytes


def measured_speeds(records: Sequence[SpeedRecord], jumped: Sequence[JumpedStop]) -> MeasuredSpeeds:
    """The records of speeds end to end."""
    bounds = np.cumsum([0, *(len(r.x) for r in records)])
    spreads = np.cumsum([0, *(len(r.x) ** 2 for r in records)])
    return MeasuredSpeeds(
        event=np.array([r.event for r in records]),
        first=bounds[:-1],
        end=bounds[1:],
        first_spread=spreads[:-1],
        speed=np.concatenate([r.speed for r in records]),
        sigma=np.concatenate([r.sigma for r in records]),
        spread=np.concatenate([r.spread.ravel() for r in records]),
        cell=np.array([stop.cell for stop in jumped]),
        jumped=np.concatenate([stop.square for stop in jumped]),
    )


def track_tables(observations: Observations, predicted: Predicted) -> TrackTables:
    """The rows of the tables that the records of the tracks leave, with some beyond."""
    tracks = observations.speeds
    event = np.array([track.event for track in tracks])
    left = predicted.status[event] == LEFT_PROFILE
    observed_left = observations.kind[event] == LEFT
    observed, error = observations.observed[event], predicted.sigma[event]
    rows = rows_left(predicted.record[event], left, observed_left, observed, error)
    begin = np.concatenate([[0], np.cumsum(rows[:, 1] - rows[:, 0])])
    speeds = np.zeros((begin[-1], max(len(track.x) for track in tracks)))
    for k, (track, (first, end)) in enumerate(zip(tracks, rows, strict=True)):
        speeds[begin[k] : begin[k + 1], : len(track.x)] = predicted.speeds[k][first:end]
    whole = [(i, slice(first, end)) for i, (first, end) in zip(event, rows, strict=True)]
    return TrackTables(
        measured_speeds(tracks, predicted.jumped),
        begin,
        rows[:, 0].copy(),  # of one layout for kernels, however many tracks there are
        np.concatenate([predicted.record[part] for part in whole]),
        np.concatenate([left[k, part] for k, (_, part) in enumerate(whole)]),
        speeds,
        observed_left,
        observed,
        error,
        hidden_from(observations, predicted, in_log=False)[event],
    )
