"""Stretches of single paths that hold avalanches back: a bend, rough ground, a dam.

Where speeds were measured. No state of the block or of the ground says where such a place is, so
the tracks do: along each one the square of speed falls short of what gravity gives by the work of
friction and of whatever else resists,

    u² = 2 g (y₀ - y) - 2 μ ∫ N dξ - 2 Σ_j φ_j ∫_j N dξ

with a friction μ of each track, and j the stretches. Without speeds a place cannot be distinguished
from a path whose friction is another.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns, MeasuredTrack
from avahazard.effects.effect import Curve, Facts, MotionEffect, Parameter, Sites
from avahazard.effects.site import Site
from avahazard.notes import Note
from avahazard.physics.cells import GRAVITY, Resistance

LEAST_TRACKS = 2
"""Of a path, of which places are asked."""
N_PARTS, FINER, LONGEST = 12, 3, 12
"""Parts of a path that are looked at, how many finer ones each has, at whose ends stretches begin
and end, and how many of these a stretch has at most."""
MOST_STRETCHES, LEAST_GAIN = 4, 6.0
"""Stretches that are taken at most, and what each must gain (nats) beyond the number tried."""
STOP_SIGMA = 150.0
"""Error of u² (m²/s²) at the recorded stop."""
KINDS = {
    "friction": Parameter("", "friction", 0.0, 0.0, 0.3, -0.1, 1.5),
    "drag": Parameter("", "1/m", 0.0, 0.0, 0.005, 0.0, 0.03),
}
"""What a stretch does: it adds to friction, or a force that grows with the square of speed."""
N_PLACES, STEP_M = 61, 5.0
LEAST_SIZE = 0.5
"""Of the work of a stretch, in standard errors, once friction and drag are taken off."""


class _Stretch(NamedTuple):
    path: str
    start_m: float
    end_m: float


def _stretches(facts: Facts) -> list[_Stretch]:
    return [_Stretch(*row) for row in facts["stretches"]]


def _path_of(columns: EventColumns, track: MeasuredTrack) -> str:
    return columns.paths[int(columns.path_index[track.event])]


def stretch_facts(columns: EventColumns, sites: Sites) -> Facts | None:
    """The stretches that the speeds show, and what they do; None where they show none."""
    bins = _bins(columns, FINER)
    found = {kind: _found(kind, columns, sites, bins) for kind in KINDS if bins}
    kind = max(found, key=lambda one: found[one][0], default=None)
    if kind is None or not found[kind][1]:
        return None
    return _facts(kind, found[kind][1], sites)


def all_parts(columns: EventColumns, sites: Sites) -> Facts | None:
    """Every part of every path as a stretch, None where too few speeds were measured."""
    parts = [
        _Stretch(path, float(low), float(high))
        for path, ends in _bins(columns).items()
        for low, high in pairwise(ends)
    ]
    return _facts("friction", parts, sites) if parts else None


def build_stretches(key: str, facts: Facts) -> MotionEffect:
    """The effect: of each stretch its amount."""
    stretches = _stretches(facts)
    names = (f"{s.path}:{s.start_m:.0f}-{s.end_m:.0f}m" for s in stretches)
    parameters = tuple(replace(KINDS[facts["kind"]], name=name) for name in names)
    acts = partial(_resistance, facts["kind"], stretches)
    return MotionEffect(key, parameters, acts, paths=tuple(s.path for s in stretches))


def stretch_curve(facts: Facts) -> Curve:
    """What is added along the path of the first stretch."""
    stretches = _stretches(facts)
    first, (start, end) = stretches[0].path, facts["ends"]
    ends = [at for s in stretches if s.path == first for at in (s.start_m, s.end_m)]
    x = np.unique(np.concatenate([np.linspace(start, end, N_PLACES), ends]))
    columns = [(s.path == first) & (x >= s.start_m) & (x < s.end_m) for s in stretches]
    kind = facts["kind"]
    return Curve(
        of="distance",
        unit="m",
        value="friction" if kind == "friction" else "drag, 1/m",
        x=x - start,
        columns=np.array(columns, np.float64).T,
        rests=True,
        path=first,
    )


def stretches_found(columns: EventColumns, sites: Sites) -> Note | None:
    """Where the speeds show stretches that hold avalanches back; None where they show none."""
    facts = stretch_facts(columns, sites)
    if facts is None:
        return None
    where = [f"{s.path} ({s.start_m:.0f} m – {s.end_m:.0f} m)" for s in _stretches(facts)]
    return Note("stretches", where=where)


def _resistance(
    kind: str, stretches: list[_Stretch], site: Site, resistance: Resistance, values: Floats
) -> Resistance:
    x = site.terrain_for(resistance).x
    more = np.zeros(len(x) - 1)
    for stretch, value in zip(stretches, values, strict=True):
        if stretch.path == site.path.path_id:
            # The share of each cell that lies within.
            inside = np.minimum(x[1:], stretch.end_m) - np.maximum(x[:-1], stretch.start_m)
            more += value * np.maximum(inside, 0.0) / np.diff(x)
    if kind == "friction":
        return replace(resistance, offset=resistance.offset + more)
    return replace(resistance, drag=resistance.drag + more)


def _bins(columns: EventColumns, n: int = 1) -> dict[str, Floats]:
    """Ends of the parts `[n * N_PARTS + 1]` (m) of each path that has tracks enough."""
    found = {}
    for name in dict.fromkeys(_path_of(columns, t) for t in columns.tracks):
        selected = [t for t in columns.tracks if _path_of(columns, t) == name]
        start, end = min(t.release_x for t in selected), max(float(t.x[-1]) for t in selected)
        if len(selected) >= LEAST_TRACKS and end > start:
            found[name] = np.linspace(start, end, n * N_PARTS + 1)
    return found


def _facts(kind: str, stretches: Sequence[_Stretch], sites: Sites) -> Facts:
    rows = [[s.path, round(s.start_m, 1), round(s.end_m, 1)] for s in stretches]
    (site,) = (site for site in sites if site.path.path_id == stretches[0].path)
    x = site.terrain_x
    return {"kind": kind, "stretches": rows, "ends": [float(x[0]), float(x[-1])]}


def _found(
    kind: str, columns: EventColumns, sites: Sites, bins: Mapping[str, Floats]
) -> tuple[float, list[_Stretch]]:
    """Stretches that do this, the one that gains most first, and what they gain together (nats)."""
    left, work = _short_fall(kind, columns, sites, bins)
    tried = {
        _Stretch(path, float(ends[i]), float(ends[j])): work[path][:, i:j].sum(axis=1)
        for path, ends in bins.items()
        for i, j in combinations(range(len(ends)), 2)
        if j - i <= LONGEST
    }
    names, each = list(tried), np.array(list(tried.values()))
    chosen, total = list[_Stretch](), 0.0
    free = len(left) - len(columns.tracks)
    while names and free > 0 and len(chosen) < MOST_STRETCHES:
        size = np.sqrt(np.maximum(np.sum(each**2, axis=1), 1e-12))
        along = np.where(size > LEAST_SIZE, each @ left / size, 0.0)
        squares = float(left @ left)
        gains = _misfit(squares, free) - _misfit(squares - along**2, free)
        best = int(np.argmax(gains))
        if gains[best] < LEAST_GAIN + np.log(len(names)):
            break
        total += float(gains[best])
        one = names[best]
        chosen.append(one)
        unit = each[best] / size[best]
        left = left - (left @ unit) * unit
        apart = [k for k, other in enumerate(names) if not _overlap(one, other)]
        names = [names[k] for k in apart]
        each = each[apart] - np.outer(each[apart] @ unit, unit)
    return total, chosen


def _misfit(squares: Floats | float, n: int) -> Floats:
    """-log likelihood of n standardised errors by their sum of squares, of unknown scale.

    The scale is at least 1: blocks miss speeds by more than the errors of these.
    """
    scale = np.maximum(np.asarray(squares) / n, 1.0)
    return np.asarray(0.5 * n * np.log(scale) + 0.5 * squares / scale)


def _overlap(one: _Stretch, other: _Stretch) -> bool:
    apart = one.end_m <= other.start_m or other.end_m <= one.start_m
    return one.path == other.path and not apart


def _short_fall(
    kind: str, columns: EventColumns, sites: Sites, bins: Mapping[str, Floats]
) -> tuple[Floats, dict[str, Floats]]:
    """What the squares of speed of all tracks `[n]` fall short of gravity, in standard errors.

    And the work of each part of a path there `[n, n_bins]`. The friction of each track, and a drag
    everywhere, are taken off both.
    """
    tracks = [t for t in columns.tracks if _path_of(columns, t) in bins]
    rows = [len(t.x) + (not t.left) for t in tracks]
    first = np.concatenate([[0], np.cumsum(rows)])
    short, rest = np.empty(first[-1]), np.zeros((first[-1], len(tracks) + 1))
    work = {path: np.zeros((first[-1], len(ends) - 1)) for path, ends in bins.items()}
    by_path = {site.path.path_id: site for site in sites}
    for k, track in enumerate(tracks):
        path = _path_of(columns, track)
        here, smooth = slice(first[k], first[k + 1]), by_path[path].smooth
        at, speed = track.x, track.speed
        sigma = 2.0 * track.sigma * np.hypot(speed, 0.71 * track.sigma)
        if not track.left:
            at, speed = np.append(at, track.stop_x), np.append(speed, 0.0)
            sigma = np.append(sigma, STOP_SIGMA)
        x = np.arange(track.release_x, max(float(at.max()), track.release_x) + STEP_M, STEP_M)
        square = np.interp(x, [track.release_x, *at], [0.0, *speed**2])
        height, slope, bend = smooth.derivatives(x)
        load = np.maximum(GRAVITY + bend / (1.0 + slope**2) * square, 0.0)
        drag = square * np.hypot(1.0, slope)
        acts = load if kind == "friction" else drag

        def until(force: Floats, x: Floats = x, at: Floats = at) -> Floats:
            return np.asarray(2.0 * np.interp(at, x, STEP_M * np.cumsum(force)))

        fallen = 2.0 * GRAVITY * (height[0] - smooth.height(at))
        short[here] = (fallen - speed**2) / sigma
        rest[here, k] = until(load) / sigma
        rest[here, -1] = until(drag) / sigma
        for j, (low, high) in enumerate(pairwise(bins[path])):
            work[path][here, j] = until(acts * ((x >= low) & (x < high))) / sigma
    whole = np.column_stack([short, *work.values()])
    whole -= rest @ np.linalg.lstsq(rest, whole, rcond=None)[0]
    parts = np.split(whole[:, 1:], len(work), axis=1)
    return whole[:, 0], dict(zip(work, parts, strict=True))
