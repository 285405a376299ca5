"""The posterior mode, the curvature there, and from it the log marginal likelihood.

A normal at the mode is wrong by nats against a bound, or on a narrow peak. So draws of Student's t
about the mode are weighted by the density, the next ones follow the weighted draws, and every draw
counts with the mixture of all that were used (Cappé, Guillin, Marin & Robert 2004; Owen & Zhou
2000).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import OptimizeResult, minimize
from scipy.special import gammaln, log_ndtr, logsumexp

from avahazard.arrays import Floats, Ints
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.seeds import generator

STEEP = 100.0
"""Change of log friction per coordinate from which on a coordinate is too coarse to move in."""


def units(posterior: Posterior) -> Floats:
    """The unit of each coordinate `[n_slots]`, 1 where it is of order one as it should be.

    With slides of 1e12 m3 the exponential law's n moves log friction by a million: there the unit
    is what moves it by one (root mean square).
    """
    law, volumes = posterior.layout.law, posterior.observations.volumes
    unit = np.ones(len(posterior.layout.slots))
    if not law.uses_volume or not volumes.population.known:
        return unit
    volume = np.exp(volumes.mean)
    middle = law.prior_mean
    for k in range(len(law.coordinates)):
        # Small enough that no law is at its bounds.
        step = np.zeros(len(middle))
        step[k] = 1e-12
        moved = law.log_friction(middle + step, volume) - law.log_friction(middle - step, volume)
        slope = float(np.sqrt(np.mean(np.square(moved / 2e-12))))
        if slope > STEEP:
            unit[k] = 1.0 / slope
    return unit


STEP, GRADIENT_STEP = 1e-3, 1e-6
"""Steps of the differences for curvature and gradient, in coordinates of order one."""
APART = 0.01
"""Differences for scores, in coordinates of order one."""
HELD_ITERATIONS, HELD_GAIN = 20, 0.01
"""Most iterations of a short ascent, and the least gain (nats) of one."""
FALL = 0.5
"""Fall of the log density (nats) over which curvature is taken along the arms of a star."""
MOST_BENT = 4.0
"""Times the information that the curvature along an arm may be."""
STEEPEST = 1e100
"""Slope (nats a unit) whose square an ascent tolerates: volumes off any scale have steeper ones."""
ITERATIONS = 200
LEAST_CURVATURE = 0.05
"""Curvature that is taken where the density hardly bends down."""
REFUSED = 1e10
"""Cost where the density is zero."""
FIRST_SPREAD = 0.5
"""Coordinate from which spreads between groups are sought."""


@dataclass(frozen=True, slots=True, eq=False)
class Mode:
    """A mode and the normal with its curvature.

    Coordinates `[n_slots]`, the log density there, and the covariance `[n_slots, n_slots]`. Or the
    normal of some draws about their mean, with no density (nan).
    """

    u: Floats
    log_density: float
    covariance: Floats


def start_coordinates(posterior: Posterior) -> Floats:
    """Coordinates near the data: least squares of the law on each event's likely friction."""
    layout = posterior.layout
    u = np.array([s.mean if np.isnan(s.neutral) else s.neutral for s in layout.slots])
    u[list(layout.spreads.values())] = FIRST_SPREAD
    pinned = posterior.pinned(u)
    friction = likely_friction(pinned.nodes.at(u), layout.log_scatter)
    middle = posterior.observations.volumes.log_volume.shape[1] // 2
    volume = np.exp(posterior.observations.volumes.log_volume[:, middle])
    n = len(layout.law.coordinates)
    # Two starts, and the more likely mode: one outlier can mislead least squares.
    rough = u.copy()
    rough[:n] = layout.law.start(volume, friction)
    tried = [rough, u]
    best = max(tried, key=pinned.log_density)
    return np.asarray(np.clip(best, layout.low, layout.high))


def likely_friction(nodes: Nodes, in_log: bool) -> Floats:
    """Mean friction of each event's nodes `[n_events]`, nan for events beyond the profile."""
    mean = np.sum(nodes.place * nodes.weight, axis=1)
    friction = np.exp(mean) if in_log else mean
    return np.where(nodes.is_probability, np.nan, friction)


def find_mode(
    posterior: Posterior, start: Floats | None = None, covariance: Floats | None = None
) -> Mode:
    """Maximise the posterior density within its bounds (L-BFGS-B), from `start` or the data.

    `covariance` may be given where a near fit knows it well enough; else it is found.
    """
    layout = posterior.layout
    u = start_coordinates(posterior) if start is None else np.clip(start, layout.low, layout.high)
    cost = -np.inf
    for _ in range(2):
        u, cost = ascent(posterior, u, np.arange(len(u)), ITERATIONS)
    if covariance is None:
        covariance = covariance_at(posterior, u)
    return Mode(u, -cost, covariance)


