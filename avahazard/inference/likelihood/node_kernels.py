"""Compiled loops that place the quadrature nodes of `nodes`, event by event."""

from __future__ import annotations

import numpy as np

from avahazard.inference.likelihood.panels import A_PANEL, N_NODES, panel_nodes
from avahazard.inference.likelihood.record_density import record_density_nodes
from avahazard.inference.likelihood.sight import edges_of_sight
from avahazard.inference.likelihood.straight_density import straight_density_nodes
from avahazard.kernels import kernel

SIDE = 6.0
"""Standard deviations to which the error of an edge is followed."""
FEWEST_OF_EDGE, MOST_OF_EDGE = 40, 1000
"""Points of that error."""


@kernel
def fill_record_nodes(  # type: ignore[no-untyped-def]
    record,
    elevation,
    left,
    observed_left,
    observed,
    sigma,
    leaving_sigma,
    height,
    limit,
    hidden_from,
    has_speed,
    grid,
    in_log,
    panels,
    most_apart,
):
    """The fields of `Nodes` but the last, for all events without speeds.

    `limit` `[n_events]` are limits of sight that are estimated (else nan), `hidden_from` the edges
    of those that are declared (else inf).
    """
    n = len(record)
    used = np.maximum(A_PANEL * panels, N_NODES)
    most = N_NODES
    for i in range(n):
        most = max(most, used[i])
    place = np.zeros((n, most))
    weight = np.zeros((n, most))
    tail_place = np.empty((n, 2))
    tail_place[:, 0], tail_place[:, 1] = grid[0], grid[-1]
    tail = np.zeros((n, 2))
    log_scale = np.zeros(n)
    is_probability = np.zeros(n, dtype=np.bool_)
    seen_place = np.zeros((n, most))
    seen_weight = np.zeros((n, most))
    floor = np.zeros(n)
    seen_floor = np.ones(n)
    has_limit = np.zeros(n, dtype=np.bool_)
    no_speed = np.zeros(len(grid))
    for i in range(n):
        if observed_left[i] and not has_speed[i]:
            is_probability[i] = True
            floor[i] = _edges_of_leaving(
                left[i],
                leaving_sigma[i],
                grid,
                in_log,
                most_apart,
                place[i, : used[i]],
                weight[i, : used[i]],
            )
        elif not np.isnan(height[i]) and not np.isnan(observed[i]):
            log_scale[i], tail_place[i, 1] = straight_density_nodes(
                height[i], observed[i], sigma[i], in_log, panels[i], place[i], weight[i], tail[i]
            )
        elif not has_speed[i]:
            log_scale[i] = record_density_nodes(
                record[i],
                left[i],
                observed_left[i],
                observed[i],
                sigma[i],
                no_speed,
                grid,
                hidden_from[i],
                panels[i],
                most_apart,
                place[i],
                weight[i],
                tail[i],
            )
        if hidden_from[i] < np.inf:
            has_limit[i] = True
            seen_floor[i] = 0.0
            seen_place[i, 0], seen_weight[i, 0] = hidden_from[i], 1.0
        elif not np.isnan(limit[i]):
            has_limit[i] = True
            seen_floor[i] = edges_of_sight(
                elevation[i],
                left[i],
                limit[i],
                sigma[i],
                grid,
                panels[i],
                most_apart,
                seen_place[i],
                seen_weight[i],
            )
    return (
        place,
        weight,
        used,
        tail_place,
        tail,
        log_scale,
        is_probability,
        floor,
        seen_place,
        seen_weight,
        seen_floor,
        has_limit,
    )


@kernel(inner=True)
def _edges_of_leaving(left, sigma, grid, in_log, finest, place, weight):  # type: ignore[no-untyped-def]
    """P(leaves) = w₀ + Σ w_k P(ν < ν_k): an edge midway wherever the status changes; returns w₀.

    Where log friction at an edge has an error `sigma`, the edge is the nodes of a normal.
    """
    n_edges = 0
    for j in range(1, len(left)):
        n_edges += 1 if left[j - 1] != left[j] else 0
    room = max(len(place) // max(n_edges, 1), 1) if sigma > 0.0 else 1
    first = 0
    for j in range(len(left) - 1, 0, -1):
        if left[j - 1] != left[j] and first + room <= len(place):
            edge = 0.5 * (grid[j - 1] + grid[j])
            here = slice(first, first + room)
            if room == 1:
                place[first], weight[first] = edge, 1.0
            else:
                _blurred(edge, sigma, in_log, finest, place[here], weight[here])
            if not left[j - 1]:
                weight[here] *= -1.0
            first += room
    return 1.0 if left[len(left) - 1] else 0.0


@kernel(inner=True)
def _blurred(edge, sigma, in_log, finest, place, weight):  # type: ignore[no-untyped-def]
    """Nodes of an edge, in log friction or in friction, whose log friction has an error `sigma`."""
    width = sigma if in_log else sigma * edge
    n = int(min(max(2.0 * SIDE * width / finest, FEWEST_OF_EDGE), MOST_OF_EDGE))
    points, masses = np.empty(n), np.empty(n)
    for k in range(n):
        z = SIDE * ((2.0 * k + 1.0) / n - 1.0)
        points[k] = edge + sigma * z if in_log else edge * np.exp(sigma * z)
        masses[k] = np.exp(-0.5 * z * z)
    panel_nodes(points, masses, max(len(place) // A_PANEL, 1), place, weight)
