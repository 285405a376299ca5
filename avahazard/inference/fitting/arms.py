"""The arms of a star: how far it reaches about a place, which way, and with what points."""

from itertools import product

import numpy as np

from avahazard.arrays import Bools, Floats, Ints
from avahazard.inference.fitting.mode import held_ascent
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import Arms, arm_between

REACH = 4.0
"""Standard deviations about the mode to which a star reaches."""
LEANS = 0.3
"""Share of the reach about the mode within which an end of a range turns no arms."""
MOST_TIMES = 6.0
"""Most by which arms are longer, or shorter, than those of the star before."""
MORE = 0.1
"""Share of an arm by which a range must go on beyond the end of it."""
EACH = 5
"""Values of each parameter of those that can be anything, at whose products there are points."""
SHARES, FAR = 2.0 ** np.arange(-6, 1), 10.0
"""Shares of its range to which an amount can go, and a fall of the log density (nats) that ends
it."""
CANDIDATES = 500
"""Most draws out of which points are chosen."""


def arms_about(posterior: Posterior, u: Floats, size: Floats, points: Ints) -> Arms:
    """The arms of a star about u, of these numbers of `points` `[n_axes]`.

    They are as long as `size` `[n_axes, n_axes]`, the square of the reach times a covariance, and
    turn with it. Those that lean against an end of their range are moved by their own arms alone,
    and so are those that can be anything (`_free_together`): these have all that they can be, with
    points beside the arms (`_all_over`).
    """
    axes, slots = posterior.layout.axes, posterior.layout.slots
    low, high = posterior.layout.ranges[:, axes]
    reach = np.sqrt(np.diag(size))
    free = _free_together(posterior, u[axes], reach)
    anywhere = np.isin(np.arange(len(axes)), [j for together in free for j in together])
    leans = (u[axes] - LEANS * reach < low) | (u[axes] + LEANS * reach > high) | anywhere
    rank = 1 - leans
    for k in np.flatnonzero(axes == posterior.layout.track_scatter):
        # Events without speeds lack it: it moves no others, and where it leans none move it.
        apart = np.arange(len(axes)) != k
        size, rank[k] = size.copy(), 2
        size[k, apart & leans[k]] = size[apart & leans[k], k] = 0.0
    turn, half = _turned(size, rank)
    at: Floats = np.linalg.solve(turn, u[axes]).astype(np.float64)
    beside = [np.empty((0, len(axes)))]
    for together in free:
        beside.append(_all_over(posterior, u, turn, together, reach[together[0]]))
        half[together] = np.max(np.abs(beside[-1] - at), axis=0)[together]
    arms, along = {}, {}
    for j, axis in enumerate(axes):
        down, up = (min(half[j], _room(s * turn[:, j], u[axes], low, high)) for s in (-1, 1))
        ends = float(at[j] - down), float(at[j] + up)
        arms[slots[axis].name] = arm_between(float(at[j]), *ends, int(points[j]))
        moved = [i for i in np.flatnonzero(turn[:, j]) if i != j]
        along[slots[axis].name] = {slots[axes[i]].name: float(turn[i, j]) for i in moved}
    return beside_arms(posterior, Arms(arms, along), np.concatenate(beside))


def beside_arms(posterior: Posterior, arms: Arms, points: Floats) -> Arms:
    """The arms with these `points` `[n_points, n_axes]` beside them, by their places on each."""
    names = [posterior.layout.slots[k].name for k in posterior.layout.axes]
    return arms._replace(beside=dict(zip(names, points.T.tolist(), strict=True)))


def _free_together(posterior: Posterior, at: Floats, reach: Floats) -> list[list[int]]:
    """Axes of each effect that may be none within `reach` `[n_axes]` of a place: can be anything.

    Where an effect is none its other parameters can be anything, and where they leave it little to
    act on, its amount can; not so where all are amounts, 0 at neutral.
    """
    layout, axes, found = posterior.layout, posterior.layout.axes.tolist(), []
    for place in layout.places.values():
        together = [axes.index(k) for k in range(place.start, place.stop) if k in axes]
        neutral = [layout.slots[axes[j]].neutral for j in together]
        if any(neutral[1:]) and abs(at[together[0]] - neutral[0]) < reach[together[0]]:
            found.append(together)
    return found


def _all_over(
    posterior: Posterior, u: Floats, turn: Floats, together: list[int], reach: float
) -> Floats:
    """Places on the arms `[n, n_axes]` all over what parameters can be that can be anything.

    The first of these `together` (axes) is an amount: it goes beyond its `reach` about u until the
    density there has fallen by `FAR`, whatever the others are. Its places are closer near none.
    """
    (first, *others), axes = together, posterior.layout.axes
    low, high = posterior.layout.ranges[:, axes]
    at, none = np.linalg.solve(turn, u[axes]), posterior.layout.slots[axes[first]].neutral
    most = max(low[first] - none, high[first] - none, key=abs)
    shapes = np.array([*product(*(np.linspace(low[j], high[j], EACH) for j in others))])

    def places(amount: float) -> Floats:
        found = np.tile(at, (len(shapes), 1))
        found[:, first], found[:, others] = none + amount, shapes
        return found

    least = posterior.pinned(u).log_density(u) - FAR
    going_on = np.full(len(shapes), True)
    for share in SHARES:
        amount = share * most
        if abs(amount) < reach + abs(at[first] - none):
            continue
        there = np.clip(places(amount) @ turn.T, low, high)
        for k in np.flatnonzero(going_on):
            going_on[k] = held_ascent(posterior, u, axes, there[k])[0] > least
        if not going_on.any():
            break
    closer = np.linspace(0.0, 1.0, EACH + 1)[1:] ** 2
    return np.concatenate([places(amount * share) for share in closer])


