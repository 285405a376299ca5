"""The likelihood p(record | μ) of one event over friction, as nodes.

Across a jump of F, or to the end of the profile, records are taken as spread evenly: real terrain
and real avalanches have no such gaps. A stop that is looked up (`physics.runout_curve`) never lies
within a jump; this is no such stop but what a record tells of friction.
"""

from __future__ import annotations

import numpy as np

from avahazard.inference.likelihood.panels import panel_nodes
from avahazard.inference.model.friction_scatter import HALF_LOG_2PI
from avahazard.kernels import kernel

REACH = 7.0
"""Records farther than this many standard deviations from F(μ) say nothing about μ."""
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

    Points lie no farther apart than `finest`. `tail` `[2]` is filled with p(record | μ) below and
    beyond the grid, where that of its ends holds, as a share of the total mass. Of frictions from
    `hidden_from` on there would be no record.
    """
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
        return _nearest(record, left, observed, sigma, log_speed, grid, hidden_from, place, weight)
    top = np.max(logs[:count])
    kept = 0
    for c in range(count):
        if logs[c] > top - DEPTH:
            points[kept], logs[kept] = points[c], logs[c]
            kept += 1
    masses = np.exp(logs[:kept] - top)
    panel_nodes(points[:kept], masses, panels, place, weight)
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
    return log_total


@kernel(inner=True)
def _leaving_points(left, log_speed, grid, points, logs):  # type: ignore[no-untyped-def]
    """Points of the frictions that leave the profile, and their log masses; returns how many."""
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


@kernel
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
