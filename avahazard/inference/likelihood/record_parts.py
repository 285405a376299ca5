"""Nodes of many records, made some paths at a time.

The tables of an event take a hundred times as much memory as its nodes: those of a part are gone
when its nodes are made, so that they do not grow with the number of paths.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import Effect
from avahazard.inference.likelihood.kept_runs import KeptRuns
from avahazard.inference.likelihood.nodes import Nodes, needed_panels, record_nodes
from avahazard.inference.likelihood.predicted import Values
from avahazard.inference.model.observations import Observations, part_of, whole_paths

MANY_EVENTS, EVENTS_AT_ONCE = 2000, 500
"""Events from which on they come in parts, and those of a part: their tables take some 15 MB."""


@dataclass(frozen=True, slots=True)
class AskedPanels:
    """Panels of friction at these values, of a block that moves as at `moved` (`needed_panels`)."""

    values: Values
    moved: Values
    track_scatter: float
    in_log: bool

    def of(self, observations: Observations, runs: KeptRuns) -> Ints:
        """Those of observations with their runs, `[n_events]`."""
        predicted = runs.records(self.values, self.moved)
        return needed_panels(observations, predicted, self.track_scatter, self.in_log)


class RecordParts:
    """Observations of many events on profiles, without speeds, in parts of whole paths.

    Arguments as those of `KeptRuns`; the runs of the block are kept where the records are asked
    for `again` with the same.
    """

    def __init__(
        self,
        observations: Observations,
        effects: tuple[Effect, ...],
        curvature: float,
        in_sight: bool,
        again: bool,
    ) -> None:
        self._again = again
        self._n_events = observations.n_events
        self._events = whole_paths(observations, EVENTS_AT_ONCE)
        self._parts = [part_of(observations, events) for events in self._events]
        self._runs = [KeptRuns(part, effects, curvature, in_sight) for part in self._parts]

    def panels(self, asked: AskedPanels) -> Ints:
        """`needed_panels` `[n_events]`."""
        panels = np.empty(self._n_events, dtype=np.int64)
        for events, part, runs in zip(self._events, self._parts, self._runs, strict=True):
            panels[events] = asked.of(part, self._own(runs))
        return panels

    def nodes(
        self, values: Values, panels: Ints | AskedPanels, limit: Floats, in_log: bool
    ) -> tuple[Nodes, Ints]:
        """`record_nodes` of all events at these values, and the panels of friction that they have.

        `limit` `[n_events]` as there. Where the panels are asked for, the same runs serve both.
        """
        made, found = [], np.empty(self._n_events, dtype=np.int64)
        for events, part, runs in zip(self._events, self._parts, self._runs, strict=True):
            own = self._own(runs)
            found[events] = (
                panels.of(part, own) if isinstance(panels, AskedPanels) else panels[events]
            )
            predicted = own.near_records(values)
            made.append(record_nodes(part, predicted, found[events], limit[events], in_log))
        return Nodes(*(self._joined(parts) for parts in zip(*made, strict=True))), found

    def emptied(self) -> RecordParts:
        """The same without the runs kept so far."""
        other = copy(self)
        other._runs = [runs.emptied() for runs in self._runs]
        return other

    def _own(self, runs: KeptRuns) -> KeptRuns:
        return runs if self._again else runs.emptied()

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
    many = observations.n_events > MANY_EVENTS
    return many and len(observations.sites) > 1 and not observations.speeds
