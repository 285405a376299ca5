"""Whether an effect, or a difference of groups, only makes up for volumes' misstated errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import logsumexp

from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.criticism.diagnosis.verdict import groups_earn_their_name, least_evidence
from avahazard.criticism.screening.significance import Screening
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.volumes import bounded

OF_THE_VOLUME = ("law", "scatter")
"""Settings of the model that say how friction goes by volume."""
OVERSTATED = (0.03, 0.1, 0.2)
"""Shares of the recorded volumes that are tried as larger than any true one."""


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

    How far records of large volumes are overstated hangs on the largest volume that there is, which
    nobody knows: where it lies under many records, friction stops falling with what is recorded,
    as in a law with a limit. So the evidence of either is the mean over some such volumes.
    """
    setting = find_definition(leader, own).changes
    if setting is None or setting.field not in OF_THE_VOLUME:
        return None
    key = _errors_of_volumes(observations, screening)
    if key is None or key in base.specification.effects:
        return None
    first = fits[leader]
    alone = fits.get(key) or _with(observations, own, base, key)
    both = _with(observations, own, first, key)
    needed = least_evidence(find_definition(leader, own))
    if both.evidence - alone.evidence <= needed:
        return key
    without, beside = [alone.evidence], [both.evidence]
    recorded = observations.columns.log_volume
    for share in OVERSTATED:
        largest = float(np.exp(np.nanquantile(recorded, 1.0 - share)))
        limited = replace(observations, volumes=bounded(observations.volumes, largest))
        without.append(_with(limited, own, base, key).evidence)
        beside.append(_with(limited, own, first, key).evidence)
    return None if float(logsumexp(beside) - logsumexp(without)) > needed else key


def groups_by_misstated_volumes(
    observations: Observations,
    own: Sequence[Definition],
    base: Refit,
    groups: str,
    screening: Screening,
) -> str | None:
    """The effect on the volumes' errors that leaves groups (a key) too little evidence, or None.

    Errors larger than stated make friction fall less with the volumes of a path's records than with
    the mean volumes of paths, in which errors average out. One law for both gives paths of large
    avalanches too much friction, and they seem to differ.
    """
    key = _errors_of_volumes(observations, screening)
    if key is None:
        return None
    wider = _with(observations, own, base, key)
    return None if groups_earn_their_name(observations, own, wider, groups) else key


def _errors_of_volumes(observations: Observations, screening: Screening) -> str | None:
    """The candidate that scales the errors of the volumes, if there is one."""
    candidates = screening.candidates
    return next((c.key for c in candidates if _on_volumes(c.definition, observations)), None)


def _with(observations: Observations, own: Sequence[Definition], start: Refit, key: str) -> Refit:
    return refit(observations, start.specification, start.facts, (key,), own, start)


def _on_volumes(entry: Definition, observations: Observations) -> bool:
    """Whether an effect scales the errors of the volumes."""
    if entry.changes is not None:
        return False
    facts = entry.facts(observations.columns, observations.sites)
    return entry.build(facts).volume_scale is not None
