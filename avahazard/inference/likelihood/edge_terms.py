"""Chances that friction lies below edges, and their derivatives in location and scatter."""

from __future__ import annotations

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
