"""Log marginal likelihood of a model, by adaptive importance sampling about its mode.

A normal at the mode (Laplace's method) is wrong by nats where the posterior leans against a bound,
as the spread of paths does at none, or has a narrow peak on a broad hill, as the line above which
snow is taken up has. Here draws of Student's t about the mode are weighted by the density, the
next ones follow the weighted draws, and every draw counts with the mixture of all that were used
(Cappé, Guillin, Marin & Robert 2004; Owen & Zhou 2000).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.special import gammaln, log_ndtr, logsumexp

from avahazard.arrays import Floats
from avahazard.inference.fitting.mode import Mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import Layout, build_layout
from avahazard.inference.seeds import generator

DRAWS = 200
"""Draws of one round."""
MAX_ROUNDS = 8
ENOUGH = 150.0
"""Effective draws with which the error is about 0.08 nats."""
SAMPLE = 400
"""Draws of the posterior that are kept (systematic resampling)."""
FREEDOM = 5.0
WIDER = 3.0
"""Half of the first draws spread that much wider than the curvature at the mode promises."""


class Evidence(NamedTuple):
    """Log marginal likelihood and its standard error by simulation, nats.

    `sample` `[n, n_slots]` are draws of the posterior, by the weights of the simulation.
    """

    value: float
    error: float
    sample: Floats


class _Proposal(NamedTuple):
    """Student's t: its middle `[n_slots]` and the Cholesky factor of its spread."""

    middle: Floats
    factor: Floats


def log_evidence(posterior: Posterior, mode: Mode) -> Evidence:
    """The log of ∫ likelihood × prior, priors normalised over their own ranges."""
    rng = generator(0, "evidence")
    # No coordinate is spread wider than its range: draws about the mode would all miss.
    sd = np.sqrt(np.diag(mode.covariance))
    share = np.minimum(1.0, (posterior.layout.high - posterior.layout.low) / sd)
    mode = replace(mode, covariance=mode.covariance * np.outer(share, share))
    factor = np.asarray(np.linalg.cholesky(mode.covariance))
    proposals = [_Proposal(mode.u, factor), _Proposal(mode.u, WIDER * factor)]
    n = DRAWS // len(proposals)
    u = np.concatenate([_draws(p, n, rng) for p in proposals])
    density = posterior.log_densities(u)
    for _ in range(MAX_ROUNDS - 1):
        weight = density - _log_mixture(u, proposals)
        if _effective(weight) >= ENOUGH:
            break
        proposals.append(_following(u, weight, mode))
        # Proposals count by their draws: the first two have half a round each.
        more = _draws(proposals[-1], n, rng)
        u = np.concatenate([u, more])
        density = np.concatenate([density, posterior.log_densities(more)])
    weight = density - _log_mixture(u, proposals)
    value = float(logsumexp(weight)) - np.log(len(weight)) - log_prior_mass(posterior)
    # Tables made on the spot decide at the mode (`star`); the shape about it is kept.
    value += posterior.exact_log_likelihood(mode.u) - posterior.log_likelihood(mode.u)
    share = np.cumsum(np.exp(weight - logsumexp(weight)))
    chosen = np.searchsorted(share, (np.arange(SAMPLE) + 0.5) / SAMPLE * share[-1])
    return Evidence(float(value), float(_effective(weight) ** -0.5), u[chosen])


def log_prior_mass(posterior: Posterior) -> float:
    """Log of the integral of `exp(layout.log_prior)` over the ranges of the effects themselves.

    A star about a mode narrows the ranges; the prior stays what it was.
    """
    speeds = bool(posterior.observations.speeds)
    layout: Layout = build_layout(posterior.specification, posterior.effects, {}, speeds=speeds)
    total = 0.0
    for slot in layout.slots:
        low, high = slot.bounds
        # Above the middle by the mirror image, where the difference keeps its digits.
        low, high = (-high, -low) if low > 0.0 else (low, high)
        mass = float(log_ndtr(high) + np.log1p(-np.exp(log_ndtr(low) - log_ndtr(high))))
        total += np.log(slot.sd) + 0.5 * np.log(2.0 * np.pi) + mass
    if layout.law_correlation is not None:  # the law's coordinates have no bounds
        total += 0.5 * np.linalg.slogdet(layout.law_correlation)[1]
    return float(total)


def _draws(proposal: _Proposal, n: int, rng: np.random.Generator) -> Floats:
    """Draws `[n, n_slots]`."""
    z = rng.standard_normal((n, len(proposal.middle)))
    widths = np.sqrt(FREEDOM / rng.chisquare(FREEDOM, n))
    return np.asarray(proposal.middle + widths[:, None] * (z @ proposal.factor.T))


def _log_mixture(u: Floats, proposals: list[_Proposal]) -> Floats:
    """Log density `[n_draws]` of the mixture of the proposals, each with as many draws."""
    d = u.shape[1]
    constant = gammaln(0.5 * (FREEDOM + d)) - gammaln(0.5 * FREEDOM)
    constant -= 0.5 * d * np.log(FREEDOM * np.pi)
    each = []
    for middle, factor in proposals:
        z = np.linalg.solve(factor, (u - middle).T)
        tail = 0.5 * (FREEDOM + d) * np.log1p(np.sum(z * z, axis=0) / FREEDOM)
        each.append(constant - np.sum(np.log(np.diag(factor))) - tail)
    return np.asarray(logsumexp(each, axis=0) - np.log(len(each)))


def _effective(log_weight: Floats) -> float:
    """Effective number of draws, (Σw)² / Σw²."""
    return float(np.exp(2.0 * logsumexp(log_weight) - logsumexp(2.0 * log_weight)))


def _following(u: Floats, log_weight: Floats, mode: Mode) -> _Proposal:
    """The proposal with mean and covariance of the weighted draws.

    Weights are cut at √n times their mean (Ionides 2008), so that one draw does not decide; the
    curvature at the mode counts as one draw in d more, so that no direction is lost.
    """
    n, d = u.shape
    weight = np.exp(log_weight - logsumexp(log_weight))
    weight = np.minimum(weight, n**-0.5)
    weight /= np.sum(weight)
    middle = weight @ u
    away = u - middle
    share = 1.0 / (1.0 + _effective(np.log(np.maximum(weight, 1e-300))) / d)
    spread = (1.0 - share) * (away * weight[:, None]).T @ away + share * mode.covariance
    return _Proposal(middle, np.linalg.cholesky(spread))
