"""Which physical effect is missing, if any: screening, full refits, held-out check, verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from avahazard.criticism.candidates import candidate_definitions
from avahazard.criticism.confounding import correlation, explained
from avahazard.criticism.expected import expected_records
from avahazard.criticism.held_out import choose_groups, held_out_log_density
from avahazard.criticism.refits import PATH_EFFECT, Refit, refit, without_path_effect
from avahazard.criticism.scores import crps
from avahazard.criticism.screening import LEVEL, PATH_LEVEL, Screened, Screening, screen
from avahazard.effects.catalogue import definition
from avahazard.effects.covariate import PREFIX
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.assemble import find_definition
from avahazard.inference.mode import likely_friction
from avahazard.inference.seeds import generator
from avahazard.inference.specification import Specification
from avahazard.inference.study import LEFT, Study

Floats = NDArray[np.float64]

MARGIN = 3.0
"""Evidence (nats) by which a candidate must lead the model without it to be named, and the next
candidate to be named alone: odds of 20 to 1."""
MAX_REFITS = 6
ERROR_DRAWS = 400
TYPICAL_SD = 0.2
"""Prior sd of a typical effect on log friction."""
ALIKE = 0.7
"""Correlation above which two effects are called confounded."""
HEAVY_TAILS = 3.0
"""Gain (nats) above which scatter is taken with Student's tails."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One candidate, screened; if it survived with its full refit, and the evidence (nats) that
    it adds."""

    screened: Screened
    fit: Refit | None
    evidence_gain: float | None
    error_after_m: float | None
    held_out_gain: float | None
    confounded_with: tuple[str, ...]

    @property
    def key(self) -> str:
        """The effect's key."""
        return self.screened.definition.key


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    """The verdict with all that it rests on; `base` is the model with the path nuisance."""

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
    study: Study,
    specification: Specification,
    facts: dict[str, Facts],
    own: Sequence[Definition] = (),
    *,
    n_worlds: int = 199,
    seed: int = 0,
    progress: Callable[[float], None] = lambda _share: None,
) -> Diagnosis:
    """Ask which effect a model lacks on a study.

    Paths may differ for reasons unknown in every fit (where there are enough of them), events
    that left and limits of sight are in the likelihood, and where friction scatters with heavy
    tails it is let to, before anything is blamed on physics.
    """
    plain = refit(study, specification, facts, (), own)
    heavy = False
    if specification.tails == "normal":
        student = refit(study, replace(specification, tails="student"), facts, (), own)
        heavy = student.log_likelihood - plain.log_likelihood > HEAVY_TAILS
        if heavy:
            plain, specification = student, replace(specification, tails="student")
    base = plain
    grants = PATH_EFFECT not in specification.effects and (
        definition(PATH_EFFECT).lacking(study.columns, study.sites) is None
    )
    if grants:
        base = refit(study, specification, facts, (PATH_EFFECT,), own, plain)
    bare, u, tau = without_path_effect(base, study, own)
    screening = screen(
        bare,
        u,
        tau,
        candidate_definitions(study, specification, own),
        n_worlds=n_worlds,
        seed=seed,
        progress=lambda share: progress(0.05 + 0.75 * share),
    )
    survivors = [c for c in screening.candidates if c.p_family <= LEVEL][:MAX_REFITS]
    fits: dict[str, Refit] = {}
    for k, survivor in enumerate(survivors):
        key = survivor.definition.key
        fits[key] = refit(study, base.specification, base.facts, (key,), own, base)
        progress(0.8 + 0.15 * (k + 1) / len(survivors))
    evidence = {c.definition.key: _evidence_gain(c, fits[c.definition.key], base) for c in survivors}
    ranked = sorted(survivors, key=lambda c: -evidence[c.definition.key])
    path_missing = grants and screening.path_p <= PATH_LEVEL
    gains, named = {}, []
    if ranked:
        leader = ranked[0].definition.key
        groups = choose_groups(study).groups
        before = held_out_log_density(base.posterior, groups, base.mode)
        for c in ranked:
            key = c.definition.key
            if evidence[leader] - evidence[key] < MARGIN:
                after = held_out_log_density(fits[key].posterior, groups, fits[key].mode)
                gains[key] = float(np.sum(after - before))
                if gains[key] > 0.0 and evidence[key] > 0.0:
                    named.append(key)
        if evidence[leader] < MARGIN:
            named = []
    verdict, missing = _verdict(named)
    if path_missing and (
        not named
        or all(
            _path_comes_first(study, specification, facts, own, plain, base, fit)
            for fit in fits.values()
        )
    ):
        verdict, missing = "missing-effect", (PATH_EFFECT,)
    change = {key: explained(fit, base) for key, fit in fits.items()}
    candidates = [
        Candidate(
            c,
            fits.get(c.definition.key),
            evidence.get(c.definition.key),
            error_of(fits[c.definition.key]) if c.definition.key in fits else None,
            gains.get(c.definition.key),
            tuple(
                other
                for other in change
                if c.definition.key in change
                and other != c.definition.key
                and abs(correlation(change[c.definition.key], change[other], base.posterior))
                > ALIKE
            ),
        )
        for c in [*ranked, *(c for c in screening.candidates if c not in survivors)]
    ]
    shift, metres = _detectable(base, screening.critical_gain)
    progress(1.0)
    return Diagnosis(
        verdict=verdict,
        missing=missing,
        candidates=tuple(candidates),
        base=base,
        screening=screening,
        error_before_m=error_of(base),
        still_needed=_still_needed(study, specification, facts, own, plain),
        heavy_tails=heavy,
        detectable_log_friction=shift,
        detectable_m=metres,
        suspects=_suspects(base),
    )


