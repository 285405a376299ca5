"""The star of exact tables on which a posterior stands (`likelihood.node_charts`), and its mode.

Gauss-Newton steps on tables made on the spot, from the best of plausible values of each effect's
parameters, then a star about the mode that agrees with such tables: docs/theory/likelihood.md,
"Stars".
"""

from collections.abc import Mapping, Sequence
from itertools import product
from operator import itemgetter

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import Effect, MotionEffect
from avahazard.inference.fitting.arms import (
    REACH,
    arms_about,
    beside_arms,
    directions,
    far_apart,
    shares_held,
    size_wanted,
    turned_back,
)
from avahazard.inference.fitting.mode import (
    APART,
    Mode,
    ascent,
    checked_draws,
    errors_at,
    find_mode,
    held_ascent,
    scores_at,
    start_coordinates,
    units,
)
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import arm_between, scatter_centre

STEPS, SMALLEST_GAIN = 40, 0.1
"""Most Gauss-Newton steps, and the gain (nats) of the last."""
SHARE_APART = 0.6
"""Differences for derivatives, in standard deviations of directions that are independent: the log
likelihood is rough by a tenth of a nat, which the coordinates by themselves do not bear."""
WIDELY_APART = 1.5
"""The same about a peak, to both sides."""
DAMPING, MOST_STRETCH = 1e-3, 16.0
ITERATIONS, CLOSELY = 30, 0.01
"""Most iterations of an ascent on one table, and the least gain (nats) of one."""
ENOUGH, WORTH_A_STEP = 0.1, 0.1
"""Share of the gain expected to first order that a step must have not to be shortened: one that
gains less may lead off along a ridge. And of the least gain that it must promise."""
LONGER = 1.6
"""How much longer by the curvature on a star its arms may be at a bound before it is made anew,
once: the peak does not show what goes with a coordinate there."""
FALLS, LEAST_FALL, MOST_FALL, IMPOSSIBLE = 5, 2.0, 18.0, 1e4
"""Distances tried for a standard deviation, falls of the log density (nats) that give it, and the
most that an infinite fall counts."""
SURVEYS, FARTHER = 4, 1.5
"""Surveys of a peak, each in the directions of the one before where that found it wider by much."""
POINTS, MOST_POINTS = 4, 16
"""Points of an arm besides the centre, and the most that it gets where it errs."""
BESIDE, MOST_BESIDE = 12, 60
"""Points beside the arms that a star gets at once, and the most."""
N_AMONG = 200
"""Points among draws that were made without a star."""
MOST_STARS, MOST_ERROR = 8, 2.0
TOLERANCE, CHECKED = 1.0, 2.0
"""Largest error (nats) of the log likelihood at draws (`errors_at`), at the mode, and `CHECKED`
standard deviations off: the likelihood itself is rough by tenths."""
EDGE_NEAR = 1e-3
"""Share of an arm within which a mode is at its end."""
EDGE, EDGE_SHARE = 0.02, 0.005
"""Draws gather at an edge where more than that share are within that part of the star's reach."""


def starred(posterior: Posterior, peak: Mode) -> tuple[Posterior, Mode]:
    """The posterior on a star about a peak, and its mode there.

    An arm along which it errs gets more points, `MOST_POINTS` at most: on terrain with steps the
    likelihood itself may be rough. Arms of a star whose mode is none of the exact tables are too
    long: they are halved.
    """
    axes = posterior.layout.axes
    u, size = peak.u, REACH**2 * peak.covariance[np.ix_(axes, axes)]
    points, before, good = np.full(len(axes), POINTS), np.inf, None
    low, high = posterior.layout.low[axes], posterior.layout.high[axes]
    sized = not np.any((u[axes] <= low) | (u[axes] >= high))
    for _ in range(MOST_STARS):
        local = posterior.on_star(arms_about(posterior, u, size, points))
        mode = find_mode(local, u)
        if _error(local, mode.u) > MOST_ERROR:
            u, size = peak.u, 0.25 * size
            continue
        good, back = (local, mode), turned_back(local)
        held = shares_held(local, mode.u[None], EDGE_NEAR) > 0.0
        wanted = size_wanted(local, (peak if sized else mode).covariance, held)
        longer = np.diag(back @ wanted @ back.T) > LONGER**2 * np.diag(back @ size @ back.T)
        if held.any() or (longer.any() and not sized):
            u, size, sized = mode.u if held.any() else u, wanted, True
            continue
        errors = _errors(local, mode, u)
        wrong = (errors > TOLERANCE) & (points < MOST_POINTS)
        if not wrong.any() or np.max(errors) > 0.5 * before:
            break  # it is right, or errs between the arms
        points, before = np.where(wrong, 2 * points, points), np.max(errors)
    return good or (local, mode)


