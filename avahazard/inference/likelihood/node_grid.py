"""Nodes at the grid points of the parameters that shape the tables, and between them."""

from __future__ import annotations

from copy import copy
from functools import reduce
from itertools import product

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import Effect
from avahazard.inference.likelihood.interpolation import (
    interpolated,
    line_weights,
    packed,
    stack,
    unpacked,
)
from avahazard.inference.likelihood.nodes import (
    Nodes,
    build_nodes,
    needed_panels,
    record_nodes,
    speed_nodes,
)
from avahazard.inference.likelihood.predicted import (
    BlockRuns,
    Predicted,
    Values,
    predict_records,
    run_blocks,
)
from avahazard.inference.likelihood.wrong_records import log_wrong
from avahazard.inference.model.layout import Layout
from avahazard.inference.model.observations import Observations
from avahazard.physics.runout_curve import MU

KEPT_STACKS, KEPT_RUNS = 64, 64
"""Neighbourhoods of grid points whose nodes are kept side by side, and runs of the block (several
MB each)."""
MOST_BYTES, LEAST_KEPT = 64_000_000, 2
"""Memory of what is kept of each of these two, and how many are kept whatever they take."""
NODE_BYTES = 8 * MOST_BYTES
"""Memory of the nodes of all grid points: those of a thousand events at a thousand points."""
RUN_BYTES = 17 * len(MU)
"""Bytes of one curve of a run (x, elevation, status)."""


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
        self.curvature = curvature
        self.in_log = in_log
        self._log_wrong = log_wrong(observations)
        self._axes = layout.tables + (
            () if layout.track_scatter is None else (layout.track_scatter,)
        )
        self._in_sight = bool(np.all(np.isnan(observations.limit))) and not any(
            e.limit for e in effects
        )
        self._runs: dict[tuple[bytes, ...], BlockRuns] = {}
        self._panels: Ints | None = None
        self._forget()

    def _forget(self) -> None:
        self._packed: dict[tuple[int, ...], tuple[Nodes, ...]] = {}
        self._points: dict[tuple[int, ...], Nodes] = {}
        self._stacks: dict[tuple[tuple[int, int], ...], Nodes] = {}

    @property
    def _speed_bytes(self) -> int:
        """Bytes of the speeds of one run of the block."""
        return 8 * len(MU) * sum(len(track.x) for track in self.observations.speeds)

    def forget_runs(self) -> None:
        """Give back the memory of runs; nodes stay, others are run anew if asked."""
        self._runs = {}
        self._stacks = {}

    def regridded(self, layout: Layout) -> NodeGrid:
        """The same on the grids of another layout; runs of the block are shared."""
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
        lines = [line_weights(self.layout.slots[a].grid, float(u[a])) for a in self._axes]
        if all(len(line.cubic) == 1 for line in lines):
            return self.point(tuple(line.first for line in lines))
        return interpolated(
            reduce(np.multiply.outer, [np.array(line.cubic) for line in lines]).ravel(),
            reduce(np.multiply.outer, [np.array(line.linear) for line in lines]).ravel(),
            self._corners(tuple((line.first, len(line.cubic)) for line in lines)),
        )

    def _corners(self, windows: tuple[tuple[int, int], ...]) -> Nodes:
        """Nodes of all grid points in these windows (first index, width), stacked and kept."""
        if windows not in self._stacks:
            ranges = [range(first, first + width) for first, width in windows]
            stacked = stack([self._of_point(index) for index in product(*ranges)])
            make_room(self._stacks, within(KEPT_STACKS, sum(part.nbytes for part in stacked)))
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
        """The same, packed and kept."""
        n_tables = len(self.layout.tables)
        key = index[:n_tables]
        if key not in self._packed:
            # All scatters along tracks get asked for, and the tables are too large to be kept.
            made = self._along_tracks(key)
            size = sum(part.nbytes for nodes in made for part in nodes)
            make_room(self._packed, max(LEAST_KEPT, NODE_BYTES // max(size, 1)))
            self._packed[key] = made
        return self._packed[key][index[-1] if len(index) > n_tables else 0]

    def _along_tracks(self, key: tuple[int, ...]) -> tuple[Nodes, ...]:
        """Packed nodes at one point of the tables' grids, for every scatter along tracks."""
        values, panels = self._values(key), self.panels()
        predicted = self.predicted(key)
        records = record_nodes(
            self.observations, predicted, panels, self._limit(values), self.in_log
        )._replace(log_wrong=self._log_wrong)
        slot = self.layout.track_scatter
        scatters = [0.0] if slot is None else np.exp(self.layout.slots[slot].grid).tolist()
        nodes = speed_nodes(records, self.observations, predicted, panels, scatters, self.in_log)
        return tuple(packed(one, self._in_sight) for one in nodes)

    def panels(self) -> Ints:
        """Panels of friction for each event `[n_events]`, the same at every point of the grids.

        They are those of the neutral model with the largest errors of the records.
        """
        if self._panels is None:
            u = np.array([0.0 if np.isnan(s.neutral) else s.neutral for s in self.layout.slots])
            values = self.layout.effect_values(u)
            for effect in self.effects:
                if effect.record_scale is not None:
                    place = self.layout.places[effect.key]
                    u[place] = [max(slot.grid) for slot in self.layout.slots[place]]
            scaled = self.layout.effect_values(u)
            predicted = predict_records(
                self.observations, self.effects, scaled, self.curvature, self._block_runs(values)
            )
            slot = self.layout.track_scatter
            scatter = 0.0 if slot is None else float(np.exp(self.layout.slots[slot].mean))
            self._panels = needed_panels(self.observations, predicted, scatter, self.in_log)
        return self._panels

    def exact(self, u: Floats) -> Nodes:
        """Nodes from tables made for just these coordinates."""
        if not self.varies:
            return self.point(())
        slot = self.layout.track_scatter
        nodes = build_nodes(
            self.observations,
            self.predicted_at(u),
            0.0 if slot is None else float(np.exp(u[slot])),
            self._limit(self.layout.effect_values(u)),
            self.in_log,
            self.panels(),
        )
        return nodes._replace(log_wrong=self._log_wrong)

    def predicted(self, index: tuple[int, ...]) -> Predicted:
        """Tables of expected records at one point of the grids."""
        values = self._values(index[: len(self.layout.tables)])
        return predict_records(
            self.observations, self.effects, values, self.curvature, self._block_runs(values)
        )

    def predicted_at(self, u: Floats) -> Predicted:
        """Tables of expected records at coordinates u; where blocks move by them, run afresh."""
        values = self.layout.effect_values(u)
        moves = any(effect.motion is not None for effect in self.effects)
        runs = None if moves else self._block_runs(values)
        return predict_records(self.observations, self.effects, values, self.curvature, runs)

    def _block_runs(self, values: Values) -> BlockRuns:
        """Runs of the block, kept: effects on the record alone leave them as they are."""
        moving = tuple(values[e.key].tobytes() for e in self.effects if e.motion is not None)
        if moving not in self._runs:
            size = sum(len(site.release_x) for site in self.observations.sites) * RUN_BYTES
            size += self._speed_bytes
            make_room(self._runs, within(KEPT_RUNS, size))
            self._runs[moving] = run_blocks(self.observations, self.effects, values, self.curvature)
        return self._runs[moving]

    def _values(self, index: tuple[int, ...]) -> Values:
        u = np.array([0.0 if np.isnan(s.neutral) else s.neutral for s in self.layout.slots])
        for axis, k in zip(self._axes, index, strict=False):
            u[axis] = self.layout.slots[axis].grid[k]
        return self.layout.effect_values(u)

    def _limit(self, values: Values) -> Floats:
        limit = self.observations.limit
        for effect in self.effects:
            if effect.limit is not None:
                limit = effect.limit(self.observations.columns, values[effect.key])
        return limit


def within(most: int, size: int) -> int:
    """How many things of `size` bytes are kept: at most `most`, fewer where they are large."""
    return max(LEAST_KEPT, min(most, MOST_BYTES // max(size, 1)))


def make_room(kept: dict, most: int) -> None:  # type: ignore[type-arg]
    """Drop the oldest of what is kept, so that one more stays within `most`."""
    while len(kept) >= most:
        del kept[next(iter(kept))]
