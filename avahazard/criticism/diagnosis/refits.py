"""Models fitted in full with or without an effect: their mode, and their evidence."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.held_out import (
    HeldOut,
    choose_groups,
    held_out_together,
    offsets_by_group,
)
from avahazard.criticism.screening.linear_model import by_name, put
from avahazard.criticism.screening.screen import Screened, Screening
from avahazard.effects.effect import Definition, Effect, Facts, shapes_tables
from avahazard.engine import spread_map
from avahazard.inference.fitted_model import FittedModel, fitted_model
from avahazard.inference.fitting import star
from avahazard.inference.fitting.mode import (
    FIRST_SPREAD,
    Evidence,
    Mode,
    find_mode,
    log_evidence,
    start_coordinates,
)
from avahazard.inference.likelihood.assemble import (
    assemble,
    definitions_of,
    find_definition,
    with_effects,
)
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification

Likely = Mapping[str, Sequence[Floats]]
"""Values of the parameters of effects, by key, from which fits begin."""
NEARER, AS_PROMISED = (1.0, 0.4, 0.16), 0.2
"""Shares of likely values that are tried in turn, until one gains this share of what its score
promises."""
LEAST_START = 0.03
"""Share of a range that a fit begins off a bound which is neutral."""
ROUGH_EVIDENCE = 0.3
"""Error of the evidence (nats) from which on the star is made anew by the draws on it."""
ROUGHLY = 0.3
"""Gain (nats) of the last step to a rough mode."""


@dataclass(frozen=True, eq=False)
class Refit:
    """A model at its mode.

    `evidence` is the log marginal likelihood (nats), in which needless parameters cost;
    `log_likelihood` is that of the mode. `sample` `[n, n_slots]` are draws of the posterior; `own`
    are the user's definitions. What was computed of it once is `kept`.
    """

    specification: Specification
    facts: dict[str, Facts]
    posterior: Posterior
    mode: Mode
    log_likelihood: float
    evidence: float
    sample: Floats
    own: Sequence[Definition] = ()
    kept: dict[str, Any] = field(default_factory=dict)

    @property
    def observations(self) -> Observations:
        """The events that it was fitted on."""
        return self.posterior.observations

    def definition(self, key: str) -> Definition:
        """The definition of an effect, the user's own first."""
        return find_definition(key, self.own)

    @property
    def by_event(self) -> Floats:
        """Log likelihood of each event at the mode, `[n_events]`."""
        return self.posterior.event_log_likelihood(
            self.mode.u, self.posterior.mode_offsets(self.mode.u)
        )

    def parameters(self, key: str) -> dict[str, float]:
        """Readable values of the parameters of one effect (or of all) at the mode."""
        values = self.posterior.layout.readable(self.mode.u)
        return {k: float(v) for k, (v, _) in values.items() if k.startswith(key)}

    def drawn(self, key: str) -> Floats:
        """Draws of the parameters of one effect, `[n_draws, n_parameters]`."""
        layout = self.posterior.layout
        place = layout.places[key]
        return self.sample[:, place] * [slot.scale for slot in layout.slots[place]]

    def at_mode(self) -> FittedModel:
        """The fitted model with its parameters, and offsets of groups, at the mode alone."""
        mode = self.posterior.mode_offsets(self.mode.u)
        offsets = offsets_by_group(self.posterior, None if mode is None else mode[None])
        return fitted_model(self.posterior, self.mode.u[None], offsets)


