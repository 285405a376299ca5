"""The posterior mode and the curvature there, and the units in which they are sought."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from avahazard.arrays import Floats, Ints
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.likelihood.posterior import Posterior

STEEP = 100.0
"""Change of log friction per coordinate from which on a coordinate is too coarse to move in."""


def units(posterior: Posterior) -> Floats:
    """The unit of each coordinate `[n_slots]`, 1 where it is of order one as it should be.

    The n of the exponential law is so on paths of snow; with slides of 1e12 m3 its coordinate
    moves log friction by a million. There the unit is what moves it by one (root mean square).
    """
    law, volumes = posterior.layout.law, posterior.observations.volumes
    unit = np.ones(len(posterior.layout.slots))
    if not law.uses_volume or not volumes.population.known:
        return unit
    volume = np.exp(volumes.mean)
    middle = law.prior_mean
    for k in range(len(law.coordinates)):
        # Small enough that no law is at its bounds.
        step = np.zeros(len(middle))
        step[k] = 1e-12
        moved = law.log_friction(middle + step, volume) - law.log_friction(middle - step, volume)
        slope = float(np.sqrt(np.mean(np.square(moved / 2e-12))))
        if slope > STEEP:
            unit[k] = 1.0 / slope
    return unit


STEP, GRADIENT_STEP = 1e-3, 1e-6
"""Steps of the differences for curvature and gradient, in coordinates of order one."""
APART = 0.01
"""Differences for scores, in coordinates of order one."""
FALL = 0.5
"""Fall of the log density (nats) over which curvature is taken along the arms of a star."""
STEEPEST = 1e100
"""Slope (nats a unit) whose square a climb can bear: volumes off any scale have steeper ones."""
ITERATIONS = 200
LEAST_CURVATURE = 0.05
"""Curvature that is taken where the density hardly bends down."""
REFUSED = 1e10
"""Cost where the density is nought."""
FIRST_SPREAD = 0.5
"""Coordinate from which spreads between groups are sought."""


@dataclass(frozen=True, slots=True, eq=False)
class Mode:
    """A mode and the normal with its curvature.

    Coordinates `[n_slots]`, the log density there, and the covariance `[n_slots, n_slots]`.
    """

    u: Floats
    log_density: float
    covariance: Floats


def start_coordinates(posterior: Posterior) -> Floats:
    """Coordinates near the data: least squares of the law on each event's likely friction."""
    layout = posterior.layout
    u = np.array([s.mean if np.isnan(s.neutral) else s.neutral for s in layout.slots])
    u[list(layout.spreads.values())] = FIRST_SPREAD
    pinned = posterior.pinned(u)
    friction = likely_friction(pinned.nodes.at(u), layout.log_scatter)
    middle = posterior.observations.volumes.log_volume.shape[1] // 2
    volume = np.exp(posterior.observations.volumes.log_volume[:, middle])
    n = len(layout.law.coordinates)
    # Two starts, and the likelier: least squares can be led astray by one wild record.
    rough = u.copy()
    rough[:n] = layout.law.start(volume, friction)
    tried = [rough, u]
    best = max(tried, key=pinned.log_density)
    return np.asarray(np.clip(best, layout.low, layout.high))


def likely_friction(nodes: Nodes, in_log: bool) -> Floats:
    """Mean friction of each event's nodes `[n_events]`, nan for events that left the profile."""
    mean = np.sum(nodes.place * nodes.weight, axis=1)
    friction = np.exp(mean) if in_log else mean
    return np.where(nodes.is_probability, np.nan, friction)


def find_mode(
    posterior: Posterior, start: Floats | None = None, covariance: Floats | None = None
) -> Mode:
    """Maximise the posterior density within its bounds (L-BFGS-B), from `start` or the data.

    `covariance` may be given where a near fit knows it well enough; else it is found.
    """
    layout = posterior.layout
    u = start_coordinates(posterior) if start is None else np.clip(start, layout.low, layout.high)
    cost = -np.inf
    for _ in range(2):
        u, cost = climb(posterior, u, np.arange(len(u)), ITERATIONS)
    if covariance is None:
        covariance = covariance_at(posterior, u)
    return Mode(u, -cost, covariance)


def climb(posterior: Posterior, u: Floats, free: Ints, iterations: int) -> tuple[Floats, float]:
    """The best coordinates from u on with only the slots `free` moving, and the cost there.

    The cost is minus the log density; gradients are exact by the slots `Posterior.sloped`, and
    differences over `GRADIENT_STEP` of `units` by the others, forwards but at an upper bound.
    """
    low, high = posterior.layout.low, posterior.layout.high
    whole = u.copy()
    unit = units(posterior)
    apart = GRADIENT_STEP * unit
    exact = np.isin(free, posterior.sloped)

    def cost(v: Floats) -> tuple[float, Floats]:
        whole[free] = v * unit[free]
        at = np.clip(whole, low, high)
        value, slopes = np.nan, np.zeros(len(at))
        if exact.any():
            value, slopes = posterior.density_and_slopes(at)
        gradient, moved = -slopes[free], ~exact
        if not (np.isfinite(value) and np.all(np.abs(slopes * unit) < STEEPEST)):
            # Where there is no density there are no slopes of it.
            value, moved = -float(costs(posterior, at[None])[0]), np.full(len(free), True)
        if moved.any():
            step = np.where(at + apart > high, -apart, apart)[free[moved]]
            around = np.tile(at, (len(step), 1))
            around[np.arange(len(step)), free[moved]] += step
            gradient[moved] = (costs(posterior, around) + value) / step
        return -value, gradient * unit[free]

    bounds = list(zip((low / unit)[free], (high / unit)[free], strict=True))
    first = (u / unit)[free]
    found = minimize(
        cost, first, method="L-BFGS-B", jac=True, bounds=bounds, options={"maxiter": iterations}
    )
    whole[free] = found.x * unit[free]
    return np.clip(whole, low, high), float(found.fun)


