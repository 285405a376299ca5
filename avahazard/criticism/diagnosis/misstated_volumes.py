"""Whether an effect of the volume only makes up for errors of the volumes that are misstated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.criticism.diagnosis.verdict import least_evidence
from avahazard.criticism.screening.significance import Screening
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations

OF_THE_VOLUME = ("law", "scatter")
"""Settings of the model that say how friction goes by volume."""


def by_misstated_volumes(
    observations: Observations,
    own: Sequence[Definition],
    base: Refit,
    fits: Mapping[str, Refit],
    leader: str,
    screening: Screening,
) -> str | None:
    """The effect on the volumes' errors that leaves the leader, on the volume, too little evidence.

    Errors larger than stated bend the law towards the mean volume and scatter friction most where
    it is steepest: another law, and another scatter, do the same. So such a leader must earn its
    evidence where the errors may be misstated too. None where it does, or is another kind.
    """
    setting = find_definition(leader, own).changes
    if setting is None or setting.field not in OF_THE_VOLUME:
        return None
    key = next((c.key for c in screening.candidates if _on_volumes(c.definition, observations)), "")
    if not key:
        return None
    alone = fits.get(key) or refit(observations, base.specification, base.facts, (key,), own, base)
    first = fits[leader]
    both = refit(observations, first.specification, first.facts, (key,), own, first)
    needed = least_evidence(find_definition(leader, own))
    return None if both.evidence - alone.evidence > needed else key


def _on_volumes(entry: Definition, observations: Observations) -> bool:
    """Whether an effect scales the errors of the volumes."""
    if entry.changes is not None:
        return False
    facts = entry.facts(observations.columns, observations.sites)
    return entry.build(facts).volume_scale is not None
