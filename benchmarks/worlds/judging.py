"""One world from its plan to a line of results."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from avahazard.criticism.diagnosis.diagnose import Diagnosis, diagnose
from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.criticism.scoring.expected import expected_records
from avahazard.criticism.scoring.held_out import choose_groups
from avahazard.criticism.scoring.scores import crps, record_pit
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.fitting.mode import Mode, find_mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.seeds import generator
from avahazard.synth.making import make_world
from avahazard.workflow.diagnose import diagnosis
from benchmarks.worlds.arms import Plan
from benchmarks.worlds.measured import as_told, with_speeds
from benchmarks.worlds.outside import EFFECTS, effect_file
from benchmarks.worlds.rivals import best_bic, regression
from benchmarks.worlds.traps import DECLARED, TRAPS, stated

PATH_EFFECT = "path-effect"
LIMIT = "observation-limit"

DRAWS = 120
OWN = {**EFFECTS, **TRAPS}


def judge(plan: Plan) -> dict[str, Any]:
    """Make the world, diagnose it, and hold the answer against the truth and the rivals."""
    began = time.perf_counter()
    observations = world(plan)
    base = Specification(centrifugal="centrifugal" not in plan.effects)
    found = diagnose(observations, base, {})
    seconds = time.perf_counter() - began
    line: dict[str, Any] = {
        "name": plan.name,
        "arm": plan.arm,
        "n_events": plan.n_events,
        "true": list(plan.true),
        "neutral": list(plan.neutral),
        "verdict": found.verdict,
        "missing": list(found.missing),
        "bic": best_bic(found),
        "regression": regression(found),
        "seconds": round(seconds, 1),
    }
    line |= _errors(plan, observations, found)
    if plan.true == (LIMIT,):
        line["told_gain"] = told_limits_gain(plan, found)
    if plan.speeds_later:
        again = diagnose(build_observations(with_speeds(plan)), base, {})
        line["with_speeds"] = [again.verdict, list(again.missing)]
    if found.verdict == "ambiguous":
        told = as_told(plan, diagnosis("", found, 0).measure_next[0].to_dict()["measurement"])
        if told is not None and len(plan.true) == 1:
            again = diagnose(told, base, {})
            line["as_told"] = [again.verdict, list(again.missing)]
    line["all_seconds"] = round(time.perf_counter() - began, 1)
    return line


def world(plan: Plan) -> Observations:
    """The observations of a plan's world."""
    records, _ = make_world(
        plan.seed, plan.n_events, plan.n_paths, plan.effects, plan.settings, own_effects=OWN
    )
    return build_observations(stated(records, plan.stated))


def told_limits_gain(plan: Plan, found: Diagnosis) -> float:
    """Gain (nats) of who is told the limits of sight, over the model that knows of none.

    A limit that is estimated gains by chance as well, just above the highest stop of each path.
    """
    told = {DECLARED if key == LIMIT else key: s for key, s in plan.effects.items()}
    fit = refit(world(replace(plan, effects=told)), found.base.specification, found.base.facts)
    return round(fit.log_likelihood - found.base.log_likelihood, 2)


def _errors(plan: Plan, observations: Observations, found: Diagnosis) -> dict[str, Any]:
    """Held-out CRPS (m) and coverage of the model, of the child that was named, of the oracle."""
    base = found.base
    fits = {c.key: c.fit for c in found.candidates if c.fit is not None}
    line: dict[str, Any] = {"base": held_out(observations, base)}
    named = [k for k in found.missing if k != PATH_EFFECT]
    chosen = fits.get(named[0]) if named else base
    line["child"] = held_out(observations, chosen) if chosen is not None and named else line["base"]
    true = _true_fit(plan, observations, found, fits)
    if true is not None:
        line["oracle_gain"] = round(true.log_likelihood - base.log_likelihood, 2)
        same = named and true is chosen
        line["oracle"] = line["child"] if same else held_out(observations, true)
    elif plan.true == (PATH_EFFECT,):
        gains = [g.gain for g in found.groups if g.key == PATH_EFFECT]
        line["oracle_gain"] = round(max(gains, default=0.0), 2)
        line["oracle"] = line["base"]
    if plan.wrong is not None:
        needless = refit(observations, base.specification, base.facts, (plan.wrong,), (), base)
        line["wrong"] = held_out(observations, needless)
        line["wrong_effect"] = plan.wrong
    return line


def _true_fit(
    plan: Plan, observations: Observations, found: Diagnosis, fits: dict[str, Refit]
) -> Refit | None:
    """The model with the true effects, fitted as the candidates are; None where there is none."""
    base = found.base
    own = (effect_file(plan.outside),) if plan.outside else ()
    keys = (own[0].key,) if own else tuple(k for k in plan.true if k != PATH_EFFECT)
    if not keys:
        return None
    if len(keys) == 1 and keys[0] in fits:
        return fits[keys[0]]
    return refit(observations, base.specification, base.facts, keys, own, base)


def held_out(observations: Observations, fit: Refit) -> list[float]:
    """CRPS (m) of records and coverage of 90 % intervals, whole paths held out and fitted anew.

    Draws vary all parameters but those that shape the tables, which stay at their mode.
    """
    posterior = fit.posterior
    groups = choose_groups(observations).groups
    scores, inside = np.empty(observations.n_events), np.empty(observations.n_events)
    for group in np.unique(groups):
        out = groups == group
        rest = posterior.restricted(~out)
        mode = find_mode(rest, fit.mode.u)
        rng = generator(0, "benchmark", int(group))
        u = _draws(rest, mode, rng)
        offsets = {}
        if rest.plan:
            shift = np.array([rest.offsets(v).draw(rng) for v in u])
            offsets = {name: shift[:, k] for k, name in enumerate(rest.plan.names)}
        records = expected_records(fitted_model(rest, u, offsets), DRAWS, rng)
        scores[out] = crps(records.draws, records.observed)[out]
        inside[out] = (np.abs(record_pit(records, rng) - 0.5) <= 0.45)[out]
    return [round(float(np.mean(scores)), 3), round(float(np.mean(inside)), 4)]


def _draws(posterior: Posterior, mode: Mode, rng: np.random.Generator) -> Any:
    layout = posterior.layout
    free = [k for k in range(len(mode.u)) if k not in layout.tables]
    # Their covariance given the others: precision, not covariance, is cut.
    given = np.linalg.inv(np.linalg.inv(mode.covariance)[np.ix_(free, free)])
    part = np.linalg.cholesky(given)
    u = np.repeat(mode.u[None], DRAWS, axis=0)
    u[:, free] += rng.standard_normal((DRAWS, len(free))) @ part.T
    return np.clip(u, layout.low, layout.high)
