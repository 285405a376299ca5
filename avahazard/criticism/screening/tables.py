"""Tables of a model's expected records in the form of the screening."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avahazard.arrays import Floats, Ints
from avahazard.criticism.screening.laplace_fit import Edges
from avahazard.criticism.screening.speed_points import STRETCH, SpeedGrid
from avahazard.effects.effect import Effect
from avahazard.inference.likelihood.node_charts import EVENTS_AT_ONCE, in_parts
from avahazard.inference.likelihood.predicted import (
    BlockRuns,
    Predicted,
    Values,
    predict_records,
    run_blocks,
    stops_asked,
)
from avahazard.inference.likelihood.record_nodes import hidden_from
from avahazard.inference.likelihood.track_nodes import squares
from avahazard.inference.model.observations import LENGTH, Observations, part_of, whole_paths
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU

LOG_MU = np.log(MU)
SPEED_STRIDE = 4
COLUMNS = ("record", "bounds", "last_left", "hidden_from", "about", "height", "sigma")
"""Columns of `Tables` that have a row for each event."""


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
    detected, detected_sd = np.where(declared, edge, 9.0), np.zeros(n)
    estimated = np.isfinite(limit) & np.isnan(observations.limit)
    has_limit = declared | (estimated & np.isfinite(predicted.elevation).all(axis=1))
    for i in np.flatnonzero(has_limit & estimated):
        chance = ndtr((limit[i] - predicted.elevation[i]) / predicted.sigma[i])
        # What goes further than a detected stop is detected, up the other side of a valley too.
        chance = np.maximum.accumulate(np.where(left[i], 1.0, chance)[::-1])[::-1]
        drop = -np.diff(chance)
        total = float(np.sum(drop))
        if total < 1e-6:
            has_limit[i] = False
            continue
        detected[i] = float(np.sum(drop * middle)) / total
        detected_sd[i] = np.sqrt(
            max(float(np.sum(drop * (middle - detected[i]) ** 2)) / total, 0.0)
        )
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
        edges=Edges(leave, predicted.leaving_sigma, detected, detected_sd, has_limit),
        speeds=_speed_grid(observations, predicted, track_scatter),
    )


def with_scatter(tables: Tables, track_scatter: float) -> Tables:
    """The same with another scatter of friction along tracks; arrays are shared."""
    return replace(tables, speeds=tables.speeds._replace(scatter=float(track_scatter)))


def record_bounds(record: NDArray[np.float32]) -> NDArray[np.float32]:
    """Lowest and highest record of each stretch of frictions, `[n_events, n_stretches, 2]`."""
    starts = np.arange(0, max(record.shape[1] - 1, 1), STRETCH)
    low, high = np.minimum.reduceat(record, starts, 1), np.maximum.reduceat(record, starts, 1)
    # A cell reaches to the first point of the next stretch.
    after = record[:, np.minimum(starts + STRETCH, record.shape[1] - 1)]
    return np.stack([np.minimum(low, after), np.maximum(high, after)], axis=2)


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


def model_tables(
    observations: Observations,
    effects: tuple[Effect, ...],
    values: Values,
    curvature: float,
    limit: Floats,
    track_scatter: float,
    about: Floats,
    runs: BlockRuns | None = None,
    near: bool = False,
) -> Tables:
    """Tables of these effects at their values; `limit`, `about` `[n_events]` as in `make_tables`.

    `curvature` and `runs` are those of `predict_records`; without runs blocks are run, `near` the
    records alone or all over. They are made some paths at a time: what the block would leave as
    records takes ten times the memory of the tables made of it.
    """

    def of(part: Observations, events: Ints, runs: BlockRuns | None) -> Tables:
        if runs is None:
            asked = stops_asked(part, effects, values) if near else None
            runs = run_blocks(part, effects, values, curvature, asked)
        predicted = predict_records(part, effects, values, curvature, runs)
        return make_tables(part, predicted, limit[events], track_scatter, about[events])

    everyone = np.arange(observations.n_events)
    if not in_parts(observations) or np.any(observations.columns.path_index < 0):
        return of(observations, everyone, runs)
    whole: Tables | None = None
    for events in whole_paths(observations, EVENTS_AT_ONCE):
        part = part_of(observations, events)
        own = None if runs is None else _runs_of(observations, events, runs)
        made = of(part, events, own)
        whole = _room(made, observations.n_events) if whole is None else whole
        _put(whole, made, events)
    assert whole is not None
    return whole


def _runs_of(observations: Observations, events: Ints, runs: BlockRuns) -> BlockRuns:
    """The runs on the sites of these events."""
    path = observations.columns.path_index[events]
    return BlockRuns(tuple(runs.tables[k] for k in np.unique(path[path >= 0])), (), ())


def _room(part: Tables, n_events: int) -> Tables:
    """Tables as long as all events, of the kind of a part's."""

    def room(column: Any) -> Any:
        return np.empty((n_events, *column.shape[1:]), dtype=column.dtype)

    return replace(
        part,
        **{name: room(getattr(part, name)) for name in COLUMNS},
        edges=Edges(*map(room, part.edges)),
        speeds=part.speeds._replace(row=np.full(n_events, -1)),
    )


def _put(whole: Tables, part: Tables, events: Ints) -> None:
    """Put a part's rows where its events are."""
    for name in COLUMNS:
        getattr(whole, name)[events] = getattr(part, name)
    for column, rows in zip(whole.edges, part.edges, strict=True):
        column[events] = rows
