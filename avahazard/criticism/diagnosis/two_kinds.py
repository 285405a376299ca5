"""Which events are of a second kind that nobody recorded, and what these have in common."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from scipy.special import expit
from scipy.stats import norm, rankdata

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.scoring.where_it_fails import contrast_p, holm
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import VOLUME, number_column
from avahazard.effects.effect import MIN_LEVEL
from avahazard.effects.levels import level_counts
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.likelihood.nodes import wrong_ranges
from avahazard.inference.likelihood.terms import event_terms
from avahazard.inference.model.layout import WRONG_SHARE
from avahazard.inference.seeds import generator
from avahazard.results.base import Rows
from avahazard.results.calibration import InCommon, Kinds

CHANCE_GAIN = 1.0
"""Mean of the exponential distribution that the gain (nats) of two kinds has where there is one, at
most: in 3 of 4 simulated datasets it is 0."""
ALWAYS = (VOLUME, "year", "day_of_winter", "release_elevation_m", "deposit_length_m")
LEVEL, N_DRAWS = 0.05, 50
WRONG_SHARES, NARROWER = np.arange(1, 21) / 100.0, (1.0, 0.8, 0.65, 0.5, 0.4)
SHIFTS = (-0.5, -0.25, 0.0, 0.25, 0.5)
"""Shares of wrong records that are tried, with scatters of the others against that of all, and
shifts of these in scatters."""


def kinds_of(model: FittedModel) -> Kinds | None:
    """The second kind of avalanche of a model: its events, and the columns that go with it.

    A column goes with it by rank correlation, paths apart, at 5 in 100 for all columns together
    (Holm). None where all avalanches are of one kind.
    """
    kinds, columns = model.friction.kinds(np.median(model.draws, axis=0)), model.columns
    if kinds is None:
        return None
    chosen = model.evenly(min(N_DRAWS, len(model.draws)))
    offsets = model.group_offsets(generator(0, "kinds"))
    each = [second_kind(model, k, None if offsets is None else offsets[k]) for k in chosen]
    probability = np.mean(each, axis=0)
    z = _scores(probability)
    _, path = np.unique(columns.path_index, return_inverse=True)
    rows: list[InCommon] = []
    for name, level, values in _contrasts(columns):
        known = np.isfinite(values)
        x, y = _scores(values[known]), z[known]
        p = contrast_p(y, x, np.unique(path[known], return_inverse=True)[1])
        if p is not None:
            rows.append(InCommon(name, level, float(np.corrcoef(x, y)[0, 1]), p))
    corrected = holm([row.p_value for row in rows])
    pairs = zip(rows, corrected, strict=True)
    found = [replace(row, p_value=p) for row, p in pairs if p < LEVEL]
    return Kinds(
        share=float(kinds.share[1]),
        shift=float(kinds.shift[1] - kinds.shift[0]),
        probability=dict(zip(columns.event_id, probability.tolist(), strict=True)),
        in_common=Rows(sorted(found, key=lambda row: row.p_value)),
    )


def second_kind(model: FittedModel, draw: int, offsets: Floats | None) -> Floats:
    """Probability `[n_events]` to be of the second kind, whose friction is lower, of one draw.

    `offsets` `[n_offsets]` are those of its groups.
    """
    posterior, u = model.posterior, model.draws[draw]
    location, scatter, weight = posterior.friction_at(u, offsets)
    nodes = posterior.nodes_at(u)
    # Seen or not, and right or wrong, the record is the same for either kind.
    nodes = nodes._replace(
        has_limit=np.zeros_like(nodes.has_limit), log_wrong=np.full_like(nodes.log_wrong, -np.inf)
    )
    student = posterior.friction.student
    of_second = np.arange(weight.shape[1]) >= weight.shape[1] // 2
    first, second = (
        event_terms(nodes, location, scatter, weight * kind, student, slopes=False).value
        for kind in (~of_second, of_second)
    )
    return np.asarray(expit(second - first))


def gain_of_wrong_records(base: Refit) -> float:
    """What the model gains (nats) if some records lie anywhere among the stops of their path.

    It has one kind; their share is free. Where it lets records be wrong they lie anywhere on the
    path's line, which may reach far beyond all stops, so that a few of them look like a kind.
    """
    posterior, u = base.posterior, base.mode.u
    observations, columns = posterior.observations, posterior.observations.columns
    offsets = posterior.mode_offsets(u)
    location, scatter, weight = posterior.friction_at(u, offsets)
    nodes, student = posterior.nodes.at(u), posterior.friction.student
    nodes = nodes._replace(log_wrong=np.full_like(nodes.log_wrong, -np.inf))
    low, high = wrong_ranges(observations)
    among = high - low
    for path, kind in np.unique([columns.path_index, observations.kind], axis=1).T:
        mine = (columns.path_index == path) & (observations.kind == kind)
        stops = observations.observed[mine]
        if (n := len(stops)) > MIN_LEVEL:
            among[mine] = np.minimum(among[mine], np.ptp(stops) * (n + 1) / (n - 1))
    may_be = np.isfinite(among)
    share = WRONG_SHARES[:, None]
    prior = -0.5 * np.log(share[:, 0] / WRONG_SHARE) ** 2
    best = posterior.event_log_likelihood(u, offsets)[may_be].sum()
    known = best
    for narrower, shift in product(NARROWER, SHIFTS):
        # Without wrong records friction scatters less, and about another middle.
        at = posterior.friction.shifted(location, shift * scatter), narrower * scatter
        right = event_terms(nodes, *at, weight, student, slopes=False).value[may_be]
        wrong = np.log(share) - np.log(among[may_be])
        mixed = np.logaddexp(np.log1p(-share) + right, wrong).sum(axis=1)
        best = max(best, np.max(mixed + prior))
    return float(best - known)


def _scores(values: Floats) -> Floats:
    """Normal scores of ranks `[n]`, equal values at the middle of theirs, of unit variance."""
    scores = norm.ppf((rankdata(values) - 0.5) / len(values))
    return np.asarray((scores - np.mean(scores)) / max(float(np.std(scores)), 1e-12))


def _contrasts(columns: EventColumns) -> list[tuple[str, str | None, Floats]]:
    """Columns of numbers, and levels of columns of texts as 0 and 1, `[n_events]`; nan: unknown."""
    found: list[tuple[str, str | None, Floats]] = []
    for name in dict.fromkeys([*ALWAYS, *columns.numbers, *columns.made]):
        values = number_column(columns, name)
        if values is not None and np.sum(np.isfinite(values)) > 2 * MIN_LEVEL:
            found.append((name, None, values))
    for name, texts in columns.texts.items():
        enough = [level for level, n in level_counts(texts).items() if n >= MIN_LEVEL]
        for level in enough if len(enough) > 2 else enough[1:]:
            of_level = np.where(texts == "", np.nan, (texts == level).astype(float))
            found.append((name, level, of_level))
    return [item for item in found if np.nanmin(item[2]) < np.nanmax(item[2])]
