"""Log likelihood of each event, and its derivatives in location and scatter of friction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.density_sums import normal_sums, student_sums, sum_memory
from avahazard.inference.likelihood.edge_terms import add_tails, edge_probability
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.kernels import kernel


class EventTerms(NamedTuple):
    """Per event: log likelihood `value` `[n_events]` and its derivatives.

    `by_location`, `by_scatter` `[n_events, n_volumes]` are derivatives in m and log σ at each
    volume node; `curvature` `[n_events]` is the second derivative in a shift common to all m.
    """

    value: Floats
    by_location: Floats
    by_scatter: Floats
    curvature: Floats


def event_terms(
    nodes: Nodes,
    location: Floats,
    scatter: Floats,
    volume_weight: Floats,
    student: bool = False,
    keep: NDArray[np.bool_] | None = None,
) -> EventTerms:
    """log Σ_q h_q Σ_k w_k p(ν_k | m_q, σ_q) of each event, less the log chance to be seen.

    Tails of vague records are added (`Nodes`).
    `location` m and `scatter` σ > 0 `[n_events, n_volumes]` at the volume nodes with weights
    `volume_weight` h. Friction scatters normally about m, or with `student` as Student's t,
    a few records being grossly wrong (`wrong_records`).
    Terms of events not in `keep` `[n_events]` are 0.
    """
    keep = np.ones(len(location), dtype=np.bool_) if keep is None else keep
    return EventTerms(
        *event_terms_kernel(nodes, location, scatter, volume_weight, student, keep, True)
    )


def event_values(
    nodes: Nodes,
    location: Floats,
    scatter: Floats,
    volume_weight: Floats,
    student: bool = False,
    keep: NDArray[np.bool_] | None = None,
) -> Floats:
    """`EventTerms.value` alone `[n_events]` in less time; the last bit may be another."""
    keep = np.ones(len(location), dtype=np.bool_) if keep is None else keep
    terms = event_terms_kernel(nodes, location, scatter, volume_weight, student, keep, False)
    return np.asarray(terms[0])


def summed_terms(
    nodes: Nodes,
    locations: Floats,
    scatters: Floats,
    volume_weight: Floats,
    student: bool,
    keep: NDArray[np.bool_] | None = None,
) -> Floats:
    """Sums `[n]` of the events' log likelihoods at `[n, n_events, n_volumes]` of both."""
    keep = np.ones(locations.shape[1], dtype=np.bool_) if keep is None else keep
    return np.asarray(_sums(nodes, locations, scatters, volume_weight, student, keep))


@kernel
def _sums(nodes, locations, scatters, volume_weight, student, keep):  # type: ignore[no-untyped-def]
    result = np.empty(len(locations))
    slopes = bool(0)  # for a constant the called kernel would be compiled once more
    for j in range(len(locations)):
        value, _, _, _ = event_terms_kernel(
            nodes, locations[j], scatters[j], volume_weight, student, keep, slopes
        )
        result[j] = np.sum(value)
    return result


@kernel
def event_terms_kernel(nodes, location, scatter, volume_weight, student, keep, slopes):  # type: ignore[no-untyped-def]
    """The arrays of `EventTerms`, 0 for events not in `keep` `[n_events]`.

    Without `slopes` the values alone are good.
    """
    n, n_volumes = location.shape
    value = np.zeros(n)
    by_location = np.zeros((n, n_volumes))
    by_scatter = np.zeros((n, n_volumes))
    curvature = np.zeros(n)
    part = np.empty((n_volumes, 4))
    memory = sum_memory(n_volumes * nodes.place.shape[1])
    for i in range(n):
        if not keep[i]:
            continue
        lift = 0.0
        used = nodes.used[i]
        place, weight = nodes.place[i, :used], nodes.weight[i, :used]
        if nodes.is_probability[i]:
            for q in range(n_volumes):
                edge_probability(
                    place, weight, location[i, q], scatter[i, q], student, slopes, part[q]
                )
        elif student:
            student_sums(place, weight, location[i], scatter[i], slopes, memory, part)
        else:
            normal_sums(place, weight, location[i], scatter[i], 0.0, slopes, memory, part)
        has_tail = nodes.tail[i, 0] > 0.0 or nodes.tail[i, 1] > 0.0
        if has_tail and not nodes.is_probability[i]:
            for q in range(n_volumes):
                add_tails(
                    nodes.tail_place[i],
                    nodes.tail[i],
                    location[i, q],
                    scatter[i, q],
                    student,
                    part[q],
                )
        if not student and not nodes.is_probability[i] and np.max(part[:, 0]) < UNDERFLOW:
            # Far off, the exponents are lifted by the largest.
            lift = _lift(place, weight, location[i], scatter[i])
            normal_sums(place, weight, location[i], scatter[i], lift, slopes, memory, part)
        total = _gather(part, volume_weight[i], nodes.floor[i], by_location[i], by_scatter[i])
        value[i] = np.log(max(total[0], TINY)) + nodes.log_scale[i] - lift
        curvature[i] = total[1]
        if nodes.has_limit[i]:
            for q in range(n_volumes):
                edge_probability(
                    nodes.seen_place[i, :used],
                    nodes.seen_weight[i, :used],
                    location[i, q],
                    scatter[i, q],
                    student,
                    slopes,
                    part[q],
                )
            seen_location = np.zeros(n_volumes)
            seen_scatter = np.zeros(n_volumes)
            seen = _gather(part, volume_weight[i], nodes.seen_floor[i], seen_location, seen_scatter)
            value[i] -= np.log(max(seen[0], TINY))
            curvature[i] -= seen[1]
            by_location[i] -= seen_location
            by_scatter[i] -= seen_scatter
        if student:
            value[i], curvature[i] = _or_wrong(
                nodes.log_wrong[i], value[i], by_location[i], by_scatter[i], curvature[i]
            )
    return value, by_location, by_scatter, curvature


TINY = 1e-290
UNDERFLOW = 1e-200


@kernel
def _lift(place, weight, location, scatter):  # type: ignore[no-untyped-def]
    """The least z²/2 of all nodes that count."""
    lift = np.inf
    for q in range(len(location)):
        for k in range(len(place)):
            if weight[k] > 0.0:
                z = (place[k] - location[q]) / scatter[q]
                lift = min(lift, 0.5 * z * z)
    return lift


@kernel
def _or_wrong(log_wrong, value, by_location, by_scatter, curvature):  # type: ignore[no-untyped-def]
    """log(exp(value) + exp(log_wrong)) and its derivatives; returns it and its curvature."""
    if log_wrong < value - 700.0:
        return value, curvature
    top = max(value, log_wrong)
    total = top + np.log(np.exp(value - top) + np.exp(log_wrong - top))
    right = np.exp(value - total)
    slope = np.sum(by_location)
    by_location *= right
    by_scatter *= right
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