def refit(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    effects: Sequence[str] = (),
    own: Sequence[Definition] = (),
    start: Refit | None = None,
    likely: Likely | None = None,
    begin: Floats | None = None,
    least: float = -np.inf,
    known: Floats | None = None,
) -> Refit:
    """Fit a specification with `effects` added, from the mode of `start` where names agree.

    Without that from coordinates `known` `[n_slots]`, or from all that is plausible.

    `likely` are values of their parameters by key that are tried in place of plausible ones
    (`search_mode`); with `begin`, those of the only one, the mode is sought from these alone.
    What they need of the data is not asked for: candidates have been asked already. A fit that does
    not reach the log likelihood `least` has no evidence (-inf).
    """
    wider, facts, posterior = _wider(observations, specification, facts, effects, own)
    if known is not None:
        posterior, mode = star.mode_from(posterior, known)
    elif start is None:
        posterior, mode = star.search_mode(posterior)
    elif begin is None:
        begun, on_star = _carried(start, posterior), posterior.on_star_of(start.posterior)
        near = None if on_star is None else star.mode_on_star(on_star, begun)
        if on_star is not None and near is not None:
            posterior, mode = on_star, near
        else:
            tried = {key: (likely or {}).get(key) or None for key in effects}
            posterior, mode = star.search_mode(posterior, begun, tried, least)
    else:
        (key,) = effects
        began = put(_carried(start, posterior), posterior.layout, key, begin)
        posterior, mode = star.mode_from(posterior, began)
    log_likelihood = posterior.exact_log_likelihood(mode.u)
    if log_likelihood < least:
        evidence = Evidence(-np.inf, 0.0, mode.u[None])
    else:
        evidence = log_evidence(posterior, mode)
        rough = posterior.nodes.varies and ROUGH_EVIDENCE < evidence.error < np.inf
        if rough and (better := star.improved(posterior, evidence.sample)) is not None:
            at = find_mode(better, mode.u)
            if (more := log_evidence(better, at)).error < evidence.error:
                posterior, mode, evidence = better, at, more
    posterior.nodes.forget_runs()
    value, _, sample = evidence
    return Refit(wider, facts, posterior, mode, log_likelihood, value, sample, own)


def _wider(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    effects: Sequence[str],
    own: Sequence[Definition],
) -> tuple[Specification, dict[str, Facts], Posterior]:
    """The specification with effects added, what these take from the data, and its posterior."""
    wider, more = with_effects(observations, specification, effects, own, granted=True)
    facts = {**facts, **more}
    return wider, facts, assemble(observations, wider, facts, own)


def held_out_gain(wider: Refit, base: Refit) -> float:
    """What a model gains over another on held-out records (nats)."""
    groups = choose_groups(base.observations, wider.posterior.effects)
    key = f"held out {groups.fits.tobytes().hex()}"
    asked = [fit for fit in (wider, base) if key not in fit.kept]
    for fit, held_out in zip(asked, spread_map(_held_out, groups, asked), strict=True):
        fit.kept[key] = held_out
    return float(np.sum(wider.kept[key] - base.kept[key]))


def _held_out(groups: HeldOut, fit: Refit) -> Floats:
    """Log density of each group of events given the others, `[n_groups]`."""
    found = held_out_together(fit.posterior, groups.fits, fit.mode)
    fit.posterior.nodes.forget_runs()
    return found


def peak_with(base: Refit, entry: Definition, start: Refit, values: Floats) -> tuple[float, Floats]:
    """The log density, and the effect's values, at the mode of `base` with it, roughly."""
    own = (*base.own, entry)
    *_, posterior = _wider(base.observations, base.specification, base.facts, (entry.key,), own)
    began = put(_carried(start, posterior), posterior.layout, entry.key, values)
    peak = star.gauss_newton(posterior, began, ROUGHLY)
    posterior.nodes.forget_runs()
    return peak.log_density, posterior.layout.effect_values(peak.u)[entry.key]


def refit_with(
    start: Refit,
    *keys: str,
    likely: Likely | None = None,
    on: Observations | None = None,
    least: float = -np.inf,
) -> Refit:
    """The model of `start` with these effects added, perhaps `on` other observations."""
    given = start.observations if on is None else on, start.specification, start.facts
    return refit(*given, keys, start.own, start, likely, least=least)


def refit_without(start: Refit, key: str) -> Refit:
    """The model of `start` less one effect."""
    keys = tuple(k for k in start.specification.effects if k != key)
    bare = replace(start.specification, effects=keys)
    return refit(start.observations, bare, start.facts, (), start.own, start)


