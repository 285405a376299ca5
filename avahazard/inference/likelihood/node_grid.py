"""Nodes at the grid points of the parameters that shape the tables, and between them."""

from __future__ import annotations

from copy import copy
from functools import cached_property
from itertools import product

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import (
    Effect,
    LimitEffect,
    MotionEffect,
    RecordErrorEffect,
    of_kind,
)
from avahazard.inference.likelihood.block_runs import Values
from avahazard.inference.likelihood.interpolation import (
    Corners,
    interpolated,
    line_weights,
    packed,
    stack,
    unpacked,
)
from avahazard.inference.likelihood.keeping import LEAST_KEPT, MOST_BYTES, make_room, within
from avahazard.inference.likelihood.kept_runs import KeptRuns
from avahazard.inference.likelihood.nodes import (
    Nodes,
    build_nodes,
    record_nodes,
    with_tracks,
)
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.record_parts import AskedPanels, RecordParts, in_parts
from avahazard.inference.likelihood.speed_nodes import track_nodes
from avahazard.inference.likelihood.stops_asked import sight_is_limited
from avahazard.inference.likelihood.track_tables import TrackTables, track_tables
from avahazard.inference.likelihood.wrong_records import log_wrong
from avahazard.inference.model.layout import Layout
from avahazard.inference.model.observations import Observations

KEPT_STACKS = 64
"""Neighbourhoods of grid points whose nodes are kept side by side."""
KEPT_BETWEEN = 4
"""Places between grid points whose nodes are kept."""
KEPT_PLACES = 512
"""Places of the grids for which it is kept what is known before scatters along tracks."""
NODE_BYTES = 8 * MOST_BYTES
"""Memory of the nodes of all grid points: those of a thousand events at a thousand points."""


