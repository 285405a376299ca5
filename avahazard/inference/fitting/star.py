"""The star of exact tables on which a posterior stands (`likelihood.node_charts`), and its mode.

The mode is sought by Gauss-Newton steps on tables made on the spot. A star about it then reaches
`REACH` standard deviations, and has points enough to agree with tables made on the spot. Where
effects shape the tables there may be more than one mode: an ascent can stop where such an effect is
not there at all, since friction has taken its part, and a little of the effect is worse than none.
So ascents also begin at the best of some plausible values of each effect's parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import Effect
from avahazard.inference.fitting.mode import (
    APART,
    Mode,
    climb,
    find_mode,
    scores_at,
    start_coordinates,
    units,
)
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import arm_between, scatter_centre

STEPS, SMALLEST_GAIN = 20, 0.01
"""Most Gauss-Newton steps, and the gain (nats) of the last."""
SHARE_APART = 0.05
"""Largest differences for derivatives, in standard deviations."""
DAMPING, MOST_DAMPING = 1e-3, 1e4
ITERATIONS = 30
FIRST_REACH, REACH = 2.0, 5.0
"""Standard deviations about the mode to which a star reaches, the first of them by those of the
information, which are rough."""
POINTS, MOST_POINTS = 4, 16
"""Points of an arm besides the centre, and the most that it gets where it errs."""
MOST_STARS, MOST_ERROR = 6, 10.0
LONGER = 6.0
"""Most by which arms are longer than those of the star before."""
TOLERANCE = 0.3
"""Largest error (nats) of the log likelihood at the mode and `CHECKED` standard deviations off."""
CHECKED = 2.0
CHECKED_DRAWS, DRAWS_TOLERANCE = 8, 1.0
"""Draws at which it is held against tables made on the spot, and the largest error there."""
EDGE, EDGE_SHARE = 0.02, 0.005
"""Draws gather at an edge where more than that share are within that part of the star's reach."""


class Peak(NamedTuple):
    """Coordinates of a mode by tables made on the spot, standard deviations there `[n_slots]`."""

    u: Floats
    sd: Floats
    log_density: float


def starred(posterior: Posterior, peak: Peak) -> tuple[Posterior, Mode]:
    """The posterior on a star about a peak, and its mode there.

    An arm along which it errs gets more points, `MOST_POINTS` at most: on terrain with steps the
    likelihood itself may be rough. Arms of a star whose mode is none of the exact tables are too
    long: they are halved.
    """
    axes = np.array([k for k, slot in enumerate(posterior.layout.slots) if slot.arm], np.int64)
    low, high = posterior.layout.low[axes], posterior.layout.high[axes]
    u, half, points = peak.u, FIRST_REACH * peak.sd[axes], np.full(len(axes), POINTS)
    checked = False
    for _ in range(MOST_STARS):
        ends = np.maximum(low, u[axes] - half), np.minimum(high, u[axes] + half)
        local, mode = _on(posterior, axes, u, *ends, points)
        if _error(local, mode.u) > MOST_ERROR:
            half, u, checked = 0.5 * half, peak.u, False
            continue
        held = ((mode.u[axes] <= ends[0]) & (ends[0] > low)) | (
            (mode.u[axes] >= ends[1]) & (ends[1] < high)
        )
        wanted = REACH * np.sqrt(np.diag(mode.covariance)[axes])
        wanted = np.clip(wanted, half / LONGER, LONGER * half)
        if checked and not held.any():
            break
        half, u, checked = np.where(held, np.maximum(wanted, 2.0 * half), wanted), mode.u, True
    errors = _errors(local, mode, u, axes)
    while (wrong := (errors > TOLERANCE) & (points < MOST_POINTS)).any():
        points, before = np.where(wrong, 2 * points, points), np.max(errors)
        local, mode = _on(posterior, axes, u, *ends, points)
        errors = _errors(local, mode, u, axes)
        if np.max(errors) > 0.5 * before:
            break  # it errs between the arms
    return local, mode