def short_ascent(
    start: Refit, key: str, likely: Sequence[Floats], promised: float
) -> tuple[float, Floats]:
    """The gain (nats) and values of the best short ascent with an effect that shapes the tables.

    From `likely` values, and plausible ones of an effect of the catalogue or where there are none.
    Where these gain far less than `promised`, the likely ones lie beyond what the derivatives at
    neutral say anything of, and nearer ones are tried.
    """
    given = start.observations, start.specification, start.facts
    *_, posterior = _wider(*given, (key,), start.own)
    u = _carried(start, posterior)
    effect = next(e for e in posterior.effects if e.key == key)
    here = posterior.pinned(u).log_density(u)
    beyond = start.definition(key).beyond
    ascents = [(here, u)] if beyond else []
    if not (beyond and likely):
        ascents += star.short_ascents(posterior, u, effect)
    for share in NEARER:
        values = [effect.neutral + share * (v - effect.neutral) for v in likely]
        ascents += star.short_ascents(posterior, u, effect, values)
        reached, at = max(ascents, key=lambda ascent: ascent[0])
        if reached - here > AS_PROMISED * promised:
            break
    posterior.nodes.forget_runs()
    return reached - here, np.asarray(posterior.layout.effect_values(at)[key])


def likely_values(screened: Iterable[Screened], observations: Observations) -> Likely:
    """Of candidates that shape the tables, values from which fits begin, off neutral bounds.

    None where what is screened has other parameters than what is fitted, as stretches of paths.
    """
    found = dict[str, list[Floats]]()
    for candidate in screened:
        effect = effect_on(candidate.definition, observations) if len(candidate.likely) else None
        if effect is None or not shapes_tables(effect):
            continue
        if len(candidate.likely) != len(effect.parameters):
            found[candidate.key] = []
            continue
        low, high = (np.array([getattr(p, e) for p in effect.parameters]) for e in ("low", "high"))
        least = LEAST_START * (high - low) * (effect.neutral == low)
        most = LEAST_START * (high - low) * (effect.neutral == high)
        found[candidate.key] = [np.clip(candidate.likely, low + least, high - most)]
    return found


def effect_on(entry: Definition, observations: Observations) -> Effect | None:
    """The effect of a candidate on these observations; None for a setting of the model."""
    if entry.changes is not None:
        return None
    return entry.build(entry.facts(observations.columns, observations.sites))


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """A model, its full refits with each candidate that stood out by itself, and the screening."""

    base: Refit
    fits: Mapping[str, Refit]
    screening: Screening


def refit_each(
    base: Refit,
    effects: Sequence[str],
    progress: Callable[[float], None] = lambda _share: None,
    likely: Likely | None = None,
    least: Mapping[str, float] = MappingProxyType({}),
) -> dict[str, Refit]:
    """The base model with each effect by itself, fitted in full if it gains its `least` nats."""
    shared = base, likely, {k: base.log_likelihood + nats for k, nats in least.items()}
    fits: dict[str, Refit] = {}
    for key, fit in zip(effects, spread_map(_refit_with, shared, effects), strict=True):
        fits[key] = fit
        progress(len(fits) / len(effects))
    return fits


def _refit_with(shared: tuple[Refit, Likely | None, Mapping[str, float]], key: str) -> Refit:
    base, likely, least = shared
    return refit_with(base, key, likely=likely, least=least.get(key, -np.inf))


def _carried(start: Refit, posterior: Posterior) -> Floats:
    """Coordinates of `start` by slot name; slots that it lacks stand at neutral."""
    layout, before = posterior.layout, start.posterior.layout
    u = by_name(before, start.mode.u, layout)
    for key, k in layout.spreads.items():
        u[k] = u[k] if key in before.spreads else FIRST_SPREAD
    if layout.law.name != before.law.name:
        # Another law: its coordinates mean something else; start at the data.
        n = len(layout.law.coordinates)
        return np.concatenate([start_coordinates(posterior)[:n], u[n:]])
    return u


def still_needed(whole: Refit) -> dict[str, float]:
    """Evidence (nats) that the model would lose without each of its effects, where it is known."""
    lost = {
        entry.key: whole.evidence - refit_without(whole, entry.key).evidence
        for entry in definitions_of(whole.specification, whole.own)
        if entry.changes is None
    }
    return {key: nats for key, nats in lost.items() if np.isfinite(nats)}
