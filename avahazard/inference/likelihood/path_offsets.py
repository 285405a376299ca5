"""Offsets of the paths at given parameters: Newton's method, all paths at once.

Paths are independent, so the step of each is a number. A fixed number of steps keeps the result a
smooth function of the parameters, as finite differences of it need.
"""

from __future__ import annotations

import numpy as np

from avahazard.inference.likelihood.event_terms import event_terms_kernel
from avahazard.kernels import kernel

EVALUATIONS = 3
LONGEST_STEP = 0.5


@kernel
def newton_offsets(  # type: ignore[no-untyped-def]
    nodes, location, scatter, volume_weight, student, in_log, group, keep, n_groups, precision
):
    """Mode of the offsets, their precision there `[n_groups]`, and log likelihoods `[n_events]`.

    Events with `group` -1 have no offset; those not in `keep` do not count and have no
    likelihood (0). Offsets have normal priors of this `precision`. `in_log`: they add to
    `location`, else they multiply it by their exponential.
    """
    n, n_volumes = location.shape
    offsets = _first_offsets(nodes, location, scatter, in_log, group, keep, n_groups, precision)
    bend = np.empty(n_groups)
    shifted = location.copy()
    for step in range(EVALUATIONS):
        for i in range(n):
            if keep[i] and group[i] >= 0:
                for q in range(n_volumes):
                    move = offsets[group[i]]
                    shifted[i, q] = (
                        location[i, q] + move if in_log else location[i, q] * np.exp(move)
                    )
        value, by_location, _, curvature = event_terms_kernel(
            nodes, shifted, scatter, volume_weight, student, keep
        )
        slope = -precision * offsets
        bend[:] = precision
        for i in range(n):
            if not keep[i] or group[i] < 0:
                continue
            # Where the offset acts on log μ, m changes by m per unit.
            level = 1.0 if in_log else np.mean(shifted[i])
            slope[group[i]] += np.sum(by_location[i]) * level
            bend[group[i]] += max(-curvature[i] * level * level, 0.0)
        if step < EVALUATIONS - 1:
            for k in range(n_groups):
                offsets[k] += min(max(slope[k] / bend[k], -LONGEST_STEP), LONGEST_STEP)
    return offsets, bend, value


@kernel
def _first_offsets(nodes, location, scatter, in_log, group, keep, n_groups, precision):  # type: ignore[no-untyped-def]
    """Offsets as if every likelihood were normal, of events that did not leave their profile."""
    pull, bend = np.zeros(n_groups), np.full(n_groups, precision)
    for i in range(len(location)):
        if not keep[i] or group[i] < 0 or nodes.is_probability[i]:
            continue
        total, first, second = 0.0, 0.0, 0.0
        for k in range(nodes.place.shape[1]):
            total += nodes.weight[i, k]
            first += nodes.weight[i, k] * nodes.place[i, k]
            second += nodes.weight[i, k] * nodes.place[i, k] ** 2
        if total <= 0.0:
            continue
        mean = first / total
        m, variance = np.mean(location[i]), max(second / total - mean * mean, 0.0)
        variance += np.mean(scatter[i]) ** 2 + np.var(location[i])
        level = 1.0 if in_log else m
        pull[group[i]] += (mean - m) * level / variance
        bend[group[i]] += level * level / variance
    offsets = pull / bend
    for k in range(n_groups):
        offsets[k] = min(max(offsets[k], -LONGEST_STEP), LONGEST_STEP)
    return offsets
