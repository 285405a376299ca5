"""Grids of the parameters that shape the tables, made fine enough about a mode.

Between grid points the likelihood is interpolated (`interpolation`). Where it falls by tens of nats
from one point to the next, as with many speeds, it can rise far above anything that tables made on
the spot would give. So it is held against these at the mode.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.effect import MotionEffect, of_kind
from avahazard.inference.fitting.mode import Mode, covariance_at, find_mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import build_layout

TOLERANCE = 1.0
"""Largest error (nats) of the interpolation at a mode."""
MAX_SPLITS = 10
PARTS = 3
"""Parts into which a cell of a grid is split."""
STEP, SLOW_STEP = 1.0, 1.5
"""Longest step near the mode, in standard deviations (cubics are exact for a normal's log). The
second is for friction that depends on speed, whose runs cost ten times as much."""
REACH = 6.0
NEAR = 2.0
"""Cells within that many standard deviations of the mode must be fine."""
EDGE, EDGE_SHARE = 0.02, 0.005
"""Draws gather at an edge where more than that share are within that part of the grid's length."""


def settled(posterior: Posterior, mode: Mode) -> tuple[Posterior, Mode]:
    """The posterior with grids split about its mode until interpolation holds there, and the mode.

    Only those grids are split along which it errs: each point more is a run of every block. Ranges
    stay as they are. After `MAX_SPLITS` it is left at what it is: on terrain with steps the
    likelihood itself may be rough.
    """
    given = mode
    for _ in range(MAX_SPLITS):
        exact = posterior.exact_log_likelihood(mode.u)
        if abs(posterior.log_likelihood(mode.u) - exact) <= TOLERANCE:
            break
        posterior = _split(posterior, mode.u, _too_coarse(posterior, mode.u, exact))
        mode = find_mode(posterior, mode.u, given.covariance)
    if mode is not given:
        mode = replace(mode, covariance=covariance_at(posterior, mode.u))
    return posterior, mode


def _too_coarse(posterior: Posterior, u: Floats, exact: float) -> list[int]:
    """The slots along whose grids alone interpolation errs by more than a share of `TOLERANCE`.

    That along which it errs most, if all together err and none by itself.
    """
    gridded = [k for k, slot in enumerate(posterior.layout.slots) if slot.grid]
    error = []
    for k in gridded:
        slots = {j: posterior.layout.slots[j] for j in gridded if j != k}
        at_u = {slot.name: _with_point(slot.grid, u[j]) for j, slot in slots.items()}
        error.append(abs(posterior.regridded(at_u).log_likelihood(u) - exact))
    chosen = [k for k, e in zip(gridded, error, strict=True) if e > TOLERANCE / len(gridded)]
    return chosen or [gridded[int(np.argmax(error))]]


def _with_point(grid: tuple[float, ...], value: float) -> tuple[float, ...]:
    return tuple(float(v) for v in np.union1d(grid, [value]))


def sharpened(posterior: Posterior, mode: Mode) -> tuple[Posterior, Mode]:
    """The posterior on grids as fine as its mode is sharp (`refined`), and its mode there."""
    fine = refined(posterior, mode)
    if fine is posterior:
        return posterior, mode
    return settled(fine, find_mode(fine, mode.u))


def refined(posterior: Posterior, mode: Mode) -> Posterior:
    """The posterior with finer grids about the mode where the present ones are too coarse.

    A grid is too coarse where a step near the mode is longer than `STEP` standard deviations of
    what the mode's curvature promises; the new one reaches `REACH` of these to both sides. The
    posterior itself is returned where all grids will do.
    """
    grids = {}
    slow = {
        k
        for e in of_kind(posterior.effects, MotionEffect)
        if e.speed_dependent
        for k in range(len(posterior.layout.slots))[posterior.layout.places[e.key]]
    }
    for k, slot in enumerate(posterior.layout.slots):
        if not slot.grid:
            continue
        step = SLOW_STEP if k in slow else STEP
        sd = float(np.sqrt(mode.covariance[k, k]))
        points = np.asarray(slot.grid)
        near = (points[1:] > mode.u[k] - NEAR * sd) & (points[:-1] < mode.u[k] + NEAR * sd)
        if np.max(np.diff(points)[near]) <= step * sd:
            continue
        low = max(slot.low, float(mode.u[k]) - REACH * sd)
        high = min(slot.high, float(mode.u[k]) + REACH * sd)
        n_points = int(np.ceil((high - low) / (step * sd))) + 1
        grids[slot.name] = tuple(float(v) for v in np.linspace(low, high, max(4, n_points)))
    return posterior.regridded(grids) if grids else posterior


def continued(fine: Posterior, whole: Posterior, draws: Floats) -> Posterior | None:
    """`fine` with its grids continued where `draws` `[..., n_slots]` gather at an edge of them.

    At an edge, that is, which the grids of `whole` do not have. The curvature at the mode of a
    posterior that is skewed or bent says too little of how far it reaches. Each goes on by its own
    length, in its own steps; None where no draws gather.
    """
    grids = {}
    for k, (slot, range_) in enumerate(zip(fine.layout.slots, whole.layout.slots, strict=True)):
        points, length = np.asarray(slot.grid), slot.high - slot.low
        below = draws[..., k] < slot.low + EDGE * length
        above = draws[..., k] > slot.high - EDGE * length
        more = []
        if slot.low > range_.low and np.mean(below) > EDGE_SHARE:
            more.append((max(slot.low - length, range_.low), slot.low))
        if slot.high < range_.high and np.mean(above) > EDGE_SHARE:
            more.append((slot.high, min(slot.high + length, range_.high)))
        if more:
            n_points = [int(np.ceil((b - a) / np.max(np.diff(points)))) + 1 for a, b in more]
            added = [np.linspace(a, b, n) for (a, b), n in zip(more, n_points, strict=True)]
            grids[slot.name] = tuple(float(v) for v in np.unique(np.concatenate([points, *added])))
    return fine.regridded(grids) if grids else None


def _split(posterior: Posterior, u: Floats, slots: Sequence[int]) -> Posterior:
    """The posterior with the cell of u, and its neighbours, split on the grids of these slots."""
    grids = {}
    for k in slots:
        slot = posterior.layout.slots[k]
        points = np.asarray(slot.grid)
        right = int(np.clip(np.searchsorted(points, u[k]), 1, len(points) - 1))
        first, last = max(right - 2, 0), min(right + 1, len(points) - 1)
        at = np.linspace(first, last, PARTS * (last - first) + 1)
        inner = np.interp(at, np.arange(len(points)), points)
        grids[slot.name] = tuple(float(v) for v in np.union1d(points, inner))
    return posterior.regridded(grids)


def refined_grids(posterior: Posterior) -> dict[str, tuple[float, ...]]:
    """The grids of parameters, by slot, that are not those of the effects themselves."""
    speeds = bool(posterior.observations.speeds)
    whole = build_layout(posterior.specification, posterior.effects, {}, speeds=speeds)
    pairs = zip(whole.slots, posterior.layout.slots, strict=True)
    return {new.name: new.grid for old, new in pairs if new.grid != old.grid}
