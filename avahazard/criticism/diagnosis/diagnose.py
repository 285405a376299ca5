"""Which physical effect is missing, if any: screening, full refits, held-out check, verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.diagnosis.confounding import correlation, explained
from avahazard.criticism.diagnosis.detectable import detectable
from avahazard.criticism.diagnosis.nuisances import with_nuisances_granted, with_tails_granted
from avahazard.criticism.diagnosis.refits import (
    Refit,
    refit_each,
    without_groups,
)
from avahazard.criticism.diagnosis.still_needed import still_needed
from avahazard.criticism.diagnosis.suspects import suspects
from avahazard.criticism.diagnosis.verdict import (
    MARGIN,
    evidence_gain,
    group_comes_first,
    least_evidence,
    verdict_of,
)
from avahazard.criticism.scoring.expected import expected_records
from avahazard.criticism.scoring.held_out import choose_groups, held_out_log_density
from avahazard.criticism.scoring.scores import crps
from avahazard.criticism.screening.candidates import candidate_definitions
from avahazard.criticism.screening.screen import screen
from avahazard.criticism.screening.significance import (
    GROUP_LEVEL,
    LEVEL,
    GroupTest,
    Screened,
    Screening,
)
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction.fitted_model import FittedModel
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
    heavy_tails: bool
    detectable_log_friction: float
    detectable_m: float
    suspects: tuple[str, ...]


def diagnose(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    own: Sequence[Definition] = (),
    *,
    n_worlds: int = 199,
    seed: int = 0,
    progress: Callable[[float], None] = lambda _share: None,
) -> Diagnosis:
    """Ask which effect a model lacks on observations.

    Paths may differ for reasons unknown in every fit, winters and storms where the records ask for
    it, events that left and limits of sight are in the likelihood, and where friction scatters
    with heavy tails it is let to, before anything is blamed on physics.
    """
    plain = with_tails_granted(observations, specification, facts, own)
    base, granted = with_nuisances_granted(observations, plain, own)
    bare, u, spreads = without_groups(base, observations, own)
    screening = screen(
        bare,
        u,
        spreads,
        candidate_definitions(observations, plain.specification, own),
        n_worlds=n_worlds,
        seed=seed,
        progress=lambda share: progress(0.05 + 0.75 * share),
    )
    survivors = [c for c in screening.candidates if c.p_family <= LEVEL][:MAX_REFITS]
    keys = [c.key for c in survivors]
    fits = refit_each(observations, keys, own, base, lambda share: progress(0.8 + 0.15 * share))
    evidence = {c.key: evidence_gain(c, fits[c.key], base) for c in survivors}
    ranked = sorted(survivors, key=lambda c: -evidence[c.key])
    gains = held_out_gains(leaders(ranked, evidence), fits, base)
    named = [c.definition for c in ranked if gains.get(c.key, 0.0) > 0.0 and evidence[c.key] > 0.0]
    verdict, missing = verdict_of(named)
    rivals = tuple(fits.values()) if named else ()
    group = named_group(observations, own, base, rivals, screening.groups, granted)
    if group:
        verdict, missing = "missing-effect", group
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
                gains.get(c.key),
                alike.get(c.key, ()),
            )
            for c in [*ranked, *rest]
        ),
        base=base,
        screening=screening,
        error_before_m=error_of(base),
        still_needed=still_needed(observations, own, plain),
        heavy_tails=plain.specification.tails != specification.tails,
        detectable_log_friction=shift,
        detectable_m=metres,
        suspects=suspects(base),
    )
    progress(1.0)
    return found


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
    come again, predict nothing: any cause comes before them.
    """
    plan = base.posterior.plan
    lasting = [key for key, lasts in zip(plan.keys, plan.lasting, strict=True) if lasts]
    plain = [
        test
        for test in tests
        if test.key in granted
        and (test.key in lasting or not rivals)
        and test.p_value <= GROUP_LEVEL
        and find_definition(test.key, own).lacking(observations.columns, observations.sites) is None
    ]
    for test in sorted(plain, key=lambda t: -t.gain):
        if all(group_comes_first(observations, own, base, rival, test.key) for rival in rivals):
            return (test.key,)
    return ()


def leaders(ranked: Sequence[Screened], evidence: Mapping[str, float]) -> list[Screened]:
    """The candidate of most evidence and those close to it; none where it is not enough."""
    if not ranked or evidence[ranked[0].key] <= least_evidence(ranked[0].definition):
        return []
    return [c for c in ranked if evidence[ranked[0].key] - evidence[c.key] < MARGIN]


def held_out_gains(
    asked: Sequence[Screened], fits: Mapping[str, Refit], base: Refit
) -> dict[str, float]:
    """What each of these gains on records kept back (nats)."""
    if not asked:
        return {}
    groups = choose_groups(base.posterior.observations).groups
    before = held_out_log_density(base.posterior, groups, base.mode)
    fitted = {c.key: fits[c.key] for c in asked}
    return {
        key: float(np.sum(held_out_log_density(fit.posterior, groups, fit.mode) - before))
        for key, fit in fitted.items()
    }


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
    offsets = {}
    plan = fit.posterior.plan
    if plan:
        mode = fit.posterior.offsets(fit.mode.u).mode
        offsets = {name: mode[[k]] for k, name in enumerate(plan.names)}
    rng = generator(0, "error of a fit")
    records = expected_records(
        FittedModel(fit.posterior, fit.mode.u[None], offsets), ERROR_DRAWS, rng
    )
    return float(np.mean(crps(records.draws, records.observed)))