def costs(posterior: Posterior, u: Floats) -> Floats:
    """Minus the log densities `[n]` at u `[n, n_slots]`; `REFUSED` where there is none."""
    values = -posterior.log_densities(u)
    return np.where(np.isfinite(values), values, REFUSED)


def covariance_at(posterior: Posterior, u: Floats) -> Floats:
    """Inverse of the Hessian of the cost, kept positive and finite."""
    n = len(u)
    # At a bound the differences are taken one step inside.
    low, high = posterior.layout.low, posterior.layout.high
    unit = units(posterior)
    centre = np.clip(u, low + 2 * STEP * unit, high - 2 * STEP * unit)
    step = _steps(posterior, centre, unit)
    steps = np.diag(step * unit)
    i, j = np.triu_indices(n, 1)
    moves = np.concatenate([np.zeros((1, n)), steps, -steps, steps[i] + steps[j]])
    moves = np.concatenate([moves, -steps[i] - steps[j]])
    parts = np.cumsum([1, n, n, len(i)])
    middle, ahead, behind, forth, back = np.split(costs(posterior, centre + moves), parts)
    alone = ahead + behind
    hessian = np.diag(alone - 2.0 * middle)
    # Both steps forwards and both back, less the steps by themselves.
    hessian[i, j] = hessian[j, i] = 0.5 * (forth + back - alone[i] - alone[j]) + middle
    hessian /= np.outer(step, step)
    values, vectors = np.linalg.eigh(hessian)
    if values[0] < LEAST_CURVATURE:
        if any(slot.arm for slot in posterior.layout.slots):
            # Bends of the blend hide the curvature: the information stands for it.
            scores = scores_at(posterior, u, APART * unit) * unit
            priors = np.array([slot.sd for slot in posterior.layout.slots]) / unit
            hessian = scores.T @ scores + np.diag(priors**-2.0)
        # Against a bound the density need not bend down, but falls as an exponential, whose
        # standard deviation is one over its rate.
        against = (u < low + 2 * STEP * unit) | (u > high - 2 * STEP * unit)
        rate = (ahead - behind) / (2.0 * step)
        values, vectors = np.linalg.eigh(hessian + np.diag(np.where(against, rate**2, 0.0)))
    values = np.clip(values, LEAST_CURVATURE, 1e8)
    return np.asarray(np.outer(unit, unit) * ((vectors / values) @ vectors.T))


def scores_at(posterior: Posterior, u: Floats, apart: Floats) -> Floats:
    """Derivatives of each event's log likelihood by every coordinate, `[n_events, n_slots]`.

    Differences over `apart` `[n_slots]`, of tables made on the spot.
    """
    pinned = posterior.pinned(u)
    offsets = pinned.mode_offsets(u)
    here = pinned.event_log_likelihood(u, offsets)
    scores, slots = np.zeros((len(here), len(u))), posterior.layout.slots

    def moved(k: int, by: float) -> Floats:
        there = u.copy()
        there[k] += by
        at = posterior.pinned(there) if slots[k].arm else pinned
        return at.event_log_likelihood(there, offsets)

    for k, step in enumerate(np.where(u + apart > posterior.layout.high, -apart, apart)):
        # A neutral effect is left out, and with it the small errors of runs that have it.
        neutral = bool(slots[k].arm) and u[k] == slots[k].neutral
        scores[:, k] = (moved(k, step) - (moved(k, 1e-6 * step) if neutral else here)) / step
    return scores


def _steps(posterior: Posterior, centre: Floats, unit: Floats) -> Floats:
    """Steps in units `[n_slots]` over which the curvature is taken: `STEP`, or until it shows.

    Along the arms of a star the density is a blend, with a bend at each point: there a step goes on
    until the density falls by `FALL`, as far as there is room.
    """
    step = np.full(len(centre), STEP)
    low, high = posterior.layout.low, posterior.layout.high
    room = np.minimum(centre - low, high - centre) / unit
    here = costs(posterior, centre[None])[0]
    for k in [k for k, slot in enumerate(posterior.layout.slots) if slot.arm]:
        longest = max(float(room[k]), STEP)
        while step[k] < longest:
            both = np.tile(centre, (2, 1))
            both[:, k] += np.array([1.0, -1.0]) * step[k] * unit[k]
            if np.mean(costs(posterior, both)) - here >= FALL:
                break
            step[k] = min(2.0 * step[k], longest)
    return step
