"""What a record says of friction, as nodes: p(record | μ), chances of leaving and of being seen.

Across a jump of F, or to the end of the profile, records are taken as spread evenly. Without a
profile L = H/μ exactly, from H/L = 0.001 of a slide on the sea floor on. A declared detection limit
is of places, and so an edge of friction (`hidden_from`): were the chance taken of records instead,
those above the limit would be impossible in part, and friction be driven up without end. A limit
that is estimated is one of records (`edges_of_sight`). See docs/theory/likelihood.md.
"""

import numpy as np

from avahazard.arrays import Bools, Floats
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.quadrature import A_PANEL, gauss_nodes, panel_nodes
from avahazard.inference.model.friction_model import HALF_LOG_2PI, normal_below
from avahazard.inference.model.observations import Observations
from avahazard.kernels import kernel
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU

REACH = 6.0
"""Records farther than this many standard deviations from F(μ), or H/μ, say nothing about μ."""
PIECE = 0.5
"""Largest step of F, in standard deviations of the record, between two points of it."""
LEAST_TAIL = 1e-9
"""Density beyond the grid, as a share of the mass within, that is not worth its cost."""
DEPTH = 40.0
"""Frictions whose log density is that much below the best are left out."""


@kernel
def record_density_nodes(  # type: ignore[no-untyped-def]
    record,
    left,
    observed_left,
    observed,
    sigma,
    log_speed,
    grid,
    hidden_from,
    panels,
    finest,
    place,
    weight,
    tail,
):
    """Nodes of p(record | μ) as in `panels`; returns the log of its total mass.

    `record`, `left`, `log_speed` `[n_friction]` are those of the frictions `grid`. Points lie no
    farther apart than `finest`. `tail` `[2]` is filled with p(record | μ) below and beyond the
    grid, where that of its ends holds, as a share of the total mass. Of frictions from
    `hidden_from` on there would be no record.
    """
    tables = record, left, observed, sigma, log_speed, grid, hidden_from
    points, masses, log_total = _density_points(*tables, observed_left, finest, tail)
    if len(points) == 0:
        return _nearest(*tables, place, weight)
    panel_nodes(points, masses, panels, place, weight)
    return log_total


@kernel(inner=True)
def _density_points(  # type: ignore[no-untyped-def]
    record, left, observed, sigma, log_speed, grid, hidden_from, observed_left, finest, tail
):
    """Points of p(record | μ), their masses as shares of the largest, and the log of all."""
    most = (int(np.ceil(2.0 * REACH / PIECE)) + 2) * len(grid)
    points, logs = np.empty(most), np.empty(most)
    if observed_left:
        count = _leaving_points(left, log_speed, grid, points, logs)
    else:
        count = _stop_points(
            record, left, observed, sigma, log_speed, grid, hidden_from, finest, points, logs
        )
    tail[:] = 0.0
    if count == 0:
        return points[:0], logs[:0], 0.0
    top = np.max(logs[:count])
    within = np.flatnonzero(logs[:count] > top - DEPTH)
    masses = np.exp(logs[within] - top)
    log_total = top + np.log(np.sum(masses))
    for side in range(2):
        j = -side
        if left[j] != observed_left or grid[j] >= hidden_from:
            continue
        log_end = log_speed[j]
        if not observed_left:
            log_end -= 0.5 * ((record[j] - observed) / sigma) ** 2 + np.log(sigma) + HALF_LOG_2PI
        share = np.exp(log_end - log_total)
        tail[side] = share if share > LEAST_TAIL else 0.0
    return points[within], masses, log_total


@kernel(inner=True)
def _leaving_points(left, log_speed, grid, points, logs):  # type: ignore[no-untyped-def]
    """Points of the frictions beyond the profile's end, and their log masses; returns how many."""
    count = 0
    for j in range(len(grid) - 1):
        if left[j] or left[j + 1]:
            # The status changes midway between two frictions.
            whole = left[j] and left[j + 1]
            t = 0.5 if whole else (0.25 if left[j] else 0.75)
            width = (grid[j + 1] - grid[j]) * (1.0 if whole else 0.5)
            points[count] = grid[j] + t * (grid[j + 1] - grid[j])
            logs[count] = np.log(width) + log_speed[j] + t * (log_speed[j + 1] - log_speed[j])
            count += 1
    return count


