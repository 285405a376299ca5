"""Which physical effect is missing, if any: screening, full refits, held-out check, verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from avahazard.criticism.diagnosis.answer import Question, answer_of
from avahazard.criticism.diagnosis.confounding import correlation, explained
from avahazard.criticism.diagnosis.detectable import detectable
from avahazard.criticism.diagnosis.findings import Candidate, Diagnosis
from avahazard.criticism.diagnosis.impossible_stops import impossible_stops
from avahazard.criticism.diagnosis.naming import Naming, name_effects
from avahazard.criticism.diagnosis.nuisances import with_nuisances_granted, with_tails_granted
from avahazard.criticism.diagnosis.refits import Refit, refit_each, without_groups
from avahazard.criticism.diagnosis.still_needed import still_needed
from avahazard.criticism.diagnosis.suspects import suspects
from avahazard.criticism.diagnosis.verdict import evidence_gain
from avahazard.criticism.scoring.expected import expected_records
from avahazard.criticism.scoring.scores import crps
from avahazard.criticism.screening.candidates import candidate_definitions, not_asked
from avahazard.criticism.screening.levels import LEVEL
from avahazard.criticism.screening.screen import screen
from avahazard.criticism.screening.significance import Screened, Screening
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.seeds import generator

MAX_REFITS = 6
ERROR_DRAWS = 400
ALIKE = 0.7
"""Correlation above which two effects are called confounded."""


def diagnose(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    own: Sequence[Definition] = (),
    *,
    expected: Sequence[str] = (),
    n_worlds: int = 199,
    seed: int = 0,
    progress: Callable[[float], None] = lambda _share: None,
) -> Diagnosis:
    """Ask which effect a model lacks on observations.

    Paths may differ for reasons unknown in every fit, winters and storms where the records ask for
    it, events that left and limits of sight are in the likelihood, and where friction scatters
    with heavy tails it is let to, before anything is blamed on physics.

    Candidates `expected` were declared beforehand, and are tested first.
    """
    plain = with_tails_granted(observations, specification, facts, own)
    base, granted, too_many = with_nuisances_granted(observations, plain, own)
    bare, u, spreads = without_groups(base, observations, own)
    screening = screen(
        bare,
        u,
        spreads,
        candidate_definitions(observations, plain.specification, own),
        expected=expected,
        n_worlds=n_worlds,
        seed=seed,
        progress=lambda share: progress(0.05 + 0.75 * share),
    )
    survivors = those_that_survived(screening, expected)
    keys = [c.key for c in survivors]
    fits = refit_each(observations, keys, own, base, lambda share: progress(0.8 + 0.15 * share))
    evidence = {c.key: evidence_gain(c, fits[c.key], base) for c in survivors}
    ranked = sorted(survivors, key=lambda c: -evidence[c.key])
    naming = name_effects(ranked, evidence, fits, base, expected)
    answer = answer_of(Question(observations, own, base, fits, screening), naming, granted)
    found = Diagnosis(
        verdict=answer.verdict,
        missing=answer.missing,
        candidates=candidates(ranked, screening, fits, evidence, naming, base),
        base=base,
        screening=screening,
        error_before_m=error_of(base),
        still_needed=still_needed(observations, own, plain),
        not_granted=too_many,
        not_asked=not_asked(observations, plain.specification, own),
        heavy_tails=plain.specification.tails != specification.tails,
        detectable=detectable(base, screening.critical_gain),
        suspects=suspects(base),
        together=answer.together,
        impossible_stops=impossible_stops(base),
    )
    progress(1.0)
    return found


def those_that_survived(screening: Screening, expected: Sequence[str]) -> list[Screened]:
    """The candidates that are worth a full fit, those declared beforehand first."""
    survivors = [c for c in screening.candidates if c.p_family <= LEVEL]
    return sorted(survivors, key=lambda c: c.key not in expected)[:MAX_REFITS]


def candidates(
    ranked: Sequence[Screened],
    screening: Screening,
    fits: Mapping[str, Refit],
    evidence: Mapping[str, float],
    naming: Naming,
    base: Refit,
) -> tuple[Candidate, ...]:
    """Every candidate with what is known of it: those refitted first, by their evidence."""
    rest = [c for c in screening.candidates if c not in ranked]
    alike = look_alikes(fits, base)
    return tuple(
        Candidate(
            c,
            fits.get(c.key),
            evidence.get(c.key),
            error_of(fits[c.key]) if c.key in fits else None,
            naming.held_out.get(c.key),
            alike.get(c.key, ()),
            naming.witnesses.get(c.key),
        )
        for c in [*ranked, *rest]
    )


def look_alikes(fits: Mapping[str, Refit], base: Refit) -> dict[str, tuple[str, ...]]:
    """The other candidates that change friction as each one does."""
    change = {key: explained(fit, base) for key, fit in fits.items()}
    return {
        key: tuple(
            other
            for other in change
            if other != key and abs(correlation(change[key], change[other], base.posterior)) > ALIKE
        )
        for key in change
    }


def error_of(fit: Refit) -> float:
    """Mean CRPS (m) of the records with the parameters at their mode."""
    rng = generator(0, "error of a fit")
    records = expected_records(fit.at_mode(), ERROR_DRAWS, rng)
    return float(np.mean(crps(records.draws, records.observed)))