def _evidence_gain(screened: Screened, fit: Refit, base: Refit) -> float:
    """Evidence (nats) that a candidate adds.

    The estimated limit of sight is that of the highest stop seen on each path: its likelihood
    rises with every path where nothing is hidden, which no price of one parameter makes good.
    What it gains on average in made worlds does, in the measure of the full fit.
    """
    key = screened.definition.key
    gain = fit.evidence - base.evidence
    if any(e.key == key and e.limit is not None for e in fit.posterior.effects):
        share = (fit.log_likelihood - base.log_likelihood) / max(screened.gain, 1e-9)
        gain -= screened.null_mean * min(max(share, 0.0), 1.0)
    return gain


def error_of(fit: Refit) -> float:
    """Mean CRPS (m) of the records with the parameters at their mode."""
    offsets = {}
    if fit.posterior.groups is not None:
        mode = fit.posterior.path_offsets(fit.mode.u).mode
        offsets = {p: np.array([mode[k]]) for k, p in enumerate(fit.posterior.study.columns.paths)}
    rng = generator(0, "error of a fit")
    records = expected_records(fit.posterior, fit.mode.u[None], offsets, ERROR_DRAWS, rng)
    return float(np.mean(crps(records.draws, records.observed)))


def _still_needed(
    study: Study,
    specification: Specification,
    facts: dict[str, Facts],
    own: Sequence[Definition],
    whole: Refit,
) -> dict[str, float]:
    """Evidence (nats) that the model would lose without each of its effects."""
    lost = {}
    for key in specification.effects:
        if find_definition(key, own).changes is not None:
            continue
        keys = tuple(k for k in specification.effects if k != key)
        less = refit(study, replace(specification, effects=keys), facts, (), own, whole)
        lost[key] = whole.evidence - less.evidence
    return lost


def _verdict(named: list[str]) -> tuple[str, tuple[str, ...]]:
    """What the leading candidates amount to."""
    if not named:
        return "adequate", ()
    if all(key.startswith(PREFIX) for key in named):
        return "unexplained", tuple(named)
    if len(named) == 1:
        return "missing-effect", tuple(named)
    return "ambiguous", tuple(named)


def _path_comes_first(
    study: Study,
    specification: Specification,
    facts: dict[str, Facts],
    own: Sequence[Definition],
    plain: Refit,
    base: Refit,
    rival: Refit,
) -> bool:
    """Whether unrecorded differences of paths explain more, given a rival, than the rival does
    given them. A rival that differs by path alone, as the section, may explain all of them."""
    keys = tuple(k for k in rival.specification.effects if k not in base.specification.effects)
    alone = refit(study, specification, facts, keys, own, plain) if keys else plain
    by_path = rival.log_likelihood - alone.log_likelihood
    by_rival = rival.log_likelihood - base.log_likelihood
    return by_path > by_rival


def _detectable(base: Refit, critical_gain: float) -> tuple[float, float]:
    """The smallest effect that would have been seen with 80 % power: rms log friction, metres.

    A shift of rms δ in log friction has, on n events of total variance s², a gain with
    non-centrality n δ²/s²; the gain must pass `critical_gain`, and be worth `MARGIN` after the
    price of one more parameter.
    """
    posterior = base.posterior
    study = posterior.study
    _, scatter = posterior.location_and_scatter(base.mode.u)
    nodes = posterior.nodes_at(base.mode.u)
    mean = np.sum(nodes.place * nodes.weight, axis=1, keepdims=True)
    record_variance = np.sum(nodes.weight * (nodes.place - mean) ** 2, axis=1)
    stopped = study.kind != LEFT
    total = np.mean(scatter**2, axis=1) + np.where(stopped, record_variance, 0.0)
    information = float(np.sum(1.0 / total[stopped]))
    price = 0.5 * float(np.log1p(information * TYPICAL_SD**2))
    gain = max(critical_gain, MARGIN + price)
    shift = (np.sqrt(2.0 * gain) + float(stats.norm.ppf(0.8))) / np.sqrt(information)
    # The record's spread in metres against that in log friction tells metres per unit.
    ratio = study.sigma[stopped] / np.sqrt(np.maximum(record_variance[stopped], 1e-8))
    return float(shift), float(shift * np.median(ratio))


def _suspects(base: Refit) -> tuple[str, ...]:
    """Events whose record is hard to believe: more than four scatters off, worst first."""
    posterior = base.posterior
    location, scatter = posterior.location_and_scatter(base.mode.u)
    friction = likely_friction(posterior.nodes_at(base.mode.u), posterior.layout.log_scatter)
    asked = np.log(friction) if posterior.layout.log_scatter else friction
    z = np.nan_to_num(np.abs(asked - location.mean(axis=1)) / scatter.mean(axis=1))
    order = np.argsort(-z, kind="stable")
    return tuple(posterior.study.columns.event_id[i] for i in order if z[i] > 4.0)
