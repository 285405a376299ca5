"""Nodes at any value of the parameters that shape the tables, from exact ones on a `star`.

The mean place and the log mass of each event's nodes are cubics, their shape about the mean is
mixed linearly. `inference.fitting.star` decides how far a star reaches, and with how many points.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Bools, Floats, Ints
from avahazard.effects.effect import Effect, LimitEffect, RecordErrorEffect, of_kind
from avahazard.inference.likelihood.nodes import (
    Nodes,
    log_wrong,
    needed_panels,
    record_nodes,
    with_tracks,
)
from avahazard.inference.likelihood.predicted import KeptRuns, Predicted, Values, keep
from avahazard.inference.likelihood.star import Star
from avahazard.inference.likelihood.track_nodes import TrackRows, track_rows
from avahazard.inference.model.layout import Layout
from avahazard.inference.model.observations import Observations, part_of, whole_paths

MANY_EVENTS, EVENTS_AT_ONCE = 2000, 500
"""Events from which on their nodes are made in parts, and those of a part. The tables of an event
take a hundred times as much memory as its nodes; those of 500 take some 15 MB."""
KEPT_BETWEEN = 4
"""Places between exact ones whose nodes are kept."""
KEPT_PLACES = 512
"""Places for which it is kept what is known before scatters along tracks."""


class Mixed(NamedTuple):
    """Places of nodes at the points of a star, to be mixed by the sizes of their weights.

    `size` and `moment`, size times place, are `[n_points, n_used]`; `low`, `high` `[n_used]` are
    the ends of the places.
    """

    size: Floats
    moment: Floats
    low: Floats
    high: Floats

    def at(self, near: Ints, linear: Floats) -> Floats:
        """Places `[n_used]` mixed of the points `near`; within those of all points."""
        mixed, total = linear @ self.moment[near], linear @ self.size[near]
        place = np.divide(mixed, total, out=self.low.copy(), where=total > 0.0)
        return np.minimum(np.maximum(place, self.low), self.high)


def _mixed(weights: Floats, places: Floats) -> Mixed:
    size = np.abs(weights)
    some = size > 0.0
    low = np.min(places, axis=0, where=some, initial=np.inf)
    high = np.max(places, axis=0, where=some, initial=-np.inf)
    never = low > high
    return Mixed(size, size * places, np.where(never, 0.0, low), np.where(never, 0.0, high))


class Chart:
    """Nodes between exact ones `[n_points]` at the points of a star.

    Those of the centre stand for what does not change; nothing is hidden where all is `in_sight`.
    """

    def __init__(self, star: Star, nodes: list[Nodes], in_sight: bool) -> None:
        centre = nodes[0]
        used = np.arange(centre.place.shape[1]) < centre.used[:, None]
        smooth, mixed, places = [], [], []
        for at in nodes:
            mean = np.where(at.is_probability, 0.0, np.sum(at.place * at.weight, axis=1))
            smooth.append(np.concatenate([mean, at.log_scale]))
            places.append((at.place - mean[:, None])[used])
            parts = [at.weight[used], at.tail.ravel(), at.floor]
            parts += [] if in_sight else [at.seen_weight[used], at.seen_floor]
            mixed.append(np.concatenate(parts))
        self.star, self._nodes, self._used = star, centre, used
        self._smooth, self._mixed = star.relative(np.array(smooth)), np.array(mixed)
        self._places = _mixed(np.array([at.weight[used] for at in nodes]), np.array(places))
        self._seen = None
        if not in_sight:
            of_seen = [(at.seen_weight[used], at.seen_place[used]) for at in nodes]
            self._seen = _mixed(*(np.array(values) for values in zip(*of_seen, strict=True)))

    def at(self, values: Sequence[float]) -> Nodes:
        """Nodes at a place `[n_axes]`."""
        place = self.star.place(values)
        linear = self.star.mixing(place)
        near = linear.nonzero()[0]
        linear = linear[near]
        centre, used = self._nodes, self._used
        n, n_used = len(used), self._places.size.shape[1]
        smooth = self.star.between(place, self._smooth)
        mixed = linear @ self._mixed[near]
        weight, tail = mixed[:n_used], mixed[n_used : n_used + 2 * n]
        # Sums over the points of a star may fall below zero; those of edges have either sign.
        edges = centre.is_probability.repeat(centre.used)
        weight = np.where(edges, weight, np.maximum(weight, 0.0))
        where = smooth[:n, None] * used
        where[used] += self._places.at(near, linear)
        nodes = centre._replace(
            place=where,
            weight=_spread(weight, used),
            tail=np.maximum(tail, 0.0).reshape(-1, 2),
            log_scale=smooth[n:],
            floor=mixed[n_used + 2 * n : n_used + 3 * n],
        )
        if self._seen is None:
            return nodes
        return nodes._replace(
            seen_place=_spread(self._seen.at(near, linear), used),
            seen_weight=_spread(mixed[n_used + 3 * n : -n], used),
            seen_floor=mixed[-n:],
        )


def _spread(values: Floats, used: Bools) -> Floats:
    """The values `[n_used]` at their nodes `[n_events, n_nodes]`."""
    whole = np.zeros(used.shape)
    whole[used] = values
    return whole


class NodeCharts:
    """What the records say of friction, for every value of the parameters that shape the tables.

    These are the parameters of effects on the motion and on the record, and the scatter of
    friction along tracks; the `arm` of their slots are those of the star.
    `curvature` is that of `run_blocks`.
    """

    def __init__(
        self,
        observations: Observations,
        effects: tuple[Effect, ...],
        layout: Layout,
        curvature: float,
    ) -> None:
        self.observations = observations
        self.effects = effects
        self.layout = layout
        self.in_log = layout.log_scatter
        along_tracks = () if layout.track_scatter is None else (layout.track_scatter,)
        self._axes = layout.tables + along_tracks
        # Else frictions count that stop a block far from the record.
        limited = np.any(np.isfinite(observations.limit)) or of_kind(effects, LimitEffect)
        self._in_sight = not limited
        of_block = effects, curvature, self._in_sight
        self._runs = KeptRuns(observations, *of_block)
        # Events whose nodes are made together, with the runs of their blocks.
        self._parts = [(np.arange(observations.n_events), self._runs)]
        many = observations.n_events > MANY_EVENTS and len(observations.sites) > 1
        if many and not observations.speeds:
            events = whole_paths(observations, EVENTS_AT_ONCE)
            parts = (part_of(observations, selected) for selected in events)
            self._parts = [(e, KeptRuns(p, *of_block)) for e, p in zip(events, parts, strict=True)]
        # Runs of parts are kept where they serve other places too.
        self._keeps = len(self._parts) == 1 or (len(layout.tables) > 0 and not self._runs.near)
        self._kept: dict[tuple[float, ...], tuple[Nodes, list[TrackRows]]] = {}
        self._chart: Chart | None = None
        self._interpolates = len(self._axes) > 0
        self._panels: Ints | None = None
        self._between: dict[tuple[float, ...], Nodes] = {}

    @cached_property
    def _log_wrong(self) -> Floats:
        return log_wrong(self.observations)

    def forget_runs(self) -> None:
        """Give back the memory of runs; the chart stays, others are made anew."""
        for runs in (self._runs, *(runs for _, runs in self._parts)):
            runs.forget()
        self._kept = {}

    def on_star(self, layout: Layout, like: NodeCharts | None = None) -> NodeCharts:
        """The same with the star of another layout: that of `like`, whose tables are shaped alike.

        The panels are the same for both.
        """
        other = copy(self)
        other.layout, other._between = layout, {}
        other._chart = None if like is None else like._chart
        other._panels = (self if like is None else like).panels()
        return other

    @property
    def varies(self) -> bool:
        """Whether nodes depend on the coordinates at all."""
        return len(self._axes) > 0

    def at(self, u: Floats) -> Nodes:
        """Nodes at coordinates u, by the chart."""
        place = tuple(u[list(self._axes)].tolist())
        if place not in self._between:
            if self._interpolates and self._chart is None:
                slots = [self.layout.slots[axis] for axis in self._axes]
                beside = [slot.beside for slot in slots]
                star = Star([slot.arm for slot in slots], np.array(beside).T)
                turn = self.layout.turn[np.ix_(self._axes, self._axes)]
                at = [self._exact(tuple(point)) for point in (star.points @ turn.T).tolist()]
                self._chart = Chart(star, at, self._in_sight)
            on_arms = self.layout.on_arms(u)[list(self._axes)].tolist()
            made = self._exact(place) if self._chart is None else self._chart.at(on_arms)
            # Differences are taken by coordinates of which most leave the place as it is.
            keep(self._between, place, made, KEPT_BETWEEN)
        return self._between[place]

    def exact(self, u: Floats) -> Nodes:
        """Nodes from runs made for just these coordinates."""
        return self._exact(tuple(u[list(self._axes)].tolist()))

    def pinned(self, u: Floats) -> NodeCharts:
        """The same where the parameters that shape the tables are held at those of u."""
        other = self.exactly()
        other._axes, other._between = (), {(): self.exact(u)}
        return other

    def exactly(self) -> NodeCharts:
        """The same without a star: nodes from runs made for whatever coordinates are asked."""
        other = copy(self)
        other._chart, other._interpolates, other._between = None, False, {}
        return other

    def _exact(self, place: tuple[float, ...]) -> Nodes:
        """Nodes from runs made for this place on the axes."""
        at, values = self._values_at(place)
        if at not in self._kept:
            self._made(at, values)
        nodes, tracks = self._kept[at]
        if not tracks:
            return nodes
        scatter = float(np.exp(place[-1])) if len(place) > len(at) else 0.0
        return with_tracks(nodes, tracks, scatter, self.panels(), self.in_log)

    def near_records(self, u: Floats) -> Predicted:
        """Tables that are right near the records, from runs made for just these coordinates.

        `exact` then needs none; of many events without speeds they are those of the last part.
        """
        return self._made(*self._values_at(tuple(u[list(self._axes)].tolist())))

    def _values_at(self, place: tuple[float, ...]) -> tuple[tuple[float, ...], Values]:
        """The part of a place without the scatter along tracks, and the effects' values there."""
        u = self._neutral()
        u[list(self._axes)] = place
        # Ends of two arms that turn can lie beyond a range, where an effect may not be defined.
        u = np.clip(u, *self.layout.ranges)
        return place[: len(self.layout.tables)], self.layout.effect_values(u)

    def _made(self, at: tuple[float, ...], values: Values) -> Predicted:
        """Keep nodes of the events without speeds and rows of tracks; tables of the last part."""
        limit = self.observations.limit
        for effect in of_kind(self.effects, LimitEffect):
            limit = effect.limit(self.observations.columns, values[effect.key])
        panels = np.empty(len(limit), np.int64) if self._panels is None else self._panels
        made = []
        for events, runs in self._parts:
            if self._panels is None:
                panels[events] = self._needed(runs)
            predicted, some = runs.near_records(values), (panels[events], limit[events])
            made.append(record_nodes(runs.observations, predicted, *some, self.in_log))
            if not self._keeps:
                runs.forget()
        self._panels = panels
        nodes = made[0] if len(made) == 1 else Nodes(*map(self._joined, zip(*made, strict=True)))
        nodes = nodes._replace(log_wrong=self._log_wrong)
        rows = track_rows(self.observations, predicted) if self.observations.speeds else []
        size = sum(column.nbytes for column in nodes)
        size += sum(r.speeds.nbytes + r.record.nbytes + r.left.nbytes for r in rows)
        keep(self._kept, at, (nodes, rows), KEPT_PLACES, size)
        return predicted

    def _joined(self, columns: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Rows of all parts in the order of the events, as wide as the widest."""
        width = [max(sides) for sides in zip(*(c.shape[1:] for c in columns), strict=True)]
        whole = np.zeros((self.observations.n_events, *width), dtype=columns[0].dtype)
        for (events, _), column in zip(self._parts, columns, strict=True):
            at: tuple[Any, ...] = (events, *map(slice, column.shape[1:]))
            whole[at] = column
        return whole

    def panels(self) -> Ints:
        """Panels of friction for each event `[n_events]`, the same everywhere.

        They are those of the neutral model with the largest errors of the records.
        """
        if self._panels is None:
            panels = np.empty(self.observations.n_events, np.int64)
            for events, runs in self._parts:
                panels[events] = self._needed(runs)
                if not self._keeps:
                    runs.forget()
            self._panels = panels
        return self._panels

    def _needed(self, runs: KeptRuns) -> Ints:
        u = self._neutral()
        moved = self.layout.effect_values(u)
        for effect in of_kind(self.effects, RecordErrorEffect):
            place = self.layout.places[effect.key]
            u[place] = self.layout.high[place]
        slot = self.layout.track_scatter
        scatter = 0.0 if slot is None else float(np.exp(self.layout.slots[slot].mean))
        predicted = runs.records(self.layout.effect_values(u), moved)
        return needed_panels(runs.observations, predicted, scatter, self.in_log)

    def predicted_at(self, u: Floats) -> Predicted:
        """Tables of expected records at coordinates u; where blocks move by them, run afresh."""
        return self._runs.fresh_records(self.layout.effect_values(u))

    def _neutral(self) -> Floats:
        return np.array([0.0 if np.isnan(s.neutral) else s.neutral for s in self.layout.slots])
