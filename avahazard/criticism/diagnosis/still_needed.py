"""Whether each effect of a model is still needed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.specification import Specification


def still_needed(
    observations: Observations,
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
        less = refit(observations, replace(specification, effects=keys), facts, (), own, whole)
        lost[key] = whole.evidence - less.evidence
    return lost
