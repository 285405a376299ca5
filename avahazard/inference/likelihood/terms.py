"""Log likelihood of each event, and its derivatives in location and scatter of friction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avahazard.arrays import Bools, Floats
from avahazard.inference.likelihood.density_sums import density_sums, sum_memory
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.model.friction_scatter import (
    normal_below,
    normal_density,
    student_below,
    student_density,
)
from avahazard.kernels import kernel


@kernel(inner=True)
def add_tails(place, weight, m, sigma, student, out):  # type: ignore[no-untyped-def]
    """Add w P(ν < ν_0 | m, σ) + w' P(ν > ν_1 | m, σ) and its derivatives to `out`."""
    for side in range(2):
        if weight[side] == 0.0:
            continue
        sign = 1.0 if side == 0 else -1.0
        z = (place[side] - m) / sigma
        if student:
            cdf = student_below(sign * z)
            pdf, pull, _ = student_density(z)
        else:
            cdf = normal_below(sign * z)
            pdf, pull = normal_density(z), z
        out[0] += weight[side] * cdf
        out[1] -= sign * weight[side] * pdf / sigma
        out[2] -= sign * weight[side] * z * pdf
        out[3] -= sign * weight[side] * pull * pdf / (sigma * sigma)


@kernel(inner=True)
def edge_probability(place, weight, m, sigma, student, slopes, out):  # type: ignore[no-untyped-def]
    """Σ w P(ν < ν_k | m, σ) and, with `slopes`, its derivatives in m, log σ, and twice in m."""
    value, first, by_scatter, second = 0.0, 0.0, 0.0, 0.0
    for k in range(len(place)):
        if weight[k] == 0.0:
            continue
        z = (place[k] - m) / sigma
        value += weight[k] * (student_below(z) if student else normal_below(z))
        if not slopes:
            continue
        if student:
            pdf, pull, _ = student_density(z)
        else:
            pdf, pull = normal_density(z), z
        first -= weight[k] * pdf
        second -= weight[k] * pull * pdf
        by_scatter -= weight[k] * z * pdf
    out[0] = value
    out[1] = first / sigma
    out[2] = by_scatter
    out[3] = second / (sigma * sigma)


TINY = 1e-290
UNDERFLOW = 1e-200


class EventTerms(NamedTuple):
    """Per event: log likelihood `value` `[n_events]` and its derivatives.

    `by_location`, `by_scatter` `[n_events, n_volumes]` are derivatives in m and log σ at each
    volume node; `curvature` `[n_events]` is the second derivative in a shift common to all m.
    Without slopes one row of them serves all.
    """

    value: Floats
    by_location: Floats
    by_scatter: Floats
    curvature: Floats


@kernel
def event_terms_kernel(nodes, volume_weight, student, keep, slopes, location, scatter):  # type: ignore[no-untyped-def]
    """The arrays of `EventTerms`, as `event_terms` has them, and the sum of the values."""
    n, n_volumes = location.shape
    n_slopes = n if slopes else 1
    values, curvature = np.zeros(n), np.zeros(n)
    by_location, by_scatter = np.zeros((n_slopes, n_volumes)), np.zeros((n_slopes, n_volumes))
    memory, part = sum_memory(n_volumes * nodes.place.shape[1]), np.zeros((n_volumes, 4))
    seen_location, seen_scatter = np.zeros(n_volumes), np.zeros(n_volumes)
    total = 0.0
    for i in range(n):
        if not keep[i]:
            continue
        m, sigma, weights, used = location[i], scatter[i], volume_weight[i], nodes.used[i]
        lift = _add_to_sums(nodes, i, m, sigma, student, slopes, memory, part)
        row = i if slopes else 0
        of_location, of_scatter = by_location[row], by_scatter[row]
        chance, bend = _gather(part, weights, nodes.floor[i], of_location, of_scatter)
        value = np.log(max(chance, TINY)) + nodes.log_scale[i] - lift
        if nodes.has_limit[i]:
            place, weight = nodes.seen_place[i, :used], nodes.seen_weight[i, :used]
            for q in range(n_volumes):
                edge_probability(place, weight, m[q], sigma[q], student, slopes, part[q])
            chance, seen_bend = _gather(
                part, weights, nodes.seen_floor[i], seen_location, seen_scatter
            )
            value -= np.log(max(chance, TINY))
            bend -= seen_bend
            for q in range(n_volumes):
                of_location[q] -= seen_location[q]
                of_scatter[q] -= seen_scatter[q]
        if student:
            value, bend = _or_wrong(nodes.log_wrong[i], value, of_location, of_scatter, bend)
        values[i], curvature[i] = value, bend
        total += value
    return values, by_location, by_scatter, curvature, total


