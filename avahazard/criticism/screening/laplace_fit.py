"""Laplace fit of a linear model of log friction with path offsets to `RecordMoments`.

Newton steps on coefficients, offsets and scatter at once (penalised iteratively re-weighted
least squares, Breslow and Clayton 1993), the spread of the offsets by Fisher's scoring, and the
log likelihood with the offsets integrated out by Laplace's method. Events that left the
profile and the chance to be seen are in it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.model.friction_scatter import (
    HALF_LOG_2PI,
    LOG_STUDENT_PEAK,
    STUDENT_INFORMATION,
    STUDENT_PULL,
    log_normal_below,
    student_shape,
)
from avahazard.kernels import kernel

Floats = NDArray[np.float64]

STEPS = 12
CONVERGED = 1e-4
"""Rise of the log likelihood (nats) from one step to the next after which there are no more."""


class Design(NamedTuple):
    """What stays alike between made worlds: columns `x` `[n_events, n_columns]`, `constant`.

    Coefficients have normal priors `prior_mean`, `prior_precision` `[n_columns]`; `path`
    `[n_events]` is the group of the offset (-1: none), `n_paths` their number (0: no offsets);
    `extra` `[n_events]` is variance from the volume's error; `multiplier` scales the scatter;
    `log_wrong` `[n_events]` is as in `wrong_records`, for Student's tails.
    """

    x: Floats
    constant: Floats
    prior_mean: Floats
    prior_precision: Floats
    path: NDArray[np.int64]
    n_paths: int
    extra: Floats
    multiplier: Floats
    log_wrong: Floats


class Edges(NamedTuple):
    """Probabilities by one edge each, `[n_events]`: of leaving, and of being seen.

    The event leaves where ν < `leave`; it is seen where ν < `seen`, blurred by `seen_sd`
    (`has_limit` False: always).
    """

    leave: Floats
    seen: Floats
    seen_sd: Floats
    has_limit: NDArray[np.bool_]


class LaplaceFit(NamedTuple):
    """Log likelihood with the prior of the coefficients, and where it is reached."""

    log_likelihood: float
    coefficients: Floats
    log_scatter: float
    tau: float


SCATTER_MEAN, SCATTER_SD = math.log(0.15), 1.0
TAU_SCALE = 0.2


@kernel
def laplace_fit(record_moments, left, edges, design, start, log_scatter, tau, student):  # type: ignore[no-untyped-def]
    """Fit from `start` `[n_columns]`, `log_scatter` and `tau`; returns a `LaplaceFit`."""
    n, p = design.x.shape
    n_paths = design.n_paths
    beta = start.copy()
    offsets = np.zeros(n_paths)
    g = np.zeros(n)
    h = np.zeros(n)
    best = -np.inf
    best_beta, best_scatter, best_tau = beta.copy(), log_scatter, tau
    for _ in range(STEPS):
        sigma = math.exp(log_scatter)
        value, d_scatter, info_scatter = _terms(
            record_moments, left, edges, design, beta, offsets, sigma, student, g, h
        )
        # Offsets: curvature by path, and their penalty.
        bend = np.full(n_paths, 1.0 / (tau * tau))
        pull = np.zeros(n_paths)
        for i in range(n):
            if n_paths and design.path[i] >= 0:
                bend[design.path[i]] += h[i]
                pull[design.path[i]] += g[i]
        for k in range(n_paths):
            pull[k] -= offsets[k] / (tau * tau)
            value -= 0.5 * offsets[k] ** 2 / (tau * tau) + 0.5 * math.log(tau * tau * bend[k])
        for c in range(p):
            value -= 0.5 * design.prior_precision[c] * (beta[c] - design.prior_mean[c]) ** 2
        value -= 0.5 * ((log_scatter - SCATTER_MEAN) / SCATTER_SD) ** 2
        if n_paths:
            value -= 0.5 * (tau / TAU_SCALE) ** 2
        rise = value - best
        if value > best:
            best, best_beta[:], best_scatter, best_tau = value, beta, log_scatter, tau
        if abs(rise) < CONVERGED:
            break
        step, offset_step = _newton(design, g, h, bend, pull, beta)
        for c in range(p):
            beta[c] += step[c]
        for k in range(n_paths):
            offsets[k] += min(max(offset_step[k], -0.5), 0.5)
        change = (d_scatter - (log_scatter - SCATTER_MEAN) / SCATTER_SD**2) / (
            info_scatter + 1.0 / SCATTER_SD**2
        )
        log_scatter += min(max(change, -0.5), 0.5)
        if n_paths:
            # Fisher's scoring of log τ: slope of the penalties and its expected curvature.
            prior = (tau / TAU_SCALE) ** 2
            slope, info = -prior, 2.0 * prior
            for k in range(n_paths):
                shrunk = 1.0 / (tau * tau * bend[k])
                slope += (offsets[k] / tau) ** 2 + shrunk - 1.0
                info += 2.0 * (1.0 - shrunk) ** 2
            tau *= math.exp(min(max(slope / (info + 1e-9), -0.7), 0.7))
            tau = min(max(tau, 1e-3), 1.0)
    return LaplaceFit(best, best_beta, best_scatter, best_tau)


@kernel
def _newton(design, g, h, bend, pull, beta):  # type: ignore[no-untyped-def]
    """Joint Newton step of coefficients and offsets, the offsets eliminated path by path."""
    n, p = design.x.shape
    n_paths = design.n_paths
    a = np.zeros((p, p))
    b = np.zeros(p)
    cross = np.zeros((n_paths, p))
    for i in range(n):
        for c in range(p):
            xc = design.x[i, c]
            b[c] += xc * g[i]
            for d in range(c + 1):
                a[c, d] += h[i] * xc * design.x[i, d]
            if n_paths and design.path[i] >= 0:
                cross[design.path[i], c] += h[i] * xc
    for c in range(p):
        b[c] -= design.prior_precision[c] * (beta[c] - design.prior_mean[c])
        a[c, c] += design.prior_precision[c] + 1e-9
        for k in range(n_paths):
            b[c] -= cross[k, c] * pull[k] / bend[k]
            for d in range(c + 1):
                a[c, d] -= cross[k, c] * cross[k, d] / bend[k]
        for d in range(c):
            a[d, c] = a[c, d]
    step = np.linalg.solve(a, b)
    offset_step = np.zeros(n_paths)
    for k in range(n_paths):
        offset_step[k] = pull[k]
        for c in range(p):
            offset_step[k] -= cross[k, c] * step[c]
        offset_step[k] /= bend[k]
    return step, offset_step


@kernel
def _terms(record_moments, left, edges, design, beta, offsets, sigma, student, g, h):  # type: ignore[no-untyped-def]
    """Sum of log likelihoods; fills score g and curvature h in m; derivatives in log σ."""
    n, p = design.x.shape
    value, d_scatter, info_scatter = 0.0, 0.0, 0.0
    for i in range(n):
        m = design.constant[i]
        for c in range(p):
            m += design.x[i, c] * beta[c]
        if design.n_paths and design.path[i] >= 0:
            m += offsets[design.path[i]]
        own = (sigma * design.multiplier[i]) ** 2
        if left[i] and record_moments.variance[i] == 0.0:
            spread = math.sqrt(own + design.extra[i])
            z = (edges.leave[i] - m) / spread
            log_p, ratio = log_normal_below(z)
            value += log_p
            g[i] = -ratio / spread
            h[i] = ratio * (ratio + z) / (spread * spread)
            share = own / (spread * spread)
            d_scatter += -z * ratio * share
            info_scatter += 0.5 * (z * ratio * share) ** 2
        else:
            s = own + record_moments.variance[i] + design.extra[i]
            e = record_moments.mean[i] - m
            share = own / s
            if student:
                shape = student_shape(e * e / s)
                log_p = LOG_STUDENT_PEAK - 0.5 * math.log(s) + 2.5 * math.log(shape)
                # What the record would be worth as a grossly wrong one.
                wrong = design.log_wrong[i] - record_moments.log_mass[i]
                either = max(log_p, wrong) + math.log1p(math.exp(-abs(log_p - wrong)))
                right = math.exp(log_p - either)
                value += either
                pull = STUDENT_PULL * shape / s
                g[i], h[i] = right * pull * e, right * pull
                d_scatter += right * (pull * e * e - 1.0) * share
                info_scatter += right * STUDENT_INFORMATION * share * share
            else:
                value += -HALF_LOG_2PI - 0.5 * math.log(s) - 0.5 * e * e / s
                g[i] = e / s
                h[i] = 1.0 / s
                d_scatter += (e * e / s - 1.0) * share
                info_scatter += 2.0 * share * share
            value += record_moments.log_mass[i]
        if edges.has_limit[i]:
            # Never less blurred than the record: else far from both the chance to be seen falls
            # faster than the record's density, and their ratio has no bound.
            blur = max(edges.seen_sd[i] ** 2, record_moments.variance[i])
            s = own + blur + design.extra[i]
            spread = math.sqrt(s)
            z = (edges.seen[i] - m) / spread
            log_p, ratio = log_normal_below(z)
            value -= log_p
            g[i] += ratio / spread
            h[i] = max(h[i] - ratio * (ratio + z) / s, 0.1 * h[i])
            d_scatter += z * ratio * own / s
    return value, d_scatter, info_scatter
