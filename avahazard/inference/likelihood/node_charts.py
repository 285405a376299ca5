"""Nodes at any value of the parameters that shape the tables, from a few exact ones.

Exact nodes cost runs of every block. They are made at a *star*: its centre, some more points along
each axis, and two for each pair of axes. In between, the mean place and the log mass of each
event's nodes are cubics through these values (along each axis, with products of two axes);
their shape about the mean is mixed linearly. Cost and memory grow with the number of axes, not with
a product of grids. How far a star reaches, and with how many points, is decided where a posterior
is fitted (`inference.fitting.star`), by comparison with exact nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from functools import cached_property, lru_cache
from itertools import accumulate, combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import (
    Effect,
    LimitEffect,
    MotionEffect,
    RecordErrorEffect,
    of_kind,
)
from avahazard.inference.likelihood.interpolation import Line, along, line_weights
from avahazard.inference.likelihood.kept_runs import KeptRuns, make_room, sight_is_limited, within
from avahazard.inference.likelihood.nodes import Nodes, log_wrong, record_nodes, with_tracks
from avahazard.inference.likelihood.predicted import Predicted, Values
from avahazard.inference.likelihood.record_parts import AskedPanels, RecordParts, in_parts
from avahazard.inference.likelihood.track_nodes import TrackTables, track_nodes, track_tables
from avahazard.inference.model.layout import Layout
from avahazard.inference.model.observations import Observations

KEPT_BETWEEN = 4
"""Places between exact ones whose nodes are kept."""
KEPT_PLACES = 512
"""Places for which it is kept what is known before scatters along tracks."""

Arms = Sequence[tuple[float, ...]]
"""Points of a star along each axis, the centre first."""


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
        return np.clip(place, self.low, self.high)


class Chart(NamedTuple):
    """Exact nodes at the points of a star, as `[n_points, …]`.

    `nodes` are those of the centre, for what does not change; `used` `[n_events, n_nodes]`.
    `smooth` `[n_points, 2 * n_events]` are mean places and log masses; `mixed` `[n_points, n]` are,
    end to end, weights of the nodes, tails, floors and the same of what is seen. `places` are those
    about the mean, `seen_places` those of what is seen, None where all is.
    """

    nodes: Nodes
    used: NDArray[np.bool_]
    smooth: Floats
    mixed: Floats
    places: Mixed
    seen_places: Mixed | None


class NodeCharts:
    """What the records say of friction, for every value of the parameters that shape the tables.

    These are the parameters of effects on the motion and on the record, and the scatter of
    friction along tracks; the `arm` of their slots are those of the star.
    `curvature` is that of `run_blocks`, `in_log` that of `build_nodes`.
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
        # Runs of blocks that no parameter moves serve all places.
        near = self._in_sight and len(of_kind(effects, MotionEffect)) > 0
        again = len(layout.tables) > 0 and not near
        self._parts = RecordParts(*of_block, again) if in_parts(observations) else None
        self._untracked: dict[tuple[float, ...], Nodes] = {}
        self._track_tables: dict[tuple[bytes, ...], TrackTables] = {}
        self._track_events = np.array([track.event for track in observations.speeds], np.int64)
        self._chart: Chart | None = None
        self._panels: Ints | None = None
        self._between: dict[tuple[float, ...], Nodes] = {}

    @cached_property
    def _log_wrong(self) -> Floats:
        return log_wrong(self.observations)

    def forget_runs(self) -> None:
        """Give back the memory of runs; the chart stays, others are made anew."""
        self._runs = self._runs.emptied()
        self._parts = None if self._parts is None else self._parts.emptied()
        self._untracked, self._track_tables = {}, {}

    def on_star(self, layout: Layout) -> NodeCharts:
        """The same with the star of another layout."""
        self.panels()  # the same for both
        other = copy(self)
        other.layout = layout
        other._between, other._chart = {}, None
        return other

    @property
    def varies(self) -> bool:
        """Whether nodes depend on the coordinates at all."""
        return len(self._axes) > 0

    def at(self, u: Floats) -> Nodes:
        """Nodes at coordinates u, by the chart."""
        place = tuple(float(u[axis]) for axis in self._axes)
        if place not in self._between:
            made = self._charted(place) if place else self._exact(place)
            # Differences are taken by coordinates of which most leave the place as it is.
            make_room(self._between, KEPT_BETWEEN)
            self._between[place] = made
        return self._between[place]

    def exact(self, u: Floats) -> Nodes:
        """Nodes from runs made for just these coordinates."""
        return self._exact(tuple(float(u[axis]) for axis in self._axes))

    def pinned(self, u: Floats) -> NodeCharts:
        """The same where the parameters that shape the tables are held at those of u."""
        other = copy(self)
        other._axes = ()
        other._between = {(): self.exact(u)}
        return other

    def _charted(self, place: tuple[float, ...]) -> Nodes:
        arms = [self.layout.slots[axis].arm for axis in self._axes]
        if self._chart is None:
            at = [self._exact(tuple(point)) for point in star(arms).tolist()]
            self._chart = chart(at, self._in_sight)
        return _charted(self._chart, arms, np.array(place))

    def _exact(self, place: tuple[float, ...]) -> Nodes:
        """Nodes from runs made for this place on the axes."""
        n_tables = len(self.layout.tables)
        values = self._values(place)
        nodes, tables = self._before_tracks(place[:n_tables], values)
        if tables is not None:
            scatter = float(np.exp(place[-1])) if len(place) > n_tables else 0.0
            panels = self.panels()[self._track_events]
            tracks = track_nodes(tables, scatter, panels, self.in_log)
            nodes = with_tracks(nodes, self._track_events, tracks)
        return nodes

    def _before_tracks(
        self, at: tuple[float, ...], values: Values
    ) -> tuple[Nodes, TrackTables | None]:
        """What is known at these values of the tables' parameters before scatters along tracks.

        Nodes of the events without speeds; of those with speeds, which no detection limit moves,
        the tables (None if there are none).
        """
        limits = {effect.key for effect in of_kind(self.effects, LimitEffect)}
        key = tuple(v.tobytes() for name, v in values.items() if name not in limits)
        measured = len(self.observations.speeds) > 0
        if self._parts is not None:
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
        """Panels of friction for each event `[n_events]`, the same everywhere.

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
        u = self._neutral()
        values = self.layout.effect_values(u)
        for effect in of_kind(self.effects, RecordErrorEffect):
            place = self.layout.places[effect.key]
            u[place] = self.layout.high[place]
        slot = self.layout.track_scatter
        scatter = 0.0 if slot is None else float(np.exp(self.layout.slots[slot].mean))
        return AskedPanels(self.layout.effect_values(u), values, scatter, self.in_log)

    def _in_parts(self, parts: RecordParts, values: Values) -> Nodes:
        """Nodes of the records at these values, some paths at a time."""
        panels = self._asked_panels() if self._panels is None else self._panels
        nodes, self._panels = parts.nodes(values, panels, self._limit(values), self.in_log)
        return nodes._replace(log_wrong=self._log_wrong)

    def predicted_at(self, u: Floats) -> Predicted:
        """Tables of expected records at coordinates u; where blocks move by them, run afresh."""
        return self._runs.fresh_records(self.layout.effect_values(u))

    def _neutral(self) -> Floats:
        return np.array([0.0 if np.isnan(s.neutral) else s.neutral for s in self.layout.slots])

    def _values(self, place: tuple[float, ...]) -> Values:
        u = self._neutral()
        u[list(self._axes)] = place
        return self.layout.effect_values(u)

    def _limit(self, values: Values) -> Floats:
        limit = self.observations.limit
        for effect in of_kind(self.effects, LimitEffect):
            limit = effect.limit(self.observations.columns, values[effect.key])
        return limit


def star(arms: Arms) -> Floats:
    """Points of a star `[n_points, n_axes]`: centre, arms, and two for each pair of axes."""
    centre = np.array([points[0] for points in arms])
    found = [centre]
    for axis, points in enumerate(arms):
        found += [_moved(centre, {axis: value}) for value in points[1:]]
    for a, b in combinations(range(len(arms)), 2):
        ends = zip(_halfway(arms[a]), _halfway(arms[b]), strict=True)
        found += [_moved(centre, {a: arms[a][i], b: arms[b][j]}) for i, j in ends]
    return np.array(found)


def _moved(centre: Floats, values: dict[int, float]) -> Floats:
    at = centre.copy()
    at[list(values)] = list(values.values())
    return at


@lru_cache(maxsize=64)
def _halfway(points: tuple[float, ...]) -> tuple[int, int]:
    """Which points of an arm lie about halfway to both its ends (or to one, for two)."""
    away = np.array(points) - points[0]
    ends = [end for end in (np.min(away), np.max(away)) if end != 0.0]
    halves = (ends[0] / 2, ends[-1] / 2) if len(ends) == 2 else (ends[0] / 2, ends[0])
    first, second = (int(np.argmin(np.abs(away[1:] - half))) + 1 for half in halves)
    return first, second


def chart(nodes: list[Nodes], in_sight: bool) -> Chart:
    """The chart of the nodes at the points of a star; nothing is hidden where all is `in_sight`."""
    first = nodes[0]
    used = np.arange(first.place.shape[1]) < first.used[:, None]
    smooth, mixed, places = [], [], []
    for at in nodes:
        mean = np.where(at.is_probability, 0.0, np.sum(at.place * at.weight, axis=1))
        smooth.append(np.concatenate([mean, at.log_scale]))
        places.append((at.place - mean[:, None])[used])
        parts = [at.weight[used], at.tail.ravel(), at.floor]
        parts += [] if in_sight else [at.seen_weight[used], at.seen_floor]
        mixed.append(np.concatenate(parts))
    weights = np.array([at.weight[used] for at in nodes])
    seen = None
    if not in_sight:
        of_seen = [(at.seen_weight[used], at.seen_place[used]) for at in nodes]
        seen = _mixed(*(np.array(values) for values in zip(*of_seen, strict=True)))
    return Chart(
        first, used, np.array(smooth), np.array(mixed), _mixed(weights, np.array(places)), seen
    )


def _mixed(weights: Floats, places: Floats) -> Mixed:
    size = np.abs(weights)
    some = size > 0.0
    low = np.min(places, axis=0, where=some, initial=np.inf)
    high = np.max(places, axis=0, where=some, initial=-np.inf)
    never = low > high
    return Mixed(size, size * places, np.where(never, 0.0, low), np.where(never, 0.0, high))


def between(arms: Arms, place: Floats, values: Floats) -> Floats:
    """Values at the points of a star `[n_points, n]`, interpolated at a place `[n_axes]`: `[n]`.

    By limited cubics along each arm, and products of two axes: what a pair's points have beyond
    the sum of both arms. Beyond the reach of an arm its end counts.
    """
    first = _first(arms)
    moved = np.clip(place, *_ends(arms)) - [points[0] for points in arms]
    result: Floats = values[0].copy()
    for axis, points in enumerate(arms):
        line, order = _line(points, float(place[axis]))
        result += along(line, values[_of_arm(first[axis], order)]) - values[0]
    pair = first[-1]
    for a, b in combinations(range(len(arms)), 2):
        for i, j in zip(_halfway(arms[a]), _halfway(arms[b]), strict=True):
            share = 0.5 * moved[a] * moved[b]
            share /= (arms[a][i] - arms[a][0]) * (arms[b][j] - arms[b][0])
            beside = values[first[a] + i - 1] + values[first[b] + j - 1] - values[0]
            result += share * (values[pair] - beside)
            pair += 1
    return result


def mixing(arms: Arms, place: Floats) -> Floats:
    """Weights of a star's points `[n_points]` that mix their values linearly along each arm."""
    first = _first(arms)
    weights = np.zeros(first[-1] + len(arms) * (len(arms) - 1))
    weights[0] = 1.0 - len(arms)
    for axis, points in enumerate(arms):
        line, order = _line(points, float(place[axis]))
        weights[_of_arm(first[axis], order)] += line.linear
    return weights


