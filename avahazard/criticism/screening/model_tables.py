"""Tables of a model with other effects or settings, made some paths at a time.

What the block would leave as records takes ten times the memory of the tables made of it: of many
events at once it finds no room in caches, and the system clears its pages anew each time.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.criticism.screening.laplace_fit import Edges
from avahazard.criticism.screening.tables import Tables, make_tables
from avahazard.effects.effect import Effect
from avahazard.inference.likelihood.block_runs import BlockRuns, Values, run_blocks
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.likelihood.record_parts import EVENTS_AT_ONCE, in_parts
from avahazard.inference.likelihood.stops_asked import stops_asked
from avahazard.inference.model.observations import Observations, part_of, whole_paths


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
    records alone or all over.
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


COLUMNS = ("record", "bounds", "last_left", "hidden_from", "about", "height", "sigma")
"""Columns of `Tables` that have a row for each event."""