@kernel(inner=True)
def _stop_points(  # type: ignore[no-untyped-def]
    record, left, observed, sigma, log_speed, grid, hidden_from, finest, points, logs
):
    """Points of the frictions that stop within reach of the record; returns how many."""
    count = 0
    most = len(points) // len(grid)
    for j in range(len(grid) - 1):
        if left[j] and left[j + 1]:
            continue
        g0, width = grid[j], grid[j + 1] - grid[j]
        if g0 >= hidden_from:
            break
        l0, l1 = log_speed[j], log_speed[j + 1]
        z0, z1 = (record[j] - observed) / sigma, (record[j + 1] - observed) / sigma
        if min(z0, z1) > REACH or max(z0, z1) < -REACH:
            continue
        first, last = 0.0, 1.0
        if abs(z1 - z0) > PIECE:
            # Only the part of a jump that is within reach of the record counts.
            first = max(0.0, min((-REACH - z0) / (z1 - z0), (REACH - z0) / (z1 - z0)))
            last = min(1.0, max((-REACH - z0) / (z1 - z0), (REACH - z0) / (z1 - z0)))
        last = min(last, (hidden_from - g0) / width)
        if last <= first:
            continue
        pieces = int(np.ceil((last - first) * abs(z1 - z0) / PIECE)) + 1
        pieces = min(max(pieces, int(np.ceil((last - first) * width / finest))), most)
        step = (last - first) * width / pieces
        for p in range(pieces):
            t = first + (last - first) * (p + 0.5) / pieces
            z = z0 + t * (z1 - z0)
            points[count] = g0 + t * width
            logs[count] = -0.5 * z * z - np.log(sigma) - HALF_LOG_2PI + np.log(step)
            logs[count] += l0 + t * (l1 - l0)
            count += 1
    return count


@kernel(inner=True)
def _nearest(  # type: ignore[no-untyped-def]
    record, left, observed, sigma, log_speed, grid, hidden_from, place, weight
):
    """A record that no friction reaches: the nearest friction, at its (tiny) density."""
    best, value = 0, -np.inf
    for j in range(len(grid) - 1):
        if grid[j] >= hidden_from:
            break
        if left[j]:
            continue
        z = (record[j] - observed) / sigma
        candidate = -0.5 * z * z + log_speed[j]
        if np.isnan(observed):
            candidate = log_speed[j] - 1e3
        if candidate > value:
            best, value = j, candidate
    place[:], weight[:] = grid[best], 0.0
    weight[0] = 1.0
    if value == -np.inf:
        value = -1e4
    return value - np.log(sigma) - HALF_LOG_2PI + np.log(grid[best + 1] - grid[best])


STEEPEST = 3.0
"""Friction up to which a record with almost no information is followed."""
STEP, FEWEST, N_POINTS = 0.02, 128, 512
"""Step in log μ, and the fewest and most points."""


@kernel
def straight_density_nodes(height, observed, sigma, in_log, panels, place, weight, tail):  # type: ignore[no-untyped-def]
    """Nodes of p(record | μ) as in `panels`; returns the log of its total mass and the last place.

    `height` is the height of fall H, `observed` the runout length with error `sigma`, all in m.
    `tail` `[2]` is filled with p(record | μ) before all places (none) and beyond the last, where
    it is that of a block which goes nowhere, as shares of the total mass.
    """
    shortest = height / STEEPEST
    if observed > 0.0:
        shortest = min(shortest, 0.5 * observed)
    low = max(observed - REACH * sigma, shortest)
    high = observed + REACH * sigma
    if high <= low:  # a simulated record below zero only indicates a short runout
        high = 2.0 * low
    span = np.log(high) - np.log(low)
    count = int(min(max(np.ceil(span / STEP), FEWEST), N_POINTS))
    step = span / count
    points = np.log(height / high) + (np.arange(count) + 0.5) * step
    z = (height * np.exp(-points) - observed) / sigma
    logs = np.log(step) - 0.5 * z * z - np.log(sigma) - HALF_LOG_2PI
    if not in_log:
        logs += points
        points = np.exp(points)
    top = np.max(logs)
    masses = np.exp(logs - top)
    panel_nodes(points, masses, panels, place, weight)
    log_total = top + np.log(np.sum(masses))
    at_rest = -0.5 * (observed / sigma) ** 2 - np.log(sigma) - HALF_LOG_2PI
    share = np.exp(at_rest - log_total)
    tail[0], tail[1] = 0.0, share if share > LEAST_TAIL else 0.0
    return log_total, points[-1]


FEW = 4
"""Nodes of an edge of sight no wider than the least scatter: chances over 1 % err by 3 % at most
even for that, by 0.03 % for twice it. Each costs a normal probability at every evaluation."""