def _first(arms: Arms) -> list[int]:
    """The first point of each arm besides the centre, and of the pairs."""
    return list(accumulate((len(points) - 1 for points in arms), initial=1))


def _ends(arms: Arms) -> tuple[list[float], list[float]]:
    return [min(points) for points in arms], [max(points) for points in arms]


def _line(points: tuple[float, ...], value: float) -> tuple[Line, Ints]:
    """The line through neighbours of a value on an arm, and which of its points they are."""
    order, rising = _rising(points)
    line = line_weights(rising, min(max(value, rising[0]), rising[-1]))
    return line, order[line.first : line.first + len(line.linear)]


@lru_cache(maxsize=64)
def _rising(points: tuple[float, ...]) -> tuple[Ints, tuple[float, ...]]:
    """Which points of an arm follow each other from its lower end on, and these."""
    order = np.argsort(points)
    return order, tuple(points[k] for k in order)


def _of_arm(first: int, points: Ints) -> Ints:
    """Points of an arm, 0 being the centre, as points of the star."""
    return np.where(points == 0, 0, first + points - 1)


def _charted(known: Chart, arms: Arms, place: Floats) -> Nodes:
    """Nodes at a place `[n_axes]`."""
    linear = mixing(arms, place)
    near = np.flatnonzero(linear)
    linear = linear[near]
    first, used = known.nodes, known.used
    n, n_used = len(first.used), known.places.size.shape[1]
    mean, log_scale = np.split(between(arms, place, known.smooth), 2)
    mixed = linear @ known.mixed[near]
    ends = [n_used, n_used + 2 * n, n_used + 3 * n, 2 * n_used + 3 * n]
    weight, tail, floor, seen_weight, seen_floor = np.split(mixed, ends)
    # Sums over the points of a star may fall below zero; those of edges have either sign.
    weight = np.where(np.repeat(first.is_probability, first.used), weight, np.maximum(weight, 0.0))
    places = mean[:, None] * used
    places[used] += known.places.at(near, linear)
    nodes = first._replace(
        place=places,
        weight=_spread(weight, used),
        tail=np.maximum(tail, 0.0).reshape(-1, 2),
        log_scale=log_scale,
        floor=floor,
    )
    if known.seen_places is None:
        return nodes
    return nodes._replace(
        seen_place=_spread(known.seen_places.at(near, linear), used),
        seen_weight=_spread(seen_weight, used),
        seen_floor=seen_floor,
    )


def _spread(values: Floats, used: NDArray[np.bool_]) -> Floats:
    """The values `[n_used]` at their nodes `[n_events, n_nodes]`."""
    whole = np.zeros(used.shape)
    whole[used] = values
    return whole