def gauss_newton(posterior: Posterior, u: Floats, least: float = SMALLEST_GAIN) -> Peak:
    """The peak that is reached from u `[n_slots]`, by steps that gain `least` nats or more.

    The information is the sum over events of squares of their scores. Against a bound, where the
    density falls as an exponential, the standard deviation is one over its rate.
    """
    layout = posterior.layout
    axes = [k for k, slot in enumerate(layout.slots) if slot.arm]
    others = np.setdiff1d(np.arange(len(u)), axes)
    u, cost = climb(posterior.pinned(u), u, others, ITERATIONS)
    prior = np.diag([slot.sd**-2.0 for slot in layout.slots])
    damping, apart = DAMPING, APART * units(posterior)
    sd = np.ones(len(u))
    for _ in range(STEPS):
        scores = scores_at(posterior, u, apart)
        slope = np.sum(scores, axis=0) + layout.prior_slopes(u)
        information = scores.T @ scores + prior
        apart = np.minimum(apart, SHARE_APART / np.sqrt(np.diag(information)))
        against = ((u <= layout.low) & (slope < 0.0)) | ((u >= layout.high) & (slope > 0.0))
        free = np.flatnonzero(~against)
        inner = information[np.ix_(free, free)]
        sd[free] = np.sqrt(np.diag(np.linalg.inv(inner)))
        sd[against] = 1.0 / np.maximum(np.abs(slope), 1.0)[against]
        gain = 0.0
        while damping <= MOST_DAMPING:
            moved = u.copy()
            damped = inner + damping * np.diag(np.diag(inner))
            moved[free] += np.linalg.solve(damped, slope[free])
            moved = np.clip(moved, layout.low, layout.high)
            moved, reached = climb(posterior.pinned(moved), moved, others, ITERATIONS)
            if reached < cost:
                gain, u, cost = cost - reached, moved, reached
                damping = max(0.1 * damping, DAMPING)
                break
            damping *= 10.0
        if gain < least:
            break
    return Peak(u, sd, -cost)


def _on(
    posterior: Posterior, axes: Ints, u: Floats, low: Floats, high: Floats, points: Ints
) -> tuple[Posterior, Mode]:
    """The posterior on a star about u with arms of these ends and numbers of points; its mode."""
    sides = zip(axes, u[axes].tolist(), low.tolist(), high.tolist(), points.tolist(), strict=True)
    slots = posterior.layout.slots
    local = posterior.on_star({slots[k].name: arm_between(*of_arm) for k, *of_arm in sides})
    return local, find_mode(local, u)


def _errors(posterior: Posterior, mode: Mode, centre: Floats, axes: Ints) -> Floats:
    """By how much a star errs (nats) along its axes `[n_axes]`, some standard deviations off.

    Where the mode has moved from the `centre`, its own error counts along all that have moved by
    much.
    """
    low, high = posterior.layout.low, posterior.layout.high
    sd = np.sqrt(np.diag(mode.covariance))
    away = np.abs(mode.u - centre)[axes] / sd[axes]
    errors = np.where(away >= 0.5 * np.max(away), _error(posterior, mode.u), 0.0)
    for j, axis in enumerate(axes):
        move = CHECKED * mode.covariance[:, axis] / sd[axis]
        sides = np.clip([mode.u - move, mode.u + move], low, high)
        errors[j] = max(errors[j], *(_error(posterior, side) for side in sides))
    return errors


def _error(posterior: Posterior, u: Floats) -> float:
    return abs(posterior.log_likelihood(u) - posterior.exact_log_likelihood(u))


