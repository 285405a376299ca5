"""A model put together: the named effects built on observations, and the posterior over it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from avahazard.effects.catalogue import definition, require
from avahazard.effects.effect import Definition, Effect, Facts
from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.laws import LAWS, law
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification, free_parameters
from avahazard.records.errors import AvahazardError


def with_effects(
    observations: Observations,
    specification: Specification,
    keys: Sequence[str],
    own: Sequence[Definition] = (),
    granted: bool = False,
) -> tuple[Specification, dict[str, Facts]]:
    """The specification with these effects added, and what they take from the observations.

    Nuisances that are `granted` need no more of the data than as such.

    `own` are definitions from the user's file. An effect that is a setting of the model
    becomes its value, or the most likely of the other ones. Raises `AvahazardError` where an
    effect is unknown, already there, or cannot be estimated from the data.
    """
    facts: dict[str, Facts] = {}
    for key in keys:
        entry = find_definition(key, own)
        if key in specification.effects:
            raise AvahazardError(f"The model already has the effect '{key}'.")
        if not granted:
            require(entry, observations.columns, observations.sites)
        if entry.changes is None:
            facts[key] = entry.facts(observations.columns, observations.sites)
        elif entry.changes.value is None:
            specification = _other_law(observations, specification, own)
        else:
            specification = specification.put(entry.changes, entry.changes.value)
        if not entry.in_base:
            specification = replace(specification, effects=(*specification.effects, key))
    if specification.scatter == "volume":
        large = float(np.exp(np.quantile(observations.volumes.mean, 0.9)))
        specification = replace(specification, reference_volume_m3=large)
    return specification, facts


def find_definition(key: str, own: Sequence[Definition] = ()) -> Definition:
    """The definition of that key, the user's own first."""
    return next((entry for entry in own if entry.key == key), None) or definition(key)


def definitions_of(
    specification: Specification, own: Sequence[Definition] = ()
) -> tuple[Definition, ...]:
    """The definitions of a specification's effects."""
    return tuple(find_definition(key, own) for key in specification.effects)


def build_effects(
    specification: Specification, facts: dict[str, Facts], own: Sequence[Definition] = ()
) -> tuple[Effect, ...]:
    """The effects of a specification, ready for use, from what they took from the data."""
    entries = definitions_of(specification, own)
    return tuple(e.build(facts.get(e.key, {})) for e in entries if e.changes is None)


def assemble(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    own: Sequence[Definition] = (),
) -> Posterior:
    """The posterior of a model on observations (which may be another than the facts are from).

    Raises `AvahazardError` where the law goes by volume and no event has one.
    """
    if not observations.volumes.population.known and law(specification.law).uses_volume:
        raise AvahazardError(
            f"No event has a volume, so the {specification.law} law has nothing to go by.",
            "Use --law constant.",
        )
    return Posterior(observations, specification, build_effects(specification, facts, own))


def _other_law(
    observations: Observations, specification: Specification, own: Sequence[Definition]
) -> Specification:
    """The specification with the most likely of the other laws (by its posterior mode).

    Priors that it was given for its own law are none of another's.
    """
    own_names = free_parameters(law(specification.law))
    given = tuple(g for g in specification.given if g.name not in own_names)
    others = [
        replace(specification, law=name, prior=None, given=given)
        for name, item in LAWS.items()
        if name != specification.law and item.uses_volume
    ]
    facts = {
        entry.key: entry.facts(observations.columns, observations.sites)
        for entry in definitions_of(specification, own)
    }
    return max(others, key=lambda s: find_mode(assemble(observations, s, facts, own)).log_density)