def ascent(
    posterior: Posterior, u: Floats, free: Ints, iterations: int, least: float = 0.0
) -> tuple[Floats, float]:
    """The best coordinates from u on with only the slots `free` moving, and the cost there.

    The cost is minus the log density; an iteration that gains less than `least` nats is the last.
    What shapes tables moves along the arms of the star; gradients are exact by the slots
    `Posterior.sloped`, else differences over `GRADIENT_STEP` of `units`.
    """
    layout = posterior.layout
    unit, (low, high) = units(posterior), layout.arm_ends
    apart = GRADIENT_STEP * unit
    exact = np.isin(free, posterior.sloped)
    whole = layout.on_arms(u).copy()

    def coordinates(v: Floats) -> Floats:
        whole[free] = np.clip(v * unit[free], low[free], high[free])
        return np.clip(layout.from_arms(whole), layout.low, layout.high)

    def cost(v: Floats) -> tuple[float, Floats]:
        at = coordinates(v)
        value, slopes = np.nan, np.zeros(len(at))
        if exact.any():
            value, slopes = posterior.density_and_slopes(at)
        gradient, moved = -slopes[free], ~exact
        if not (np.isfinite(value) and np.all(np.abs(slopes * unit) < STEEPEST)):
            # Where there is no density there are no slopes of it.
            value, moved = -float(costs(posterior, at[None])[0]), np.full(len(free), True)
        if moved.any():
            step = np.where(whole + apart > high, -apart, apart)[free[moved]]
            around = at + step[:, None] * layout.turn[:, free[moved]].T
            gradient[moved] = (costs(posterior, around) + value) / step
        return -value, gradient * unit[free]

    bounds = list(zip((low / unit)[free], (high / unit)[free], strict=True))
    first = (whole / unit)[free]
    before = np.inf

    def stop_at_little(intermediate_result: OptimizeResult) -> None:
        nonlocal before
        gain, before = before - intermediate_result.fun, intermediate_result.fun
        if gain < least:
            raise StopIteration

    found = minimize(
        cost,
        first,
        method="L-BFGS-B",
        jac=True,
        bounds=bounds,
        callback=stop_at_little,
        options={"maxiter": iterations},
    )
    return coordinates(found.x), float(found.fun)


def held_ascent(
    posterior: Posterior, u: Floats, held: Sequence[int] | Ints, values: Sequence[float] | Floats
) -> tuple[float, Floats]:
    """Log density and coordinates of a short ascent from u with slots `held` kept at `values`.

    All that shapes the tables is held as well, where it is.
    """
    start = u.copy()
    start[list(held)] = values
    free = np.setdiff1d(np.arange(len(u)), [*posterior.layout.axes, *held])
    reached, cost = ascent(posterior.pinned(start), start, free, HELD_ITERATIONS, HELD_GAIN)
    return -cost, reached


def costs(posterior: Posterior, u: Floats) -> Floats:
    """Minus the log densities `[n]` at u `[n, n_slots]`; `REFUSED` where there is none."""
    values = -posterior.log_densities(u)
    return np.where(np.isfinite(values), values, REFUSED)