class NodeGrid:
    """What the records say of friction, for every value of the parameters that shape the tables.

    These are the parameters of effects on the motion and on the record, and the scatter of
    friction along tracks. Tables and nodes are built where needed on the grids of `layout` and
    kept. `curvature` is that of `run_blocks`, `in_log` that of `build_nodes`.
    """

    def __init__(
        self,
        observations: Observations,
        effects: tuple[Effect, ...],
        layout: Layout,
        curvature: float,
        in_log: bool,
    ) -> None:
        self.observations = observations
        self.effects = effects
        self.layout = layout
        self.in_log = in_log
        self._axes = layout.tables + (
            () if layout.track_scatter is None else (layout.track_scatter,)
        )
        self._in_sight = not sight_is_limited(observations, effects)
        of_block = observations, effects, curvature, self._in_sight
        self._runs = KeptRuns(*of_block)
        # Runs of blocks that no parameter moves serve all points of the grids.
        near = self._in_sight and len(of_kind(effects, MotionEffect)) > 0
        again = len(layout.tables) > 0 and not near
        self._parts = RecordParts(*of_block, again) if in_parts(observations) else None
        self._untracked: dict[tuple[float, ...], Nodes] = {}
        self._track_tables: dict[tuple[bytes, ...], TrackTables] = {}
        self._track_events = np.array([track.event for track in observations.speeds], np.int64)
        self._packed: dict[tuple[float, ...], Nodes] = {}
        self._panels: Ints | None = None
        self._forget()

    @cached_property
    def _log_wrong(self) -> Floats:
        return log_wrong(self.observations)

    def _forget(self) -> None:
        self._between: dict[tuple[float, ...], Nodes] = {}
        self._points: dict[tuple[int, ...], Nodes] = {}
        self._stacks: dict[tuple[tuple[int, int], ...], Corners] = {}

    def forget_runs(self) -> None:
        """Give back the memory of runs; nodes on the present grids stay, others are made anew."""
        self._runs = self._runs.emptied()
        self._parts = None if self._parts is None else self._parts.emptied()
        self._stacks, self._untracked, self._track_tables = {}, {}, {}
        grids = [set(self.layout.slots[axis].grid) for axis in self._axes]
        self._packed = {
            at: nodes
            for at, nodes in self._packed.items()
            if all(v in grid for v, grid in zip(at, grids, strict=True))
        }

    def regridded(self, layout: Layout) -> NodeGrid:
        """The same on the grids of another layout; what is made at places of both is shared."""
        self.panels()  # the same for both
        other = copy(self)
        other.layout = layout
        other._forget()
        return other

    @property
    def varies(self) -> bool:
        """Whether nodes depend on the coordinates at all."""
        return len(self._axes) > 0

    def at(self, u: Floats) -> Nodes:
        """Nodes at coordinates u, interpolated between those of the grid points."""
        place = tuple(float(u[axis]) for axis in self._axes)
        if place not in self._between:
            made = self._at(place)
            # Differences are taken by coordinates of which most leave the place as it is.
            make_room(self._between, KEPT_BETWEEN)
            self._between[place] = made
        return self._between[place]

    def _at(self, place: tuple[float, ...]) -> Nodes:
        """The same at these coordinates of the axes."""
        grids = [self.layout.slots[axis].grid for axis in self._axes]
        lines = [line_weights(grid, value) for grid, value in zip(grids, place, strict=True)]
        if all(len(line.linear) == 1 for line in lines):
            return self.point(tuple(line.first for line in lines))
        windows = tuple((line.first, len(line.linear)) for line in lines)
        return interpolated(lines, self._corners(windows))

    def _corners(self, windows: tuple[tuple[int, int], ...]) -> Corners:
        """Nodes of all grid points in these windows (first index, width), stacked and kept."""
        if windows not in self._stacks:
            ranges = [range(first, first + width) for first, width in windows]
            stacked = stack([self._of_point(index) for index in product(*ranges)])
            make_room(self._stacks, within(KEPT_STACKS, stacked.nbytes))
            self._stacks[windows] = stacked
        return self._stacks[windows]

    def point(self, index: tuple[int, ...]) -> Nodes:
        """Nodes at one point of the grids, that of the scatter along tracks last."""
        if index not in self._points:
            nodes = unpacked(self._of_point(index))
            make_room(self._points, LEAST_KEPT)
            self._points[index] = nodes
        return self._points[index]

    def _of_point(self, index: tuple[int, ...]) -> Nodes:
        """The same, packed and kept by the values of the parameters there."""
        n_tables = len(self.layout.tables)
        at = tuple(
            self.layout.slots[axis].grid[k] for axis, k in zip(self._axes, index, strict=True)
        )
        if at not in self._packed:
            values = self._values(index[:n_tables])
            nodes, tables = self._told(at[:n_tables], values)
            if tables is not None:
                scatter = float(np.exp(at[-1])) if len(at) > n_tables else 0.0
                panels = self.panels()[self._track_events]
                tracks = track_nodes(tables, scatter, panels, self.in_log)
                nodes = with_tracks(nodes, self._track_events, tracks)
            nodes = packed(nodes, self._in_sight)
            size = sum(part.nbytes for part in nodes)
            make_room(self._packed, max(LEAST_KEPT, NODE_BYTES // max(size, 1)))
            self._packed[at] = nodes
        return self._packed[at]

    def _told(self, at: tuple[float, ...], values: Values) -> tuple[Nodes, TrackTables | None]:
        """What is known at these values of the tables' parameters before scatters along tracks.

        Nodes of the events without speeds; of those with speeds, which no limit of sight moves,
        the tables (None if there are none).
        """
        limits = {effect.key for effect in of_kind(self.effects, LimitEffect)}
        key = tuple(v.tobytes() for name, v in values.items() if name not in limits)
        measured = len(self.observations.speeds) > 0
        if self._parts is not None:  # packed, they are kept
            return self._in_parts(self._parts, values), None
        if at not in self._untracked or (measured and key not in self._track_tables):
            predicted = self._runs.near_records(values)
            if measured and key not in self._track_tables:
                tables = track_tables(self.observations, predicted)
                make_room(self._track_tables, within(KEPT_PLACES, tables.nbytes))
                self._track_tables[key] = tables
            if at not in self._untracked:
                made = record_nodes(
                    *(self.observations, predicted, self.panels(), self._limit(values)),
                    self.in_log,
                )._replace(log_wrong=self._log_wrong)
                make_room(self._untracked, within(KEPT_PLACES, sum(part.nbytes for part in made)))
                self._untracked[at] = made
        return self._untracked[at], self._track_tables.get(key)

    def panels(self) -> Ints:
        """Panels of friction for each event `[n_events]`, the same at every point of the grids.

        They are those of the neutral model with the largest errors of the records.
        """
        if self._panels is None:
            asked = self._asked_panels()
            self._panels = (
                asked.of(self.observations, self._runs)
                if self._parts is None
                else self._parts.panels(asked)
            )
        return self._panels

    def _asked_panels(self) -> AskedPanels:
        u = np.array([0.0 if np.isnan(s.neutral) else s.neutral for s in self.layout.slots])
        values = self.layout.effect_values(u)
        for effect in of_kind(self.effects, RecordErrorEffect):
            place = self.layout.places[effect.key]
            u[place] = [max(slot.grid) for slot in self.layout.slots[place]]
        slot = self.layout.track_scatter
        scatter = 0.0 if slot is None else float(np.exp(self.layout.slots[slot].mean))
        return AskedPanels(self.layout.effect_values(u), values, scatter, self.in_log)

    def _in_parts(self, parts: RecordParts, values: Values) -> Nodes:
        """Nodes of the records at these values, some paths at a time."""
        panels = self._asked_panels() if self._panels is None else self._panels
        nodes, self._panels = parts.nodes(values, panels, self._limit(values), self.in_log)
        return nodes._replace(log_wrong=self._log_wrong)

    def exact(self, u: Floats) -> Nodes:
        """Nodes from tables made for just these coordinates."""
        if not self.varies:
            return self.point(())
        slot = self.layout.track_scatter
        values = self.layout.effect_values(u)
        if self._parts is not None:
            return self._in_parts(self._parts, values)
        nodes = build_nodes(
            self.observations,
            self._runs.near_records(values),
            0.0 if slot is None else float(np.exp(u[slot])),
            self._limit(values),
            self.in_log,
            self.panels(),
        )
        return nodes._replace(log_wrong=self._log_wrong)

    def predicted(self, index: tuple[int, ...]) -> Predicted:
        """Tables of expected records at one point of the grids."""
        return self._runs.records(self._values(index[: len(self.layout.tables)]))

    def predicted_at(self, u: Floats) -> Predicted:
        """Tables of expected records at coordinates u; where blocks move by them, run afresh."""
        return self._runs.fresh_records(self.layout.effect_values(u))

    def _values(self, index: tuple[int, ...]) -> Values:
        u = np.array([0.0 if np.isnan(s.neutral) else s.neutral for s in self.layout.slots])
        for axis, k in zip(self._axes, index, strict=False):
            u[axis] = self.layout.slots[axis].grid[k]
        return self.layout.effect_values(u)

    def _limit(self, values: Values) -> Floats:
        limit = self.observations.limit
        for effect in of_kind(self.effects, LimitEffect):
            limit = effect.limit(self.observations.columns, values[effect.key])
        return limit
