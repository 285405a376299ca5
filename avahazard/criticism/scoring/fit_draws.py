"""A fit to a part of the events: its mode, and draws of its posterior.

The draws are weighted by the posterior density (importance sampling), so that its bounds are kept
and, where draws of the whole posterior are at hand to draw near, its bends.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.special import logsumexp
from scipy.stats import multivariate_t

from avahazard.arrays import Floats
from avahazard.inference.fitting.mode import Mode, find_mode, units
from avahazard.inference.likelihood.offsets import Offsets
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.seeds import generator

Density = Callable[[Floats], float]

N_CENTRES = 150
CENTRE_WIDTH = 0.4
"""Width of the steps from draws of the whole posterior, of its standard deviation."""
FLAT, FLAT_SHARE = 1e-9, 0.01
"""Draws of chains that hardly moved may span less than all directions: where their least variance
is that small a share of the largest, they get this share of the covariance at the mode."""
MODE_SHARE = 0.2
STAGES = 4
FREEDOM = 5
FIRST_WIDTH = 1.5
"""The first draws are that much wider than the curvature at the mode promises."""
NARROWEST = 1e-4
"""Least standard deviation of a proposal, in coordinates."""
EDGE = 2e-3
"""A mode that close to a bound, in coordinates of order one, lies on it."""


class FitDraws(NamedTuple):
    """Draws of a fit.

    Coordinates `[n_draws, n_slots]`, their log weights `[n_draws]` (which sum to 1) and, with
    groups of events, their offsets `[n_draws, n_offsets]`.
    """

    coordinates: Floats
    log_weight: Floats
    offsets: Floats | None


def fit_draws(
    posterior: Posterior, start: Mode, n_draws: int, key: str, around: Floats | None = None
) -> FitDraws:
    """Fit the posterior from `start`, the mode given all events, and draw from it.

    Equal keys give equal draws. The first draws are as wide as at `start`; they adapt.

    With draws `around` `[n, n_slots]` of the posterior given all events, the new ones are near
    these, which follows any bend; else they are about the mode.
    """
    mode = find_mode(posterior, start.u, start.covariance)
    known: dict[bytes, Offsets] = {}

    def log_density(u: Floats) -> float:
        value, found = posterior.density_and_offsets(u)
        if found is not None:
            known[u.tobytes()] = found
        return value

    if around is None:
        u, log_weight = _about_the_mode(posterior, log_density, mode, n_draws, key)
    else:
        u, log_weight = _near_draws(posterior, log_density, mode, start.u, around, n_draws, key)
    offsets = None
    if posterior.plan:
        rng = generator(0, "offset draws", key)
        given = [known.get(v.tobytes()) or posterior.offsets(v) for v in u]
        offsets = np.array([one.draw(rng) for one in given])
    return FitDraws(u, log_weight, offsets)


def _near_draws(
    posterior: Posterior,
    log_density_at: Density,
    mode: Mode,
    start: Floats,
    around: Floats,
    n_draws: int,
    key: str,
) -> tuple[Floats, Floats]:
    """Draws and log weights from small Student distributions at draws of the full posterior.

    Half of these stand where they are, half are moved as the mode has moved from `start`; a share
    of the draws is about the new mode, should the old posterior be nowhere near.
    """
    chosen = np.linspace(0, len(around) - 1, N_CENTRES).round().astype(np.int64)
    centres = np.concatenate([around[chosen], around[chosen] + mode.u - start])
    at_mode = _bounded_covariance(posterior, mode)
    unit = units(posterior)
    spread = np.atleast_2d(np.cov(around.T)) + 1e-10 * np.diag(unit**2)
    narrow, longest = np.linalg.eigvalsh(spread / np.outer(unit, unit))[[0, -1]]
    if narrow < FLAT * longest:
        spread = spread + FLAT_SHARE * at_mode
    kernel = _student(np.zeros(len(mode.u)), CENTRE_WIDTH**2 * spread, unit)
    wide = _student(mode.u, FIRST_WIDTH**2 * at_mode, unit)
    rng = generator(0, "fit draws", key)
    n_wide = int(MODE_SHARE * n_draws)
    n_near = n_draws - n_wide
    picked = centres[rng.permutation(np.arange(n_near) % len(centres))]
    u = np.concatenate([picked + kernel.rows(n_near, rng), wide.rows(n_wide, rng)])
    log_density = np.array([log_density_at(v) for v in u])
    inside = np.isfinite(log_density)
    if not np.any(inside):
        return mode.u[None, :], np.zeros(1)
    u, log_density = u[inside], log_density[inside]
    near = logsumexp(kernel.logpdf(u[:, None, :] - centres), axis=1) - np.log(len(centres))
    log_q = np.logaddexp(np.log(1.0 - MODE_SHARE) + near, np.log(MODE_SHARE) + wide.logpdf(u))
    return u, _cut(log_density - log_q)


def _about_the_mode(
    posterior: Posterior, log_density_at: Density, mode: Mode, n_draws: int, key: str
) -> tuple[Floats, Floats]:
    """Draws and log weights by adaptive importance sampling (Cornuet et al. 2012).

    Student distributions, the first a little wider than the curvature at the mode promises, each
    further one with the moments of what was found so far.
    """
    covariance = FIRST_WIDTH**2 * _bounded_covariance(posterior, mode)
    unit = units(posterior)
    proposals = [_student(mode.u, covariance, unit)]
    u = np.empty((0, len(mode.u)))
    log_density = np.empty(0)
    for stage in range(STAGES):
        rng = generator(0, "fit draws", key, stage)
        n = n_draws // STAGES
        drawn = proposals[-1].rows(n, rng)
        values = np.array([log_density_at(v) for v in drawn])
        inside = np.isfinite(values)
        u = np.concatenate([u, drawn[inside]])
        log_density = np.concatenate([log_density, values[inside]])
        if len(u) == 0:
            u, log_density = mode.u[None, :], np.array([mode.log_density])
        log_q = np.column_stack([q.logpdf(u) for q in proposals])
        log_weight = _cut(log_density - logsumexp(log_q, axis=1))
        weight = np.exp(log_weight)
        centre = weight @ u
        moved = (u - centre) * np.sqrt(weight)[:, None]
        # Few draws say little about a covariance: the one before has its share.
        share = 1.0 / (1.0 + 2.0 * len(mode.u) * np.sum(weight**2))
        covariance = share * moved.T @ moved + (1.0 - share) * covariance
        proposals.append(_student(centre, covariance, unit))
    return u, log_weight


def _cut(log_weight: Floats) -> Floats:
    """Weights that sum to 1; none counts for too many draws (Ionides 2008)."""
    most = logsumexp(log_weight) - 0.5 * np.log(len(log_weight))
    log_weight = np.minimum(log_weight, most)
    return np.asarray(log_weight - logsumexp(log_weight))


def _bounded_covariance(posterior: Posterior, mode: Mode) -> Floats:
    """The covariance at the mode, narrowed where the density falls off from a bound."""
    layout, u = posterior.layout, mode.u
    on_edge = np.flatnonzero((u < layout.low + EDGE) | (u > layout.high - EDGE))
    precision = np.linalg.inv(mode.covariance)
    for k in on_edge:
        inside = u.copy()
        inside[k] += EDGE if u[k] < layout.low[k] + EDGE else -EDGE
        slope = (mode.log_density - posterior.log_density(inside)) / EDGE
        # The standard deviation of an exponential fall-off is one over its rate.
        precision[k, k] += max(slope, 0.0) ** 2
    return np.linalg.inv(precision)


class _Student(NamedTuple):
    """A multivariate Student distribution, held in units: its coordinates are of order one."""

    in_units: Any
    unit: Floats

    def rows(self, n: int, rng: np.random.Generator) -> Floats:
        """`n` draws `[n, n_slots]`."""
        drawn = np.asarray(self.in_units.rvs(n, random_state=rng), np.float64)
        return np.asarray(self.unit * drawn.reshape(n, -1))

    def logpdf(self, u: Floats) -> Floats:
        """The log density at `u` `[..., n_slots]`."""
        values = np.atleast_1d(self.in_units.logpdf(u / self.unit))
        return np.asarray(values - np.sum(np.log(self.unit)))


def _student(centre: Floats, covariance: Floats, unit: Floats) -> _Student:
    # Nowhere near to flat, as it is at a mode on a bound where the density falls off steeply.
    shape = covariance / np.outer(unit, unit) + NARROWEST**2 * np.eye(len(centre))
    return _Student(multivariate_t(centre / unit, shape, FREEDOM), unit)


def evenly_weighted(draws: FitDraws, n: int) -> FitDraws:
    """`n` draws of equal weight, each as often as it counts (systematic resampling)."""
    level = np.cumsum(np.exp(draws.log_weight))
    chosen = np.searchsorted(level, (np.arange(n) + 0.5) / n * level[-1])
    return FitDraws(
        draws.coordinates[chosen],
        np.full(n, -np.log(n)),
        None if draws.offsets is None else draws.offsets[chosen],
    )
