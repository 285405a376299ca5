"""Laplace fit of a linear model of log friction with offsets of groups to `RecordMoments`.

Newton steps on coefficients, offsets and scatter at once (penalised iteratively re-weighted
least squares, Breslow and Clayton 1993), the spread of the offsets by Fisher's scoring, and the
log likelihood with the offsets integrated out by Laplace's method. Events that left the
profile and the chance of detection are in it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.offsets import (
    by_offset,
    log_determinant,
    offset_system,
    solved,
    variances,
)
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

STEPS = 12
CONVERGED = 1e-4
"""Rise of the log likelihood (nats) from one step to the next after which there are no more."""
NO_ODDS = 40.0
"""Nats by which a record is likelier right than wrong from which on no digit tells of the wrong."""
SCATTER_MEAN, SCATTER_SD = math.log(0.15), 1.0
LEAST_SPREAD, LARGEST_SPREAD = 1e-3, 1.0


class Design(NamedTuple):
    """What stays alike between simulated datasets: columns `x` `[n_events, n_columns]`, `constant`.

    Coefficients have normal priors `prior_mean`, `prior_precision` `[n_columns]`; `of`, `places`
    (the `index`), `alone`, `rest` are those of an `OffsetPlan`, and `spread_scale` `[n_groupings]`
    the scale of the half-normal priors of the spreads; `extra` `[n_events]` is variance from the
    volume's error; `multiplier` scales the scatter; `log_wrong` `[n_events]` is as in
    `wrong_records`, for Student's tails.
    """

    x: Floats
    constant: Floats
    prior_mean: Floats
    prior_precision: Floats
    of: NDArray[np.int64]
    places: NDArray[np.int64]
    alone: NDArray[np.bool_]
    rest: NDArray[np.int64]
    spread_scale: Floats
    extra: Floats
    multiplier: Floats
    log_wrong: Floats


class Edges(NamedTuple):
    """Probabilities by one edge each, `[n_events]`: of leaving, and of detection.

    The event leaves where ν < `leave`, blurred by `leave_sd`; it is detected where ν < `detected`,
    blurred by `detected_sd` (`has_limit` False: always).
    """

    leave: Floats
    leave_sd: Floats
    detected: Floats
    detected_sd: Floats
    has_limit: NDArray[np.bool_]


class LaplaceFit(NamedTuple):
    """Log likelihood with the prior of the coefficients, and where it is reached.

    `tau` `[n_groupings]` are the spreads of the offsets.
    """

    log_likelihood: float
    coefficients: Floats
    log_scatter: float
    tau: Floats


@kernel
def laplace_fit(record_moments, left, edges, design, start, log_scatter, first_tau, student):  # type: ignore[no-untyped-def]
    """Fit from `start` `[n_columns]`, `log_scatter` and `first_tau` `[n_groupings]`."""
    n, n_offsets = len(design.x), len(design.of)
    beta = start.copy()
    tau = first_tau.copy()
    offsets = np.zeros(n_offsets)
    # Score and curvature in m, and in the variance, of each event.
    g, h, dv, iv = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    everyone = np.ones(n, dtype=np.bool_)
    best = -np.inf
    best_beta, best_scatter, best_tau = beta.copy(), log_scatter, tau.copy()
    for _ in range(STEPS):
        sigma = math.exp(log_scatter)
        lone = _own_offsets(design, tau)
        value = _terms(
            record_moments, left, edges, design, beta, offsets, sigma, lone, student, g, h, dv, iv
        )
        own = (sigma * design.multiplier) ** 2
        d_scatter, info_scatter = np.sum(dv * own), np.sum(iv * own * own)
        precision = tau[design.of] ** -2.0
        bend, cross, root = offset_system(design.places, design.rest, h, everyone, precision)
        pull = by_offset(design.places, everyone, g, n_offsets) - precision * offsets
        value -= 0.5 * log_determinant(design.rest, bend, root)
        value += 0.5 * np.sum(np.log(precision) - precision * offsets**2)
        value -= 0.5 * np.sum(design.prior_precision * (beta - design.prior_mean) ** 2)
        value -= 0.5 * ((log_scatter - SCATTER_MEAN) / SCATTER_SD) ** 2
        value -= 0.5 * np.sum((tau / design.spread_scale) ** 2)
        rise = value - best
        if value > best:
            best, best_beta[:], best_scatter, best_tau[:] = value, beta, log_scatter, tau
        if abs(rise) < CONVERGED:
            break
        step, offset_step = _newton(design, g, h, bend, cross, root, pull, beta)
        beta += step
        for k in range(n_offsets):
            offsets[k] += min(max(offset_step[k], -0.5), 0.5)
        if len(tau):
            shrunk = precision * variances(design.rest, bend, cross, root)
            _move_spreads(design, tau, offsets, shrunk, dv, iv)
        change = (d_scatter - (log_scatter - SCATTER_MEAN) / SCATTER_SD**2) / (
            info_scatter + 1.0 / SCATTER_SD**2
        )
        log_scatter += min(max(change, -0.5), 0.5)
    return LaplaceFit(best, best_beta, best_scatter, best_tau)


@kernel(inner=True)
def _own_offsets(design, tau):  # type: ignore[no-untyped-def]
    """Variance `[n_events]` of the offsets that events have for themselves."""
    total = np.zeros(len(design.constant))
    for a in range(len(tau)):
        for i in range(len(total)):
            if design.alone[a, i]:
                total[i] += tau[a] * tau[a]
    return total


@kernel(inner=True)
def _move_spreads(design, tau, offsets, shrunk, dv, iv):  # type: ignore[no-untyped-def]
    """Fisher's scoring of every log τ, in place: slope of the penalties, expected curvature.

    `shrunk` `[n_offsets]` is the variance of each offset over that of its prior.
    """
    for a in range(len(tau)):
        prior = (tau[a] / design.spread_scale[a]) ** 2
        slope, info = -prior, 2.0 * prior
        for k in range(len(offsets)):
            if design.of[k] == a:
                slope += (offsets[k] / tau[a]) ** 2 + shrunk[k] - 1.0
                info += 2.0 * (1.0 - shrunk[k]) ** 2
        for i in range(len(dv)):
            if design.alone[a, i]:
                slope += dv[i] * tau[a] ** 2
                info += iv[i] * tau[a] ** 4
        tau[a] *= math.exp(min(max(slope / (info + 1e-9), -0.7), 0.7))
        tau[a] = min(max(tau[a], LEAST_SPREAD), LARGEST_SPREAD)


@kernel(inner=True)
def _newton(design, g, h, bend, cross, root, pull, beta):  # type: ignore[no-untyped-def]
    """Joint Newton step of coefficients and offsets, the offsets eliminated first."""
    n, p = design.x.shape
    n_offsets = len(bend)
    a = np.zeros((p, p))
    b = np.zeros(p)
    joint = np.zeros((p, n_offsets))
    for i in range(n):
        for c in range(p):
            xc = design.x[i, c]
            b[c] += xc * g[i]
            for d in range(c + 1):
                a[c, d] += h[i] * xc * design.x[i, d]
            for q in range(len(design.places)):
                if design.places[q, i] >= 0:
                    joint[c, design.places[q, i]] += h[i] * xc
    for c in range(p):
        b[c] -= design.prior_precision[c] * (beta[c] - design.prior_mean[c])
        a[c, c] += design.prior_precision[c] + 1e-9
    # What offsets alone would do, and what they do for each coefficient.
    free = solved(design.rest, bend, cross, root, pull)
    for c in range(p):
        answer = solved(design.rest, bend, cross, root, joint[c])
        b[c] -= np.sum(joint[c] * free)
        for d in range(c + 1):
            a[c, d] -= np.sum(answer * joint[d])
            a[d, c] = a[c, d]
    step = np.linalg.solve(a, b)
    for c in range(p):
        pull -= joint[c] * step[c]
    return step, solved(design.rest, bend, cross, root, pull)


@kernel(inner=True)
def _terms(  # type: ignore[no-untyped-def]
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
            # Never less blurred than the record: else far from both the chance of detection falls
            # faster than the record's density, and their ratio has no bound.
            blur = max(edges.detected_sd[i] ** 2, record_moments.variance[i])
            s = own + blur + design.extra[i]
            spread = math.sqrt(s)
            z = (edges.detected[i] - m) / spread
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