def covariance_at(posterior: Posterior, u: Floats) -> Floats:
    """Inverse of the Hessian of the cost, kept positive and finite."""
    n = len(u)
    # At a bound the differences are taken one step inside.
    low, high = posterior.layout.low, posterior.layout.high
    unit = units(posterior)
    centre = np.clip(u, low + 2 * STEP * unit, high - 2 * STEP * unit)
    step = _steps(posterior, centre, unit)
    steps = np.diag(step * unit)
    i, j = np.triu_indices(n, 1)
    # Over long steps the change of one curvature by another coordinate would pass for slant.
    long = (step[i] > STEP) | (step[j] > STEP)
    apart = [steps[i[long]] - steps[j[long]], steps[j[long]] - steps[i[long]]]
    moves = [np.zeros((1, n)), steps, -steps, steps[i] + steps[j], -steps[i] - steps[j], *apart]
    parts = np.cumsum([len(part) for part in moves[:-1]])
    places = _mirrored(posterior, centre + np.concatenate(moves))
    middle, ahead, behind, forth, back, one, other = np.split(costs(posterior, places), parts)
    alone, both = ahead + behind, forth + back
    hessian = np.diag(alone - 2.0 * middle)
    # Both steps forwards and both back, less the steps by themselves.
    across = 0.5 * (both - alone[i] - alone[j]) + middle
    across[long] = 0.25 * (both[long] - one - other)
    hessian[i, j] = hessian[j, i] = across
    hessian /= np.outer(step, step)
    arms = np.isin(np.arange(n), posterior.layout.axes)
    if arms.any():
        # Bends of the blend hide the curvature, or pass for it: the information stands for it.
        scores = scores_at(posterior, u, np.diag(APART * unit)) * unit
        priors = np.array([slot.sd for slot in posterior.layout.slots]) / unit
        information = scores.T @ scores + np.diag(priors**-2.0)
        # Of spreads the scores, given offsets, say nothing.
        spreads = [*posterior.layout.spreads.values()]
        information[spreads, spreads] = np.maximum(hessian[spreads, spreads], LEAST_CURVATURE)
        if np.linalg.eigvalsh(hessian)[0] < LEAST_CURVATURE:
            hessian = information
        share = MOST_BENT * np.diag(information) / np.diag(hessian)
        less = np.where(arms, np.minimum(1.0, share), 1.0) ** 0.5
        hessian *= np.outer(less, less)
    values, vectors = np.linalg.eigh(hessian)
    if values[0] < LEAST_CURVATURE:
        # Against a bound the density need not bend down, but falls as an exponential, whose
        # standard deviation is one over its rate.
        against = (u < low + 2 * STEP * unit) | (u > high - 2 * STEP * unit)
        rate = (ahead - behind) / (2.0 * step)
        values, vectors = np.linalg.eigh(hessian + np.diag(np.where(against, rate**2, 0.0)))
    values = np.clip(values, LEAST_CURVATURE, 1e8)
    return np.asarray(np.outer(unit, unit) * ((vectors / values) @ vectors.T))


def scores_at(posterior: Posterior, u: Floats, moves: Floats, *, both_ways: bool = False) -> Floats:
    """Derivatives of each event's log likelihood by every coordinate, `[n_events, n_slots]`.

    Differences over the columns of `moves` `[n_slots, n_slots]`, `both_ways` where there is room,
    of tables made on the spot. Where F jumps an event's likelihood has steps, which are no slopes:
    along a move none counts for more than all other events together.
    """
    layout = posterior.layout
    pinned = posterior.pinned(u)
    offsets = pinned.mode_offsets(u)
    here = pinned.event_log_likelihood(u, offsets)
    shapes = np.isin(np.arange(len(u)), layout.axes)
    neutral = shapes & (u == [slot.neutral for slot in layout.slots])
    low, high = layout.ranges

    def moved(by: Floats) -> Floats:
        there = u + by
        at = posterior.pinned(there) if np.any(by[shapes]) else pinned
        return at.event_log_likelihood(there, offsets)

    changes, signs = np.empty((len(here), len(u))), np.ones(len(u))
    for k, move in enumerate(moves.T):
        ahead, behind = (np.all((v <= high) & (v >= low)) for v in (u + move, u - move))
        if both_ways and ahead and behind:
            changes[:, k] = 0.5 * (moved(move) - moved(-move))
            continue
        signs[k] = 1.0 if ahead else -1.0
        by = np.clip(u + signs[k] * move, low, high) - u
        # A neutral effect is left out, and with it the small errors of runs that have it.
        beside = moved(1e-6 * by) if np.any(by[neutral]) else here
        changes[:, k] = moved(by) - beside
    if len(here) > 1:
        squares = changes**2
        most = np.sqrt(np.sum(squares, axis=0) - squares)
        changes = np.clip(changes, -most, most)
    return changes @ np.linalg.inv(signs * moves)


def _steps(posterior: Posterior, centre: Floats, unit: Floats) -> Floats:
    """Steps in units `[n_slots]` over which the curvature is taken: `STEP`, or until it shows.

    Along the arms of a star, where the density is a blend with bends, and near no spread of groups,
    a step goes on until the density falls by `FALL`, as far as there is room.
    """
    layout = posterior.layout
    step = np.full(len(centre), STEP)
    spreads = [*layout.spreads.values()]
    below = centre - layout.low
    below[spreads] = np.inf  # the density goes on beyond no spread as before it
    room = np.minimum(below, layout.high - centre) / unit
    here = costs(posterior, centre[None])[0]
    for k in [*layout.axes, *spreads]:
        longest = max(float(room[k]), STEP)
        while step[k] < longest:
            both = np.tile(centre, (2, 1))
            both[:, k] += np.array([1.0, -1.0]) * step[k] * unit[k]
            if np.mean(costs(posterior, _mirrored(posterior, both))) - here >= FALL:
                break
            step[k] = min(2.0 * step[k], longest)
    return step