def improved(fine: Posterior, whole: Posterior, draws: Floats) -> Posterior | None:
    """`fine` on a better star where its `draws` `[..., n_slots]` ask for one, else None.

    It reaches on where draws gather at an end that the ranges of `whole` do not have: the curvature
    at the mode of a posterior that is skewed or bent says too little of how far it reaches. It gets
    more points where some of the draws disagree with tables made on the spot.
    """
    flat = draws.reshape(-1, draws.shape[-1])
    some = flat[np.linspace(0, len(flat) - 1, CHECKED_DRAWS).astype(np.int64)]
    wrong = bool(fine.nodes.varies) and max(_error(fine, u) for u in some) > DRAWS_TOLERANCE
    arms = {}
    for k, (slot, range_) in enumerate(zip(fine.layout.slots, whole.layout.slots, strict=True)):
        if not slot.arm:
            continue
        length, low, high, n = slot.high - slot.low, slot.low, slot.high, len(slot.arm) - 1
        if low > range_.low and np.mean(flat[:, k] < low + EDGE * length) > EDGE_SHARE:
            low = max(low - length, range_.low)
        if high < range_.high and np.mean(flat[:, k] > high - EDGE * length) > EDGE_SHARE:
            high = min(high + length, range_.high)
        longer = (low, high) != (slot.low, slot.high)
        more = min(2 * n, MOST_POINTS) if longer or wrong else n
        if longer or more > n:
            centre = float(np.median(flat[:, k])) if longer else slot.arm[0]
            arms[slot.name] = arm_between(centre, low, high, more)
    return fine.on_star(arms) if arms else None


FIRST_POINTS, OTHER_POINTS = 5, 3
"""Values tried of the first parameter of an effect, and of each other one."""
TRACK_SCATTERS = (-1.2, 0.0, 1.2)
"""Logs of the scatters along tracks that are tried, from the most plausible one."""
HELD_ITERATIONS = 20
SHARES, SHIFTS, CLIMBED, MOST_EXPLAINED = (0.15, 0.3, 0.5, 0.7, 0.85), (1.5, 2.5, 4.0, 6.0), 2, 0.85
"""Shares of a second kind of avalanche that are tried, its shifts in scatters, from how many of
these the mode is sought, and the part of the variance of friction that kinds may explain."""


def search_mode(
    posterior: Posterior,
    start: Floats | None = None,
    likely: Mapping[str, Sequence[Floats] | None] | None = None,
    least: float = -np.inf,
) -> tuple[Posterior, Mode]:
    """The highest mode found from `start` (or the data) and from plausible values of effects.

    With it, the posterior on the star about it (`starred`), if the log likelihood there is `least`
    or more. `likely` names the effects that are tried, if not all, with values for those that have
    more likely ones.
    """
    layout = posterior.layout
    u = start_coordinates(posterior) if start is None else np.clip(start, layout.low, layout.high)
    starts = starts_of_kinds(posterior, u)
    if not posterior.nodes.varies:
        modes = [find_mode(posterior, at) for at in starts]
        return posterior, max(modes, key=lambda mode: mode.log_density)
    at = max(starts, key=lambda start: posterior.pinned(start).log_density(start))
    for effect in posterior.effects:
        if likely is None or effect.key in likely:
            tried = short_climbs(posterior, at, effect, (likely or {}).get(effect.key))
            here = posterior.pinned(at).log_density(at)
            at = max([(here, at), *tried], key=lambda climb: climb[0])[1]
    peak = gauss_newton(posterior, at)
    if posterior.exact_log_likelihood(peak.u) < least:
        return posterior, Mode(peak.u, peak.log_density, np.diag(peak.sd**2))
    return starred(posterior, peak)


