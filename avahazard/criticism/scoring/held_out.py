"""Held-out events: the model is fitted to the others and gives the likelihood of these.

Every fit is a true one: the posterior mode without the held-out events, and draws of its posterior.
These are weighted by the posterior density (importance sampling), so that its bounds are kept and,
where draws of the whole posterior are known nearby, its second derivatives.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.special import logsumexp
from scipy.stats import multivariate_t

from avahazard.arrays import Bools, Floats, Ints
from avahazard.criticism.scoring.scores import ExpectedRecords, crps, error_sign, expected_records
from avahazard.criticism.scoring.speed_misfit import MatchedSpeeds, matched_speeds, track_places
from avahazard.effects.effect import Effect, GroupEffect, of_kind
from avahazard.engine import spread_map
from avahazard.inference.fitted_model import FittedModel, fitted_model
from avahazard.inference.fitting.mode import Mode, find_mode, units
from avahazard.inference.likelihood.offsets import Offsets
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import Observations
from avahazard.inference.seeds import generator
from avahazard.results.base import Rows
from avahazard.results.comparison import GroupError

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
    """Draws of a fit `[n_draws, n_slots]`, logs of weights that sum to 1, offsets of any groups."""

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
        if not np.isfinite(slope):
            continue  # nothing is known inside
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
    values, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    shape = (vectors * (np.maximum(values, 0.0) + NARROWEST**2)) @ vectors.T
    return _Student(multivariate_t(centre / unit, shape, FREEDOM), unit)


def resampled(draws: FitDraws, n: int) -> FitDraws:
    """`n` draws of equal weight, each as often as it counts (systematic resampling)."""
    level = np.cumsum(np.exp(draws.log_weight))
    chosen = np.searchsorted(level, (np.arange(n) + 0.5) / n * level[-1])
    offsets = None if draws.offsets is None else draws.offsets[chosen]
    return FitDraws(draws.coordinates[chosen], np.full(n, -np.log(n)), offsets)


MIN_PATHS = 3
MAX_FITS = 24
"""Paths are left out one by one up to this many, then in this many parts."""
N_FOLDS = 5
DENSITY_DRAWS = 240
RECORD_DRAWS = 300


class HeldOut(NamedTuple):
    """A group for each event `[n_events]`, by path or fold, and the fit without it `[n_events]`."""

    by: Literal["path", "fold"]
    groups: Ints
    fits: Ints


class HeldOutPredictions(NamedTuple):
    """Each event by the fit to the other groups: log densities `[n_events]`, records, speeds."""

    log_density: Floats
    records: ExpectedRecords
    speeds: MatchedSpeeds | None


def choose_groups(observations: Observations, effects: Sequence[Effect] = ()) -> HeldOut:
    """Whole paths where there are three or more, else five folds of events drawn at random.

    Folds as well where some of the `effects` act on single paths: what happens at a place of one
    path, or its offset, cannot be predicted by others. Where some are of winters or storms, which
    do not come again but are common to paths, folds of whole winters, if there are so many.
    Of more than `MAX_FITS` paths several are left out together, in parts of like many events: each
    path is still predicted by a fit without any of its events, and with nearly all others.
    """
    columns = observations.columns
    path, winter = columns.path_index, np.unique(columns.winter, return_inverse=True)[1]
    grouped = [e.groups(columns) for e in of_kind(effects, GroupEffect)]
    if any(groups.alone for groups in grouped) and winter.max() >= N_FOLDS:
        folds = gathered(winter, N_FOLDS)
        return HeldOut("fold", folds, folds)
    on_single_paths = any(e.paths for e in effects) or not all(groups.alone for groups in grouped)
    if len(np.unique(path[path >= 0])) >= MIN_PATHS and not on_single_paths:
        return HeldOut("path", path, gathered(path))
    order = generator(0, "folds").permutation(observations.n_events)
    groups = np.empty(observations.n_events, dtype=np.int64)
    groups[order] = np.arange(observations.n_events) % min(N_FOLDS, observations.n_events)
    return HeldOut("fold", groups, groups)


def gathered(groups: Ints, n_parts: int = MAX_FITS) -> Ints:
    """Part `[n_events]` of each event: whole `groups`, in `n_parts` of like many events.

    Groups come in random order, the largest first, each to the part that has fewest events. No
    more groups than parts stay as they are.
    """
    names, of, count = np.unique(groups, return_inverse=True, return_counts=True)
    if len(names) <= n_parts:
        return groups
    mixed = generator(0, "parts").permutation(len(names))
    part = np.empty(len(names), dtype=np.int64)
    size = np.zeros(n_parts, dtype=np.int64)
    for k in mixed[np.argsort(-count[mixed], kind="stable")]:
        part[k] = np.argmin(size)
        size[part[k]] += count[k]
    return np.asarray(part[of])


def left_out_log_density(
    posterior: Posterior, out: Bools, start: Mode, around: Floats | None = None
) -> Floats:
    """Log density of the records `out` given the events that are not, `[n_events]` (others 0).

    `start` is the mode given all events, `around` draws of the posterior given all (see
    `fit_draws`). The mean over draws of the density given the parameters and the offsets of groups;
    a group all of whose events are out has an offset from the spread between groups.
    """
    rest = posterior.restricted(~out)
    draws = fit_draws(rest, start, DENSITY_DRAWS, key_of(out), around)
    return mean_log_density(rest, draws, out)


def mean_log_density(posterior: Posterior, draws: FitDraws, out: Bools) -> Floats:
    """Log of the weighted mean over draws of the density of each record in `out`, `[n_events]`."""
    given = [
        posterior.event_log_likelihood(u, None if draws.offsets is None else draws.offsets[k], out)
        for k, u in enumerate(draws.coordinates)
    ]
    return np.asarray(logsumexp(np.array(given) + draws.log_weight[:, None], axis=0))


def held_out_predictions(
    model: FittedModel, groups: Ints, progress: Callable[[float], None] = lambda _share: None
) -> HeldOutPredictions:
    """What the fits without each group say of it; their draws are near those of the model."""
    posterior, around = model.posterior, model.draws
    start = find_mode(posterior, np.median(around, axis=0))
    observations = posterior.observations
    names, found = np.unique(groups), list[HeldOutPredictions]()
    # The fits share the tables of one posterior, which fill up as they go.
    fits = spread_map(_predict_left_out, (posterior, around, start, groups), names, threads=False)
    for one in fits:
        found.append(one)
        progress(len(found) / len(names))

    def merged(parts: Iterable[Floats], of: Ints) -> Floats:
        """One after the other, in the order of the groups `of` whose parts they are."""
        return np.asarray(np.concatenate([*parts])[np.argsort(np.argsort(of, kind="stable"))])

    log_density = merged((one.log_density for one in found), groups)
    each = zip(*(one.records for one in found), strict=True)
    records = ExpectedRecords._make(merged(parts, groups) for parts in each)
    # In a part the sign may be another: there elevations may stand alone.
    records = records._replace(sign=error_sign(observations))
    speeds = None
    if observations.speeds:
        speeds = track_places(observations)
        draws = merged((one.speeds.draws for one in found if one.speeds), groups[speeds.event])
        speeds = speeds._replace(draws=draws)
    return HeldOutPredictions(log_density, records, speeds)


def _predict_left_out(
    shared: tuple[Posterior, Floats, Mode, Ints], group: int
) -> HeldOutPredictions:
    """What the fit without a group says of the group."""
    posterior, around, start, groups = shared
    out = groups == group
    rest = posterior.restricted(~out)
    fit = resampled(fit_draws(rest, start, RECORD_DRAWS, key_of(out), around), RECORD_DRAWS)
    rng = generator(0, "held out records", key_of(out))
    part, offsets = posterior.of_part(np.flatnonzero(out)), offsets_by_group(rest, fit.offsets)
    fitted = fitted_model(part, fit.coordinates, offsets)
    records = expected_records(fitted, RECORD_DRAWS, rng)
    log_density = mean_log_density(rest, fit, out)[out]
    return HeldOutPredictions(log_density, records, matched_speeds(fitted, rng))


def offsets_by_group(posterior: Posterior, offsets: Floats | None) -> dict[str, Floats]:
    """Draws of the offsets `[n_draws]` by group."""
    if offsets is None:
        return {}
    return {name: offsets[:, k] for k, name in enumerate(posterior.plan.names)}


def key_of(out: Bools) -> str:
    """A text for the held-out events, to key random numbers by."""
    return np.packbits(out).tobytes().hex()


def held_out_together(posterior: Posterior, groups: Ints, start: Mode) -> Floats:
    """Log density of all records of each group at once, given those of the others, `[n_groups]`.

    `groups` `[n_events]` says which events are left out together; `start` is the mode given all
    events. Records of one path share its offset: judged one by one, a path that lies off would
    count as often as it has records, and the narrower model, which is the better one within paths,
    would lose for it.
    """
    found = []
    for group in np.unique(groups):
        out = groups == group
        rest = posterior.restricted(~out)
        draws = fit_draws(rest, start, DENSITY_DRAWS, key_of(out))
        given = _together_given(posterior, rest, out, draws.coordinates)
        found.append(float(logsumexp(given + draws.log_weight)))
    return np.array(found)


def _together_given(posterior: Posterior, rest: Posterior, out: Bools, u: Floats) -> Floats:
    """Log density `[n]` of the records `out` given u `[n, n_slots]`, offsets integrated out.

    And given the other records, where these share an offset.
    """
    index = posterior.plan.index
    if np.any(np.intersect1d(index[:, out], index[:, ~out]) >= 0):
        return posterior.log_densities(u) - rest.log_densities(u)
    selected = posterior.restricted(out).log_densities(u)
    return np.asarray(selected - posterior.layout.log_prior(u))


def group_errors(
    held: HeldOut, others: HeldOutPredictions, observations: Observations
) -> Rows[GroupError]:
    """Mean CRPS (m) of each held-out path or fold."""
    error = crps(others.records.draws, others.records.observed)
    rows = []
    for group in np.unique(held.groups):
        selected = held.groups == group
        named = held.by == "path" and group >= 0
        name = observations.columns.paths[group] if named else str(int(group))
        rows.append(GroupError(name, int(np.sum(selected)), float(np.mean(error[selected]))))
    return Rows(rows)
