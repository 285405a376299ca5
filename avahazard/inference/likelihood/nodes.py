"""Quadrature nodes over friction: what a record says about the friction of its event.

For each event, p(record | μ) is narrow over friction. It is summed up by the nodes of the
Gauss quadrature that has it as weight (Golub and Welsch 1969), so that

    p(record | m, σ) = ∫ p(record | μ) p(ν | m, σ) dν ≈ Σ_k w_k p(ν_k | m, σ),  ν = log μ,

costs a few evaluations of the scatter density. No inverse of F is needed: where F jumps, the
likelihood has two parts. Without a profile no table is needed (`straight_density`). Events that
left the profile give a probability instead, w₀ + Σ_k w_k P(ν < ν_k), and so does the chance that
a stop low enough was seen. A record so vague that frictions beyond the tables might have left it
adds w P(ν < lowest) and w P(ν > highest).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.likelihood.panels import A_PANEL, N_NODES, finest, n_panels, panel_nodes
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.record_density import record_density_nodes
from avahazard.inference.likelihood.speed_nodes import fill_speed_nodes, measured_speeds
from avahazard.inference.likelihood.straight_density import straight_density_nodes
from avahazard.inference.model.friction_scatter import normal_below
from avahazard.inference.model.observations import LEFT, LENGTH, Observations
from avahazard.kernels import kernel
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU
from avahazard.workers import n_workers, ordered_map

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Nodes(NamedTuple):
    """Nodes of all events, `[n_events, n_nodes]`; `place` is ν, or μ for normal scatter.

    `used` `[n_events]` counts those of each event; others have weight 0. `tail` `[n_events, 2]`
    are weights of P(ν < place) and P(ν > place) at `tail_place` `[n_events, 2]`.
    `is_probability` `[n_events]`: the event left its profile, and its nodes are edges of
    probabilities. `log_scale` `[n_events]` is the log of what all weights are multiplied by,
    `floor` `[n_events]` is w₀, `log_wrong` `[n_events]` as in `wrong_records` (or -inf).
    `seen_place`, `seen_weight`, `seen_floor` give the chance to be seen, where `has_limit`.
    """

    place: Floats
    weight: Floats
    used: Ints
    tail_place: Floats
    tail: Floats
    log_scale: Floats
    is_probability: NDArray[np.bool_]
    floor: Floats
    seen_place: Floats
    seen_weight: Floats
    seen_floor: Floats
    has_limit: NDArray[np.bool_]
    log_wrong: Floats


def build_nodes(
    observations: Observations,
    predicted: Predicted,
    speed_scatter: float = 0.0,
    limit: Floats | None = None,
    in_log: bool = True,
    panels: Ints | None = None,
) -> Nodes:
    """Nodes of every event for one set of tables.

    `speed_scatter` (m/s) is the standard deviation of the model's own error of speed, correlated
    along the track; `limit` `[n_events]` replaces the elevations above which a stop is not
    seen; `in_log` gives nodes in log μ, else in μ; `panels` `[n_events]` as in `needed_panels`,
    by default what these tables need.
    """
    if panels is None:
        panels = needed_panels(observations, predicted, speed_scatter, in_log)
    records = record_nodes(observations, predicted, panels, limit, in_log)
    return speed_nodes(records, observations, predicted, panels, speed_scatter, in_log)


def needed_panels(
    observations: Observations, predicted: Predicted, speed_scatter: float, in_log: bool
) -> Ints:
    """Panels of friction for each event `[n_events]`: 1 but for likelihoods that are wide."""
    one = np.ones(observations.n_events, dtype=np.int64)
    nodes = build_nodes(observations, predicted, speed_scatter, None, in_log, one)
    return np.where(nodes.is_probability, 1, n_panels(nodes.place, nodes.weight, in_log))


def record_nodes(
    observations: Observations,
    predicted: Predicted,
    panels: Ints,
    limit: Floats | None = None,
    in_log: bool = True,
) -> Nodes:
    """Nodes of the events without speeds; those of the others are left blank."""
    has_speed = np.zeros(observations.n_events, dtype=np.bool_)
    has_speed[[m.event for m in observations.speeds]] = True
    seen_limit = observations.limit if limit is None else limit
    built = _build(
        predicted.record,
        np.nan_to_num(predicted.elevation, nan=0.0),
        predicted.status == LEFT_PROFILE,
        observations.kind == LEFT,
        observations.observed,
        predicted.sigma,
        np.where(observations.kind == LENGTH, observations.fall_height, np.nan),
        np.where(np.isnan(predicted.elevation).all(axis=1), np.nan, seen_limit),
        has_speed,
        np.log(MU) if in_log else MU,
        in_log,
        panels,
        finest(in_log),
    )
    return Nodes(*built, np.full(observations.n_events, -np.inf))  # type: ignore[call-arg]


def speed_nodes(
    records: Nodes,
    observations: Observations,
    predicted: Predicted,
    panels: Ints,
    speed_scatter: float,
    in_log: bool = True,
) -> Nodes:
    """`record_nodes` with those of the events with speeds filled in."""
    if not observations.speeds:
        return records
    nodes = records._replace(
        place=records.place.copy(),
        weight=records.weight.copy(),
        tail=records.tail.copy(),
        log_scale=records.log_scale.copy(),
    )
    measured = measured_speeds(observations.speeds)
    speeds = np.concatenate(predicted.speeds, axis=1)
    left, observed_left = predicted.status == LEFT_PROFILE, observations.kind == LEFT

    parts = n_workers()

    def fill(part: int) -> None:
        mine = np.arange(part, len(measured.event), parts)
        fill_speed_nodes(
            measured._replace(
                event=measured.event[mine], first=measured.first[mine], end=measured.end[mine]
            ),
            speeds,
            speed_scatter,
            MU,
            predicted.record,
            left,
            observed_left,
            observations.observed,
            predicted.sigma,
            in_log,
            panels,
            finest(in_log),
            nodes,
        )

    # Each event's row is its own.
    list(ordered_map(fill, range(parts)))
    return nodes


@kernel
def _build(  # type: ignore[no-untyped-def]
    record,
    elevation,
    left,
    observed_left,
    observed,
    sigma,
    height,
    limit,
    has_speed,
    grid,
    in_log,
    panels,
    most_apart,
):
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
            floor[i] = _edges_of_leaving(left[i], grid, place[i], weight[i])
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
                panels[i],
                most_apart,
                place[i],
                weight[i],
                tail[i],
            )
        if not np.isnan(limit[i]):
            has_limit[i] = True
            seen_floor[i] = _edges_of_sight(
                elevation[i],
                left[i],
                limit[i],
                sigma[i],
                grid,
                panels[i],
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


@kernel
def _edges_of_leaving(left, grid, place, weight):  # type: ignore[no-untyped-def]
    """P(leaves) = w₀ + Σ w_k P(ν < ν_k): an edge midway wherever the status changes; returns w₀."""
    k = 0
    for j in range(len(left) - 1, 0, -1):
        if left[j - 1] != left[j] and k < len(place):
            place[k] = 0.5 * (grid[j - 1] + grid[j])
            weight[k] = 1.0 if left[j - 1] else -1.0
            k += 1
    return 1.0 if left[len(left) - 1] else 0.0


@kernel
def _edges_of_sight(elevation, left, limit, sigma, grid, panels, place, weight):  # type: ignore[no-untyped-def]
    """P(seen) = w₀ + Σ w_k P(ν < ν_k): the chance falls as friction rises; returns w₀."""
    n = len(grid)
    points = np.empty(n)
    drops = np.empty(n)
    count = 0
    level = 1.0
    for j in range(n):
        chance = 1.0 if left[j] else normal_below((limit - elevation[j]) / sigma)
        # Steps of the terrain may raise it again; the running minimum keeps weights positive.
        if level - chance > 1e-9:
            points[count] = grid[j] if j == 0 else 0.5 * (grid[j - 1] + grid[j])
            drops[count] = level - chance
            level = chance
            count += 1
    if count:
        panel_nodes(points[:count], drops[:count], panels, place, weight)
        weight *= 1.0 - level
    return level