@kernel(inner=True)
def _add_to_sums(nodes, i, location, scatter, student, slopes, memory, part):  # type: ignore[no-untyped-def]
    """Fill `part` with the sums of event i; returns by how much its exponents are lifted far off.

    That is by the largest of them.
    """
    used = nodes.used[i]
    place, weight = nodes.place[i, :used], nodes.weight[i, :used]
    if nodes.is_probability[i]:
        for q in range(len(location)):
            edge_probability(place, weight, location[q], scatter[q], student, slopes, part[q])
        return 0.0
    lift = 0.0
    for far_off in range(2):
        density_sums(place, weight, location, scatter, lift, student, slopes, memory, part)
        if far_off:
            break
        if nodes.tail[i, 0] > 0.0 or nodes.tail[i, 1] > 0.0:
            tail, at = nodes.tail[i], nodes.tail_place[i]
            for q in range(len(location)):
                add_tails(at, tail, location[q], scatter[q], student, part[q])
        if student or _largest(part) >= UNDERFLOW:
            break
        lift = _lift(place, weight, location, scatter)
    return lift


@kernel(inner=True)
def _largest(part):  # type: ignore[no-untyped-def]
    """The largest value of all volumes."""
    largest = part[0, 0]
    for q in range(len(part)):
        largest = max(largest, part[q, 0])
    return largest


@kernel(inner=True)
def _lift(place, weight, location, scatter):  # type: ignore[no-untyped-def]
    """The least z²/2 of all nodes that count."""
    lift = np.inf
    for q in range(len(location)):
        for k in range(len(place)):
            if weight[k] > 0.0:
                z = (place[k] - location[q]) / scatter[q]
                lift = min(lift, 0.5 * z * z)
    return lift


@kernel(inner=True)
def _or_wrong(log_wrong, value, by_location, by_scatter, curvature):  # type: ignore[no-untyped-def]
    """log(exp(value) + exp(log_wrong)) and its derivatives; returns it and its curvature."""
    if log_wrong < value - 700.0:
        return value, curvature
    top = max(value, log_wrong)
    total = top + np.log(np.exp(value - top) + np.exp(log_wrong - top))
    right = np.exp(value - total)
    slope = 0.0
    for q in range(len(by_location)):
        slope += by_location[q]
        by_location[q] *= right
        by_scatter[q] *= right
    return total, right * (curvature + (1.0 - right) * slope * slope)


@kernel(inner=True)
def _gather(part, weight, floor, by_location, by_scatter):  # type: ignore[no-untyped-def]
    """Sum over volume nodes; log derivatives; returns the sum and the second log derivative."""
    total, first, second = floor, 0.0, 0.0
    for q in range(len(weight)):
        total += weight[q] * part[q, 0]
        first += weight[q] * part[q, 1]
        second += weight[q] * part[q, 3]
    safe = max(total, TINY)
    for q in range(len(weight)):
        by_location[q] = weight[q] * part[q, 1] / safe
        by_scatter[q] = weight[q] * part[q, 2] / safe
    return total, second / safe - (first / safe) ** 2


def event_terms(
    nodes: Nodes,
    location: Floats,
    scatter: Floats,
    volume_weight: Floats,
    student: bool = False,
    keep: Bools | None = None,
    *,
    slopes: bool = True,
) -> EventTerms:
    """log Σ_q h_q Σ_k w_k p(ν_k | m_q, σ_q) of each event, less the log chance to be seen.

    Tails of vague records are added (`Nodes`).
    `location` m and `scatter` σ > 0 `[n_events, n_volumes]` at the volume nodes with weights
    `volume_weight` h. Friction scatters normally about m, or with `student` as Student's t,
    a few records being grossly wrong (`nodes.log_wrong`). Terms of events not in `keep`
    `[n_events]` are 0. Without `slopes` the values alone are good, and their last bit may be
    another; it takes less time.
    """
    keep = np.ones(len(location), dtype=np.bool_) if keep is None else keep
    of_events = nodes, volume_weight, student, keep, slopes
    return EventTerms(*event_terms_kernel(*of_events, location, scatter)[:-1])
