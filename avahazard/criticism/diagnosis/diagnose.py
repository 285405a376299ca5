"""Which physical effect is missing, if any: nuisances, screening, full refits, naming, verdict."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from scipy import stats

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis import full_fits, measurements, nuisances, record_faults
from avahazard.criticism.diagnosis.force_witness import force_witness
from avahazard.criticism.diagnosis.full_fits import TriedGroup
from avahazard.criticism.diagnosis.laws import Laws, curve_of, found_laws, found_shape, with_laws
from avahazard.criticism.diagnosis.naming import (
    MARGIN,
    Naming,
    evidence_beside_places,
    group_comes_first,
    name_effects,
    verdict_of,
    was_added_to,
    worst_speeds,
)
from avahazard.criticism.diagnosis.refits import (
    Question,
    Refit,
    held_out_gain,
    refit_each,
    refit_with,
    refit_without,
    still_needed,
)
from avahazard.criticism.scoring.scores import crps, expected_records
from avahazard.criticism.screening.screen import (
    PAIR_LEVEL,
    Screened,
    candidate_definitions,
    not_asked,
    screen,
)
from avahazard.effects.effect import Definition, Facts
from avahazard.effects.pairs import columns_of_pair
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.results.base import Rows
from avahazard.results.diagnosis import (
    FIELD_DAYS,
    LEVEL,
    Candidate,
    Diagnosis,
    GroupTest,
    MeasuredAmount,
    Measurement,
    Pair,
)
from avahazard.workers import ordered_map

ERROR_DRAWS = 400
ALIKE = 0.7
"""Correlation above which two effects are called confounded."""
MOST_HIDDEN = 3
"""Candidates that stand out without nuisances which the records ask for, and are fitted beside
them: heavy tails, or winters, may be what an effect leaves."""
EXPLANATIONS = 3
"""Of which each pair is to be distinguished."""


@dataclass(frozen=True, slots=True, eq=False)
class Findings(Question):
    """The diagnosis with all that it rests on; the fits are in the order of its candidates.

    `laws` are those that the leading smooth of what is missing may be.
    """

    result: Diagnosis
    laws: Laws


def diagnose(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    own: Sequence[Definition] = (),
    *,
    expected: Sequence[str] = (),
    field_days: Mapping[str, float] = FIELD_DAYS,
    seed: int = 0,
    calibrated: Floats | None = None,
    progress: Callable[[float], None] = lambda _share: None,
) -> Findings:
    """Ask which effect a model lacks on observations.

    Paths may differ for reasons unknown in every fit, winters and storms where the records ask for
    it, events beyond the profile and detection limits are in the likelihood, and where friction
    scatters with heavy tails it is let to, before anything is blamed on physics.

    Candidates `expected` were declared beforehand, and are tested first; `field_days` are those of
    a measurement (`FIELD_DAYS`). The model has no name; it has been calibrated to parameters about
    `calibrated` `[n_slots]`, if at all.
    """
    plain = nuisances.with_tails_granted(observations, specification, facts, own, calibrated)
    base, granted, too_many = nuisances.with_nuisances_granted(plain)
    entries = candidate_definitions(observations, plain.specification, own)
    alone = [entry for entry in entries if entry.level_alone is not None]
    groups = full_fits.group_tests(base)
    progress(0.2)
    screened = screen(base.posterior, base.mode.u, entries, seed=seed)
    left, known = None, dict[str, Refit]()
    if plain_groups := full_fits.plainly_different(groups, granted):
        without = refit_without(base, plain_groups[0].key)
        by_others = screen(without.posterior, without.mode.u, entries, seed=seed)
        known = full_fits.explained_otherwise(without, by_others, plain_groups[0])
        if known:
            left, base, screened = plain_groups[0], without, by_others
            granted = tuple(key for key in granted if key != left.key)
            groups = (*full_fits.group_tests(base), left)
    hidden = hidden_by_nuisances(base, specification, entries, seed)
    fits, screening = full_fits.fitted_in_full(
        base, screened, alone, expected, known, hidden, lambda share: progress(0.3 + 0.45 * share)
    )
    survivors = [c for c in screening.candidates if c.key in fits and c.p_family <= LEVEL]
    evidence = {
        c.key: full_fits.evidence_gain(c, fits, base, screening, expected) for c in survivors
    }
    evidence = beside_places(evidence, fits)
    evidence, laws = with_laws(base, fits, evidence)
    evidence = beside_places(evidence, fits, laws)
    ranked = sorted(survivors, key=lambda c: -evidence[c.key])
    fits = {c.key: fits[c.key] for c in ranked}
    firsts = {key: of_key[0] for key, of_key in laws.items() if of_key}
    of_laws = {k: first.fit for k, first in firsts.items() if first.law.evidence_over_curve > 0.0}
    question = Question(base, fits, screening)
    naming = name_effects(question, ranked, evidence, expected, of_laws)
    progress(0.8)
    naming, speeds_off = unless_speeds_are_off(question, naming)
    progress(0.85)
    verdict, missing, together = verdict_on(question, naming, groups, granted)
    if left and (keys := beside_group(left, missing, evidence)):
        verdict, missing = verdict_of(map(base.definition, keys))
    # What a fault of the records names has evidence of its own as well, which ranks it; `question`
    # has the same fits.
    fits |= fits_of_faults(question, missing)
    evidence |= {key: fits[key].evidence - base.evidence for key in fits if key not in evidence}
    of_smooth: Laws = ()
    if smooth := leading_smooth(missing, fits):
        of_smooth = laws.get(smooth) or found_laws(base, {smooth: fits[smooth]})[smooth]
    of_groups = [named_as_candidate(base, group) for group in groups if group.name in missing]
    laws = {**laws, smooth: of_smooth} if smooth else laws
    tried = [*of_groups, *candidates(question, ranked, evidence, naming, laws, of_laws)]
    tried.sort(key=lambda c: (*missing, c.effect).index(c.effect))
    fitted_laws = Rows(found.law for found in of_smooth)
    leading = {
        key: fits[key]
        for key in (*missing, *fits)
        if key in fits and (key in missing or evidence[key] > 0.0)
    }
    missed = measurements.detectable(base, screening.critical_gain)
    result = Diagnosis(
        model="",
        verdict=verdict,
        missing=missing,
        candidates=Rows(
            replace(c, laws=fitted_laws) if c.effect in missing[:1] else c for c in tried
        ),
        groups=Rows(GroupTest(g.key, g.gain, g.p_value, g.spread) for g in groups),
        pairs=Rows([together] if together else []),
        detectable_m=missed.metres,
        detectable_log_friction=missed.log_friction,
        detectable_share=missed.share,
        still_needed=still_needed(plain),
        heavy_tails=plain.specification.tails != specification.tails,
        suspect_events=record_faults.suspects(base),
        impossible_stops=record_faults.impossible_stops(base),
        measure_next=_measure_next(
            Question(base, leading, screening), missed.metres, field_days, seed
        ),
        notes=(
            *speeds_off,
            *_unsure(base, evidence, missing),
            *record_faults.on_one_path(base),
            *(Note("not_granted", effect=key, most=nuisances.MOST_CROSSED) for key in too_many),
            *(
                Note("not_asked", effect=key, lack=lack)
                for key, lack in not_asked(observations, plain.specification, own).items()
            ),
        ),
        n_worlds=len(screening.largest),
        seed=seed,
    )
    progress(1.0)
    return Findings(base, fits, screening, result, of_smooth)


def fits_of_faults(question: Question, missing: Sequence[str]) -> dict[str, Refit]:
    """Full refits with candidates that are missing by a fault of the records alone."""
    asked = (c.key for c in question.screening.candidates if c.key in missing)
    return {key: refit_with(question.base, key) for key in asked if key not in question.fits}


def hidden_by_nuisances(
    base: Refit, specification: Specification, entries: Sequence[Definition], seed: int
) -> list[str]:
    """Candidates that stand out where nuisances which the records ask for are not granted.

    The most surprising, and beside pairs what stands out of their columns alone.
    """
    bare = nuisances.without_those_asked_for(base, specification)
    if bare is None:
        return []
    screened = screen(bare.posterior, bare.mode.u, entries, seed=seed).candidates
    found = [c for c in screened if c.p_family <= LEVEL]
    first = [c.key for c in found[:MOST_HIDDEN]]
    columns = {column for key in first for column in columns_of_pair(key)}
    return [*first, *(c.key for c in found[MOST_HIDDEN:] if c.definition.column in columns)]


def beside_group(
    group: TriedGroup, missing: Sequence[str], evidence: Mapping[str, float]
) -> list[str]:
    """What is missing with a group in whose place it was sought, the likeliest first.

    Nothing where a candidate has so much evidence that groups are not named beside it.
    """
    lead = evidence.get(missing[0], -np.inf) - group.evidence if missing else -np.inf
    if missing and (lead >= MARGIN or not group.persistent):
        return []
    return sorted((*missing, group.name), key=lambda key: -evidence.get(key, group.evidence))


def _unsure(base: Refit, evidence: Mapping[str, float], missing: Sequence[str]) -> tuple[Note, ...]:
    """That a detection limit has evidence which what is left over, or missing, may have made up."""
    note = "limit_unsure" if was_added_to(base) else "limit_later"
    return tuple(
        Note(note, effect=key, nats=nats)
        for key, nats in evidence.items()
        if base.definition(key).says_what_is_seen and key not in missing
        if nats > MARGIN
    )


def _measure_next(
    question: Question, detectable_m: float, field_days: Mapping[str, float], seed: int
) -> Rows[Measurement]:
    """What would distinguish the best explanations, or show an effect that is too small to see.

    Explanations are the candidates in the lead, and the model itself where these are few.
    """
    if question.fits:
        best = [*question.fits.items(), ("", question.base)][:EXPLANATIONS]
        return measurements.measurement_gains(dict(best), field_days, seed)
    # An effect as large as the smallest detectable gains in proportion to the events.
    observations = question.base.observations
    key = "more_events_ratio" if observations.in_ratio else "more_events"
    more = Note(key, n=observations.n_events, size=detectable_m / 2**0.5)
    days = observations.n_events * field_days["runout"]
    return Rows([Measurement(more, question.screening.critical_gain, field_days=days)])


def beside_places(
    evidence: Mapping[str, float],
    fits: Mapping[str, Refit],
    laws: Mapping[str, Laws] = MappingProxyType({}),
) -> dict[str, float]:
    """Evidence (nats) of candidates, less where friction that varies by place leaves too little.

    Of a smooth with laws, by itself or by the best of them.
    """

    def beside(key: str) -> float:
        found = evidence_beside_places(fits[key], key)
        for best in laws.get(key, ())[:1]:
            found = max(found, evidence_beside_places(best.fit, best.law.effect))
        return found

    high = [key for key, nats in evidence.items() if nats > MARGIN]
    left = zip(high, ordered_map(beside, high), strict=True)
    too_little = {key: nats for key, nats in left if nats <= MARGIN}
    return {key: min(nats, too_little.get(key, nats)) for key, nats in evidence.items()}


def leading_smooth(missing: Sequence[str], fits: Mapping[str, Refit]) -> str | None:
    """The first of what is missing, where it is a smooth curve; laws are asked of it alone."""
    for key in missing[:1]:
        curve = curve_of(fits[key], key) if key in fits else None
        if curve is not None and curve.form:
            return key
    return None


def unless_speeds_are_off(question: Question, naming: Naming) -> tuple[Naming, tuple[Note, ...]]:
    """The naming, or that of the speeds which fail where all may be off by one factor; and a note.

    That is where the factor explains more than the force that leads.
    """
    leader = next((key for key in naming.missing if key in question.fits), None)
    factor = leader and record_faults.by_speeds_off(question, leader)
    if not factor:
        return naming, ()
    speeds = replace(naming, verdict="unexplained", missing=(worst_speeds(question.base),))
    return speeds, (Note("speeds_off", factor=factor, effect=leader),)


def verdict_on(
    question: Question, naming: Naming, groups: Sequence[TriedGroup], granted: Sequence[str]
) -> tuple[str, tuple[str, ...], Pair | None]:
    """The verdict, the keys that it names, and effects that are needed together.

    What else could explain the same is asked in turn: faults of the records, two effects that count
    only together, groups that differ; last, whether those that are named are all needed. `granted`
    are the nuisances that the base was given, by key.
    """
    definition, fits = question.base.definition, question.fits
    verdict, missing = naming.verdict, naming.missing
    together: Pair | None = None
    if missing and missing[0] in fits:
        faults = record_faults.explained_by_record_faults(question, missing[0])
        if more := tuple(key for key in faults if key not in missing):
            verdict, missing = "ambiguous", (*missing, *more)
    rivals = tuple(fits.values()) if missing else ()
    if pair := best_pair(question, missing):
        together, fit = pair
        rivals = (fit,)
        verdict, missing = verdict_of([definition(together.effects[0])])
    if group := named_group(question, rivals, groups, granted):
        return *verdict_of(map(definition, group)), None
    if len(missing) > 1 and missing[0] in fits and (together := needed_beside(question, missing)):
        verdict, missing = verdict_of([definition(missing[0])])
    return verdict, missing, together


def named_group(
    question: Question,
    rivals: Sequence[Refit],
    groups: Sequence[TriedGroup],
    granted: Sequence[str],
) -> tuple[str, ...]:
    """The granted groups that differ most plainly, where no rival explains more.

    Winters and storms, which do not come again, predict nothing: any cause comes before them.
    Beside the groups stand the errors of volumes, where these may make them up.
    """
    for test in full_fits.plainly_different(groups, granted):
        if rivals and not test.persistent:
            continue
        if all(group_comes_first(question.base, rival, test.key) for rival in rivals):
            errors = record_faults.groups_by_misstated_volumes(question, test.key)
            return (test.name, errors) if errors else (test.name,)
    return ()


def candidates(
    question: Question,
    ranked: Sequence[Screened],
    evidence: Mapping[str, float],
    naming: Naming,
    laws: Mapping[str, Laws],
    of_laws: Mapping[str, Refit],
) -> list[Candidate]:
    """Every candidate with what is known of it: those refitted (`ranked`) first.

    A smooth with less evidence than its law is judged by that, its fit among `of_laws`.
    """
    base, fits = question.base, question.fits
    rest = [c for c in question.screening.candidates if c not in ranked]
    alike = look_alikes(fits, base)
    new = base.posterior.layout.kinds is None
    kinds = {key: full_fits.kinds_of(fit.at_mode()) for key, fit in fits.items()} if new else {}
    before = error_of(base)
    found = []
    for c in [*ranked, *rest]:
        fit, witness = fits.get(c.key), naming.witnesses.get(c.key)
        by = of_laws.get(c.key, fit)
        found.append(
            Candidate(
                effect=c.key,
                gain=c.gain if by is None else by.log_likelihood - base.log_likelihood,
                evidence_gain=evidence.get(c.key),
                held_out_gain=naming.held_out.get(c.key),
                p_value=c.p_family,
                screened_gain=c.gain,
                chance_gain=c.null_gain,
                p_value_alone=c.p_single,
                error_before_m=before,
                error_after_m=None if by is None else error_of(by),
                parameters={} if fit is None else fit.parameters(c.key),
                physics=c.definition.meaning,
                confounded_with=alike.get(c.key, ()),
                force_witness=witness and MeasuredAmount(witness.value, witness.se),
                kinds=kinds.get(c.key),
                shape=None if fit is None else found_shape(fit, c.key, laws.get(c.key, ())),
            )
        )
    return found


def named_as_candidate(base: Refit, group: TriedGroup) -> Candidate:
    """A named group of events as a candidate."""
    return Candidate(
        effect=group.name,
        gain=group.gain,
        evidence_gain=group.evidence,
        held_out_gain=None,
        p_value=group.p_value,
        screened_gain=group.gain,
        chance_gain=full_fits.GROUP_BY_CHANCE,
        p_value_alone=group.p_value,
        error_before_m=error_of(refit_without(base, group.key)),
        error_after_m=error_of(base),
        parameters=base.parameters(group.key),
        physics=base.definition(group.name).meaning,
        confounded_with=(),
    )


def look_alikes(fits: Mapping[str, Refit], base: Refit) -> dict[str, tuple[str, ...]]:
    """The other candidates that change friction as each one does."""
    change = {key: measurements.explained(fit, base) for key, fit in fits.items()}
    return {
        key: tuple(
            other
            for other in change
            if other != key
            and abs(measurements.correlation(change[key], change[other], base.posterior)) > ALIKE
        )
        for key in change
    }


def error_of(fit: Refit) -> float:
    """Mean CRPS (m) of the records with the parameters at their mode."""
    rng = generator(0, "error of a fit")
    records = expected_records(fit.at_mode(), ERROR_DRAWS, rng)
    return float(np.mean(crps(records.draws, records.observed)))


def needed_beside(question: Question, keys: Sequence[str]) -> Pair | None:
    """The effects of a set, the first fitted already, if each is needed beside the others."""
    base, singles = question.base, dict(question.fits)
    fit = singles[keys[0]]
    for key in keys[1:]:
        wider = refit_with(fit, key)
        if not _is_needed(fit, wider, (key,)):
            return None
        if key not in singles:
            singles[key] = refit_with(base, key)
        if wider.evidence - singles[key].evidence <= MARGIN:
            return None  # this one does it alone
        fit = wider
    p_value = max(c.p_family for c in question.screening.candidates if c.key in keys)
    return _together(tuple(keys), fit, base, singles, p_value)


def best_pair(question: Question, missing: Sequence[str]) -> tuple[Pair, Refit] | None:
    """The two effects that explain more together than those named so far, and the fit of both.

    None where any of these is simpler than a pair of columns.
    """
    fits, test = question.fits, question.screening.pair
    if any(key not in fits or question.base.definition(key).beyond < 2 for key in missing):
        return None
    if missing and (apart := columns_apart(question, missing[0])):
        return apart
    if test is None or test.p_value > PAIR_LEVEL:
        return None
    pair = _needed_pair(question.base, test.keys, test.p_value)
    if pair and missing and fits[missing[0]].evidence - pair[1].evidence > MARGIN:
        return None
    return pair


def columns_apart(question: Question, leader: str) -> tuple[Pair, Refit] | None:
    """The effects of both columns of a leading pair, where these explain more by themselves.

    Or where the product of columns has no evidence of its own.
    """
    names, tried = columns_of_pair(leader), question.screening.candidates
    of_each = [
        [c for c in tried if name in (c.definition.column, c.definition.needs)] for name in names
    ]

    def comes_first(found: Sequence[Screened]) -> Screened:
        # Of a smooth and an effect of the catalogue this one, unless it explains far less.
        most = max(c.surprise for c in found)
        close = (c for c in found if c.surprise > most - MARGIN)
        return min(close, key=lambda c: (c.definition.beyond, -c.surprise))

    keys = [comes_first(found).key for found in of_each if found]
    fit = question.fits[leader]
    region = "region" in fit.facts[leader]
    if len(keys) != 2 or not (region or product_evidence(fit, leader) <= MARGIN):
        return None
    p_value = next(c.p_family for c in tried if c.key == leader)
    pair = _needed_pair(question.base, (keys[0], keys[1]), p_value)
    return None if pair and region and pair[1].evidence <= fit.evidence else pair


def product_evidence(fit: Refit, pair: str) -> float:
    """Evidence (nats) that the columns of a pair, the last effect of a fit, act by their product.

    The ratio of Savage and Dickey, by the moments of the draws.
    """
    parameters = fit.posterior.effects[-1].parameters
    at = [k for k, p in enumerate(parameters) if "*" in p.name]
    drawn, sd = fit.drawn(pair)[:, at], [parameters[k].prior_sd for k in at]
    after = stats.multivariate_normal(np.mean(drawn, axis=0), np.cov(drawn.T), allow_singular=True)
    return float(np.sum(stats.norm.logpdf(0.0, scale=sd)) - after.logpdf(np.zeros(len(at))))


def _needed_pair(base: Refit, keys: tuple[str, str], p_value: float) -> tuple[Pair, Refit] | None:
    singles = refit_each(base, keys)
    both = refit_with(base, *keys)
    alone = max((base, *singles.values()), key=lambda fit: fit.evidence)
    if not _is_needed(alone, both, keys):
        return None

    def comes_first(key: str) -> float:
        # Of two that hide each other a cause, but where it explains less by far.
        return singles[key].evidence + MARGIN * base.definition(key).names_cause

    order = tuple(sorted(keys, key=comes_first, reverse=True))
    return _together(order, both, base, singles, p_value), both


def _together(
    keys: tuple[str, ...], fit: Refit, base: Refit, singles: Mapping[str, Refit], p_value: float
) -> Pair:
    return Pair(
        effects=keys,
        gain=fit.log_likelihood - base.log_likelihood,
        gain_over_best_single=fit.log_likelihood - max(singles[k].log_likelihood for k in keys),
        p_value=p_value,
        error_after_m=error_of(fit),
        parameters={k: v for key in keys for k, v in fit.parameters(key).items()},
    )


def _is_needed(fit: Refit, wider: Refit, more: Sequence[str]) -> bool:
    """Whether a wider model is worth it: by evidence, by held-out records, by the force."""
    return (
        wider.evidence - fit.evidence > MARGIN
        and evidence_beside_places(wider, more[-1]) > MARGIN
        and not any(w.denies for k in more if (w := force_witness(wider.posterior, wider.mode, k)))
        and held_out_gain(wider, fit) > 0.0
    )