def _turned(covariance: Floats, rank: Ints) -> tuple[Floats, Floats]:
    """Directions (columns) that are independent under a covariance, and the spread along each.

    Coordinates move with those of lower rank; of those of rank 0 each keeps to itself.
    """
    order = np.argsort(rank, kind="stable")
    # Positive in spite of rounding.
    covariance = covariance + 1e-9 * np.diag(np.diag(covariance))
    lower, n = np.linalg.cholesky(covariance[np.ix_(order, order)]), int(np.sum(rank == 0))
    spread = np.sqrt(np.diag(covariance))
    spread[order[n:]] = np.diag(lower)[n:]
    lower /= np.diag(lower)
    lower[:n, :n] = np.eye(n)
    turn = np.empty_like(lower)
    turn[np.ix_(order, order)] = lower
    return turn, spread


def directions(posterior: Posterior, u: Floats, covariance: Floats) -> tuple[Floats, Floats]:
    """`_turned` of all coordinates: what shapes no tables moves with what does."""
    layout = posterior.layout
    rank, spread = np.full(len(u), 2), LEANS * np.sqrt(np.diag(covariance))
    rank[posterior.layout.axes] = 1
    leans = (u - spread < layout.low) | (u + spread > layout.high)
    return _turned(covariance, np.where(leans, 0, rank))


def _room(move: Floats, at: Floats, low: Floats, high: Floats) -> float:
    """How far `move` `[n]` can be gone from a place within its ends, `[n]` each."""
    ends = np.where(move > 0.0, high, low)
    ways = (ends - at)[move != 0.0] / move[move != 0.0]
    return max(0.0, float(np.min(ways)))


def shares_held(posterior: Posterior, u: Floats, edge: float) -> Floats:
    """Shares of places u `[n, n_slots]` at an end of each arm `[n_axes]` where its range goes on.

    That is, within the part `edge` of the arm from that end.
    """
    layout, axes = posterior.layout, posterior.layout.axes
    (low, high), places = layout.arm_ends[:, axes], layout.on_arms(u)[:, axes]
    near, mean, turn = edge * (high - low), np.mean(u, axis=0), layout.turn[:, axes].T
    at, shares = np.mean(places, axis=0), np.zeros(len(axes))
    for beyond, sign, end in (
        (places <= low + near, -1.0, low),
        (places >= high - near, 1.0, high),
    ):
        rooms = np.array([_room(sign * move, mean, *layout.ranges) for move in turn])
        goes_on = rooms > sign * (end - at) + MORE * (high - low)
        shares = np.maximum(shares, np.mean(beyond, axis=0) * goes_on)
    return shares


def size_wanted(posterior: Posterior, covariance: Floats, longer: Bools) -> Floats:
    """The size of a better star (`arms_about`), by a covariance `[n_slots, n_slots]`.

    Of an arm that must be `longer` at least twice the length.
    """
    axes = posterior.layout.axes
    back, half = turned_back(posterior), 0.5 * np.ptp(posterior.layout.arm_ends[:, axes], axis=0)
    on_arms = back @ covariance[np.ix_(axes, axes)] @ back.T
    sd = np.sqrt(np.diag(on_arms))
    wanted = np.clip(REACH * sd, half / MOST_TIMES, MOST_TIMES * half)
    times = np.where(longer, np.maximum(wanted, 2.0 * half), wanted) / sd
    turn = posterior.layout.turn[np.ix_(axes, axes)]
    return np.asarray(turn @ (np.outer(times, times) * on_arms) @ turn.T)


def turned_back(posterior: Posterior) -> Floats:
    """What gives the places on the arms of coordinates, `[n_axes, n_axes]`."""
    axes = posterior.layout.axes
    return np.asarray(np.linalg.inv(posterior.layout.turn[np.ix_(axes, axes)]))


def far_apart(places: Floats, taken: Floats, n: int) -> Floats:
    """Places `[n_taken, n_axes]` that are taken, and n more of `places`, far from one another."""
    scale = np.std(places, axis=0)
    some = places[:: max(1, len(places) // CANDIDATES)]
    away = np.min(np.linalg.norm((some[:, None] - taken) / scale, axis=-1), axis=1)
    chosen = [*taken]
    for _ in range(n):
        chosen.append(some[np.argmax(away)])
        away = np.minimum(away, np.linalg.norm((some - chosen[-1]) / scale, axis=-1))
    return np.array(chosen)
