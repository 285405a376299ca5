"""Grids of the parameters that shape the tables, made fine enough about a mode.

Between grid points the likelihood is interpolated (`interpolation`). Where it falls by tens of nats
from one point to the next, as with many speeds, it can rise far above anything that tables made on
the spot would give. So it is held against these at the mode.
"""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.fitting.mode import Mode, find_mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import build_layout

TOLERANCE = 1.0
"""Largest error (nats) of the interpolation at a mode."""
MAX_SPLITS = 6
PARTS = 4
"""Parts into which a cell of a grid is split."""
STEP, SLOW_STEP = 1.0, 1.5
"""Longest step near the mode, in standard deviations (cubics are exact for a normal's log). The
second is for friction that depends on speed, whose runs cost ten times as much."""
REACH = 6.0
NEAR = 2.0
"""Cells within that many standard deviations of the mode must be fine."""


def settled(posterior: Posterior, mode: Mode) -> tuple[Posterior, Mode]:
    """The posterior with grids split about its mode until interpolation holds there, and the mode.

    Ranges stay as they are. After `MAX_SPLITS` it is left at what it is: on terrain with steps
    the likelihood itself may be rough.
    """
    for _ in range(MAX_SPLITS):
        interpolated = posterior.log_likelihood(mode.u)
        if abs(interpolated - posterior.exact_log_likelihood(mode.u)) <= TOLERANCE:
            break
        posterior = _split(posterior, mode.u)
        mode = find_mode(posterior, mode.u)
    return posterior, mode


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
        for e in posterior.effects
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


def _split(posterior: Posterior, u: Floats) -> Posterior:
    """The posterior with the cell of u, and its neighbours, split on every grid."""
    grids = {}
    for k, slot in enumerate(posterior.layout.slots):
        if slot.grid:
            points = np.asarray(slot.grid)
            right = int(np.clip(np.searchsorted(points, u[k]), 1, len(points) - 1))
            first, last = max(right - 2, 0), min(right + 1, len(points) - 1)
            at = np.linspace(first, last, PARTS * (last - first) + 1)
            inner = np.interp(at, np.arange(len(points)), points)
            grids[slot.name] = tuple(float(v) for v in np.union1d(points, inner))
    return posterior.regridded(grids)


def refined_grids(posterior: Posterior) -> dict[str, tuple[float, ...]]:
    """The grids of parameters, by slot, that are not those of the effects themselves."""
    whole = build_layout(posterior.specification, posterior.effects, posterior.observations, {})
    pairs = zip(whole.slots, posterior.layout.slots, strict=True)
    return {new.name: new.grid for old, new in pairs if new.grid != old.grid}