def hidden_from(observations: Observations, predicted: Predicted, in_log: bool = True) -> Floats:
    """Friction `[n_events]`, or its log, from which on stops lie above the declared limit.

    inf where all are seen, or no limit is declared; the lowest of the tables where none is. Seen is
    what stops below the limit, and all that goes further. Between two frictions stops are spread
    evenly, but for a discontinuous cell, in each half of which its end holds.
    """
    edge = np.full(observations.n_events, np.inf)
    grid = np.log(MU) if in_log else MU
    limited = np.flatnonzero(np.isfinite(observations.limit))
    for i, discontinuous in zip(limited, predicted.curve[limited].discontinuous, strict=True):
        elevation = predicted.elevation[i] - predicted.raised[i]
        left = predicted.status[i] == LEFT_PROFILE
        limit = observations.limit[i]
        seen = np.flatnonzero(left | (elevation <= limit))
        if not np.isfinite(elevation).any():
            continue
        if not len(seen):
            edge[i] = grid[0]
        elif (j := int(seen[-1])) < len(grid) - 1:
            low, high = elevation[j], elevation[j + 1]
            # The end of a profile may itself lie above the limit.
            share = 0.5 if discontinuous[j] or low > limit else (limit - low) / (high - low)
            edge[i] = grid[j] + share * (grid[j + 1] - grid[j])
    return edge


@kernel
def edges_of_sight(elevation, left, limit, sigma, grid, panels, finest, place, weight):  # type: ignore[no-untyped-def]
    """P(seen) = w₀ + Σ w_k P(ν < ν_k) by records, with error `sigma`; returns w₀.

    It falls as friction rises, all that goes further than what is seen being seen, too: so no
    weight is negative. Fills in `place` and `weight` `[n_nodes]`.
    """
    edges, drops, level = _drops_of_sight(elevation, left, limit, sigma, grid)
    if len(edges) > 0:
        chances = drops / (1.0 - level)
        away = edges - np.sum(chances * edges)
        if np.sqrt(np.sum(chances * away * away)) <= 2.0 * finest:
            gauss_nodes(edges, chances, place[:FEW], weight[:FEW])
        else:
            panel_nodes(edges, chances, panels, place, weight)
        weight *= 1.0 - level
    return level


@kernel(inner=True)
def _drops_of_sight(elevation, left, limit, sigma, grid):  # type: ignore[no-untyped-def]
    """Where the chance to be seen falls, by how much, and what is left of it in the end."""
    n = len(grid)
    chance, points, drops = np.empty(n), np.empty(n), np.empty(n)
    furthest, count, level = 0.0, 0, 1.0
    for j in range(n - 1, -1, -1):
        below = 1.0 if left[j] else normal_below((limit - elevation[j]) / sigma)
        furthest = max(furthest, below)
        chance[j] = furthest
    for j in range(n):
        if level - chance[j] > 1e-9:
            points[count] = grid[j] if j == 0 else 0.5 * (grid[j - 1] + grid[j])
            drops[count] = level - chance[j]
            level = chance[j]
            count += 1
    return points[:count], drops[:count], level


SIDE = 6.0
"""Standard deviations to which the error of an edge is followed."""
FEWEST_OF_EDGE, MOST_OF_EDGE = 40, 1000
"""Points of that error."""


def edges_of_leaving(
    left: Bools,
    sigma: float,
    grid: Floats,
    in_log: bool,
    finest: float,
    place: Floats,
    weight: Floats,
) -> float:
    """P(leaves) = w₀ + Σ w_k P(ν < ν_k): an edge midway wherever the status changes; returns w₀.

    Where log friction at an edge has an error `sigma`, the edge is the nodes of a normal. Fills in
    `place` and `weight` `[n_nodes]`.
    """
    changes = np.flatnonzero(left[1:] != left[:-1])[::-1]
    room = max(len(place) // max(len(changes), 1), 1) if sigma > 0.0 else 1
    for k, j in enumerate(changes[: len(place) // room].tolist()):
        edge, here = 0.5 * (grid[j] + grid[j + 1]), slice(k * room, (k + 1) * room)
        place[here], weight[here] = edge, 1.0
        if room > 1:
            width = sigma if in_log else sigma * edge
            n = int(min(max(2.0 * SIDE * width / finest, FEWEST_OF_EDGE), MOST_OF_EDGE))
            z = SIDE * ((2.0 * np.arange(n) + 1.0) / n - 1.0)
            points = edge + sigma * z if in_log else edge * np.exp(sigma * z)
            masses, panels = np.exp(-0.5 * z * z), max(room // A_PANEL, 1)
            panel_nodes(points, masses, panels, place[here], weight[here])
        if not left[j]:
            weight[here] *= -1.0
    return float(left[-1])