def _mirrored(posterior: Posterior, u: Floats) -> Floats:
    """Coordinates `[n, n_slots]` with the sizes of spreads, by which the density goes."""
    u, spreads = u.copy(), [*posterior.layout.spreads.values()]
    u[:, spreads] = np.maximum(np.abs(u[:, spreads]), posterior.layout.low[spreads])
    return u


DRAWS = 200
"""Draws of one round."""
MAX_ROUNDS = 8
ENOUGH = 150.0
"""Effective draws with which the error is about 0.08 nats."""
SAMPLE = 400
"""Draws of the posterior that are kept (systematic resampling)."""
CHECKED_DRAWS = 8
"""Draws at which a star is held against tables made on the spot."""
FREEDOM = 5.0
WIDER = 3.0
"""Half of the first draws spread that much wider than the curvature at the mode promises."""
NARROWER, HARDLY_ANY = (1.0, 0.3, 0.1, 0.03), 0.02
"""Shares of that to which they are drawn in where fewer than this share lie within the star."""
LEAST_WITHIN = 0.1
"""Where few draws of a round lie within the star there are more of the next one, as those beyond
cost little; as many more as if at least this share were within."""


class Evidence(NamedTuple):
    """Log marginal likelihood and its standard error by simulation and by the star, nats.

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
    n = DRAWS // 2
    for narrower in NARROWER:
        proposals = [_Proposal(mode.u, wide * narrower * factor) for wide in (1.0, WIDER)]
        u = np.concatenate([_draws(p, n, rng) for p in proposals])
        density = posterior.log_densities(u)
        within = float(np.mean(np.isfinite(density)))
        if within >= HARDLY_ANY:
            break
    if not within:
        return Evidence(-np.inf, np.inf, mode.u[None])
    counts = [n, n]
    for _ in range(MAX_ROUNDS - 1):
        weight = density - _log_mixture(u, proposals, counts)
        if _effective(weight) >= ENOUGH:
            break
        proposals.append(_following(u, weight, mode))
        counts.append(int(n / max(within, LEAST_WITHIN)))
        more = _draws(proposals[-1], counts[-1], rng)
        found = posterior.log_densities(more)
        within = float(np.mean(np.isfinite(found)))
        u, density = np.concatenate([u, more]), np.concatenate([density, found])
    weight = density - _log_mixture(u, proposals, counts)
    value = float(logsumexp(weight)) - np.log(len(weight)) - log_prior_mass(posterior)
    share = np.cumsum(np.exp(weight - logsumexp(weight)))
    chosen = np.searchsorted(share, (np.arange(SAMPLE) + 0.5) / SAMPLE * share[-1])
    sample = u[chosen]
    # Tables made on the spot decide: the mean of what they are more likely by than the star.
    off = errors_at(posterior, sample)
    value += float(logsumexp(off)) - np.log(len(off))
    error = np.hypot(_effective(weight) ** -0.5, np.std(off) / np.sqrt(len(off)))
    return Evidence(float(value), float(error), sample)


def errors_at(posterior: Posterior, draws: Floats) -> Floats:
    """By how much (nats) a star errs at some of its `draws` `[n, n_slots]`."""
    if not posterior.nodes.varies:
        return np.zeros(1)
    some = checked_draws(draws)
    return np.array([posterior.exact_log_likelihood(u) - posterior.log_likelihood(u) for u in some])


def checked_draws(draws: Floats) -> Floats:
    """Some of the draws `[n, n_slots]`."""
    return draws[np.linspace(0, len(draws) - 1, CHECKED_DRAWS).astype(np.int64)]


def log_prior_mass(posterior: Posterior) -> float:
    """Log of the integral of `exp(layout.log_prior)` over the ranges of the effects themselves."""
    layout = posterior.layout
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


def _log_mixture(u: Floats, proposals: list[_Proposal], counts: list[int]) -> Floats:
    """Log density `[n_draws]` of the mixture of the proposals, which count by their draws."""
    d = u.shape[1]
    constant = gammaln(0.5 * (FREEDOM + d)) - gammaln(0.5 * FREEDOM)
    constant -= 0.5 * d * np.log(FREEDOM * np.pi)
    each = []
    for middle, factor in proposals:
        z = np.linalg.solve(factor, (u - middle).T)
        tail = 0.5 * (FREEDOM + d) * np.log1p(np.sum(z * z, axis=0) / FREEDOM)
        each.append(constant - np.sum(np.log(np.diag(factor))) - tail)
    share = np.array(counts) / np.sum(counts)
    return np.asarray(logsumexp(each, axis=0, b=share[:, None]))


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