def gauss_newton(posterior: Posterior, u: Floats, least: float = SMALLEST_GAIN) -> Mode:
    """The peak that is reached from u `[n_slots]`, by steps that gain `least` nats or more.

    Steps are stretched while they gain. Where they end, the information is held against how the
    density falls (`surveyed_peak`), after every gain once more, and from there on scores are taken
    over wider differences (docs/theory/likelihood.md, "Stars").
    """
    layout = posterior.layout
    others = np.setdiff1d(np.arange(len(u)), posterior.layout.axes)
    u, cost = ascent(posterior.pinned(u), u, others, ITERATIONS, CLOSELY)
    moves, surveyed = np.diag(APART * units(posterior)), None
    damping, stretch, apart, both_ways = DAMPING, 1.0, SHARE_APART, False
    for _ in range(STEPS):
        scores = scores_at(posterior, u, moves, both_ways=both_ways)
        slope, free, inner, covariance = _information(posterior, u, scores)
        turn, along = directions(posterior, u, covariance)
        moves = apart * turn * along
        at, best = u, cost
        while True:
            moved = u.copy()
            move = np.linalg.solve(inner + damping * np.diag(np.diag(inner)), slope[free])
            expected = 0.5 * slope[free] @ move
            if expected < WORTH_A_STEP * least:
                break
            moved[free] += stretch * move
            moved = np.clip(moved, layout.low, layout.high)
            moved, reached = ascent(posterior.pinned(moved), moved, others, ITERATIONS, CLOSELY)
            if reached < best:
                at, best = moved, reached
            if cost - best > ENOUGH * expected:
                damping, stretch = max(0.1 * damping, DAMPING), min(2.0 * stretch, MOST_STRETCH)
                break
            if stretch > 1.0:
                stretch = 1.0
            else:
                damping *= 10.0
        gain, u, cost = cost - best, at, best
        if gain >= least:
            surveyed = None
        elif surveyed is None:
            surveyed = surveyed_peak(posterior, Mode(u, -cost, covariance), scores)
            u, cost = surveyed.u, -surveyed.log_density
            turn, along = directions(posterior, u, surveyed.covariance)
            damping, stretch, apart, both_ways = DAMPING, 1.0, WIDELY_APART, True
            moves = apart * turn * along
        else:
            break
    return Mode(u, -cost, covariance if surveyed is None else surveyed.covariance)


def _information(
    posterior: Posterior, u: Floats, scores: Floats
) -> tuple[Floats, Ints, Floats, Floats]:
    """Slope `[n_slots]` of the density by scores `[n_events, n_slots]`, and their information.

    This is of the slots that are free, not held against a bound; last, the covariance of all.
    """
    layout = posterior.layout
    slope = np.sum(scores, axis=0) + layout.prior_slopes(u)
    prior = np.diag([1.0 / slot.sd for slot in layout.slots])
    against = ((u <= layout.low) & (slope < 0.0)) | ((u >= layout.high) & (slope > 0.0))
    free = np.flatnonzero(~against)
    # By its root: what the prior alone holds is lost beside scores 1e5 times as large.
    root = np.linalg.qr(np.vstack([scores, prior])[:, free]).R
    back = np.linalg.inv(root)
    covariance = np.diag(np.maximum(np.abs(slope), 1.0) ** -2.0)
    covariance[np.ix_(free, free)] = back @ back.T
    return slope, free, root.T @ root, covariance


