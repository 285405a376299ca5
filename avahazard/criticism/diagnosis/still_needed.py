"""Whether each effect of a model is still needed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.assemble import definitions_of
from avahazard.inference.model.observations import Observations


def still_needed(
    observations: Observations, own: Sequence[Definition], whole: Refit
) -> dict[str, float]:
    """Evidence (nats) that the model would lose without each of its effects."""
    lost, specification = {}, whole.specification
    for entry in definitions_of(specification, own):
        if entry.changes is None:
            keys = tuple(k for k in specification.effects if k != entry.key)
            bare = replace(specification, effects=keys)
            less = refit(observations, bare, whole.facts, (), own, whole)
            lost[entry.key] = whole.evidence - less.evidence
    return lost
