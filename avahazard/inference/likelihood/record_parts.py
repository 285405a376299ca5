"""Nodes of many records, made some paths at a time.

The tables of an event take a hundred times as much memory as its nodes: those of a part are gone
when its nodes are made, so that they do not grow with the number of paths.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import Effect
from avahazard.inference.likelihood.kept_runs import KeptRuns
from avahazard.inference.likelihood.nodes import Nodes, needed_panels, record_nodes
from avahazard.inference.likelihood.predicted import Values
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.part_of import part_of, whole_paths

EVENTS_AT_ONCE = 2000
"""Events of a part: their tables take some 60 MB."""


class RecordParts:
    """Observations of many events on profiles, without speeds, in parts of whole paths.

    Arguments as those of `KeptRuns`; the runs of the block are not kept.
    """

    def __init__(
        self,
        observations: Observations,
        effects: tuple[Effect, ...],
        curvature: float,
        in_sight: bool,
    ) -> None:
        self._n_events = observations.n_events
        self._events = whole_paths(observations, EVENTS_AT_ONCE)
        self._parts = [part_of(observations, events) for events in self._events]
        self._runs = [KeptRuns(part, effects, curvature, in_sight) for part in self._parts]

    def panels(self, values: Values, moved: Values, track_scatter: float, in_log: bool) -> Ints:
        """`needed_panels` `[n_events]` at these values, of a block that moves as at `moved`."""
        panels = np.empty(self._n_events, dtype=np.int64)
        for events, part, runs in zip(self._events, self._parts, self._runs, strict=True):
            predicted = runs.emptied().records(values, moved)
            panels[events] = needed_panels(part, predicted, track_scatter, in_log)
        return panels

    def nodes(self, values: Values, panels: Ints, limit: Floats, in_log: bool) -> Nodes:
        """`record_nodes` of all events at these values; `limit` `[n_events]` as there."""
        made = [
            record_nodes(
                part, runs.emptied().near_records(values), panels[events], limit[events], in_log
            )
            for events, part, runs in zip(self._events, self._parts, self._runs, strict=True)
        ]
        return Nodes(*(self._joined(parts) for parts in zip(*made, strict=True)))

    def _joined(self, parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Rows of all parts in the order of the events, as wide as the widest."""
        width = [max(sides) for sides in zip(*(part.shape[1:] for part in parts), strict=True)]
        whole = np.zeros((self._n_events, *width), dtype=parts[0].dtype)
        for events, part in zip(self._events, parts, strict=True):
            if part.ndim == 1:
                whole[events] = part
            else:
                whole[events, : part.shape[1]] = part
        return whole


def in_parts(observations: Observations) -> bool:
    """Whether the events are many, on profiles and without speeds."""
    many = observations.n_events > EVENTS_AT_ONCE
    return many and len(observations.sites) > 1 and not observations.speeds
