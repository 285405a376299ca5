"""Tables of a model's expected records in the form of the screening."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avahazard.arrays import Floats
from avahazard.criticism.screening.laplace_fit import Edges
from avahazard.criticism.screening.speed_points import SpeedGrid
from avahazard.criticism.screening.stop_moments import record_bounds
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.sight import hidden_from
from avahazard.inference.likelihood.speed_nodes import squares
from avahazard.inference.model.observations import LENGTH, Observations
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU

LOG_MU = np.log(MU)
SPEED_STRIDE = 4


@dataclass(frozen=True, slots=True, eq=False)
class Tables:
    """What one set of tables says of every event.

    `record` `[n_events, n_friction]` (float32) and its `record_bounds`, `last_left` `[n_events]`,
    `hidden_from` `[n_events]` (log friction from which on stops are above a declared limit),
    `about` `[n_events]` (the log friction that the model itself expects, nan: none),
    `height` `[n_events]` of fall (m) where there is no profile (else nan), `sigma` `[n_events]` (m)
    of the records, edges of leaving and of sight, and speeds.
    """

    record: NDArray[np.float32]
    bounds: NDArray[np.float32]
    last_left: NDArray[np.int64]
    hidden_from: Floats
    about: Floats
    height: Floats
    sigma: Floats
    edges: Edges
    speeds: SpeedGrid


def make_tables(
    observations: Observations,
    predicted: Predicted,
    limit: Floats,
    track_scatter: float,
    about: Floats | None = None,
) -> Tables:
    """Tables in the screening's form; `limit` `[n_events]` as in `build_nodes`."""
    left = predicted.status == LEFT_PROFILE
    n = len(left)
    last_left = np.where(left.any(axis=1), left.shape[1] - 1 - np.argmax(left[:, ::-1], axis=1), -1)
    middle = 0.5 * (LOG_MU[1:] + LOG_MU[:-1])
    leave = np.where(last_left >= 0, middle[np.clip(last_left, 0, len(middle) - 1)], -9.0)
    edge = hidden_from(observations, predicted)
    declared = np.isfinite(edge)
    seen, seen_sd = np.where(declared, edge, 9.0), np.zeros(n)
    estimated = np.isfinite(limit) & np.isnan(observations.limit)
    has_limit = declared | (estimated & np.isfinite(predicted.elevation).all(axis=1))
    for i in np.flatnonzero(has_limit & estimated):
        chance = ndtr((limit[i] - predicted.elevation[i]) / predicted.sigma[i])
        # What goes further than a stop that is seen is seen, up the other side of a valley too.
        chance = np.maximum.accumulate(np.where(left[i], 1.0, chance)[::-1])[::-1]
        drop = -np.diff(chance)
        total = float(np.sum(drop))
        if total < 1e-6:
            has_limit[i] = False
            continue
        seen[i] = float(np.sum(drop * middle)) / total
        seen_sd[i] = np.sqrt(max(float(np.sum(drop * (middle - seen[i]) ** 2)) / total, 0.0))
    # Without any profile nobody looks a record up.
    looked_up = predicted.record if observations.sites else np.zeros((n, 1))
    record = looked_up.astype(np.float32)
    return Tables(
        record=record,
        bounds=record_bounds(record),
        last_left=last_left.astype(np.int64),
        hidden_from=edge,
        about=np.full(n, np.nan) if about is None else about,
        height=np.where(observations.kind == LENGTH, observations.fall_height, np.nan),
        sigma=predicted.sigma,
        edges=Edges(leave, predicted.leaving_sigma, seen, seen_sd, has_limit),
        speeds=_speed_grid(observations, predicted, track_scatter),
    )


def with_scatter(tables: Tables, track_scatter: float) -> Tables:
    """The same with another scatter of friction along tracks; arrays are shared."""
    return replace(tables, speeds=tables.speeds._replace(scatter=float(track_scatter)))


def _speed_grid(observations: Observations, predicted: Predicted, scatter: float) -> SpeedGrid:
    row = np.full(observations.n_events, -1, dtype=np.int64)
    widest = max((len(m.x) for m in observations.speeds), default=1)
    n_rows = max(1, len(observations.speeds))
    coarse = np.zeros((n_rows, len(MU[::SPEED_STRIDE]), widest), dtype=np.float32)
    sigma, jumped = np.ones((n_rows, widest)), np.zeros((n_rows, widest))
    cell = np.full(n_rows, -1)
    for r, (measured, speeds) in enumerate(zip(observations.speeds, predicted.speeds, strict=True)):
        k = len(measured.x)
        row[measured.event] = r
        coarse[r, :, :k] = squares(speeds[::SPEED_STRIDE])
        sigma[r, :k] = measured.sigma
        cell[r] = predicted.jumped[r].cell
        jumped[r, :k] = predicted.jumped[r].square
    return SpeedGrid(row, coarse, SPEED_STRIDE, cell, jumped, sigma, float(scatter))