def surveyed_peak(posterior: Posterior, peak: Mode, scores: Floats) -> Mode:
    """A peak with spreads by how far the density falls, and the best place seen on the way.

    Along each direction that moves the tables, to both sides. The `scores` have the steps of a
    rough likelihood in them; where those over the wide differences reach farther, along a ridge,
    the density is surveyed again in the directions that they give.
    """
    layout, best, best_at = posterior.layout, peak.log_density, peak.u
    given, covariance = posterior.pinned(peak.u).mode_offsets(peak.u), peak.covariance
    for _ in range(SURVEYS):
        turn, along = directions(posterior, peak.u, covariance)
        by_direction = scores @ turn
        for j in posterior.layout.axes:
            away, spread = REACH, along[j]
            for _ in range(FALLS):
                sides = peak.u + np.outer([-away, away], along[j] * turn[:, j])
                inside = [v for v in sides if np.all((v >= layout.low) & (v <= layout.high))]
                if not inside:
                    away *= 0.5
                    continue
                here = [posterior.pinned(v).log_density(v) for v in inside]
                seen = [(best, best_at), *zip(here, inside, strict=True)]
                best, best_at = max(seen, key=itemgetter(0))
                fall = np.clip(peak.log_density - sum(here) / len(here), LEAST_FALL, IMPOSSIBLE)
                spread = along[j] * away / np.sqrt(2.0 * fall)
                if LEAST_FALL < fall <= MOST_FALL:
                    break
                away *= 2.0 if fall == LEAST_FALL else 0.5
            if len(inside) == 2:
                behind, ahead = (posterior.pinned(v).event_log_likelihood(v, given) for v in inside)
                slopes = (ahead - behind) / (inside[1] - inside[0])[j]  # `turn` is 1 there
                if np.all(np.isfinite(slopes)):  # no event is impossible there
                    by_direction[:, j] = slopes
            along[j] = spread
        found = turn @ np.diag(along**2) @ turn.T
        scores = by_direction @ np.linalg.inv(turn)
        before, covariance = covariance, _information(posterior, peak.u, scores)[-1]
        if np.all(np.diag(covariance) < FARTHER**2 * np.diag(before)):
            break
    return Mode(best_at, best, found)


def _errors(posterior: Posterior, mode: Mode, centre: Floats) -> Floats:
    """By how much a star errs (nats) along its arms `[n_axes]`, some standard deviations off.

    Where the mode has moved from the `centre`, its own error counts along all that have moved by
    much.
    """
    axes, back, moves = posterior.layout.axes, turned_back(posterior), _moves(posterior, mode)
    away = np.abs(back @ (mode.u - centre)[axes]) / np.diag(back @ moves[:, axes].T)
    errors = np.where(away >= 0.5 * np.max(away), _error(posterior, mode.u), 0.0)
    for j, move in enumerate(moves):
        sides = np.clip([mode.u - move, mode.u + move], *posterior.layout.ranges)
        errors[j] = max(errors[j], *(_error(posterior, side) for side in sides))
    return errors


def _moves(posterior: Posterior, mode: Mode) -> Floats:
    """`CHECKED` standard deviations along each arm, `[n_axes, n_slots]`, with what goes with it."""
    axes, back = posterior.layout.axes, turned_back(posterior)
    together = mode.covariance[:, axes] @ back.T
    return np.asarray(CHECKED * (together / np.sqrt(np.diag(back @ together[axes]))).T)


def _error(posterior: Posterior, u: Floats) -> float:
    return abs(posterior.log_likelihood(u) - posterior.exact_log_likelihood(u))


