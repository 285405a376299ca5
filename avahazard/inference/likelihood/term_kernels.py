"""The terms of `EventTerms`, compiled: block by block, and event by event."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.density_sums import SumMemory, normal_sums, sum_memory
from avahazard.inference.likelihood.edge_terms import add_tails, edge_probability
from avahazard.inference.likelihood.student_sums import (
    BLOCK,
    BlockMemory,
    block_memory,
    by_nodes_used,
    student_sums,
)
from avahazard.kernels import kernel

TINY = 1e-290
UNDERFLOW = 1e-200


class TermMemory(NamedTuple):
    """Working memory: of sums over nodes, and `parts` `[BLOCK, n_volumes, 4]` of these sums.

    `seen_location`, `seen_scatter` `[n_volumes]` are derivatives of the log chance to be seen.
    """

    normal: SumMemory
    student: BlockMemory
    parts: Floats
    seen_location: Floats
    seen_scatter: Floats


class Terms(NamedTuple):
    """The arrays of `EventTerms` to be filled; without slopes one row of them serves all."""

    value: Floats
    by_location: Floats
    by_scatter: Floats
    curvature: Floats


@kernel
def event_terms_kernel(nodes, location, scatter, volume_weight, student, keep, slopes):  # type: ignore[no-untyped-def]
    """The arrays of `EventTerms`, 0 for events not in `keep` `[n_events]`.

    Without `slopes` the values alone are good.
    """
    n, n_volumes = location.shape
    n_nodes, n_slopes = nodes.place.shape[1], n if slopes else 1
    terms = Terms(
        np.zeros(n), np.zeros((n_slopes, n_volumes)), np.zeros((n_slopes, n_volumes)), np.zeros(n)
    )
    memory = TermMemory(
        sum_memory(1 if student else n_volumes * n_nodes),
        block_memory(n_nodes if student else 1),
        np.zeros((BLOCK, n_volumes, 4)),
        np.zeros(n_volumes),
        np.zeros(n_volumes),
    )
    order = by_nodes_used(nodes.used, keep)
    _fill_terms(nodes, order, location, scatter, volume_weight, student, slopes, memory, terms)
    return terms.value, terms.by_location, terms.by_scatter, terms.curvature


@kernel(inner=True)
def _fill_terms(nodes, order, location, scatter, volume_weight, student, slopes, memory, terms):  # type: ignore[no-untyped-def]
    """Fill the terms of the events in `order`, block by block."""
    parts = memory.parts
    for begin in range(0, len(order), BLOCK):
        events = order[begin : begin + BLOCK]
        if student:
            student_sums(nodes, events, location, scatter, slopes, memory.student, parts)
        for e in range(len(events)):
            i = events[e]
            m, sigma, part = location[i], scatter[i], parts[e]
            lift = _add_to_sums(nodes, i, m, sigma, student, slopes, memory.normal, part)
            row = i if slopes else 0
            slopes_of = terms.by_location[row], terms.by_scatter[row]
            total, bend = _gather(part, volume_weight[i], nodes.floor[i], *slopes_of)
            value = np.log(max(total, TINY)) + nodes.log_scale[i] - lift
            if nodes.has_limit[i]:
                log_seen, seen_bend = _chance_to_be_seen(
                    nodes, i, m, sigma, volume_weight[i], student, slopes, memory, part
                )
                value -= log_seen
                bend -= seen_bend
                for q in range(len(m)):
                    terms.by_location[row, q] -= memory.seen_location[q]
                    terms.by_scatter[row, q] -= memory.seen_scatter[q]
            if student:
                value, bend = _or_wrong(nodes.log_wrong[i], value, *slopes_of, bend)
            terms.value[i], terms.curvature[i] = value, bend


@kernel(inner=True)
def _add_to_sums(nodes, i, location, scatter, student, slopes, memory, part):  # type: ignore[no-untyped-def]
    """Fill `part` with the sums of event i, those of Student's being there; returns its lift.

    Far off, the exponents are lifted by the largest.
    """
    used = nodes.used[i]
    place, weight = nodes.place[i, :used], nodes.weight[i, :used]
    if nodes.is_probability[i]:
        for q in range(len(location)):
            edge_probability(place, weight, location[q], scatter[q], student, slopes, part[q])
        return 0.0
    if not student:
        normal_sums(place, weight, location, scatter, 0.0, slopes, memory, part)
    if nodes.tail[i, 0] > 0.0 or nodes.tail[i, 1] > 0.0:
        for q in range(len(location)):
            add_tails(nodes.tail_place[i], nodes.tail[i], location[q], scatter[q], student, part[q])
    if student or _largest(part) >= UNDERFLOW:
        return 0.0
    lift = _lift(place, weight, location, scatter)
    normal_sums(place, weight, location, scatter, lift, slopes, memory, part)
    return lift


@kernel(inner=True)
def _chance_to_be_seen(nodes, i, location, scatter, weight, student, slopes, memory, part):  # type: ignore[no-untyped-def]
    """The log chance that event i is seen and its second derivative; fills its slopes."""
    used = nodes.used[i]
    place, by_place = nodes.seen_place[i, :used], nodes.seen_weight[i, :used]
    for q in range(len(location)):
        edge_probability(place, by_place, location[q], scatter[q], student, slopes, part[q])
    seen = memory.seen_location, memory.seen_scatter
    chance, bend = _gather(part, weight, nodes.seen_floor[i], *seen)
    return np.log(max(chance, TINY)), bend


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
