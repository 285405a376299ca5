"""Events held out: the model is fitted to the others and says how likely these were.

Every fit is a true one: the posterior mode without the events held out, and draws about it that
are weighted by the posterior density, so that its bounds and bends are kept. They come from
Student distributions, the first with the curvature at the mode, each further one with the
moments of what was found so far (adaptive importance sampling; Cornuet et al. 2012).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import multivariate_t

from avahazard.criticism.expected import ExpectedRecords, expected_records
from avahazard.criticism.speed_misfit import MatchedSpeeds, matched_speeds
from avahazard.inference.mode import Mode, find_mode
from avahazard.inference.posterior import Posterior
from avahazard.inference.seeds import generator
from avahazard.inference.study import Study

Floats = NDArray[np.float64]
Groups = NDArray[np.int64]

MIN_PATHS = 3
N_FOLDS = 5
DENSITY_DRAWS = 60
RECORD_DRAWS = 300
STAGES = 4
FREEDOM = 5.0
FIRST_WIDTH = 1.5
"""The first draws are that much wider than the curvature at the mode promises."""
EDGE = 2e-3
"""A mode that close to a bound, in coordinates of order one, lies on it."""


class HeldOut(NamedTuple):
    """What is held out together: a group for each event `[n_events]`, made by path or fold."""

    by: Literal["path", "fold"]
    groups: Groups


class FitDraws(NamedTuple):
    """Draws of a fit: coordinates `[n_draws, n_slots]`, their log weights `[n_draws]` (which sum
    to 1) and, with a path effect, path offsets `[n_draws, n_groups]`."""

    coordinates: Floats
    log_weight: Floats
    offsets: Floats | None


class HeldOutPredictions(NamedTuple):
    """For each event, by the fit to the other groups: the log density of its record `[n_events]`,
    the records to be expected, and the speeds along measured tracks (None without)."""

    log_density: Floats
    records: ExpectedRecords
    speeds: MatchedSpeeds | None


def choose_groups(study: Study) -> HeldOut:
    """Whole paths where there are three or more, else five folds of events drawn at random."""
    path = study.columns.path_index
    if len(np.unique(path[path >= 0])) >= MIN_PATHS:
        return HeldOut("path", path)
    order = generator(0, "folds").permutation(study.n_events)
    groups = np.empty(study.n_events, dtype=np.int64)
    groups[order] = np.arange(study.n_events) % min(N_FOLDS, study.n_events)
    return HeldOut("fold", groups)


def held_out_log_density(posterior: Posterior, groups: Groups, start: Floats) -> Floats:
    """Log density of each record given the events of all other groups, `[n_events]`.

    `groups` `[n_events]` says which events are held out together; each fit starts from the
    coordinates `start` `[n_slots]`.
    """
    result = np.empty(len(groups))
    for group in np.unique(groups):
        out = groups == group
        result[out] = left_out_log_density(posterior, out, start)[out]
    return result


def left_out_log_density(posterior: Posterior, out: NDArray[np.bool_], start: Floats) -> Floats:
    """Log density of every record `[n_events]` given the events that are not `out`.

    The mean over draws of the density given the parameters and the path offsets; a path all of
    whose events are out has an offset from the spread between paths.
    """
    rest = posterior.restricted(~out)
    draws = fit_draws(rest, start, DENSITY_DRAWS, _key(out))
    return mean_log_density(rest, draws)


def mean_log_density(posterior: Posterior, draws: FitDraws) -> Floats:
    """Log of the weighted mean over draws of the density of each record, `[n_events]`."""
    given = [
        posterior.event_log_likelihood(u, None if draws.offsets is None else draws.offsets[k])
        for k, u in enumerate(draws.coordinates)
    ]
    return np.asarray(logsumexp(np.array(given) + draws.log_weight[:, None], axis=0))


def held_out_predictions(
    posterior: Posterior,
    groups: Groups,
    start: Floats,
    progress: Callable[[float], None] = lambda _share: None,
) -> HeldOutPredictions:
    """What the fits without each group say of it: one fit a group, from the coordinates `start`."""
    n = len(groups)
    log_density = np.empty(n)
    draws, x = (np.empty((n, RECORD_DRAWS)) for _ in range(2))
    left = np.empty((n, RECORD_DRAWS), dtype=np.bool_)
    speeds = None
    names = np.unique(groups)
    for done, group in enumerate(names):
        out = groups == group
        rest = posterior.restricted(~out)
        fit = _evenly_weighted(fit_draws(rest, start, RECORD_DRAWS // STAGES, _key(out)))
        rng = generator(0, "held out records", _key(out))
        by_path = offsets_by_path(rest, fit.offsets)
        found = expected_records(rest, fit.coordinates, by_path, RECORD_DRAWS, rng)
        draws[out], left[out], x[out] = found.draws[out], found.left[out], found.x[out]
        log_density[out] = mean_log_density(rest, fit)[out]
        tracks = matched_speeds(rest, fit.coordinates, fit.offsets, rng)
        if tracks is not None:
            speeds = tracks if speeds is None else speeds
            mine = out[speeds.event]
            speeds.draws[mine] = tracks.draws[mine]
        progress((done + 1) / len(names))
    records = ExpectedRecords(found.observed, found.sigma, draws, left, x, found.sign)
    return HeldOutPredictions(log_density, records, speeds)


def fit_draws(posterior: Posterior, start: Floats, n_draws: int, key: str) -> FitDraws:
    """Fit the posterior from `start` and draw about its mode, `STAGES` times `n_draws` at most.

    Equal keys give equal draws, and the same random numbers for every model of one size.
    """
    mode = find_mode(posterior, start)
    covariance = FIRST_WIDTH**2 * _bounded_covariance(posterior, mode)
    proposals = [multivariate_t(mode.u, covariance, FREEDOM, seed=0)]
    u = np.empty((0, len(mode.u)))
    log_density = np.empty(0)
    for stage in range(STAGES):
        rng = generator(0, "fit draws", key, stage)
        drawn = np.atleast_2d(proposals[-1].rvs(n_draws, random_state=rng)).reshape(n_draws, -1)
        values = np.array([posterior.log_density(v) for v in drawn])
        inside = np.isfinite(values)
        u = np.concatenate([u, drawn[inside]])
        log_density = np.concatenate([log_density, values[inside]])
        if len(u) == 0:
            u, log_density = mode.u[None, :], np.array([mode.log_density])
        log_q = np.column_stack([np.atleast_1d(q.logpdf(u)) for q in proposals])
        log_weight = _cut(log_density - logsumexp(log_q, axis=1))
        weight = np.exp(log_weight)
        centre = weight @ u
        moved = (u - centre) * np.sqrt(weight)[:, None]
        # Few draws say little about a covariance: the one before has its share.
        share = 1.0 / (1.0 + 2.0 * len(mode.u) * np.sum(weight**2))
        covariance = share * moved.T @ moved + (1.0 - share) * covariance
        proposals.append(multivariate_t(centre, covariance, FREEDOM, seed=0))
    offsets = None
    if posterior.groups is not None:
        rng = generator(0, "offset draws", key)
        found = [posterior.path_offsets(v) for v in u]
        offsets = np.array([o.mode + o.sd * rng.standard_normal(len(o.mode)) for o in found])
    return FitDraws(u, log_weight, offsets)


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


def _evenly_weighted(draws: FitDraws) -> FitDraws:
    """Draws by their weights, each as often as it counts (systematic resampling)."""
    n = RECORD_DRAWS
    level = np.cumsum(np.exp(draws.log_weight))
    chosen = np.searchsorted(level, (np.arange(n) + 0.5) / n * level[-1])
    return FitDraws(
        draws.coordinates[chosen],
        np.full(n, -np.log(n)),
        None if draws.offsets is None else draws.offsets[chosen],
    )


def offsets_by_path(posterior: Posterior, offsets: Floats | None) -> dict[str, Floats]:
    """Draws of path offsets `[n_draws]` by path."""
    if offsets is None:
        return {}
    paths = posterior.study.columns.paths
    return {paths[k]: offsets[:, k] for k in range(offsets.shape[1])}


def _key(out: NDArray[np.bool_]) -> str:
    """A text for the events held out, to key random numbers by."""
    return np.packbits(out).tobytes().hex()