def improved(fine: Posterior, draws: Floats) -> Posterior | None:
    """`fine` on a better star where its `draws` `[..., n_slots]` ask for one, else None.

    It reaches on where draws gather at an end that their range does not have, and has more points,
    some beside its arms, where draws disagree with tables made on the spot.
    """
    if not fine.nodes.varies:
        return None
    flat = draws.reshape(-1, draws.shape[-1])
    checked = checked_draws(flat)
    wrong = checked[np.abs(errors_at(fine, checked)) > TOLERANCE]
    gathers = shares_held(fine, flat, EDGE) > EDGE_SHARE
    slots, axes = fine.layout.slots, fine.layout.axes
    points = np.array([len(slots[k].arm) - 1 for k in axes])
    more = np.where(gathers | (len(wrong) > 0), np.minimum(2 * points, MOST_POINTS), points)
    if gathers.any():
        size = size_wanted(fine, np.cov(flat.T), gathers)
        return fine.on_star(arms_about(fine, np.median(flat, axis=0), size, more))
    beside = np.array([slots[k].beside for k in axes]).T
    if not len(wrong) or len(beside) >= MOST_BESIDE:
        return None
    on_arms = fine.layout.on_arms
    beside = np.concatenate([beside, on_arms(wrong)[:, axes]])
    beside = far_apart(on_arms(flat)[:, axes], beside, BESIDE - len(wrong))
    ends = zip(axes, *fine.layout.arm_ends[:, axes].tolist(), more.tolist(), strict=True)
    arms = {slots[k].name: arm_between(slots[k].arm[0], low, high, n) for k, low, high, n in ends}
    return fine.on_star(beside_arms(fine, fine.layout.arms._replace(points=arms), beside))


def star_among(posterior: Posterior, draws: Floats) -> Posterior:
    """The posterior on a star about its `draws` `[n, n_slots]`, with points among these."""
    axes = posterior.layout.axes
    points = np.full(len(axes), MOST_POINTS)
    size = REACH**2 * np.cov(draws.T)[np.ix_(axes, axes)]
    star = posterior.on_star(arms_about(posterior, np.median(draws, axis=0), size, points))
    slots = [star.layout.slots[k] for k in axes]
    places = np.clip(star.layout.on_arms(draws), *star.layout.arm_ends)[:, axes]
    taken = np.array([[slot.arm[0], *slot.beside] for slot in slots]).T
    among = far_apart(places, taken, N_AMONG)[1:]
    return star.on_star(beside_arms(star, star.layout.arms, among))


FIRST_POINTS, OTHER_POINTS = 5, 3
"""Values tried of the first parameter of an effect, and of each other one."""
TRACK_SCATTERS = (-1.2, 0.0, 1.2)
"""Logs of the scatters along tracks that are tried, from the most plausible one."""
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
            tried = short_ascents(posterior, at, effect, (likely or {}).get(effect.key))
            here = posterior.pinned(at).log_density(at)
            at = max([(here, at), *tried], key=lambda ascent: ascent[0])[1]
    peak = gauss_newton(posterior, at)
    if posterior.exact_log_likelihood(peak.u) < least:
        return posterior, peak
    return starred(posterior, peak)


def mode_on_star(posterior: Posterior, u: Floats) -> Mode | None:
    """The highest mode found from u `[n_slots]` on the star that a posterior has already.

    None where the star errs there by more than at draws, or ends there while the ranges go on.
    """
    modes = [find_mode(posterior, at) for at in starts_of_kinds(posterior, u)]
    mode = max(modes, key=lambda mode: mode.log_density)
    ends = shares_held(posterior, mode.u[None], EDGE_NEAR) > 0.0
    return None if ends.any() or _error(posterior, mode.u) > TOLERANCE else mode


def mode_from(posterior: Posterior, u: Floats) -> tuple[Posterior, Mode]:
    """The mode that is reached from u `[n_slots]`, with the posterior on the star about it."""
    if not posterior.nodes.varies:
        return posterior, find_mode(posterior, u)
    return starred(posterior, gauss_newton(posterior, u))


def short_ascents(
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
    return [held_ascent(posterior, u, held, v) for v in starts]


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
    amounts = first.plausible(FIRST_POINTS)
    tried = [np.array(corner) for corner in product(amounts, *between)]
    shapes = effect.shapes if isinstance(effect, MotionEffect) else ()
    return tried + [by * np.array(shape) for shape in shapes for by in amounts]