def mode_on_star(posterior: Posterior, u: Floats, whole: Posterior) -> Mode | None:
    """The highest mode found from u `[n_slots]` on the star that a posterior has already.

    None where the star errs there, or ends within `CHECKED` standard deviations while the ranges of
    `whole` go on.
    """
    modes = [find_mode(posterior, at) for at in starts_of_kinds(posterior, u)]
    mode = max(modes, key=lambda mode: mode.log_density)
    low, high = posterior.layout.low, posterior.layout.high
    away = CHECKED * np.sqrt(np.diag(mode.covariance))
    ends = (mode.u - away < low) & (low > whole.layout.low)
    ends |= (mode.u + away > high) & (high < whole.layout.high)
    return None if ends.any() or _error(posterior, mode.u) > TOLERANCE else mode


def mode_from(posterior: Posterior, u: Floats) -> tuple[Posterior, Mode]:
    """The mode that is reached from u `[n_slots]`, with the posterior on the star about it."""
    if not posterior.nodes.varies:
        return posterior, find_mode(posterior, u)
    return starred(posterior, gauss_newton(posterior, u))


def short_climbs(
    posterior: Posterior, u: Floats, effect: Effect, values: Sequence[Floats] | None = None
) -> list[tuple[float, Floats]]:
    """Log density and coordinates of short ascents from u with the effect kept at these values.

    At plausible ones where none are given. No ascents for an effect that shapes no tables.
    """
    layout = posterior.layout
    place = layout.places.get(effect.key, slice(0, 0))
    held = [k for k in layout.tables if place.start <= k < place.stop]
    if not held:
        return []
    scales = [layout.slots[k].scale for k in held]
    starts = [v / scales for v in (_tried(effect) if values is None else values)]
    if layout.track_scatter is not None:
        # With the effect less is left to scatter along tracks.
        middle = layout.slots[layout.track_scatter].mean
        held = [*held, layout.track_scatter]
        starts = [np.append(v, middle + s) for v in starts for s in TRACK_SCATTERS]
    return [held_climb(posterior, u, held, v) for v in starts]


def starts_of_kinds(posterior: Posterior, u: Floats) -> list[Floats]:
    """Coordinates from which two kinds of avalanche are sought where u has one: the likeliest.

    Where all are of one kind nothing moves. What is tried leaves friction its mean, and takes what
    kinds explain from its variance.
    """
    layout = posterior.layout
    if layout.kinds is None or posterior.friction.kinds(u) is not None:
        return [u]
    sigma = np.exp(u[layout.scatter])
    sigma *= scatter_centre(True) / scatter_centre(layout.log_scatter)
    scales = [slot.scale for slot in layout.slots[layout.kinds]]
    tried = []
    for share, shift in product(SHARES, SHIFTS):
        at = u.copy()
        part = min(share * (1.0 - share) * shift**2, MOST_EXPLAINED)
        at[layout.kinds] = np.array([share, -sigma * shift]) / scales
        at[layout.scatter] += 0.5 * np.log1p(-part)
        tried.append(np.clip(at, layout.low, layout.high))
    best = np.argsort(-posterior.log_densities(np.array(tried)))
    return [tried[k] for k in best[:CLIMBED]]


def _tried(effect: Effect) -> list[Floats]:
    """Values of an effect's parameters `[n_parameters]`."""
    first, *others = effect.parameters
    # One that is 0 at neutral is an amount by itself, which Gauss-Newton's steps find.
    between = (
        [0.0] if p.neutral == 0.0 else np.linspace(p.low, p.high, OTHER_POINTS) for p in others
    )
    return [np.array(corner) for corner in product(first.plausible(FIRST_POINTS), *between)]


def held_climb(
    posterior: Posterior, u: Floats, held: Sequence[int], values: Sequence[float] | Floats
) -> tuple[float, Floats]:
    """Log density and coordinates of a short ascent from u with slots `held` kept at `values`.

    All that shapes the tables is held as well, where it is.
    """
    start = u.copy()
    start[list(held)] = values
    slots = posterior.layout.slots
    free = [k for k, slot in enumerate(slots) if not slot.arm and k not in held]
    reached, cost = climb(posterior.pinned(start), start, np.array(free, np.int64), HELD_ITERATIONS)
    return -cost, reached
