"""Which physical effect is missing, if any: screening, full refits, held-out check, verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.diagnosis.confounding import correlation, explained
from avahazard.criticism.diagnosis.detectable import detectable
from avahazard.criticism.diagnosis.force_witness import ForceWitness
from avahazard.criticism.diagnosis.impossible_stops import impossible_stops
from avahazard.criticism.diagnosis.misstated_volumes import by_misstated_volumes
from avahazard.criticism.diagnosis.naming import name_effects
from avahazard.criticism.diagnosis.nuisances import with_nuisances_granted, with_tails_granted
from avahazard.criticism.diagnosis.refits import (
    Refit,
    refit_each,
    without_groups,
)
from avahazard.criticism.diagnosis.still_needed import still_needed
from avahazard.criticism.diagnosis.suspects import suspects
from avahazard.criticism.diagnosis.together import Together, masked_pair, needed_beside
from avahazard.criticism.diagnosis.unseen_stops import by_what_is_seen
from avahazard.criticism.diagnosis.verdict import (
    evidence_gain,
    group_comes_first,
    groups_earn_their_name,
    verdict_of,
)
from avahazard.criticism.scoring.expected import expected_records
from avahazard.criticism.scoring.scores import crps
from avahazard.criticism.screening.candidates import candidate_definitions
from avahazard.criticism.screening.levels import LEVEL
from avahazard.criticism.screening.screen import screen
from avahazard.criticism.screening.significance import GroupTest, Screened, Screening
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.seeds import generator

Floats = NDArray[np.float64]

MAX_REFITS = 6
ERROR_DRAWS = 400
ALIKE = 0.7
"""Correlation above which two effects are called confounded."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One candidate, screened.

    With its full refit if it survived, and the evidence (nats) that it adds.
    """

    screened: Screened
    fit: Refit | None
    evidence_gain: float | None
    error_after_m: float | None
    held_out_gain: float | None
    confounded_with: tuple[str, ...]
    force_witness: ForceWitness | None

    @property
    def key(self) -> str:
        """The effect's key."""
        return self.screened.key


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    """The verdict with all that it rests on; `base` is the model with the nuisances."""

    verdict: str
    missing: tuple[str, ...]
    candidates: tuple[Candidate, ...]
    base: Refit
    screening: Screening
    error_before_m: float
    still_needed: dict[str, float]
    not_granted: tuple[str, ...]
    heavy_tails: bool
    detectable_log_friction: float
    detectable_m: float
    suspects: tuple[str, ...]
    together: tuple[Together, ...]
    impossible_stops: tuple[str, ...]


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
    survivors = [c for c in screening.candidates if c.p_family <= LEVEL]
    survivors = sorted(survivors, key=lambda c: c.key not in expected)[:MAX_REFITS]
    keys = [c.key for c in survivors]
    fits = refit_each(observations, keys, own, base, lambda share: progress(0.8 + 0.15 * share))
    evidence = {c.key: evidence_gain(c, fits[c.key], base) for c in survivors}
    ranked = sorted(survivors, key=lambda c: -evidence[c.key])
    naming = name_effects(ranked, evidence, fits, base, expected)
    verdict, missing = naming.verdict, naming.missing
    if missing and missing[0] in fits:
        leader = missing[0]
        for beside in (by_what_is_seen, by_misstated_volumes):
            other = beside(observations, own, base, fits, leader, screening)
            if other is not None and other not in missing:
                verdict, missing = "ambiguous", (*missing, other)
    rivals = tuple(fits.values()) if missing else ()
    together: tuple[Together, ...] = ()
    pair = None if missing else masked_pair(observations, own, base, screening)
    if pair is not None:
        together, rivals = (pair,), (pair.fit,)
        verdict, missing = verdict_of_pair(pair, own)
    group = named_group(observations, own, base, rivals, screening.groups, granted)
    if group:
        verdict, missing, together = "missing-effect", group, ()
    elif missing and missing[0] in fits:
        together = needed_beside(observations, own, base, fits, missing[0], screening)
        if any(set(missing) <= set(more.effects) for more in together):
            # Each is needed beside the others: that tells them apart.
            verdict, missing = verdict_of([find_definition(missing[0], own)])
    rest = [c for c in screening.candidates if c not in survivors]
    alike = look_alikes(fits, base)
    shift, metres = detectable(base, screening.critical_gain)
    found = Diagnosis(
        verdict=verdict,
        missing=missing,
        candidates=tuple(
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
        ),
        base=base,
        screening=screening,
        error_before_m=error_of(base),
        still_needed=still_needed(observations, own, plain),
        not_granted=too_many,
        heavy_tails=plain.specification.tails != specification.tails,
        detectable_log_friction=shift,
        detectable_m=metres,
        suspects=suspects(base),
        together=together,
        impossible_stops=impossible_stops(base),
    )
    progress(1.0)
    return found


def verdict_of_pair(pair: Together, own: Sequence[Definition]) -> tuple[str, tuple[str, ...]]:
    """The verdict on two effects that count only together: the cause of more evidence is named."""
    entries = [find_definition(key, own) for key in pair.effects]
    causes = [entry for entry in entries if entry.names_cause]
    return verdict_of(causes[:1] or entries)


def named_group(
    observations: Observations,
    own: Sequence[Definition],
    base: Refit,
    rivals: Sequence[Refit],
    tests: Sequence[GroupTest],
    granted: Sequence[str],
) -> tuple[str, ...]:
    """The granted groups that differ most plainly, where no rival explains more; none or one key.

    Groups that are too few to tell their spread are never named. Winters and storms, which do not
    come again, predict nothing: any cause comes before them, and they need the same evidence.
    """
    plan = base.posterior.plan
    lasting = [key for key, lasts in zip(plan.keys, plan.lasting, strict=True) if lasts]
    plain = [
        test
        for test in tests
        if test.key in granted
        and (test.key in lasting or not rivals)
        and test.p_value <= test.level
        and find_definition(test.key, own).lacking(observations.columns, observations.sites) is None
    ]
    for test in sorted(plain, key=lambda t: -t.gain):
        if test.key not in lasting and not groups_earn_their_name(
            observations, own, base, test.key
        ):
            continue
        if all(group_comes_first(observations, own, base, rival, test.key) for rival in rivals):
            return (test.key,)
    return ()


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
