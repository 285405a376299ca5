"""Log likelihoods of a linear model of log friction, with their slopes and curvatures."""

from __future__ import annotations

import math

from avahazard.inference.model.friction_scatter import (
    HALF_LOG_2PI,
    LOG_STUDENT_PEAK,
    STUDENT_INFORMATION,
    STUDENT_PULL,
    log_normal_below,
    log_student_below,
    student_shape,
)
from avahazard.kernels import kernel

NO_ODDS = 40.0
"""Nats by which a record is likelier right than wrong from which on no digit tells of the wrong."""


@kernel(inner=True)
def laplace_terms(  # type: ignore[no-untyped-def]
    record_moments, left, edges, design, beta, offsets, sigma, lone, student, g, h, dv, iv
):
    """Sum of log likelihoods; fills score g and curvature h in m.

    For any part d of an event's variance, d `dv` `[n_events]` is the derivative of its log
    likelihood in half of log d, and d² `iv` the expected curvature.
    """
    n, p = design.x.shape
    value = 0.0
    for i in range(n):
        m = design.constant[i]
        for c in range(p):
            m += design.x[i, c] * beta[c]
        for a in range(len(design.places)):
            if design.places[a, i] >= 0:
                m += offsets[design.places[a, i]]
        own = (sigma * design.multiplier[i]) ** 2 + lone[i]
        gone = left[i] and record_moments.variance[i] == 0.0
        if gone:
            spread = math.sqrt(own + edges.leave_sd[i] ** 2 + design.extra[i])
            z = (edges.leave[i] - m) / spread
            here, ratio = log_normal_below(z)
            g[i] = -ratio / spread
            h[i] = ratio * (ratio + z) / (spread * spread)
            dv[i] = -z * ratio / (spread * spread)
            iv[i] = 0.5 * dv[i] ** 2
        else:
            s = own + record_moments.variance[i] + design.extra[i]
            e = record_moments.mean[i] - m
            if student:
                shape = student_shape(e * e / s)
                here = LOG_STUDENT_PEAK + math.log(shape * shape * math.sqrt(shape / s))
                pull = STUDENT_PULL * shape / s
                g[i], h[i] = pull * e, pull
                dv[i] = (pull * e * e - 1.0) / s
                iv[i] = STUDENT_INFORMATION / (s * s)
            else:
                here = -HALF_LOG_2PI - 0.5 * math.log(s) - 0.5 * e * e / s
                g[i] = e / s
                h[i] = 1.0 / s
                dv[i] = (e * e / s - 1.0) / s
                iv[i] = 2.0 / (s * s)
            here += record_moments.log_mass[i]
        if edges.has_limit[i]:
            # Never less blurred than the record: else far from both the chance to be seen falls
            # faster than the record's density, and their ratio has no bound.
            blur = max(edges.seen_sd[i] ** 2, record_moments.variance[i])
            s = own + blur + design.extra[i]
            spread = math.sqrt(s)
            z = (edges.seen[i] - m) / spread
            log_p, ratio = log_student_below(z) if student else log_normal_below(z)
            # How the density falls at the edge: of the shape of the scatter, as the record's does.
            fall = STUDENT_PULL * z * student_shape(z * z) if student else z
            here -= log_p
            g[i] += ratio / spread
            h[i] = max(h[i] - ratio * (ratio + fall) / s, 0.1 * h[i])
            dv[i] += z * ratio / s
        if student and not gone:
            here, right = _or_wrong(here, design.log_wrong[i])
            for part in (g, h, dv, iv):
                part[i] *= right
        value += here
    return value


@kernel(inner=True)
def _or_wrong(here, wrong):  # type: ignore[no-untyped-def]
    """Log density of a record that is right or grossly `wrong`, and the chance that it is right."""
    if wrong < here - NO_ODDS:
        return here, 1.0
    odds = math.exp(-abs(here - wrong))
    right = (1.0 if here > wrong else odds) / (1.0 + odds)
    return max(here, wrong) + math.log1p(odds), right
