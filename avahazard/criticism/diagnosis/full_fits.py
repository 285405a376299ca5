"""Candidates that stand out, fitted in full, groups of events, and the second kind of avalanche.

A full fit may gain more than the screening's first order, or far less: its p-value is that of the
fit (docs/theory/criticism.md, "In full").
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType

import numpy as np
from scipy import stats
from scipy.special import comb, expit
from scipy.stats import norm, rankdata

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.laws import form_by_place
from avahazard.criticism.diagnosis.naming import MARGIN
from avahazard.criticism.diagnosis.refits import (
    Likely,
    Refit,
    effect_on,
    held_out_gain,
    likely_values,
    refit_each,
    refit_without,
    short_ascent,
)
from avahazard.criticism.scoring.where_it_fails import contrast_p, holm
from avahazard.criticism.screening.screen import (
    EXPECTED_SHARE,
    Screened,
    Screening,
    price_of_family,
)
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import RELEASE, VOLUME, level_counts, number_column
from avahazard.effects.effect import (
    MIN_LEVEL,
    Curve,
    Definition,
    Facts,
    FrictionEffect,
    LimitEffect,
    Sites,
)
from avahazard.effects.record import VOLUME_ERROR
from avahazard.engine import spread_map
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.likelihood.nodes import wrong_ranges
from avahazard.inference.likelihood.terms import event_terms
from avahazard.inference.model.layout import WRONG_SHARE
from avahazard.inference.model.observations import Observations
from avahazard.inference.seeds import generator
from avahazard.results.base import Rows
from avahazard.results.calibration import InCommon, Kinds
from avahazard.results.diagnosis import LEVEL

FITTED, OF_A_FAMILY = 7, 2
"""Candidates that are fitted in full at most, and of one family beyond the catalogue."""
ROUNDS = ((0.0, 0.7), (0.7, 0.9), (0.9, 1.0))
"""Times that candidates are chosen, by what those before them have gained: their parts of the work
in the progress that is reported."""
BY_PATH = 3
"""Of those that differ by path alone, however little they gain to first order."""
WORTH_A_FIT = float(-np.log(0.2))
"""Surprise of the screening from which on a candidate is."""
WORTH_A_STAR = 1.0
"""Gain (nats) at a rough mode from which on it is worth a star: evidence is never more than the
gain."""
ROUGHER = 5.0
"""Nats that a rough mode may lie below the mode: one whose gain, with them, is what chance does is
not worth a star either."""
FAR_BEHIND = 30.0
"""Lead (nats) of the best short ascent over a rough mode from which on this gets no star: what the
leader pays for more parameters is less."""
WORTH_BESIDE, BOTH_BY_PLACE = 0.5, 0.2
"""Share of the largest gain to first order that a candidate must have to be fitted beside it. Of
two forces by the place a law may lead whose smooth does not: it follows no narrow band."""
WORTH_INSTEAD = 0.7
"""Share of the evidence for groups that a candidate must gain to first order to be tried in their
place."""
PERSISTENT_LEVEL, TRANSIENT_LEVEL = 0.003, 0.001
"""Levels of groups of events, each tested by itself: of those that persist, as paths, of winters
and of storms, which must have evidence besides."""

GROUP_BY_CHANCE = 0.5 * float(stats.chi2.isf(0.1, 1))
"""Gain (nats) of groups that do not differ, in one of twenty datasets: in half of them it is 0."""


@dataclass(frozen=True, slots=True)
class TriedGroup:
    """An effect on groups of events, tested beside the others; gain and evidence in nats.

    `spread` is how far the groups differ; those that are `persistent`, as paths, come again. They
    are named by the key `name`.
    """

    key: str
    gain: float
    p_value: float
    persistent: bool
    evidence: float
    spread: float
    name: str


def fitted_in_full(
    base: Refit,
    screening: Screening,
    alone: Sequence[Definition],
    expected: Sequence[str] = (),
    known: Mapping[str, Refit] = MappingProxyType({}),
    hidden: Sequence[str] = (),
    progress: Callable[[float], None] = lambda _share: None,
) -> tuple[dict[str, Refit], Screening]:
    """The candidates that stand out, fitted (but those `known`), and the screening with p-values.

    Without those that gain too little to have evidence. `alone` are candidates that no screening
    can try, tested by themselves; `expected` the keys of those declared beforehand, a family of
    their own (the fallback procedure, Wiens 2003; docs/theory/criticism.md). Those `hidden` by
    nuisances are fitted however little they gain to first order.
    """
    observations = base.observations
    likely = likely_values(screening.candidates, observations)
    ascents = list(spread_map(_strong, (likely, base), screening.candidates))
    strong, reached = [c for c, _ in ascents], max((gain for _, gain in ascents), default=0.0)
    likely = dict(likely_values(strong, observations))
    data = observations.columns, observations.sites
    entries = [c.definition for c in strong]
    curves = {entry.key: entry.curve(entry.facts(*data)) for entry in entries}
    tested = sorted(strong, key=lambda c: -c.surprise)
    worth, more = _worth_a_fit(tested, curves, lambda c: c.surprise > WORTH_A_FIT)
    by_path = [c.key for c in tested if _by_path(c.definition, observations)][:BY_PATH]
    # To first order larger errors of the volumes may gain a fifth of what they do, or nothing, and
    # so may what was left out of the base model.
    left_out = [d.key for d in entries if d.changes and d.changes.without is not None]
    far = [*left_out, *({VOLUME_ERROR.key} & curves.keys())]
    by_themselves = [*expected, *(d.key for d in alone)]
    asked = [*by_themselves, *worth, *by_path, *far, *hidden]
    significant = {c.key: c.gain_at(screening.critical_surprise) for c in strong}
    # Those have levels of their own.
    rough = {k: gain - ROUGHER for k, gain in significant.items() if k not in by_themselves}
    fits = dict(known)
    for begin, end in ROUNDS:
        likely |= {key: [*values, *likely.get(key, [])] for key, values in more.items()}
        new = [key for key in dict.fromkeys(asked) if key not in fits]
        enough = {key: max(rough.get(key, 0.0), WORTH_A_STAR, reached - FAR_BEHIND) for key in new}

        def tell(share: float, begin: float = begin, end: float = end) -> None:
            progress(begin + (end - begin) * share)

        fits |= refit_each(base, new, tell, likely, enough)
        gains = {key: fit.log_likelihood - base.log_likelihood for key, fit in fits.items()}
        tested = [_fitted(c, gains[c.key]) if c.key in gains else c for c in tested]
        tested.sort(key=lambda c: -c.surprise)
        # Beside one that promised much and gained little others may stand.
        asked, more = _worth_a_fit(
            tested, curves, lambda c: screening.p_family(c.surprise) <= LEVEL
        )
        if fits.keys() >= {*asked}:
            break
    tested += [_alone(d, fits[d.key], gains[d.key]) for d in alone]
    declared = [c for c in tested if c.key in expected]
    p_values = {c.key: min(c.p_single * len(declared) / EXPECTED_SHARE, 1.0) for c in declared}
    share = 1.0 - EXPECTED_SHARE if any(p > LEVEL for p in p_values.values()) else 1.0
    for c in tested:
        level = c.definition.level_alone
        p = c.p_single * LEVEL / level if level else screening.p_family(c.surprise, share)
        p_values.setdefault(c.key, min(p, 1.0))
    # Too little for evidence is nothing, however rare it is by chance.
    p_values |= {c.key: 1.0 for c in tested if c.gain < WORTH_A_STAR}
    ranked = sorted(tested, key=lambda c: (p_values[c.key], -c.surprise))
    found = tuple(replace(c, p_family=float(p_values[c.key])) for c in ranked)
    fits = {key: fit for key, fit in fits.items() if np.isfinite(fit.evidence)}
    return fits, replace(screening, candidates=found)


def _worth_a_fit(
    candidates: Sequence[Screened],
    curves: Mapping[str, Curve | None],
    stands: Callable[[Screened], bool],
) -> tuple[list[str], Likely]:
    """Keys of candidates that are worth it, and values from which smooths among them begin.

    Of the `candidates`, the most surprising first, those that pass `stands` and gain enough beside
    the one that gains most; with a member of a smooth goes the smooth, and the other way.
    """
    most = max((c.gain for c in candidates), default=0.0)
    by_place = {key for key, curve in curves.items() if form_by_place(curve) is not None}
    place_leads = any(c.gain == most and c.key in by_place for c in candidates)
    families: Counter[str] = Counter()
    worth: list[str] = []
    for c in candidates:
        least = most * (BOTH_BY_PLACE if place_leads and c.key in by_place else WORTH_BESIDE)
        families[c.definition.family] += 1
        rare = not c.definition.beyond or families[c.definition.family] <= OF_A_FAMILY
        if rare and stands(c) and c.gain >= least and len(worth) < FITTED:
            worth.append(c.key)
    likely: dict[str, list[Floats]] = {}
    for c in candidates:
        key, shape = c.definition.member_of or ("", None)
        curve = curves.get(key)
        if curve is not None and shape is not None and {c.key, key} & {*worth}:
            worth += [c.key, key]
            values = curve.values_of(shape(c.likely, curve.x))
            likely[key] = [values, *likely.get(key, [])]
    return worth, likely


def _strong(shared: tuple[Likely, Refit], candidate: Screened) -> tuple[Screened, float]:
    """The candidate by a short ascent where it shapes the tables, and its gain, 0 without one.

    Far from neutral the tables are no longer linear in it: even the sign of its score may mislead.
    """
    likely, base = shared
    known = bool(base.observations.speeds) and not candidate.definition.beyond
    if (candidate.surprise <= WORTH_A_FIT and not known) or candidate.key not in likely:
        return candidate, 0.0
    given = likely[candidate.key], candidate.gain
    gain, values = short_ascent(base, candidate.key, *given)
    candidate = replace(candidate, likely=values)
    more = candidate.surprise_of(gain) > candidate.surprise
    return _fitted(candidate, gain) if more else candidate, gain


def _by_path(entry: Definition, observations: Observations) -> bool:
    """Whether a candidate on friction differs by path alone.

    What paths differ by takes its place to first order, until it is fitted and that goes.
    """
    effect = effect_on(entry, observations)
    if not isinstance(effect, FrictionEffect):
        return False
    design, path = effect.design(observations.columns), observations.columns.path_index
    return all(not np.any(np.ptp(design[path == k], axis=0)) for k in np.unique(path))


def _fitted(candidate: Screened, gain: float) -> Screened:
    """The candidate with what it gains once it is fitted."""
    return replace(candidate, gain=gain, surprise=candidate.surprise_of(gain))


def _alone(entry: Definition, fit: Refit, gain: float) -> Screened:
    """A candidate that has no score at neutral: what it gains by chance is known.

    Two kinds gain what `CHANCE_GAIN` says, a detection limit an exponential's nat a path
    (docs/theory/criticism.md).
    """
    observations = fit.observations
    effect = next(e for e in fit.posterior.effects if e.key == entry.key)
    shape, scale = 1.0, CHANCE_GAIN
    if isinstance(effect, LimitEffect):
        lowest = np.array([p.low for p in effect.parameters])
        limited = np.isfinite(effect.limit(observations.columns, lowest))
        limited &= np.isnan(observations.limit)
        shape, scale = len(np.unique(observations.columns.path_index[limited])) + 0.5, 1.0
    found = Screened(entry, gain, shape, scale, False, 0.0, 1.0, np.empty(0))
    return replace(found, surprise=found.surprise_of(gain))


def group_tests(base: Refit) -> tuple[TriedGroup, ...]:
    """Each of the granted groups beside the others; a spread that is 0 lies at its bound."""
    plan, found = base.posterior.plan, []
    spreads = base.posterior.layout.spread_values(base.mode.u)
    for key, lasts, spread in zip(plan.keys, plan.persistent, spreads, strict=True):
        without = refit_without(base, key)
        gain = max(base.log_likelihood - without.log_likelihood, 0.0)
        p_value = 0.5 * float(stats.chi2.sf(2.0 * gain, 1))
        evidence = base.evidence - without.evidence
        name = _name_of_groups(base, key)
        found.append(TriedGroup(key, gain, p_value, lasts, evidence, float(spread), name))
    return tuple(found)


def plainly_different(groups: Sequence[TriedGroup], granted: Sequence[str]) -> list[TriedGroup]:
    """The granted groups with enough evidence to name; the plainest first.

    By p-values alone one of several kinds of groups would be named too often.
    """
    plain = [
        test
        for test in groups
        if test.key in granted
        and test.evidence > MARGIN
        and test.p_value <= (PERSISTENT_LEVEL if test.persistent else TRANSIENT_LEVEL)
    ]
    return sorted(plain, key=lambda test: -test.gain)


def _name_of_groups(base: Refit, key: str) -> str:
    """The key by which granted groups are named: of few paths it is the one that differs most."""
    data = base.observations.columns, base.observations.sites
    if base.definition(key).lacking(*data) is None:
        return key
    plan, offsets = base.posterior.plan, base.posterior.mode_offsets(base.mode.u)
    assert offsets is not None
    own = np.flatnonzero(plan.of == plan.keys.index(key))
    most = int(own[np.argmax(np.abs(offsets[own]))])
    return plan.told[most]


def explained_otherwise(
    without: Refit, screening: Screening, group: TriedGroup
) -> dict[str, Refit]:
    """Candidates fitted in place of groups that differ, if one has their evidence less `MARGIN`.

    `without` is the model without the groups, which may take up what a cause would gain, and
    `screening` that of all candidates on it. None where no candidate has that evidence, or it does
    not gain on held-out records.
    """
    enough = WORTH_INSTEAD * group.evidence
    worth = [c for c in screening.candidates if c.p_family <= LEVEL and c.gain > enough]
    worth = sorted(worth, key=lambda c: -c.gain)[:OF_A_FAMILY]
    likely = likely_values(worth, without.observations)
    least = max(group.evidence - MARGIN, WORTH_A_STAR)
    keys = [c.key for c in worth]
    fits = refit_each(without, keys, likely=likely, least=dict.fromkeys(keys, least))
    found = any(
        evidence_gain(c, fits, without, screening) > group.evidence - MARGIN
        and held_out_gain(fits[c.key], without) > 0.0
        for c in worth
    )
    return fits if found else {}


def evidence_gain(
    candidate: Screened,
    fits: Mapping[str, Refit],
    base: Refit,
    screening: Screening,
    expected: Sequence[str] = (),
) -> float:
    """Evidence (nats) that a candidate adds.

    Never more than it gains in likelihood. One of many of a kind, or of many dates, is as likely
    beforehand as they are together, unless it was `expected`; an estimated detection limit and two
    kinds of avalanche have prices of their own (docs/theory/criticism.md).
    """
    entry = candidate.definition
    tried = [c.definition for c in screening.candidates]
    price = 0.0 if entry.key in expected else price_of_family(entry, tried)
    fit = fits[candidate.key]
    if entry.alternatives is not None:
        price += np.log(ways_to_choose(fit, entry, entry.alternatives))
    gain = fit.log_likelihood - base.log_likelihood
    if fit.posterior.layout.kinds is not None and base.posterior.layout.kinds is None:
        price += gain_of_wrong_records(base)
    if candidate.definition.says_what_is_seen:
        gain -= candidate.shape
    return float(min(fit.evidence - base.evidence, gain) - price)


def ways_to_choose(
    fit: Refit, entry: Definition, alternatives: Callable[[EventColumns, Sites], Sequence[Facts]]
) -> float:
    """In how many ways the data could choose where an effect acts: dates, regions, stretches.

    Those that are stated alike: an effect of stretches may be a smooth one in their place. Of
    one way with all parts of the paths some are chosen.
    """
    fitted = fit.facts[entry.key]
    ways = alternatives(fit.observations.columns, fit.observations.sites)
    alike = [entry.build(way) for way in ways if way.keys() == fitted.keys()]
    parts, chosen = (len(effect.parameters) for effect in (alike[0], entry.build(fitted)))
    return float(len(alike) * comb(parts, chosen))


CHANCE_GAIN = 1.0
"""Mean of the exponential distribution that the gain (nats) of two kinds has where there is one, at
most: in 3 of 4 simulated datasets it is 0."""
ALWAYS = (VOLUME, "year", "day_of_winter", RELEASE, "deposit_length_m")
IN_COMMON_LEVEL, N_DRAWS = 0.05, 50
WRONG_SHARES, NARROWER = np.arange(1, 21) / 100.0, (1.0, 0.8, 0.65, 0.5, 0.4)
SHIFTS = (-0.5, -0.25, 0.0, 0.25, 0.5)
"""Shares of wrong records that are tried, with scatters of the others against that of all, and
shifts of these in scatters."""


def kinds_of(model: FittedModel) -> Kinds | None:
    """The second kind of avalanche of a model: its events, and the columns that go with it.

    By rank correlation, paths apart, at 5 in 100 for all columns together (Holm). None where all
    avalanches are of one kind.
    """
    kinds, columns = model.friction.kinds(np.median(model.draws, axis=0)), model.columns
    if kinds is None:
        return None
    chosen = model.thinned(min(N_DRAWS, len(model.draws)))
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
    found = [replace(row, p_value=p) for row, p in pairs if p < IN_COMMON_LEVEL]
    return Kinds(
        share=float(kinds.share[1]),
        shift=float(kinds.shift[1] - kinds.shift[0]),
        probability=dict(zip(columns.event_id, probability.tolist(), strict=True)),
        in_common=Rows(sorted(found, key=lambda row: row.p_value)),
    )


def second_kind(model: FittedModel, draw: int, offsets: Floats | None) -> Floats:
    """Probability `[n_events]` of the second kind, of lower friction, by a draw and its offsets."""
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

    Where a model lets records be wrong they lie anywhere on the path's line, far beyond all stops.
    """
    posterior, u = base.posterior, base.mode.u
    observations, columns = posterior.observations, posterior.observations.columns
    offsets = posterior.mode_offsets(u)
    location, scatter, weight = posterior.friction_at(u, offsets)
    nodes, student = posterior.nodes.at(u), posterior.friction.student
    nodes = nodes._replace(log_wrong=np.full_like(nodes.log_wrong, -np.inf))
    low, high = wrong_ranges(observations)
    among = high - low
    among[[track.event for track in observations.speeds]] = np.nan  # wrong with all its speeds
    for path, kind in np.unique([columns.path_index, observations.kind], axis=1).T:
        selected = (columns.path_index == path) & (observations.kind == kind)
        stops = observations.observed[selected]
        if (n := len(stops)) > MIN_LEVEL:
            among[selected] = np.minimum(among[selected], np.ptp(stops) * (n + 1) / (n - 1))
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
